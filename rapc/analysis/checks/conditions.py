"""RAP110: formulas that never hold, whatever happens.

A conjunction is taken apart into literals (`rapc.analysis.facts.logic`), of which two
never hold together; each branch of an `or` is asked with what stands around it.

RAP117: what is said twice in one `and` or `or`.

RAP107: facts that hold together because nothing is known of either [L 2.22].

RAP108: comparisons whose answer stands in the text [L 2].

RAP153: requests about items that the sensors may have no name for (T 2.3.2).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable, Iterator, Sequence
from typing import NamedTuple

from rapc.analysis.check import Fact, Pass, check
from rapc.analysis.facts.bindings import Bound, whole_formulas
from rapc.analysis.facts.index import INDEX, Index
from rapc.analysis.facts.logic import (
    Clash,
    Conjunction,
    Literal,
    holds_between,
    literals,
    may_clash,
    number_of,
)
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.base.values import Number
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import steps, subformulas, variable_names, variables, ways

CONTRADICTION = Rule(
    code="RAP110",
    name="contradiction",
    severity=Severity.WARNING,
    summary="two parts of a formula never hold together",
    why="""A property has one value at a time; what is asked cannot be denied as well;
no number is below 3 and above 5. A conjunction, or a branch of an `or`, with two such
parts never holds, whatever happens: mostly `or` was meant, or one of the two speaks of
another thing (T 4.1).""",
    ignore="where a method is switched off on purpose: write `nil` as its context",
    source="T 4.1.3",
    example="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (and (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
    better="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (or (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
)


class Contradiction(NamedTuple):
    """A formula of a clause that never holds, and what in it contradicts what."""

    formula: nodes.Formula
    clash: Clash


def _run(run: Pass) -> Sequence[Contradiction]:
    return [
        Contradiction(formula, clash)
        for form in run.library.forms
        for formula, given in whole_formulas(form, run.library.functions)
        for clash in _contradictions(run, formula, given)
    ]


CONTRADICTIONS = Fact(_run)
"""The contradictions in clauses, in the order of the text."""


@check(CONTRADICTION, needs_whole="form")
def contradictions(run: Pass) -> Iterable[Diagnostic]:
    """Find formulas that never hold, whatever happens."""
    every = run.result(CONTRADICTIONS)
    return one_for_each_place(_contradiction(one.clash) for one in every)


def one_for_each_place(found: Iterable[Diagnostic]) -> Iterable[Diagnostic]:
    """Return the first finding at each place."""
    first: dict[Span, Diagnostic] = {}
    for one in found:
        first.setdefault(one.span, one)
    return first.values()


def clash_at(rule: Rule, message: str, span: Span, label: Label) -> Diagnostic:
    """Return a finding with a label, unless that is about the same place."""
    return rule.at(span, message, labels=(label,) if label.span != span else ())


class _Asked(NamedTuple):
    """A formula with what is asked together with it."""

    formula: nodes.Formula
    #: The variables that may have values before all of that.
    given: Container[str]
    before: Sequence[Literal] = ()
    behind: Sequence[Literal] = ()


def _contradictions(
    run: Pass, formula: nodes.Formula, given: Container[str]
) -> Iterator[Clash]:
    """Yield what never holds in a formula.

    Args:
        run: the pass.
        formula: the formula.
        given: the variables that may have values before it is asked.
    """
    if not isinstance(formula, _JOINED):
        return
    waiting = [_Asked(formula, given)]
    while waiting:
        here = waiting.pop()
        own = list(literals(here.formula))
        after = [*own, *here.behind]
        clash = first_clash(run, here.before, after, here.given)
        if clash is not None:
            if any(clash.second is one for one in here.behind):
                clash = Clash(clash.second, clash.first)
            if any(clash.second is one for one in own):
                yield clash
            continue
        for at, literal in enumerate(own):
            inner = literal.formula
            if not isinstance(inner, _JOINED):
                continue
            before = [*here.before, *own[:at]]
            if literal.holds:
                asked = _Asked(inner, here.given, before, after[at + 1 :])
            else:
                asked = _Asked(inner, _bound_by(here.given, before))
            waiting += [asked._replace(formula=w) for w in reversed(ways(inner))]


def _bound_by(given: Container[str], before: Iterable[Literal]) -> Container[str]:
    """The variables that may have values behind some literals."""
    held = [set(variable_names(one.formula)) for one in before if one.holds]
    return Bound(given, set().union(*held)) if held else given


_JOINED = (nodes.And, nodes.Or, nodes.Not)
"""What other formulas are put together by."""


def first_clash(
    run: Pass,
    held: Sequence[Literal],
    own: Sequence[Literal],
    given: Container[str],
) -> Clash | None:
    """Return the first of some literals that contradicts another.

    Args:
        run: the run of the pass.
        held: literals that hold, and do not contradict each other.
        own: the literals that are put to them, one after another.
        given: the variables that may have values before all of them.
    """
    if not may_clash([*held, *own]):
        return None
    made = Conjunction(run.signatures.relations, given)
    for literal in held:
        made.add(literal)
    for literal in own:
        clash = made.add(literal)
        if clash is not None:
            return clash
    return None


def _contradiction(clash: Clash) -> Diagnostic:
    return clash_at(
        CONTRADICTION,
        f"{said(clash.second)} and {said(clash.first)} never hold together",
        clash.second.span,
        Label(clash.first.span, "asked here" if clash.first.holds else "denied here"),
    )


def said(literal: Literal) -> str:
    """Return what a literal says, shortened, in back-ticks."""
    text = format_formula(literal.formula)
    if len(text) > _LONG:
        text = text[:_LONG] + "..."
    return f"`{text}`" if literal.holds else f"`(not {text})`"


_LONG = 50
"""How many letters of a formula are told."""


TWICE = Rule(
    code="RAP117",
    name="said-twice",
    severity=Severity.WARNING,
    summary="an `and` or `or` has the same part twice",
    why="""The second one asks nothing new. It was mostly copied to be changed: another
