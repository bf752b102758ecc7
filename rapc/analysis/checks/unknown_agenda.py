"""RAP080: tests that take the tasks of an agenda that nobody defines."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.names import UnknownNames
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.names import Suggestions
from rapc.library.library import word_span
from rapc.library.signatures import Fault

UNKNOWN = Rule(
    code="RAP080",
    name="unknown-agenda",
    severity=Severity.ERROR,
    summary="a test names an agenda that the library does not define",
    why="""The tasks of an agenda are given to the robot as the test begins. Without
the agenda there would be none of them.""",
    source="T 5.4",
    example="""\
(define-rap (watch))
(define-agenda night (task (watch) :background true))
(define-test the-robot-watches
  (agenda nigt)
  (until 10))
""",
    better="""\
(define-rap (watch))
(define-agenda night (task (watch) :background true))
(define-test the-robot-watches
  (agenda night)
  (until 10))
""",
)


@check(UNKNOWN)
def unknown_agenda(run: Pass) -> Iterator[Diagnostic]:
    """Find tests that name an agenda that is not defined."""
    known = run.library.agendas
    unknown = UnknownNames(UNKNOWN)
    near = Suggestions(known)
    for test in run.library.tests:
        name = test.agenda
        if name is not None and name not in known:
            advice = "define it with `define-agenda`, or `require` the file that does"
            help = near.did_you_mean(name, advice)
            message, meant = f"no agenda is called `{name}`", near.near(name)
            fault = Fault("unknown", message, help, name=name, meant=meant)
            place = word_span(run.library.files, test.span, 1)
            unknown.add(fault, place, test)
    yield from unknown.findings(run)
