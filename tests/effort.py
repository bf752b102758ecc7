"""How much of a test `pytest` does by default, and how much `.ci/run` does.

Some tests say the same of many seeds or of many examples. A few of these belong to the
default set, so that no room goes untested; the rest is marked `slow`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

THOROUGH = "thorough"
"""The profile of hypothesis under which tests try all the examples they ask for."""

SHARE = 6
"""By default a test tries one in so many of its examples, unless the test says more."""


def first(number: int, values: Iterable[Any]) -> list[Any]:
    """Return parameters of a test of which all but the first `number` are slow."""
    return [
        value if at < number else pytest.param(value, marks=pytest.mark.slow)
        for at, value in enumerate(values)
    ]


def thorough() -> bool:
    """Whether tests do all that they can, as in `.ci/run`."""
    return settings.get_current_profile_name() == THOROUGH


def examples(most: int, share: int = SHARE, **others: Any) -> settings:
    """Settings of hypothesis: `most` examples if thorough, else one in `share`."""
    return settings(max_examples=most if thorough() else most // share, **others)
