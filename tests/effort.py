"""How much of a test `pytest` does by default, and how much `.ci/run` does.

Some tests say the same of many seeds or of many examples. A few of these belong to the
default set, so that no room goes untested; the rest is marked `slow`, or `nightly`
where a part shows the same in kind.
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


def first(number: int, values: Iterable[Any], in_ci: int | None = None) -> list[Any]:
    """Return parameters of a test of which all but the first `number` are slow.

    All but the first `in_ci`, if that is not None, are nightly.
    """
    parameters = []
    for at, value in enumerate(values):
        mark = pytest.mark.slow
        if in_ci is not None and at >= in_ci:
            mark = pytest.mark.nightly
        parameters.append(value if at < number else pytest.param(value, marks=mark))
    return parameters


def thorough() -> bool:
    """Whether tests do all that they can, as in `.ci/run`."""
    return settings.get_current_profile_name() == THOROUGH


def examples(most: int, share: int = SHARE, **others: Any) -> settings:
    """Settings of hypothesis: `most` examples if thorough, else one in `share`."""
    return settings(max_examples=most if thorough() else most // share, **others)
