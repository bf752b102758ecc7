"""The table of events: each field of a kind is plain data, or a trace writes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import pytest

from rapc import events
from rapc.spec import RunSpec

PLAIN = {
    *(str, int, bool, int | float, events.Goal, RunSpec, str | None, int | None),
    *(int | float | None, events.Cause | None),
    *(tuple[int, ...], tuple[str, ...], tuple[events.TaskResult, ...]),
    *(tuple[events.PlanStep, ...], Mapping[str, str], dict[str, Any]),
}
"""The types of fields that an encoder writes as they are."""


@pytest.mark.parametrize("name", sorted(events.kinds()))
def test_each_field_is_plain_or_has_words(name: str) -> None:
    kind = events.kinds()[name]
    in_words = {key for key, _ in events.words(kind)}
    for field in msgspec.structs.fields(kind):
        assert (field.encode_name in in_words) != (field.type in PLAIN), field.name
