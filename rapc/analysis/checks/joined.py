"""RAP107: facts that hold together because nothing is known of either [L 2.22]."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.bindings import whole_formulas
from rapc.analysis.facts.logic import Literal, literals
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.walk import variable_names, variables

JOINED = Rule(
    code="RAP107",
    name="joined-by-unknown",
    severity=Severity.INFO,
    opt_in=True,
    summary="two properties are to have the same value, which may be `unknown`",
    why="""A property of which nothing is known has its default, and that binds a
variable like any value [L 2.22]. So two things of which nobody knows where they are
lie at the same place, `unknown`. Ask that the value is none. Where something is always
known of one of the two the test is not needed; the rule is opt-in for that reason.""",
    ignore="where something is always known of one of the two",
    source="T 2.2.2",
    example="""\
(declare-memory-property place-of (?thing ?place) unknown)
(declare-primitive join (?one ?other) (okay))
(define-rap (put-together ?one ?other)
  (method
    (context (and (place-of ?one ?here) (place-of ?other ?here)))
    (primitive (join ?one ?other))))
""",
    better="""\
(declare-memory-property place-of (?thing ?place) unknown)
(declare-primitive join (?one ?other) (okay))
(define-rap (put-together ?one ?other)
  (method
    (context (and (place-of ?one ?here) (n= ?here unknown) (place-of ?other ?here)))
    (primitive (join ?one ?other))))
""",
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
        parts = list(literals(waiting.pop()))
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
    """Yield the second of two properties with one value, if nothing else asks of it.

    Args:
        run: the run of the pass.
        parts: a conjunction.
        given: the variables that may have values before it is asked.
        elsewhere: the variables that something else in the formula asks for.
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
                f"`{value}` may be `unknown` here, and equal for that alone",
                labels=(Label(other.span, "the other one"),),
                help=f"ask `(n= {value} unknown)` as well",
            )


def _value(run: Pass, part: Literal) -> str | None:
    """The variable that takes the value of a property whose default is `unknown`."""
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
