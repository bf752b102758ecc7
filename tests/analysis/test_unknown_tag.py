"""Where `unknown-tag` points: at the tag, not at all of its annotation."""

from __future__ import annotations

import pytest

from rapc.analysis.driver import check_library
from rapc.library.loader import load_text


@pytest.mark.parametrize(
    "annotation",
    [
        "(for T9)",
        "((ready arm) for t9 )",
        "((ready arm)\n for t9\n)",
        "(until-end  t9)",
        "(until-start t9)",
        "(window t9 0 5)",
    ],
)
def test_the_finding_points_at_the_tag(annotation: str) -> None:
    text = f"""(declare-memory-proposition ready (?x)) (define-rap (lift))
    (define-rap (go) (method (task-net (t1 (lift) {annotation}))))"""
    [finding] = check_library(load_text(text)).findings
    span = finding.diagnostic.span
    assert (finding.rule.name, text[span.start : span.end].lower()) == (
        "unknown-tag",
        "t9",
    )
