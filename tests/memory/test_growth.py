"""A truck that drives about for long knows about as many items as there are."""

from __future__ import annotations

from bench.memory import curve


def test_descriptions_stay_bounded_on_the_road() -> None:
    counts = [count for _, count in curve(6000, 10, recognising=True)]
    assert max(counts) <= 240


def test_without_recognition_they_grow_with_every_visit() -> None:
    (first, second) = [count for _, count in curve(20_000, 2, recognising=False)]
    assert first > 600
    assert second > first * 1.7