argument or another fact was meant, and that is not asked.""",
    fix="safe: takes the second one away",
    ignore="never: the second one asks nothing",
    source="T 4.1.3",
    example="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive drive (?from ?to) (okay))
(define-rap (pass ?one ?other)
  (method
    (context (and (door ?one open) (door ?one open)))
    (primitive (drive ?one ?other))))
""",
    better="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive drive (?from ?to) (okay))
(define-rap (pass ?one ?other)
  (method
    (context (and (door ?one open) (door ?other open)))
    (primitive (drive ?one ?other))))
""",
)


@check(TWICE)
def said_twice(run: Pass) -> Iterator[Diagnostic]:
    """Find parts of an `and` or `or` that say the same."""
    index = run.result(INDEX)
    for conjunction in index.of(nodes.And):
        yield from _look(run, conjunction.node.parts, joined=True)
    for choice in index.of(nodes.Or):
        yield from _look(run, choice.node.parts, joined=False)


def _look(
    run: Pass, parts: tuple[nodes.Formula, ...], *, joined: bool
) -> Iterator[Diagnostic]:
    if len({_head(part) for part in parts}) == len(parts):
        return
    first: dict[nodes.Formula, nodes.Formula] = {}
    for at, part in enumerate(parts):
        other = first.setdefault(part, part)
        if other is part or (joined and _is_another(run, parts[:at], part)):
            continue
        whole = Span(part.span.file, parts[at - 1].span.end, part.span.end)
        fix = Fix(Applicability.SAFE, "take it away", (Edit(whole, ""),))
        yield TWICE.at(
            part.span,
            f"`{format_formula(part)}` is said already",
            labels=(Label(other.span, "here"),),
            fix=fix,
        )


def _is_another(
    run: Pass, before: Sequence[nodes.Formula], part: nodes.Formula
) -> bool:
    """Whether a part may mean something else than the same one before it.

    A `not` may be about one thing that was bound in between, and before about all: a
    default, or a query, may hold of that one though it holds of none [L 2.21]. An age
    that a `believe` has bound is a bound behind it [L 2.56].
    """
    if isinstance(part, nodes.Believe):
        return isinstance(part.age, nodes.Var) and not part.age.anonymous
    if not isinstance(part, nodes.Not):
        return False
    at = before.index(part)
    late = set(_bound(before[at:])) - set(_bound(before[:at]))
    relations = run.signatures.relations
    return not late.isdisjoint(variable_names(part)) and any(
        isinstance(one, nodes.SensorName)
        or (
            isinstance(one, nodes.Proposition)
            and (one.name not in relations or relations[one.name].is_property)
        )
        for one in subformulas(part)
    )


def _bound(parts: Sequence[nodes.Formula]) -> Sequence[str]:
    return variable_names(*[one for one in parts if not isinstance(one, nodes.Not)])


def _head(part: nodes.Formula) -> object:
    """Return what two parts that say the same have in common, and few others."""
    return part.name if type(part) is nodes.Proposition else type(part)


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


SETTLED_COMPARISON = Rule(
    code="RAP108",
    name="settled-comparison",
    severity=Severity.WARNING,
    summary="a comparison holds always, or never, as it is written",
    why="""Two constants, or a variable and the same one with a number added, compare in
