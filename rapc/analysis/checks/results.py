"""RAP022, RAP152, RAP154, RAP156: results and events of tasks [T 4.1.2] [L 3.54].

The possible results of a task are `okay`, the reasons of the interpreter and the
results of declared primitives. If an event fails a primitive or a step, the result is
the event's name without its colon. A task stores the results of its own methods.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import EFFECTS, Effects
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.analysis.facts.logic import literals
from rapc.analysis.facts.names import UnknownNames, declared_at, renaming
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Suggestions
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.language.results import RESULTS
from rapc.library.library import Library
from rapc.library.signatures import Fault

UNKNOWN = Rule(
    code="RAP022",
    name="unknown-result",
    severity=Severity.ERROR,
    summary="a query, a script or a declaration has an unknown result",
    fix="unsafe: writes the similar name, if there is one",
    source="T 4.1.2",
)


@check(UNKNOWN)
def unknown_result(run: Pass) -> Iterator[Diagnostic]:
    """Find conditions on results that cannot occur."""
    known = {*RESULTS, *(name.removeprefix(":") for name in run.library.events)}
    known.update(*map(_results, run.library.primitives.values()))
    names = Suggestions(known)
    unknown = UnknownNames(UNKNOWN)
    for constant, owner in _results_asked(run.result(INDEX)):
        value = constant.value
        if not isinstance(value, str) or value not in known:
            message = f"unknown result `{value}`"
            word = str(value)
            help_, meant = names.did_you_mean(word), names.near(word)
            fault = Fault("unknown", message, help_, name=word, meant=meant)
            unknown.add(fault, constant.span, owner)
    yield from unknown.findings(run)
    for row in run.result(INDEX).of(nodes.ScriptRow):
        answered = row.node.kind == "request" and not row.node.refused
        result = row.node.result or "okay"
        wrong = run.signatures.no_result(row.node.request.name, result)
        if wrong is not None and answered:
            yield _no_result(run, row.node, wrong)
    for primitive in run.library.primitives.values():
        for on in primitive.on:
            wrong = run.signatures.no_result(primitive.name, on.result)
            if wrong is not None:
                yield _no_result(run, on, wrong)


def _results_asked(index: Index) -> Iterator[tuple[nodes.Const, Form]]:
    """Yield every constant that stands for a result, with its top-level form."""
    bound: set[tuple[int, str]] = set()
    for use in index.of(nodes.HistoryTest):
        if use.node.query != "method-tried":
            result = use.node.args[-1]
            if type(result) is nodes.Const:
                yield result, use.owner
            elif type(result) is nodes.Var:
                bound.add((id(use.owner), result.name))
    for test in index.of(nodes.Compare) if bound else ():
        sides = (test.node.left, test.node.right)
        for one, other in (sides, sides[::-1]):
            asked = type(one) is nodes.Var and (id(test.owner), one.name) in bound
            if asked and type(other) is nodes.Const:
                yield other, test.owner
    for case in index.of(nodes.ResultCase):
        expected = case.node.result
        if isinstance(expected, nodes.Const) and expected.value != "succeed":
            yield expected, case.owner
    for fails in index.of(nodes.Fails):
        if isinstance(fails.node.result, nodes.Const):
            yield fails.node.result, fails.owner


def _no_result(
    run: Pass, place: nodes.ScriptRow | nodes.ResultEffects, wrong: Fault
) -> Diagnostic:
    assert wrong.declared is not None
    declared = declared_at(run, wrong.declared)
    return UNKNOWN.at(
        place.span,
        wrong.message,
        labels=(Label(declared, "the results are declared here"),),
        help=wrong.help,
        fix=renaming(run.library.files, wrong.name, wrong.meant, [place.span]),
    )


OTHERS = Rule(
    code="RAP154",
    name="impossible-result",
    severity=Severity.WARNING,
    summary="a RAP queries a result that none of its methods can have",
    ignore="where a problem solver adds a method with this result",
    source="T 4.1.2",
)


@check(OTHERS, needs_whole="form")
def own_results(run: Pass) -> Iterator[Diagnostic]:
    """Find conditions on results that the RAP's own methods cannot have."""
    known = {r for form in run.library.primitives.values() for r in _results(form)}
    ends: dict[int, _Ends] = {}
    wrong: dict[int, list[tuple[nodes.Const, Sequence[nodes.Method]]]] = {}
    for asked in run.result(INDEX).of(nodes.HistoryTest):
        rap, test = asked.owner, asked.node
        if not isinstance(rap, nodes.DefineRap) or test.query == "method-tried":
            continue
        result = test.args[-1] if test.args else None
        if not isinstance(result, nodes.Const) or result.value not in known:
            continue
        if result.value in RESULTS or not rap.methods or rap.plan is not None:
            continue  # a solver or the planner may add a method with the result
        if id(rap) not in ends:
            ends[id(rap)] = _Ends(run, rap)
        name = _method_meant(test)
        if not ends[id(rap)].count(name, str(result.value)):
            meant = ends[id(rap)].methods.get(name, ())
            wrong.setdefault(id(rap), []).append((result, meant))
    for found in wrong.values():
        yield _impossible_result(run.library, found)
    for rap in run.library.raps.values():
        if id(rap) in ends and id(rap) not in wrong:
            yield from _by_itself_alone(rap, ends[id(rap)], known)


