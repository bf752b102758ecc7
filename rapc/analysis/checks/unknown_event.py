"""RAP077: expectations of a test about events that no trace ever holds."""

from __future__ import annotations

from collections.abc import Iterator

from rapc import events
from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.names import renaming
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.names import Suggestions
from rapc.ir import nodes
from rapc.library.library import word_span

UNKNOWN = Rule(
    code="RAP077",
    name="unknown-event",
    severity=Severity.ERROR,
    summary="a test expects an event, or a key of one, that no trace ever holds",
    why="""`(trace (event :key value...)...)` holds if the trace has such events in that
order. The names of events and of their keys are those of the trace; one that is spelled
otherwise is never found.""",
    fix="unsafe: writes the event or key that is spelled almost so",
    source="L 1",
    example="""\
(define-rap (wait))
(define-test waits
  (task (wait))
  (expect (trace (task-succeded :goal (wait)))))
""",
    better="""\
(define-rap (wait))
(define-test waits
  (task (wait))
  (expect (trace (task-succeeded :goal (wait)))))
""",
)


@check(UNKNOWN)
def unknown_event(run: Pass) -> Iterator[Diagnostic]:
    """Find events and keys of events in tests that no trace ever holds."""
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
            help_ = near_kinds.did_you_mean(pattern.event, "`docs/trace.md` lists them")
            message = f"no event is called `{pattern.event}`"
            yield UNKNOWN.at(place, message, help=help_, fix=fix)
            continue
        if pattern.event not in keys:
            keys[pattern.event] = Suggestions(events.keys(known_kinds[pattern.event]))
        known = keys[pattern.event]
        for key, _ in pattern.keys:
            if key not in known:
                message = f"`{pattern.event}` has no key `{key}`"
                near, place = known.near(key), pattern.span
                fix = renaming(
                    run.library.files, f":{key}", near and f":{near}", [place]
                )
                help_ = known.did_you_mean(key)
                yield UNKNOWN.at(place, message, help=help_, fix=fix)