one way whatever happens; so do the age of a belief, a number, and a word. Mostly one of
the two was to be another variable: a test is missing, or stands in the way of all that
depends on it.""",
    ignore="never: write `true` or `nil` if that is meant",
    source="T 4.1",
    example="""\
(declare-memory-property tank (?level) unknown)
(declare-memory-property room-for (?litres) unknown)
(define-query (tank-full)
  (and (tank ?level) (room-for ?litres) (> (+ ?level 5) ?level)))
""",
    better="""\
(declare-memory-property tank (?level) unknown)
(declare-memory-property room-for (?litres) unknown)
(define-query (tank-full)
  (and (tank ?level) (room-for ?litres) (> (+ ?level 5) ?litres)))
""",
)


@check(SETTLED_COMPARISON)
def settled_comparison(run: Pass) -> Iterator[Diagnostic]:
    """Find comparisons whose answer stands in the text."""
    index = run.result(INDEX)
    of_ages = {id(test): holds for test, holds in _tests_of_ages(index)}
    for use in index.of(nodes.Compare):
        holds = _answer(use.node)
        if holds is None:
            holds = of_ages.get(id(use.node))
        if holds is not None:
            yield SETTLED_COMPARISON.at(
                use.node.span,
                f"`{format_formula(use.node)}` {'always' if holds else 'never'} holds",
                help="compare with something else, or leave it out",
            )


def _answer(test: nodes.Compare) -> bool | None:
    """Return what a comparison comes to whatever happens; None if that depends."""
    one, first = _apart(test.left)
    other, second = _apart(test.right)
    if isinstance(one, nodes.Const) and isinstance(other, nodes.Const):
        equal = one.value == other.value
        return {"=": equal, "n=": not equal}.get(test.op)
    if type(one) is not type(other) or one != other:
        return None
    if one is not None and (not isinstance(one, nodes.Var) or one.anonymous):
        return None
    return holds_between(test.op, first, second)


def _tests_of_ages(index: Index) -> Iterator[tuple[nodes.Compare, bool]]:
    """Yield comparisons of an age, behind its `believe`, with a constant that is none.

    Yields:
        the comparison, and whether it holds.
    """
    if not index.of(nodes.Believe):
        return
    for use in index.of(nodes.And):
        ages: set[str] = set()
        for literal in literals(use.node):
            belief = literal.formula
            if isinstance(belief, nodes.Believe):
                if literal.holds and isinstance(belief.age, nodes.Var):
                    ages.add(belief.age.name)
                continue
            for test in subformulas(belief) if ages else ():
                if isinstance(test, nodes.Compare) and _is_age_and_word(test, ages):
                    holds = {"n=": True, "=": False}.get(test.op)
                    if holds is not None:
                        yield test, holds


def _is_age_and_word(test: nodes.Compare, ages: Container[str]) -> bool:
    """Whether an age, which is a number, is compared with a constant that is none."""
    return any(
        isinstance(one, nodes.Var)
        and one.name in ages
        and isinstance(other, nodes.Const)
        and number_of(other) is None
        for one, other in ((test.left, test.right), (test.right, test.left))
    )


def _apart(term: nodes.Term) -> tuple[nodes.Term | None, Number]:
    """Return a term without a number that is added to it, and that number.

    A number alone is nothing and that number.
    """
    alone = number_of(term)
    if alone is not None:
        return None, alone
    if isinstance(term, nodes.Call) and term.function in _ADDING:
        left, right = term.args[0], term.args[-1]
        added = number_of(right)
        if added is not None:
            return left, added if term.function == "+" else -added
        added = number_of(left)
        if added is not None and term.function == "+":
            return right, added
    return term, 0


_ADDING = ("+", "-")
"""What adds a number to a term, or takes one away."""


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
        alone = len(silent) == 1 and len(rap.methods) > THRESHOLDS.unnamed_item
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
