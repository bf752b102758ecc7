"""RAP107, RAP153: formulas that do not consider an unknown value.

A property without a known value has the value `unknown`, and an item out of sight has
no sensor name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.bindings import whole_formulas
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.logic import Literal, literals
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import clauses, nodes
from rapc.ir.walk import steps, subformulas, variable_names, variables

JOINED = Rule(
    code="RAP107",
    name="joined-by-unknown",
    severity=Severity.INFO,
    opt_in=True,
    summary="two properties are compared for equality, and both may be `unknown`",
    ignore="where one of the two values is always known",
    source="T 2.2.2",
)


@check(JOINED)
def joined(run: Pass) -> Iterator[Diagnostic]:
    """Find properties that share a value that may be unknown."""
    for form in run.library.forms:
        for formula, given in whole_formulas(form, run.library.functions):
            often = Counter(variable.name for variable in variables(formula))
            for parts in _conjunctions(formula):
                own = variables(*[part.formula for part in parts])
                here = Counter(variable.name for variable in own)
                beside = {name for name in here if often[name] > here[name]}
                yield from _joined(run, parts, given, beside)


def _conjunctions(formula: nodes.Formula) -> Iterator[Sequence[Literal]]:
    """Yield the conjunctions in a formula, each as its literals."""
    waiting = [formula]
    while waiting:
        parts = literals(waiting.pop())
        if len(parts) > 1:
            yield parts
        for part in parts:
            if isinstance(part.formula, nodes.Or):
                waiting += part.formula.parts
            elif isinstance(part.formula, nodes.And | nodes.Not):
                waiting.append(part.formula)


def _joined(
    run: Pass, parts: Sequence[Literal], given: Container[str], elsewhere: set[str]
) -> Iterator[Diagnostic]:
    """Yield the second of two properties with one value and without further tests.

    Args:
        run: the pass.
        parts: a conjunction.
        given: the variables that may have values before the conjunction.
        elsewhere: the variables that other parts of the formula use.
    """
    first: dict[str, nodes.Proposition] = {}
    pairs: list[tuple[nodes.Proposition, nodes.Proposition, str]] = []
    for part in parts:
        value = _value(run, part)
        if value is None:
            elsewhere.update(variable_names(part.formula))
            continue
        fact = part.formula
        assert isinstance(fact, nodes.Proposition)
        elsewhere |= {a.name for a in fact.args[:-1] if isinstance(a, nodes.Var)}
        other = first.setdefault(value, fact)
        if other is not fact:
            pairs.append((other, fact, value))
    for other, fact, value in pairs:
        if value not in elsewhere and value not in given:
            yield JOINED.at(
                fact.span,
                f"`{value}` may be `unknown` and equal for this reason alone",
                labels=(Label(other.span, "the other property"),),
                help=f"add `(n= {value} unknown)`",
            )


def _value(run: Pass, part: Literal) -> str | None:
    """Return the variable with the value of a property whose default is `unknown`."""
    fact = part.formula
    if not part.holds or not isinstance(fact, nodes.Proposition) or not fact.args:
        return None
    declared = run.signatures.relations.get(fact.name)
    last = fact.args[-1]
    if declared is None or not declared.is_property or declared.default != "unknown":
        return None
    if declared.most != len(fact.args) or not isinstance(last, nodes.Var):
        return None
    return None if last.anonymous else last.name


UNNAMED = Rule(
    code="RAP153",
    name="unnamed-item",
    severity=Severity.WARNING,
    summary="a request names an item that may have no sensor name",
    ignore="where the item is in sight whenever the method is chosen",
    source="T 2.3.2",
)


@check(UNNAMED, needs_whole="form")
def unnamed_item(run: Pass) -> Iterator[Diagnostic]:
    """Find requests about items without a condition on the item's sensor name."""
    asked = run.result(INDEX).of(nodes.SensorName)
    for rap in run.library.raps.values() if asked else ():
        unknown = dict(_unknown(rap))
        if not unknown:
            continue
        silent = [method for method in rap.methods if not _asks(rap, method)]
        alone = len(silent) == 1 and len(rap.methods) > THRESHOLDS.unnamed_item
        for method in silent:
            yield from _unnamed(method, unknown, alone=alone)