def _by_itself_alone(
    rap: nodes.DefineRap, ends: _Ends, known: Container[str]
) -> Iterator[Diagnostic]:
    """Find methods that require a failure that only the method itself can have."""
    for method in rap.methods:
        for one in literals(method.context):
            test = one.formula
            if not isinstance(test, nodes.HistoryTest) or not one.holds:
                continue
            result = test.args[-1] if test.args else None
            if test.query == "method-tried" or not isinstance(result, nodes.Const):
                continue
            if result.value in RESULTS or result.value not in known:
                continue
            name, failure = _method_meant(test), str(result.value)
            itself = name in (None, method.name) and ends.may(method, failure)
            if ends.count(name, failure) <= int(itself):
                yield OTHERS.at(
                    result.span,
                    f"only this method ends with the result `{failure}`, so that the "
                    "method is never chosen",
                    labels=(Label(method.body.span, "the method"),),
                    help="negate the formula, or query the result in another method",
                )


_Request = tuple[nodes.Request, nodes.DeclarePrimitive]
"""A request of a method, and the declaration of its primitive."""


class _Ends:
    """The results with which the methods of a RAP may end.

    Args:
        run: the pass.
        rap: the RAP.
    """

    def __init__(self, run: Pass, rap: nodes.DefineRap) -> None:
        self._run = run
        #: The methods by name, and all methods under None.
        self.methods: dict[object, list[nodes.Method]] = {None: list(rap.methods)}
        for method in rap.methods:
            if method.name is not None:
                self.methods.setdefault(method.name, []).append(method)
        self._counts: dict[tuple[object, str], int] = {}

    def count(self, name: object, result: str) -> int:
        """Return how many methods of a name, or of any, may end with a result."""
        key = name, result
        if key not in self._counts:
            meant = self.methods.get(name)
            among = [True] if meant is None else [self.may(m, result) for m in meant]
            self._counts[key] = sum(among)
        return self._counts[key]

    def may(self, method: nodes.Method, result: str) -> bool:
        """Return whether a method may end with a result; True if unknown."""
        match method.body:
            case nodes.Primitive():
                asked = list(_requests(self._run.library, method))
                return not asked or any(result in _results(form) for _, form in asked)
            case nodes.TaskNet():
                effects = self._run.result(EFFECTS)
                return any(
                    effects.fails_with(step.goal.name, result)
                    or any(_fails_step(note, result) for note in step.annotations)
                    for step in method.body.steps
                )
        return True


