"""RAP153: requests about items that the sensors may have no name for (T 2.3.2)."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.logic import literals
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import clauses, nodes
from rapc.ir.walk import steps, subformulas

_WORLD = """\
(declare-primitive grasp ((?thing item)) (okay))
(declare-primitive scan () (okay))
(declare-memory-proposition held ((?thing item)))
(define-rap (take (?thing item))
  (succeed (held ?thing))
  (method look
    (context (know-sensor-name ?thing false))
    (primitive (scan)))
  (method take
    {}(primitive (grasp ?thing))))
"""

UNNAMED = Rule(
    code="RAP153",
    name="unnamed-item",
    severity=Severity.WARNING,
    summary="a request is about an item whose sensor name may not be known",
    why="""The hardware knows a thing by the name that the sensors have for it now, and
a request about an item without one fails before it is made (T 2.3.2). The RAP has a
method for the case that the name is not known, but this method may be chosen then too:
ask `(know-sensor-name ?thing true)` in its context.""",
    ignore="where the robot has the thing in sight whenever the method is chosen",
    source="T 2.3.2",
    example=_WORLD.format(""),
    better=_WORLD.format("(context (know-sensor-name ?thing true))\n    "),
)


@check(UNNAMED, needs_whole="form")
def unnamed_item(run: Pass) -> Iterator[Diagnostic]:
    """Find requests about items whose sensor name the method does not ask for."""
    asked = run.result(INDEX).of(nodes.SensorName)
    for rap in run.library.raps.values() if asked else ():
        unknown = dict(_unknown(rap))
        if not unknown:
            continue
        silent = [method for method in rap.methods if not _asks(rap, method)]
        alone = len(silent) == 1 and len(rap.methods) > _ENOUGH
        for method in silent:
            yield from _unnamed(method, unknown, alone=alone)


def _unknown(rap: nodes.DefineRap) -> Iterator[tuple[str, nodes.SensorName]]:
    """Yield the inputs for which a method is there if they have no sensor name."""
    inputs = {variable.name for variable in rap.inputs}
    for method in rap.methods:
        for one in literals(method.context):
            test = one.formula
            if isinstance(test, nodes.SensorName) and isinstance(test.item, nodes.Var):
                value = test.value
                false = isinstance(value, nodes.Const) and value.value == "false"
                if one.holds is false and test.item.name in inputs:
                    yield test.item.name, test


def _unnamed(
    method: nodes.Method, unknown: dict[str, nodes.SensorName], *, alone: bool
) -> Iterator[Diagnostic]:
    told: set[str] = set()
    for term in _asked_for(method, alone=alone):
        if not isinstance(term, nodes.Var) or term.name in told:
            continue
        if term.name in unknown:
            told.add(term.name)
            yield UNNAMED.at(
                term.span,
                f"the sensors may have no name for `{term.name}` here",
                labels=(
                    Label(unknown[term.name].span, "there is a method for that case"),
                ),
                help=f"ask `(know-sensor-name {term.name} true)` in the context",
            )


_ENOUGH = 3
"""More methods than this show by their number that each should ask."""


def _asked_for(method: nodes.Method, *, alone: bool) -> Iterator[nodes.Term]:
    """Yield what a method needs a sensor name for.

    What its steps need is for their RAPs to ask; but where all other methods ask for it
    already, and this one is alone, it is no exception.
    """
    if isinstance(method.body, nodes.Primitive):
        yield from method.body.request.args
    elif alone:
        for step in steps(method):
            yield from step.goal.args


def _asks(rap: nodes.DefineRap, method: nodes.Method) -> bool:
    """Whether a method, or what holds for all of them, asks for a sensor name."""
    asked = [*clauses.held(clauses.METHOD, method), *clauses.held(clauses.RAP, rap)]
    return any(
        isinstance(part, nodes.SensorName | nodes.Otherwise)
        for clause, formula in asked
        if clause.required
        for part in subformulas(formula)
    )