def _unknown(rap: nodes.DefineRap) -> Iterator[tuple[str, nodes.SensorName]]:
    """Yield the inputs for which a method handles a missing sensor name."""
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
                f"`{term.name}` may have no sensor name here",
                labels=(
                    Label(
                        unknown[term.name].span,
                        "this method covers an item without a sensor name",
                    ),
                ),
                help=f"add `(know-sensor-name {term.name} true)` to the context",
            )


def _asked_for(method: nodes.Method, *, alone: bool) -> Iterator[nodes.Term]:
    """Yield the terms for which a method needs a sensor name.

    The called RAPs check the terms of steps. If all other methods check the sensor name
    and only this method does not (`alone`), the terms of its steps count, too.
    """
    if isinstance(method.body, nodes.Primitive):
        yield from method.body.request.args
    elif alone:
        for step in steps(method):
            yield from step.goal.args


def _asks(rap: nodes.DefineRap, method: nodes.Method) -> bool:
    """Return whether a method, or a clause for all methods, tests a sensor name."""
    asked = [*clauses.held(clauses.METHOD, method), *clauses.held(clauses.RAP, rap)]
    return any(
        isinstance(part, nodes.SensorName | nodes.Otherwise)
        for clause, formula in asked
        if clause.required
        for part in subformulas(formula)
    )


BELIEVED_UNKNOWN = Rule(
    code="RAP173",
    name="believed-unknown",
    severity=Severity.WARNING,
    summary="the default `unknown` of a property counts as a fresh belief",
    ignore="where something always asserts a value before the formula is evaluated",
    source="T 4.1.1",
)


@check(BELIEVED_UNKNOWN)
def believed_unknown(run: Pass) -> Iterator[Diagnostic]:
    """Find beliefs of any value of a property whose default is `unknown`."""
    for form in run.library.forms:
        if isinstance(form, nodes.DefineRap | nodes.DefineQuery | nodes.MemoryRule):
            for formula, given in whole_formulas(form, run.library.functions):
                yield from _beliefs(run, form, formula, given)


def _beliefs(
    run: Pass, form: nodes.Node, formula: nodes.Formula, given: Container[str]
) -> Iterator[Diagnostic]:
    every = list(subformulas(formula))
    asked = {
        one.name
        for one in every
        if isinstance(one, nodes.Proposition) and one.args[-1:] == (_UNKNOWN,)
    }
    for one in every:
        if not isinstance(one, nodes.Believe) or not _may_be_unknown(run, one):
            continue
        value = one.pattern.args[-1]
        if not isinstance(value, nodes.Var) or one.pattern.name in asked:
            continue
        if not value.anonymous and (
            value.name in given or _is_used(form, value, every)
        ):
            continue
        name = "?x" if value.anonymous else value.name
        yield BELIEVED_UNKNOWN.at(
            one.pattern.span,
            f"the default of `{one.pattern.name}` is `unknown`, and is believed at any "
            "age",
            help=f"name the value and add `(n= {name} unknown)`",
        )


def _may_be_unknown(run: Pass, one: nodes.Formula) -> bool:
    """Return whether a formula is a belief with an age and an unknown default."""
    if not isinstance(one, nodes.Believe) or isinstance(one.age, nodes.Var):
        return False
    declared = run.signatures.relations.get(one.pattern.name)
    return (
        declared is not None
        and declared.is_property
        and declared.default == "unknown"
        and len(one.pattern.args) == declared.most
    )


def _is_used(
    form: nodes.Node, value: nodes.Var, every: Sequence[nodes.Formula]
) -> bool:
    """Return whether anything but `n=` with another constant needs a known value."""
    tests = [
        one
        for one in every
        if isinstance(one, nodes.Compare)
        and one.op == "n="
        and one.left == value
        and isinstance(one.right, nodes.Const)
    ]
    if any(one.right == _UNKNOWN for one in tests):
        return True
    often = sum(1 for variable in variables(form) if variable == value)
    return often > len(tests) + 1


_UNKNOWN = nodes.Const("unknown")