def _fails_step(note: nodes.Annotation, result: str) -> bool:
    """Return whether an annotation may fail its step with a result."""
    return isinstance(note, nodes.WaitFor) and note.signal == f":{result}"


def _requests(library: Library, method: nodes.Method) -> Iterator[_Request]:
    """Yield the request of a method, if its primitive is declared."""
    if isinstance(method.body, nodes.Primitive):
        form = library.primitives.get(method.body.request.name)
        if form is not None:
            yield method.body.request, form


def _results(form: nodes.DeclarePrimitive) -> set[str]:
    """Return the results that the declaration of a primitive names."""
    return {*form.results, *(on.result for on in form.on)}


def _method_meant(test: nodes.HistoryTest) -> object:
    """Return the name of the method in a condition; None for any method."""
    if test.query == "last-result" or len(test.args) == 1:
        return None
    first = test.args[0]
    return first.value if isinstance(first, nodes.Const) else None


def _impossible_result(
    library: Library, wrong: Sequence[tuple[nodes.Const, Sequence[nodes.Method]]]
) -> Diagnostic:
    result, methods = wrong[0]
    answers = [one for method in methods for one in _requests(library, method)]
    names = ", ".join(dict.fromkeys(f"`{form.name}`" for _, form in answers))
    own = sorted({name for _, form in answers for name in _results(form)})
    others = ", ".join(f"`{name}`" for name in own)
    further = [
        Label(other.span, "this result is impossible, too") for other, _ in wrong[1:]
    ]
    if len(answers) < len(methods):
        return OTHERS.at(
            result.span,
            f"no method or step ends with the result `{result.value}`",
            labels=(Label(methods[0].body.span, "the first method"), *further),
            help=Suggestions(own).did_you_mean(str(result.value)),
        )
    asked = Label(answers[0][0].span, "queried here")
    return OTHERS.at(
        result.span,
        f"{names} never ends with the result `{result.value}`",
        labels=(asked, *further),
        help=Suggestions(own).did_you_mean(str(result.value))
        or f"the results are {others}",
    )


ALIKE = Rule(
    code="RAP156",
    name="failures-alike",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP has several methods, but never queries how its primitive failed",
    ignore="where each method fits any failure",
    source="T 4.1.2",
)


@check(ALIKE, needs_whole="form")
def failures(run: Pass) -> Iterator[Diagnostic]:
    """Find failures that a RAP with several methods does not distinguish."""
    least = THRESHOLDS.failures_alike
    asked, asks_any = _failures_asked(run.result(INDEX))
    for rap in run.library.raps.values():
        if len(rap.methods) < least or id(rap) in asks_any or not run.complete:
            continue
        for method in rap.methods:
            for request, form in _requests(run.library, method):
                alike = [f"`{name}`" for name in _alike(form, asked)]
                if len(alike) >= least:
                    yield ALIKE.at(
                        request.span,
                        f"no method of `{rap.name}` queries whether `{form.name}` has "
                        f"failed with {', '.join(alike[:-1])} or {alike[-1]}",
                        labels=(Label(form.span, "declared here"),),
                        help="query `last-result` in the contexts of the other methods",
                    )


def _failures_asked(index: Index) -> tuple[set[object], set[int]]:
    """Return the results queried by name, and the RAPs that query any result.

    A query of any result counts for every RAP that names the query.
    """
    named: set[object] = set()
    by: set[int] = set()
    for one in index.of(nodes.HistoryTest):
        result = one.node.args[-1] if one.node.args else None
        if one.node.query == "method-tried" or isinstance(result, nodes.Var):
            by.add(id(one.owner))
        elif isinstance(result, nodes.Const):
            named.add(result.value)
    queries = {
        one.owner.name
        for one in index.of(nodes.HistoryTest)
        if isinstance(one.owner, nodes.DefineQuery)
    }
    for fact in index.of(nodes.Proposition) if queries else ():
        if fact.node.name in queries:
            by.add(id(fact.owner))
    return named, by


