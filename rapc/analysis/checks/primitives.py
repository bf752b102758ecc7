"""RAP020 and RAP021: requests to the world that no declaration knows, or that miss it.

What the world offers is declared in the library; no world is imported to find out
[L 1].
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.names import unknown_names, wrong_arity
from rapc.base.diagnostics import Diagnostic, Rule, Severity

UNDECLARED = Rule(
    code="RAP020",
    name="undeclared-primitive",
    severity=Severity.ERROR,
    summary="a method or a test names a primitive that is not declared",
    why="""A primitive is a request to the world. What the world offers is declared, so
that a library can be checked without the world; what is not declared nobody answers. A
step of a task-net is no primitive: it names a RAP.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="T 4.5.3",
    example="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?arm ?thing)
  (method (primitive (arm-grsp ?arm ?thing))))
""",
    better="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?arm ?thing)
  (method (primitive (arm-grasp ?arm ?thing))))
""",
)

ARITY = Rule(
    code="RAP021",
    name="wrong-primitive-arity",
    severity=Severity.ERROR,
    summary="a request has another number of arguments than its primitive",
    why="""The world takes a request with the arguments that were declared for it and
no others.""",
    source="T 4.5.3",
    example="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?thing)
  (method (primitive (arm-grasp ?thing))))
""",
    better="""\
(declare-primitive arm-grasp (?arm ?thing) (okay))
(define-rap (grasp ?thing)
  (method (primitive (arm-grasp left ?thing))))
""",
)


@check(UNDECLARED, ARITY)
def primitives(run: Pass) -> Iterator[Diagnostic]:
    """Find requests for primitives that are not declared, or declared otherwise."""
    yield from unknown_names(run, UNDECLARED, ("primitive",))
    yield from wrong_arity(run, ARITY, ("primitive",))
