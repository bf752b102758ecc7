"""RAP167: tests that name no world, and have or need what only a world brings along."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.signature import CONSTANT_DEFAULTS

WORLDLESS = Rule(
    code="RAP167",
    name="worldless-test",
    severity=Severity.ERROR,
    summary="a test names no world, but needs what only a world brings along",
    why="""Handlers of sensor data, comparators and the options of a world come from the
world that a test names by `(world name)`; so do the functions of a library, unless
`answers` says what they return. Without them the test cannot be run.""",
    source="L 1",
    example="""\
(declare-memory-function distance (?from ?to))
(define-rap (wait))
(define-test waits
  (task (wait))
  (expect (succeeds (wait))))
""",
    better="""\
(declare-memory-function distance (?from ?to))
(define-rap (wait))
(define-test waits
  (answers ((distance ? ?) 3))
  (task (wait))
  (expect (succeeds (wait))))
""",
)


@check(WORLDLESS)
def worldless_test(run: Pass) -> Iterator[Diagnostic]:
    """Find tests without a world that need what only a world brings along."""
    for test in run.library.tests:
        if test.world is None:
            for place, message in _lacking(run.library, test):
                help = "name the world by `(world name)`"
                yield WORLDLESS.at(place, message, help=help)


def _lacking(library: Library, test: nodes.DefineTest) -> Iterator[tuple[Span, str]]:
    """Yield what a test without a world lacks, each with its place."""
    for option in test.options[:1]:
        message = "these are options of a world, and the test names none"
        yield option.span, message
    asked = [row for row in test.script if row.kind == "request"]
    for row in asked:
        for datum in row.data:
            if datum.name in library.data:
                message = f"there is no handler for the datum `{datum.name}`"
                yield datum.span, message
    answered = {answer.call.function for answer in test.answers}
    for declared in library.properties.values():
        default = declared.default
        known = default in CONSTANT_DEFAULTS or default in library.functions
        if not known and default not in answered:
            message = f"no default function is registered as `{default}`"
            yield test.name_span, message
    for name in library.functions:
        if name not in answered:
            yield test.name_span, f"no function is registered as `{name}`"
    named = [node.comparator for node in library.indistinct.values()]
    named += [node.function for node in library.comparators]
    for comparator in dict.fromkeys(filter(None, named)):
        yield test.name_span, f"no comparator is registered as `{comparator}`"
