"""RAP075 and RAP076: sensor data that no declaration knows, or that do not meet it.

Data are named by the `:tells` of primitives and in tests: a row of a script sends them
with a result, to the handlers of the world that the test names.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.names import UnknownNames, misuses, wrong_arity
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes

_AS_DECLARED = """\
(declare-primitive look () (okay))
(declare-sensor-datum seen (?thing))
(define-rap (look-around) (method (primitive (look))))
(define-test sees-the-box
  (world truck)
  (script ((look) :data ((seen box))))
  (task (look-around)))
"""

UNDECLARED = Rule(
    code="RAP075",
    name="undeclared-datum",
    severity=Severity.ERROR,
    summary="a test sends, or a primitive tells, a sensor datum that is not declared",
    why="""A row of a script may send sensor data with `:data`, and a primitive says
with `:tells` which may come with it. What a world sends is declared in the library that
is to take it in; no handler is called for anything else.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="T 3.3.1",
    example="""\
(declare-primitive look () (okay))
(declare-sensor-datum seen (?thing))
(define-rap (look-around) (method (primitive (look))))
(define-test sees-the-box
  (world truck)
  (script ((look) :data ((sene box))))
  (task (look-around)))
""",
    better=_AS_DECLARED,
)

ARITY = Rule(
    code="RAP076",
    name="wrong-datum-arity",
    severity=Severity.ERROR,
    summary="a sensor datum has another number of arguments than was declared",
    why="""A world sends a datum with the arguments it was declared with, and its
handler takes those and no others.""",
    source="T 3.3.1",
    example="""\
(declare-primitive look () (okay))
(declare-sensor-datum seen (?thing))
(define-rap (look-around) (method (primitive (look))))
(define-test sees-the-box
  (world truck)
  (script ((look) :data ((seen box here))))
  (task (look-around)))
""",
    better=_AS_DECLARED,
)


@check(UNDECLARED, ARITY)
def data(run: Pass) -> Iterator[Diagnostic]:
    """Find sensor data that are not declared, or declared otherwise."""
    unknown = UnknownNames(UNDECLARED)
    for one in misuses(run, ("datum",), "unknown"):
        unknown.add(one.fault, one.used.place(run.library.files), one.used.owner)
    for primitive in run.result(INDEX).of(nodes.DeclarePrimitive):
        for name in primitive.node.tells:
            if name not in run.signatures.data:
                fault = run.signatures.unknown("datum", name)
                unknown.add(fault, primitive.node.span, primitive.owner)
    yield from unknown.findings(run)
    yield from wrong_arity(run, ARITY, ("datum",))
