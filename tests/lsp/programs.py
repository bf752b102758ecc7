"""A small library for the tests of editors."""

from __future__ import annotations

WORLD = """\
(declare-memory-proposition at (?thing ?place) "Where a thing is.")
(declare-primitive drive ((?place symbol)) (okay blocked)
  :on (okay (at robot ?place))
  "Drive to a place. äöü 🤖")
"""

RAPS = """\
(require "world")

; Go to a place.
(define-rap (go ?place)
  (succeed (at robot ?place))
  (method
    (primitive (drive ?place))))

(define-rap (tour)
  (method
    (task-net
      (t1 (go kitchen))
      (t2 (go hall)))))
"""

TESTS = """\
(require "raps")

(define-test drives
  (script ((drive kitchen) okay :asserts ((at robot kitchen))))
  (task (go kitchen))
  (expect (primitives (drive kitchen))))
"""

PYTHON = """\
from rapc.world import Handlers


def driven(memory, request, result):
    memory.assert_fact("at", "robot", request[1])


HANDLERS = Handlers({"drive": driven})
"""

SUPPRESSED = RAPS.replace(
    "      (t2 (go hall", "      ; rapc: ignore[copied-step]\n      (t2 (go kitchen"
)
"""`RAPS` with a copied step whose finding is ignored."""

EXTRACTED = """\
(require "world")

; Go to a place.
(define-rap (go ?place)
  (succeed (at robot ?place))
  (method
    (primitive (drive ?place))))

(define-rap (tour)
  (method
    (task-net
      (t1 (tour-t1)))))

(define-rap (tour-t1)
  (method
    (task-net
      (t1 (go kitchen))
      (t2 (go hall)))))
"""
"""`RAPS` with the steps of `tour` in a RAP of their own."""
