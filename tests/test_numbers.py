"""Numbers are printed as they are: digits and a point, and the same when read again."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.base.values import format_float, readable
from tests.effort import examples


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1e-25, "0." + "0" * 24 + "1"),
        (-1.25e-7, "-0.000000125"),
        (1 / 3e15, "0.0000000000000003333333333333333"),
        (1e16, "10000000000000000.0"),
        (-1.5e22, "-15000000000000000000000.0"),
        (1.2345678901234567e16, "12345678901234568.0"),
        (0.5, "0.5"),
        (5e-324, "0." + "0" * 323 + "5"),
    ],
)
def test_a_number_has_no_exponent(value: float, text: str) -> None:
    assert format_float(value) == text


@examples(1000)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_read_again_is_the_same(value: float) -> None:
    text = format_float(value)
    assert float(text) == value
    assert "e" not in text
    assert "." in text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (49.440000000000005, "49.44"),
        (2.7279999999999998, "2.728"),
        (0.1 + 0.2, "0.3"),
        (100 / 3, "33.333333"),
        (-1e-25, "-0." + "0" * 24 + "1"),
        (1.2345678e-9, "0.00000000123457"),
        (7, "7"),
        (7.0000000001, "7"),
        (1e16, "10000000000000000"),
        ("dock", "dock"),
    ],
)
def test_a_number_for_people_has_no_noise(value: object, text: str) -> None:
    assert readable(value) == text
