"""Nothing happens in a run of which the checker says that it never does.

Random libraries that ask about few things are checked, and run with various facts.
"""

from __future__ import annotations

from collections import Counter

import pytest

from rapc.analysis.driver import check_library
from rapc.analysis.selection import Selection, rule_names
from rapc.base.diagnostics import Diagnostic, Label
from rapc.base.source import Span
from rapc.library.library import Library
from rapc.library.loader import load_text
from rapc.worlds.script import Row
from tests.effort import first
from tests.reference.asking import asking
from tests.reference.case import Case, run_reference
from tests.reference.holding import Holding

CHUNK = 60
CHUNKS = 30
RUNS = 4

NEVER = ("contradiction", "unreachable-method", "succeeds-at-once", "never-begins")
"""The rules that say of something that it never happens."""


def _refuted(found: Diagnostic, library: Library, holding: Holding) -> bool:
    """Whether something has happened that never does, as a finding says."""
    if found.rule == "contradiction":
        pair = {found.span, *(label.span for label in found.labels)}
        return len(pair) > 1 and any(pair <= spans for spans in holding.together)
    if found.rule == "unreachable-method" and not found.message.startswith("no method"):
        return any(found.span in spans for spans in holding.chosen)
    return any(
        rap.span.start <= found.span.start < rap.span.end
        for rap in library.raps.values()
        if rap.name in holding.choosing
    )


def _wrong(cases: list[Case], holding: Holding) -> tuple[int, list[Diagnostic]]:
    """Return how much is found in a library, and what of that some run refutes."""
    loaded = load_text(cases[0].text, "lib.rap")
    report = check_library(loaded, Selection(rule_names(frozenset(NEVER))))
    found = [one.diagnostic for one in report.findings if one.rule.name in NEVER]
    assert not any("@" in one.message for one in found)
    for case in cases if found else ():
        run_reference(case)
    return len(found), [one for one in found if _refuted(one, loaded.library, holding)]


@pytest.mark.parametrize("chunk", first(1, range(CHUNKS), 10))
def test_runs_refute_no_finding(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    counts: Counter[str] = Counter()
    for seed in range(chunk * CHUNK, (chunk + 1) * CHUNK):
        with monkeypatch.context() as patched:
            holding = Holding(patched)
            many, wrong = _wrong(list(asking(seed, RUNS)), holding)
        assert wrong == [], f"seed {seed}"
        counts["found"] += many
        counts["held"] += len(holding.together)
    assert counts["found"] > CHUNK / 3
    assert counts["held"] > CHUNK


CHARGER = """\
(declare-memory-property robot-at (?place) unknown)
(declare-memory-proposition charger (?place))
(declare-primitive drive (?place) (okay))
(define-rap (recharge)
  (succeed (last-result okay))
  (repeat-while (robot-at ?here))
  (method
    (context (or nil (and (charger ?place) (not (charger ?here)))))
    (primitive (drive ?place))))
"""


@pytest.mark.parametrize(
    ("rule", "text", "message"),
    [
        ("contradiction", "(charger ?here)", ""),
        ("unreachable-method", "(charger ?here)", "`x` never holds"),
        ("unreachable-method", "(robot-at ?here)", "no method is ever chosen"),
        ("succeeds-at-once", "(last-result okay)", ""),
    ],
)
def test_run_refutes_wrong_finding(
    rule: str, text: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the test above would not notice one."""
    case = Case(
        seed=1,
        source=CHARGER,
        rows=(Row(("drive", "?place")),),
        facts=("(robot-at lab)", "(charger dock)"),
        tasks=("(recharge)",),
    )
    library = load_text(CHARGER, "lib.rap").library
    holding = Holding(monkeypatch)
    run_reference(case)
    here, beside = _span(text), _span("(charger ?place) (not")
    wrong = Diagnostic(rule, message, here, labels=(Label(beside, ""),))
    assert _refuted(wrong, library, holding)
    nowhere = Span("lib.rap", 0, 1)
    right = Diagnostic(rule, "this never holds", nowhere, labels=(Label(here, ""),))
    assert not _refuted(right, library, holding)


def _span(text: str) -> Span:
    start = CHARGER.index(text)
    return Span("lib.rap", start, start + text.index(")") + 1)
