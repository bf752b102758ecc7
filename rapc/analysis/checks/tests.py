"""Tests with events that no trace has, and tests without a required world."""

from __future__ import annotations

from collections.abc import Iterator

from rapc import events
from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.names import renaming
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Suggestions
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.effects import complete_data
from rapc.library.library import Library, word_span

WORLDLESS_TEST = Rule(
    code="RAP167",
    name="worldless-test",
    severity=Severity.ERROR,
    summary="a test uses parts of a world but names no world",
    source="L 1",
)


@check(WORLDLESS_TEST)
def worldless_test(run: Pass) -> Iterator[Diagnostic]:
    """Find tests without a world that need a world."""
    for test in run.library.tests:
        if test.world is None:
            for place, message in _lacking(run.library, test):
                help = "name the world with `(world name)`"
                yield WORLDLESS_TEST.at(place, message, help=help)


def _lacking(library: Library, test: nodes.DefineTest) -> Iterator[tuple[Span, str]]:
    """Yield the missing features of a test without a world, each with its place."""
    for option in test.options[:1]:
        message = "options of a world require a world"
        yield option.span, message
    asked = [row for row in test.script if row.kind == "request"]
    complete = complete_data(library)
    for row in asked:
        for datum in row.data:
            if datum.name in library.data and datum.name not in complete:
                message = f"datum `{datum.name}` has no handler"
                yield datum.span, message
    answered = {answer.call.function for answer in test.answers}
    for name in library.functions:
        if name not in answered:
            yield test.name_span, f"unknown function `{name}`"
    named = [node.comparator for node in library.indistinct.values()]
    named += [node.function for node in library.comparators]
    for comparator in dict.fromkeys(filter(None, named)):
        yield test.name_span, f"unknown comparator `{comparator}`"


IMPOSSIBLE_ROW = Rule(
    code="RAP087",
    name="impossible-row",
    severity=Severity.ERROR,
    summary="a row of a script has a part that is impossible for its request or skill",
    source="L 3.72",
)


@check(IMPOSSIBLE_ROW)
def impossible_row(run: Pass) -> Iterator[Diagnostic]:
    """Find script rows with effects that their request or skill cannot have."""
    for use in run.result(INDEX).of(nodes.ScriptRow):
        row = use.node
        wrong = _of_request(row) if row.kind == "request" else _of_skill(row)
        for message in wrong:
            yield IMPOSSIBLE_ROW.at(row.span, message)
        declared = run.library.primitives.get(row.request.name)
        later = row.kind == "request" and row.after is not None
        if later and declared is not None and declared.atomic:
            yield _atomic(row, declared)


def _atomic(row: nodes.ScriptRow, declared: nodes.DeclarePrimitive) -> Diagnostic:
    name = declared.name
    return IMPOSSIBLE_ROW.at(
        row.span,
        f"`{name}` is declared atomic and cannot end `:after` its request",
        labels=(Label(declared.span, "declared here"),),
        help=f"declare `{name}` with `:atomic false`, or write the duration "
        "with `:takes`",
    )


def _of_request(row: nodes.ScriptRow) -> Iterator[str]:
    if row.every is not None or row.pauses:
        yield "only a skill emits signals with waits between them, or repeatedly"


def _of_skill(row: nodes.ScriptRow) -> Iterator[str]:
    """Yield the parts of a row that are not valid for a skill."""
    off = row.kind == "disable"
    given = (
        ("result", row.result is not None),
        ("`:takes`", bool(row.takes)),
        ("`:data`", bool(row.data)),
        ("`:after`", off and row.after is not None),
        ("`:every`", off and row.every is not None),
        ("`:refused`", off and row.refused),
        ("wait between signals", off and bool(row.pauses)),
    )
    for what, said in given:
        if said:
            yield f"a skill that {'is disabled' if off else 'is enabled'} has no {what}"


UNKNOWN_EVENT = Rule(
    code="RAP077",
    name="unknown-event",
    severity=Severity.ERROR,
    summary="a test expects an unknown event, or an unknown key of an event",
    fix="unsafe: writes the similar event or key",
    source="L 1",
)


@check(UNKNOWN_EVENT)
def unknown_event(run: Pass) -> Iterator[Diagnostic]:
    """Find events and keys of events in tests that no trace has."""
    known_kinds = events.kinds()
    near_kinds = Suggestions(known_kinds)
    keys: dict[str, Suggestions] = {}
    for found in run.result(INDEX).of(nodes.EventPattern):
        pattern = found.node
        place = word_span(run.library.files, pattern.span, 0)
        if pattern.event not in known_kinds:
            fix = renaming(
                run.library.files,
                pattern.event,
                near_kinds.near(pattern.event),
                [place],
            )
            help_ = near_kinds.did_you_mean(
                pattern.event, "the page `reference/trace` lists the events"
            )
            message = f"unknown event `{pattern.event}`"
            yield UNKNOWN_EVENT.at(place, message, help=help_, fix=fix)
            continue
        if pattern.event not in keys:
            keys[pattern.event] = Suggestions(events.keys(known_kinds[pattern.event]))
        known = keys[pattern.event]
        for key, _ in pattern.keys:
            if key not in known:
                message = f"unknown key `{key}` of `{pattern.event}`"
                near, place = known.near(key), pattern.span
                fix = renaming(
                    run.library.files, f":{key}", near and f":{near}", [place]
                )
                help_ = known.did_you_mean(key)
                yield UNKNOWN_EVENT.at(place, message, help=help_, fix=fix)


NO_EXPECTATION = Rule(
    code="RAP174",
    name="no-expectation",
    severity=Severity.WARNING,
    summary="a test with a script expects nothing",
    ignore="where the test only has to run without an unknown request",
    source="L 9",
)

VAIN_NEVER = Rule(
    code="RAP175",
    name="vain-never",
    severity=Severity.WARNING,
    summary="a test expects that a request with an unused constant is never made",
    ignore="where a handler of the world or a function makes the constant",
    source="L 9",
)


@check(NO_EXPECTATION, VAIN_NEVER, needs_whole="form")
def expectations(run: Pass) -> Iterator[Diagnostic]:
    """Find tests without expectations, and expectations that cannot fail."""
    index = run.result(INDEX)
    named = [one.node.args for one in index.of(nodes.Goal)]
    for kind in _WITH_TERMS:
        named += [
            one.node.args
            for one in index.of(kind)
            if type(one.parent) is not nodes.Never
        ]
    used = {
        term.value for args in named for term in args if isinstance(term, nodes.Const)
    }
    for test in run.library.tests:
        later = [action for at in test.ats for action in at.actions]
        nested = [action for action in later if isinstance(action, nodes.Expect)]
        if test.script and not test.expectations and not nested:
            yield NO_EXPECTATION.at(
                test.name_span,
                f"the test `{test.name}` expects nothing",
                help="add `(expect ...)`",
            )
    for never in index.of(nodes.Never):
        owner = never.owner
        if not isinstance(owner, nodes.DefineTest) or owner.world is not None:
            continue
        for term in never.node.request.args:
            if isinstance(term, nodes.Const) and term.value not in used:
                yield VAIN_NEVER.at(
                    term.span,
                    f"`{term.value}` is used nowhere else, so no request has it",
                    help="name a constant of the test or of the library",
                )


_WITH_TERMS: tuple[type[nodes.Pattern], ...] = (
    nodes.Proposition,
    nodes.Request,
    nodes.Signal,
    nodes.Skill,
    nodes.Datum,
)
"""The nodes with arguments that may become arguments of a request."""
