"""Every way in which a task may fail, each as a library with what it is told for.

In each library the comment `; here` marks the line that the cause names.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from rapc.worlds.script import Row
from tests.runtime.helpers import row


class Way(NamedTuple):
    """A library whose task `(top a)` fails, and the first cause expected of it."""

    text: str
    clause: str
    part: str = ""
    bindings: Mapping[str, str] = MappingProxyType({})
    note: str = ""
    facts: tuple[str, ...] = ()
    rows: tuple[Any, ...] = ()
    times: tuple[Any, ...] = ()
    methods: tuple[str, ...] = ()


WAYS = {
    "preconditions": Way(
        """(define-rap (top ?x)
             (preconditions (and (q ?x ?y)
                                 (p ?y)  ; here
                                 (go)))
             (method (primitive (act ?x))))""",
        "preconditions of `top`",
        "(p ?y)",
        {"?y": "b"},
        facts=("(q a b)",),
    ),
    "constraints of its own": Way(
        """(define-rap (top ?x)
             (constraints (not (p ?x)))  ; here
             (method (primitive (act ?x))))""",
        "constraints of `top`",
        "(not (p ?x))",
        {"?x": "a"},
        facts=("(p a)",),
    ),
    "constraints of a task above": Way(
        """(define-rap (top ?x) (succeed (go))
             (constraints (not (p ?x)))  ; here
             (method (task-net (t1 (one) (for t2)) (t2 (one)))))
           (define-rap (one) (method (primitive (act x))))""",
        "constraints of `top`",
        "(not (p ?x))",
        {"?x": "a"},
        rows=(row("(act x)", asserts=["(p a)"]),),
    ),
    "constraints of a method": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (context (q ?x ?y)) (constraints (not (p ?y)))  ; here
               (task-net (t1 (one) (for t2)) (t2 (one)))))
           (define-rap (one) (method (primitive (act x))))""",
        "constraints of method `#1` of `top`",
        "(not (p ?y))",
        {"?y": "b"},
        facts=("(q a b)",),
        rows=(row("(act x)", asserts=["(p b)"]),),
    ),
    "a `for` formula": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one) ((and (q ?x ?y)
                               (p ?y)) for t2))  ; here
               (t2 (one)))))
           (define-rap (one) (method (primitive (act x))))""",
        "`for` formula of step `t1` of `top`",
        "(p ?y)",
        {"?y": "b"},
        facts=("(q a b)",),
    ),
    "an input that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one ?y)))))  ; here
           (define-rap (one ?z) (method (primitive (act ?z))))""",
        "inputs of step `t1` of `top`",
        "(one ?y)",
        note="?y not bound",
    ),
    "resources that cannot be": Way(
        """(define-rap (top ?x)
             (resources (counter ?c ?x))  ; here
             (method (primitive (act ?x))))""",
        "resources of `top`",
        "?x",
        {"?x": "a"},
        note="is no counter",
    ),
    "a window that is no time": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one) (window now ?x 9)))))  ; here
           (define-rap (one) (method (primitive (act x))))""",
        "window of step `t1`",
        "?x",
        {"?x": "a"},
        note="`a` is not a number",
    ),
    "repeat-while": Way(
        """(define-rap (top ?x)
             (repeat-while (q ?x ?y))  ; here
             (method (primitive (act ?x))))""",
        "repeat-while of `top`",
        "(q ?x ?y)",
        {"?x": "a"},
    ),
    "no method": Way(
        """(define-rap (top ?x)  ; here
             (method one (context (p ?x)) (primitive (act ?x)))
             (method two (context (and (q ?x ?y) (p ?y))) (primitive (act ?x))))""",
        "methods of `top`",
        facts=("(q a b)",),
        methods=("context of method `one` (p ?x)", "context of method `two` (p ?y)"),
    ),
    "no method at all": Way(
        "(define-rap (top ?x) (succeed (go)))  ; here",
        "methods of `top`",
        note="none",
    ),
    "a futile choice": Way(
        """(define-rap (top ?x) (succeed (go))
             (method try (context (q ?x ?y))  ; here
               (primitive (act ?y))))""",
        "method `try` of `top`",
        bindings={"?x": "a", "?y": "b"},
        note="chosen 2 times with the same bindings",
        facts=("(q a b)",),
    ),
    "a goal that stands above": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (top ?x)))))  ; here""",
        "step `t1`",
        "(top ?x)",
        {"?x": "a"},
        note="repeats (top a) [1]",
    ),
    "a goal that turns out to stand above": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (find => ?y) (for t2))
               (t2 (top ?y)))))  ; here
           (define-rap (find => ?w) (succeed (q found ?w))
             (method (primitive (act x))))""",
        "step `t2`",
        "(top ?y)",
        {"?y": "a"},
        note="repeats (top a) [1]",
        rows=(row("(act x)", asserts=["(q found a)"]),),
    ),
    "outputs": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (find => ?x)))))  ; here
           (define-rap (find => ?w) (succeed (q found ?w))
             (method (primitive (act x))))""",
        "outputs of step `t1` of `top`",
        "?x",
        {"?x": "a"},
        note="is not `b`",
        facts=("(q found b)",),
    ),
    "effects": Way(
        """(define-rap (top ?x) (succeed (go)) (resources (counter ?c 0))
             (method (task-net
               (t1 (one) (counter-add ?c ?x)))))  ; here
           (define-rap (one) (succeed (go2)) (method (primitive (act x))))
           (declare-memory-proposition go2 ())""",
        "effects of step `t1` of `top`",
        bindings={"?c": "#counter(0)", "?x": "a"},
        note="one of them cannot be made",
        rows=(row("(act x)", asserts=["(go2)"]),),
    ),
    "a notation that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (notations (q ?x ?free))  ; here
               (primitive (act ?x))))""",
        "notation of `top`",
        "(q ?x ?free)",
        {"?x": "a"},
        note="?free is not bound",
    ),
    "a request that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (primitive (act ?free))))  ; here""",
        "request of `top`",
        "(act ?free)",
        note="?free is not bound",
    ),
    "a claim that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (claims (arm ?x) (arm ?free))  ; here
               (primitive (act ?x))))""",
        "claims of method `#1` of `top`",
        "(arm ?free)",
        note="?free is not bound",
    ),
    "a resource that is to be noted": Way(
        """(define-rap (top ?x) (succeed (go))
             (resources (counter ?c))
             (method
               (notations (q ?x ?c))  ; here
               (primitive (act ?x))))""",
        "notation of `top`",
        "(q ?x ?c)",
        {"?x": "a", "?c": "#counter(0)"},
        note="?c is a resource",
    ),
    "a delay that is no time": Way(
        """(define-rap (top ?x) (succeed (go))
             (monitor-time now ?x 9)  ; here
             (method (primitive (act ?x))))""",
        "monitor-time of `top`",
        "?x",
        {"?x": "a"},
        note="`a` is not a number",
    ),
    "a skill that is not bound": Way(
        """(declare-skill :hum (?x))
           (declare-event :done ())
           (define-rap (top ?x) (succeed (go))
             (method (primitive
               (wait-for (:done) :succeed)
               (enable (:hum ?x) (:hum ?free)))))  ; here""",
        "skill of `top`",
        "(:hum ?free)",
        note="?free is not bound",
    ),
    "an event that fails a primitive": Way(
        """(declare-skill :hum (?x))
           (declare-event :stuck (?where))
           (define-rap (top ?x) (succeed (go))
             (method (primitive
               (enable (:hum ?x))
               (wait-for (:stuck ?where) :fail))))  ; here""",
        "wait-for of `top`",
        "(:stuck ?where)",
        {"?where": "b"},
        note="its event came",
        rows=(Row((":hum", "?"), kind="enable", after=2, signals=((":stuck", "b"),)),),
    ),
    "a request that the world refuses": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (primitive (slow ?x))))  ; here""",
        "primitive of `top`",
        "(slow ?x)",
        {"?x": "a"},
        note="the world refused it, and nothing could be waited for",
        rows=(Row(("slow", "?"), refused=True),),
    ),
    "skills that the world refuses": Way(
        """(declare-skill :hum (?x))
           (declare-event :done ())
           (define-rap (top ?x) (succeed (go))
             (method (primitive
               (wait-for (:done) :succeed)
               (enable (:hum ?x)))))  ; here""",
        "skill of `top`",
        "(:hum ?x)",
        {"?x": "a"},
        note="the world refused it, and nothing could be waited for",
        rows=(Row((":hum", "?"), kind="enable", refused=True),),
    ),
    "what the world answers": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (primitive (act ?x))))  ; here""",
        "primitive of `top`",
        "(act ?x)",
        {"?x": "a"},
        note="the world answered `dropped`",
        rows=(row("(act a)", "dropped"),),
    ),
    "a signal": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one) (wait-for (:bump) :fail)))))  ; here
           (define-rap (one) (method (primitive (slow x))))
           (declare-event :bump ())""",
        "wait-for of step `t1`",
        note="its signal came",
        rows=(row("(slow x)", after=9, signals=((":bump",),)),),
    ),
    "a step of a step": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net (t1 (middle ?x)))))
           (define-rap (middle ?x) (succeed (go))
             (method (task-net (t2 (low ?x)))))
           (define-rap (low ?x)
             (preconditions (p ?x))  ; here
             (method (primitive (act ?x))))""",
        "preconditions of `low`",
        "(p ?x)",
        {"?x": "a"},
    ),
}
"""Every way to fail; the clause is that of some cause in the chain."""
