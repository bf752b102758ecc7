"""Explanation of a failed test: expectation, position, result, trace.

The same lines go to a terminal (`rapc.cli.test`), to pytest and into JUnit files.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby

from rapc.base.source import SourceFile, Span, place
from rapc.console.junit import JUnitCase, junit
from rapc.console.lines import Line
from rapc.testing.run import Outcome, Status
from rapc.testing.setting import Unmet

_MOST_ROWS = 8


def test_title(outcome: Outcome) -> str:
    """Return the test's name, with the failing seed unless the seed is 0."""
    told = outcome.seed and outcome.status is not Status.PASSED
    seed = f" (seed {outcome.seed})" if told else ""
    return f"{outcome.case.test.name}{seed}"


def reason(outcome: Outcome) -> str:
    """Return in a line why a test did not pass."""
    return outcome.failures[0].happened[0]


def failure_lines(outcome: Outcome) -> Iterator[Line]:
    """Yield the complete explanation of a test that did not pass."""
    wrong = outcome.status is Status.ERROR
    files = outcome.case.library.library.files
    for failure in outcome.failures:
        yield Line("place", place(failure.span, files))
        yield from _excerpt(files.get(failure.span.file), failure.span)
        yield from _happened(failure, wrong)
    if outcome.note:
        yield Line("text", f"  {outcome.note}")
    if outcome.trace:
        yield Line("text", "  the last cycles:")
        for text in outcome.trace:
            yield Line("trace", "  " + text)


def as_junit(outcomes: Iterable[Outcome]) -> bytes:
    """Return outcomes as JUnit XML in UTF-8: one suite for each file."""
    grouped = groupby(outcomes, key=lambda outcome: outcome.case.test.span.file)
    suites = [(file, list(map(_junit_case, group))) for file, group in grouped]
    return junit("rapc", suites).encode()


def _junit_case(outcome: Outcome) -> JUnitCase:
    name = outcome.case.test.name
    if outcome.status is Status.PASSED:
        return JUnitCase(name)
    kind = "error" if outcome.status is Status.ERROR else "failure"
    lines = (test_title(outcome), *[line.text for line in failure_lines(outcome)])
    return JUnitCase(name, kind, {"message": reason(outcome)}, "\n".join(lines))


def _happened(failure: Unmet, wrong: bool) -> Iterator[Line]:
    head = "wrong with the test:" if wrong else "what happened:"
    if len(failure.happened) == 1:
        yield Line("text", f"  {head} {failure.happened[0]}")
        return
    yield Line("text", f"  {head}")
    for text in failure.happened:
        yield Line("text", f"    {text}")


def _excerpt(source: SourceFile | None, span: Span) -> Iterator[Line]:
    """Yield the source at a position, marked if it lies in a single row."""
    if source is None:
        return
    first, last = source.position(span.start), source.position(span.end)
    rows = range(first.row, min(last.row, first.row + _MOST_ROWS - 1) + 1)
    margin = len(str(rows[-1]))
    for row in rows:
        yield Line("source", f"  {row:>{margin}} | {source.line(row)}".rstrip())
    if first.row == last.row:
        before = "".join(c if c == "\t" else " " for c in source.line(first.row))
        indent = before[: first.column - 1]
        yield Line(
            "mark", f"  {'':>{margin}} | {indent}{'^' * (last.column - first.column)}"
        )
    elif last.row > rows[-1]:
        yield Line("source", f"  {'':>{margin}} | ...")