def _alike(form: nodes.DeclarePrimitive, asked: set[object]) -> Sequence[str]:
    """Return the failures without a condition, and with the same effects."""
    told = {on.result: on.effects for on in form.on}
    failures = [name for name in form.results if name not in ("okay", *asked)]
    groups: dict[object, list[str]] = {}
    for name in failures:
        groups.setdefault(told.get(name, ()), []).append(name)
    return max(groups.values(), key=len, default=())


DEAD = Rule(
    code="RAP152",
    name="dead-case",
    severity=Severity.WARNING,
    summary="a case of a memory rule can never apply",
    ignore="where a problem solver adds methods with this result",
    source="S 4.2",
)


@check(DEAD, needs_whole="form")
def dead_case(run: Pass) -> Iterator[Diagnostic]:
    """Find cases of memory rules that are never taken."""
    results = {r for form in run.library.primitives.values() for r in form.results}
    results |= {name.removeprefix(":") for name in run.library.events}
    results -= {*RESULTS}
    told = {e for form in run.library.skills.values() for e in form.events or ()}
    for rule in run.result(INDEX).of(nodes.MemoryRule):
        dead = set[Span]()
        for found in _dead(rule.node):
            dead.add(found.span)
            yield found
        if not run.complete or rule.node.index.name not in run.library.raps:
            continue
        for found in _impossible(rule.node, run.result(EFFECTS), results, told):
            if found.span not in dead:
                yield found


def _impossible(
    rule: nodes.MemoryRule, effects: Effects, results: set[str], told: set[str]
) -> Iterator[Diagnostic]:
    """Yield the cases for results that a RAP cannot have, though other RAPs can."""
    name = rule.index.name
    for case in rule.cases:
        result = case.result
        if rule.when == "event":
            if not isinstance(result, nodes.Signal) or result.name not in told:
                continue
            if not effects.tells(name, result.name):
                yield DEAD.at(
                    result.span,
                    f"no enabled skill of `{name}` or its subtasks emits "
                    f"`{result.name}`",
                    help="move the case to the RAP with the skill, or write an event "
                    "rule",
                )
        elif isinstance(result, nodes.Const) and isinstance(result.value, str):
            failure = result.value
            if failure == "okay":
                yield DEAD.at(
                    result.span,
                    "a task that succeeds has the result `succeed`",
                    help="write `succeed` in place of `okay`",
                )
            elif failure in results and not effects.fails_with(name, failure):
                yield DEAD.at(
                    result.span,
                    f"`{name}` never fails with `{failure}`",
                    help="write a result of the RAP, or remove the case",
                )


def _dead(rule: nodes.MemoryRule) -> Iterator[Diagnostic]:
    terms = (*rule.index.args, *rule.index.outputs)
    names = {term.name for term in terms if isinstance(term, nodes.Var)}
    every: nodes.ResultCase | None = None
    seen: dict[object, nodes.ResultCase] = {}
    for case in rule.cases:
        result = case.result
        first = every
        if isinstance(result, nodes.Const):
            first = first or seen.setdefault(result.value, case)
        if first is not None and first is not case:
            yield DEAD.at(
                result.span,
                "this case can never apply",
                labels=(Label(first.result.span, "this case matches first"),),
                help="move the case before that case, or remove it",
            )
        elif rule.when == "event" and isinstance(result, nodes.Const):
            yield DEAD.at(
                result.span,
                f"expected an event in an event rule, not the result `{result.value}`",
                help="write an event: `((:event ?what) (rule ...))`",
            )
        elif rule.when == "finish" and isinstance(result, nodes.Signal):
            yield DEAD.at(
                result.span,
                f"expected a result in this rule, not the event `{result.name}`",
                help="write an `:event` rule, or a result",
            )
        if isinstance(result, nodes.Var) and result.name not in names:
            every = every or case
