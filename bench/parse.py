"""Reading and checking: a generated library, definitions per second, stage by stage."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.child import take
from bench.common import Figure, compiled, seconds
from rapc.analysis import driver, registry
from rapc.analysis.selection import Selection, errors
from rapc.base.source import SourceFile
from rapc.compiler.program import Program
from rapc.library import loader
from rapc.parser.parse import parse
from rapc.parser.reader import read

DECLARATIONS = """\
(declare-primitive arm-grasp (?arm ?thing) (okay arm-dropped))
(declare-primitive drive-to (?place) (okay road-closed))
(declare-memory-proposition arm-holding (?arm ?thing))
(declare-memory-proposition at (?place))
(declare-memory-property location (?thing ?place) unknown)
(declare-memory-property size (?thing ?size) unknown)
(define-rap (go-to ?place)
  (succeed (at ?place))
  (method (primitive (drive-to ?place))))
(define-rap (pickup-0 ?arm ?thing)
  (method (primitive (arm-grasp ?arm ?thing))))
"""

DEFINITION = """\
;;; Number {n}: go there, and leave the rest to another.
(define-rap (index (pickup-{n} ?arm ?thing))
  (succeed (arm-holding ?arm ?thing))
  (method m{n}
    (context (and (location ?thing ?place) (not (= ?place unknown))
                  (size ?thing ?size) (> ?size {n})))
    (task-net
      (t1 (go-to ?place) ((at ?place) for t2))
      (t2 (pickup-{other} ?arm ?thing)))))
"""


OLDEST = "RAP074"
"""The last of the 67 rules that there were at 0e03d9a, by its code."""


def library(size: int) -> str:
    """The text of a library of so many RAPs besides its declarations."""
    definitions = (DEFINITION.format(n=n, other=n // 2) for n in range(1, size + 1))
    return DECLARATIONS + "".join(definitions)


def _compiled(text: str) -> Program:
    """All that a task needs of each RAP; queries become code when they are asked."""
    made = compiled(loader.load_text(text))
    for name in made.library.raps:
        made.rap(name)
    return made


def _command(raps: int) -> float:
    """The least CPU time of `rapc check` as a command, the start of Python in it."""
    with TemporaryDirectory() as folder:
        file = Path(folder, "generated.rap")
        file.write_text(library(raps), encoding="utf-8")
        start = "from rapc.cli.start import main; main()"
        command = [sys.executable, "-c", start, "check", "-q", str(file)]
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(Path(folder, "pyc"))}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        return min(take(command, environment)["cpu"] for _ in range(3))


def figures(quick: bool = False) -> Iterator[Figure]:
    """Read, read to IR, link, check, compile: each with all that comes before it."""
    size = 100 if quick else 5000
    text = library(size)
    source = SourceFile("generated.rap", text)
    loaded = loader.load_text(text)
    found = driver.check_library(loaded).findings
    if found:
        raise ValueError(found[0].diagnostic.message)
    rules = registry.rules().values()
    oldest = Selection(frozenset(r.name for r in rules if r.code <= OLDEST))
    stages = (
        ("text to data", lambda: read(source)),
        ("text to IR", lambda: parse(source)),
        ("text to linked library", lambda: loader.load_text(text)),
        ("all passes over it", lambda: driver.check_library(loaded)),
        (
            "text to checked library",
            lambda: driver.check_library(loader.load_text(text)),
        ),
        ("text to compiled library", lambda: _compiled(text)),
        (
            "the passes of the 67 oldest rules over it",
            lambda: driver.check_library(loaded, oldest),
        ),
        (
            "the passes that find errors over it",
            lambda: driver.check_library(loaded, errors()),
        ),
    )
    for what, work in stages:
        rate = size / seconds(work, rounds=3)
        yield Figure("parse", what, f"{size} RAPs", rate, "definitions/s")
    for raps in (100,) if quick else (500, 5000):
        used = _command(raps)
        yield Figure("parse", "`rapc check`, CPU time", f"{raps} RAPs", used, "s")
    megabytes = len(text.encode()) / 1e6
    rate = megabytes / seconds(lambda: read(source), rounds=3)
    yield Figure("parse", "text to data", f"{megabytes:.1f} MB", rate, "MB/s")
