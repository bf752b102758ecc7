"""RAP108, RAP112 to RAP116, RAP182, RAP183, RAP193: constant conditions.

A property with a default always has a value: a fact that queries the property with a
new variable always holds [L 2.20]. Identical methods are reported here, too.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from itertools import pairwise, permutations

from rapc.analysis.check import Pass, RapFact, check
from rapc.analysis.facts.effects import does_nothing, may_end
from rapc.analysis.facts.index import INDEX, Index, Occurrence
from rapc.analysis.facts.logic import (
    Always,
    Literal,
    apart,
    follows,
    implies,
    is_never,
    literals,
    number_of,
    turned,
)
from rapc.analysis.facts.resources import FirstValues
from rapc.analysis.facts.usage import USAGE, Place
from rapc.base.diagnostics import (
    Diagnostic,
    Label,
    Rule,
    Severity,
    Subject,
)
from rapc.base.values import Number, holds_between
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import (
    formulas,
    given_names,
    steps,
    subformulas,
    variable_names,
    ways,
)

COPY = Rule(
    code="RAP112",
    name="copied-method",
    severity=Severity.WARNING,
    summary="two methods of a RAP are equal",
    ignore="where the second method is a second try",
    source="T 3.2.2",
)

AT_ONCE = Rule(
    code="RAP113",
    name="succeeds-at-once",
    severity=Severity.WARNING,
    summary="a RAP has succeeded before any of its methods can be chosen",
    ignore="never: remove the methods if the RAP must do nothing",
    source="T 3.2.3",
)

NEVER = Rule(
    code="RAP114",
    name="never-succeeds",
    severity=Severity.WARNING,
    summary="a RAP can never succeed and has no monitor",
    ignore="where the task must run until it fails as futile, for example in a test",
    source="T 4.7.1",
)

ALWAYS = Rule(
    code="RAP115",
    name="monitor-always-holds",
    severity=Severity.WARNING,
    summary="a monitor always holds, so no task waits",
    ignore="never: remove the monitor if the task must not wait",
    source="T 4.7.1",
)

NOT_AT_FIRST = Rule(
    code="RAP116",
    name="never-begins",
    severity=Severity.WARNING,
    summary="a clause does not hold for any new task, so no method begins",
    ignore="where a host fills the set or sets the counter before the task begins",
    source="T 4.8.1",
)


NEEDLESS_NEED = Rule(
    code="RAP182",
    name="idle-precondition",
    severity=Severity.WARNING,
    summary="a precondition that each new task meets",
    ignore="where a task must end when its own counter has a value",
    source="T 4.6",
)


@check(COPY, AT_ONCE, NEVER, ALWAYS, NOT_AT_FIRST, NEEDLESS_NEED, needs_whole="form")
def settled(run: Pass) -> Iterator[Diagnostic]:
    """Find identical methods, and clauses with a constant result."""
    awaited = {
        step.goal.name
        for rap in run.library.raps.values()
        for method in rap.methods
        for step in steps(method)
        if not any(map(may_end, step.annotations))
    }
    for rap in run.library.forms:
        if not isinstance(rap, nodes.DefineRap):
            continue
        yield from run.of(SETTLED, rap)
        if rap.methods or rap.succeed is None or rap.name not in awaited:
            continue
        if is_never(rap.succeed) and not _waits(rap):
            yield _never_succeeds(rap, rap.succeed)


def _of_rap(run: Pass, rap: nodes.DefineRap) -> Sequence[Diagnostic]:
    given = given_names(rap)
    found = list(_without_a_wait(run, rap, given))
    if rap.methods:
        found += _copies(rap)
        found += _settled(rap, Always(run.signatures), given)
    return tuple(found)


SETTLED = RapFact(_of_rap)
"""The findings about the clauses and methods of a RAP alone."""


def _copies(rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    if len(rap.methods) == 1:
        return
    first: dict[object, nodes.Method] = {}
    for method in rap.methods:
        if isinstance(method.body, nodes.TaskNet) and not method.body.steps:
            continue
        other = first.setdefault((method.context, _acts(method)), method)
        if other is not method:
            yield COPY.at(
                method.span,
                f"duplicate method of `{rap.name}`",
                labels=(Label(other.span, "the first method"),),
                help="change or remove the method",
            )

    yield from _equal_denials(rap)
    *others, last = rap.methods
    names = given_names(rap)
    if all(_acts(method) == _acts(last) for method in others):
        retries = any(_asks_history(method.context) for method in rap.methods)
        if (
            len(first) > 1
            and not retries
            and names.issuperset(variable_names(last.body))
        ):
            yield COPY.at(
                last.body.span,
                f"all methods of `{rap.name}` do the same",
                labels=(Label(others[0].body.span, "the first method"),),
                help="change the steps, or join the contexts in one method",
            )
        return
    for one, other in pairwise(rap.methods):
        same = _acts(one) == _acts(other) and one.context != other.context
        if _asks_history(one.context) or _asks_history(other.context):
            continue
        if does_nothing(other):
            continue
        if same and names.issuperset(variable_names(other.body)):
            yield COPY.at(
                other.body.span,
                "this method does the same as the method before it",
                labels=(Label(one.body.span, "the method before"),),
                help="change the steps, or join the two contexts with `or`",
            )


def _equal_denials(rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    """Find methods that all deny the same, so that no method is for the opposite."""
    every = [m.context for m in rap.methods if isinstance(m.context, nodes.Not)]
    required = (rap.monitor_state, rap.repeat_while, rap.preconditions)
    if len(set(every)) != 1 or len(every) < len(rap.methods) or every[0] in required:
        return
    yield COPY.at(
        every[-1].span,
        f"no method of `{rap.name}` is for the opposite of this context",
        labels=(Label(every[0].span, "the same context"),),
        help="change the context, or write it as `preconditions`",
    )


def _asks_history(formula: nodes.Formula | None) -> bool:
    """Return whether a context shows in the trace how often a task has tried."""
    parts = subformulas(formula) if formula is not None else ()
    return any(isinstance(part, nodes.HistoryTest) for part in parts)


def _acts(method: nodes.Method) -> object:
    """Return the parts of a method that determine its actions."""
    return (
        method.notations,
        method.constraints,
        method.claims,
        method.skills,
        method.body,
    )


def _settled(
    rap: nodes.DefineRap, always: Always, given: set[str]
) -> Iterator[Diagnostic]:
    succeed, monitor = rap.succeed, rap.monitor_state
    first = FirstValues(rap.resources)
    yield from _not_at_first(rap, always, given, first)
    yield from _always_met(rap, always, given, first)
    if any(first.holds(way) for way in ways(succeed)):
        assert succeed is not None
        yield AT_ONCE.at(
            succeed.span,
            f"`succeed` of `{rap.name}` holds before any change",
            labels=tuple(
                Label(r.variable.span, "the first value is set here")
                for r in rap.resources
            ),
        )
    elif succeed is not None and always.holds(succeed, given):
        yield AT_ONCE.at(
            succeed.span,
            f"`succeed` of `{rap.name}` always holds",
            help=_ADVICE if not isinstance(succeed, nodes.Truth) else "",
        )
    elif succeed is not None and is_never(succeed) and not _waits(rap):
        yield _never_succeeds(rap, succeed)
    if monitor is not None and always.holds(monitor, given):
        yield ALWAYS.at(
            monitor.span,
            f"the monitor of `{rap.name}` always holds",
            help=_ADVICE if not isinstance(monitor, nodes.Truth) else "",
        )


def _without_a_wait(
    run: Pass, rap: nodes.DefineRap, given: set[str]
) -> Iterator[Diagnostic]:
    """Find a RAP whose `succeed` holds wherever its monitor does not."""
    monitor, goal = rap.monitor_state, rap.succeed
    if monitor is None or goal is None or isinstance(goal, nodes.Truth):
        return
    parts = [one for way in ways(monitor) for one in literals(way)]
    denied = [Literal(one.formula, not one.holds) for one in parts]
    if len(parts) > 1 and not isinstance(monitor, nodes.Or):
        denied = [Literal(monitor, False)]
    for way in ways(goal):
        wanted = apart(way, given, "@goal")
        free = set(variable_names(wanted)) - given
        relations = run.signatures.relations
        if follows(literals(wanted), denied, free, relations, given):
            yield ALWAYS.at(
                monitor.span,
                f"`{rap.name}` never waits: `succeed` holds where the monitor does not",
                labels=(Label(way.span, "the task has succeeded then"),),
                help="query the awaited state in the monitor",
            )
            return


def _always_met(
    rap: nodes.DefineRap, always: Always, given: set[str], first: FirstValues
) -> Iterator[Diagnostic]:
    """Find preconditions that query only the task itself, or hold for any memory."""
    asked, bound = rap.preconditions, set(given)
    if asked is None or isinstance(asked, nodes.Truth) or first.fails(asked):
        return
    used = [one.pattern for one in rap.effects]
    values = [*used, rap.duration] if rap.duration is not None else used
    if not set(variable_names(*values)).isdisjoint({*variable_names(asked)} - given):
        return  # the precondition gives a variable its value
    own = {
        resource.variable.name
        for resource in rap.resources
        if resource.initial is None or number_of(resource.initial) is not None
    }
    for literal in literals(asked):
        names = set(variable_names(literal.formula))
        tested = isinstance(literal.formula, nodes.Compare | nodes.SetTest)
        about_task = tested and not names.isdisjoint(own)
        if not about_task and not (
            literal.holds and always.holds(literal.formula, bound)
        ):
            return
        bound |= names
    yield NEEDLESS_NEED.at(
        asked.span,
        f"each new task of `{rap.name}` meets this precondition, so it has no effect",
        help="write a limit of the rounds in `repeat-while`, or query the state that "
        "the methods require",
    )


def _never_succeeds(rap: nodes.DefineRap, goal: nodes.Formula) -> Diagnostic:
    return NEVER.at(
        goal.span,
        f"`{rap.name}` never succeeds, and has no monitor",
        help="add the awaited state to `monitor-state`, or a time to `monitor-time`",
    )


def _denied(
    formula: nodes.Formula, always: Always, given: set[str], first: FirstValues
) -> Literal | None:
    """Return a denied literal whose formula holds for a new task, if any."""
    for literal in literals(formula):
        inner = literals(literal.formula)
        bound = set(given)
        found = []
        for one in () if literal.holds else inner:
            known = first.holds(one.formula) or always.holds(one.formula, bound)
            found.append(one.holds and known)
            bound.update(variable_names(one.formula))
        if found and all(found):
            return literal
    return None


def _not_at_first(
    rap: nodes.DefineRap, always: Always, given: set[str], first: FirstValues
) -> Iterator[Diagnostic]:
    for clause, formula in clauses.held(clauses.RAP, rap):
        failing = (
            first.fails(formula) or _denied(formula, always, given, first)
            if clause.is_condition
            else None
        )
        if failing is not None:
            yield NOT_AT_FIRST.at(
                failing.span,
                f"`{clause.word}` of `{rap.name}` does not hold for a new task, "
                "so no method begins",
                labels=tuple(
                    Label(r.variable.span, "the first value is set here")
                    for r in rap.resources
                ),
            )


_ADVICE = "a property has a value even if nothing is known: query the value"


def _waits(rap: nodes.DefineRap) -> bool:
    """Return whether a RAP has a monitor, or each method waits for a signal or time."""
    if rap.monitor_state is not None or rap.monitor_time is not None:
        return True
    return bool(rap.methods) and all(
        any(
            isinstance(annotation, nodes.Window)
            or (isinstance(annotation, nodes.WaitFor) and annotation.mode != "fail")
            for step in steps(method)
            for annotation in step.annotations
        )
        for method in rap.methods
    )


IDLE_PART = Rule(
    code="RAP183",
    name="idle-part",
    severity=Severity.WARNING,
    summary="a part of an `and` or `or` has no effect on the result",
    ignore="where the part is to be filled in: write a comment",
    source="T 4.1",
)


@check(IDLE_PART, needs_whole="form")
def idle_parts(run: Pass) -> Iterator[Diagnostic]:
    """Find parts of conditions that hold always and bind no variable in use."""
    always, named = Always(run.signatures), run.result(INDEX).variables()
    for rap, names in named:
        if isinstance(rap, nodes.DefineQuery):
            arguments = {argument.variable.name for argument in rap.args}
            yield from _idle(rap.formula, always, arguments, names)
        elif isinstance(rap, nodes.DefineRap):
            given = given_names(rap)
            for whole in formulas(rap):
                if whole.clause.word != "repeat-while":
                    yield from _idle(whole.formula, always, given, names)


def _idle(
    formula: nodes.Formula,
    always: Always,
    given: set[str],
    names: Mapping[str, Collection[object]],
) -> Iterator[Diagnostic]:
    for whole in subformulas(formula):
        if isinstance(whole, nodes.And):
            yield from _implied(whole)
        for part in whole.parts if isinstance(whole, nodes.And | nodes.Or) else ():
            joined = isinstance(whole, nodes.And)
            if isinstance(part, nodes.Truth):
                if part.value:
                    yield _idle_part(part if joined else whole, "always holds")
                elif not joined:
                    yield _idle_part(part, "never holds")
                continue
            if joined and type(part) is nodes.Proposition and always.holds(part, given):
                own = set(variable_names(part)) - given
                if all(len(names[name]) == 1 for name in own):
                    yield _idle_part(part, "always holds")


def _implied(whole: nodes.And) -> Iterator[Diagnostic]:
    """Find a comparison with a number that another comparison implies."""
    tests = [turned(one) for one in whole.parts if isinstance(one, nodes.Compare)]
    for one, other in permutations([test for test in tests if test.op != "n="], 2):
        if one.left == other.left and one != other and implies(one, other):
            yield IDLE_PART.at(
                other.span,
                f"`{format_formula(other)}` follows from `{format_formula(one)}`",
                labels=(Label(one.span, "this comparison is stronger"),),
                help="change one of the comparisons, or remove the weaker one",
            )


def _idle_part(part: nodes.Formula, how: str) -> Diagnostic:
    return IDLE_PART.at(
        part.span,
        f"`{format_formula(part)}` {how}",
        help="query the value that is meant, or remove the part",
        about=tuple(Subject(part.span, name) for name in variable_names(part)),
    )


NEGATIVE = Rule(
    code="RAP195",
    name="negative-number",
    severity=Severity.WARNING,
    summary="a comparison requires a negative number, but no known number is negative",
    ignore="where the world sends negative numbers",
    source="T 4.1",
)


@check(NEGATIVE)
def negative_numbers(run: Pass) -> Iterator[Diagnostic]:
    """Find comparisons with a number below 0, at a place with 0 and no such number.

    Only numbers of facts count. A form that also compares with `>` tells the signs
    apart.
    """
    usage = run.result(USAGE)
    for use in run.result(INDEX).of(nodes.Compare):
        test = turned(use.node)
        if test.op != "<" or number_of(test.right) != 0:
            continue
        if not isinstance(test.left, nodes.Var):
            continue
        places = usage.of(use.owner, test.left.name)
        others = [
            number
            for place in places
            for one in usage.at(place)
            if one.count
            if (number := number_of(one.const)) is not None
        ]
        if 0 in others and min(others) == 0 and not _tests_sign(run, use, places):
            yield NEGATIVE.at(
                use.node.span,
                f"`{format_formula(use.node)}` requires a negative number, but the "
                "lowest known number is 0",
                help="write `>`, if positive numbers are meant",
            )


def _tests_sign(
    run: Pass, use: Occurrence[nodes.Compare], places: Collection[Place]
) -> bool:
    """Return whether the form around a comparison also tests for numbers above 0."""
    usage = run.result(USAGE)
    for other in run.result(INDEX).of(nodes.Compare):
        test = turned(other.node)
        if other.owner is not use.owner or test.op not in (">", ">="):
            continue
        if isinstance(test.left, nodes.Var) and number_of(test.right) == 0:
            there = usage.of(other.owner, test.left.name)
            if not set(there).isdisjoint(places):
                return True
    return False


UNCOMPARED = Rule(
    code="RAP193",
    name="uncompared-number",
    severity=Severity.WARNING,
    summary="a monitor, goal or condition binds a number that nothing compares",
    ignore="never: write `?` for any number",
    source="T 4.1",
)


@check(UNCOMPARED, needs_whole="form")
def uncompared_numbers(run: Pass) -> Iterator[Diagnostic]:
    """Find numbers that a clause binds for itself and does not use."""
    usage = run.result(USAGE)
    for variable, parent, rap in run.result(INDEX).used_once():
        if (
            not isinstance(rap, nodes.DefineRap)
            or type(parent) is not nodes.Proposition
        ):
            continue
        if parent.args[-1] is not variable or parent.name not in run.library.properties:
            continue
        clause = _local_clause(rap, variable)
        if clause and usage.kinds(list(usage.of(rap, variable.name))) == ("number",):
            yield UNCOMPARED.at(
                variable.span,
                f"nothing compares the number `{variable.name}` of `{clause}`",
                help="compare the number, or write `?` for any number",
                about=(Subject(variable.span, variable.name),),
            )


def _local_clause(rap: nodes.DefineRap, variable: nodes.Var) -> str:
    """Return the clause of a RAP with a variable; empty if its bindings are kept."""
    for clause, formula in clauses.held(clauses.RAP, rap):
        inside = formula.span.start <= variable.span.start < formula.span.end
        if inside and not clause.hands_on:
            return clause.word
    return ""


SETTLED_COMPARISON = Rule(
    code="RAP108",
    name="settled-comparison",
    severity=Severity.WARNING,
    summary="a comparison is always true or never true",
    ignore="never: write `true` or `nil` if this is meant",
    source="T 4.1",
)


@check(SETTLED_COMPARISON)
def settled_comparison(run: Pass) -> Iterator[Diagnostic]:
    """Find comparisons with a constant result."""
    index = run.result(INDEX)
    of_ages = {id(test): holds for test, holds in _tests_of_ages(index)}
    for use in index.of(nodes.Compare):
        holds = _answer(use.node)
        if holds is None:
            holds = of_ages.get(id(use.node))
        if holds is not None:
            yield SETTLED_COMPARISON.at(
                use.node.span,
                f"`{format_formula(use.node)}` is "
                f"{'always' if holds else 'never'} true",
                help="compare with another value, or remove the comparison",
            )


def _answer(test: nodes.Compare) -> bool | None:
    """Return the constant result of a comparison; None if the result depends."""
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
    """Yield comparisons of an age with a constant that is not an age.

    Yields:
        the comparison, and whether the comparison holds.
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
    """Return whether an age is compared with a constant that is not a number."""
    return any(
        isinstance(one, nodes.Var)
        and one.name in ages
        and isinstance(other, nodes.Const)
        and number_of(other) is None
        for one, other in ((test.left, test.right), (test.right, test.left))
    )


def _apart(term: nodes.Term) -> tuple[nodes.Term | None, Number]:
    """Return a term without the number added to the term, and that number.

    For a number alone, the term is None.
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
"""The functions that add a number to a term or subtract a number."""
