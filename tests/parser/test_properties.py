"""What holds of every text, read once: of those of the repository and of made ones.

The grammar and the front end agree about it; lark finds the same data in it; what is
found lies in it; its definitions read back as they are printed; its layout keeps what
it means.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given

from tests.effort import examples, first

from .agreement import accepted, disagreement
from .by_lark import hold_data
from .layout import hold_layout
from .programs import programs, texts
from .reading import hold_places, parsed
from .round_trip import changed


def hold(where: str, text: str) -> None:
    """Hold a text to all of it."""
    assert disagreement(text) == set(), where
    hold_data(text)
    hold_places(text)
    assert changed(text) == [], where
    hold_layout(text)


@pytest.mark.parametrize("share", first(1, range(24)))
def test_every_text_of_the_repository(share: int) -> None:
    some = dict(list(texts().items())[share::24])
    for where, text in some.items():
        hold(where, text)
    assert sum(map(accepted, some.values())) > 10
    assert sum(len(parsed(text).forms) for text in some.values()) > 40


@examples(150, suppress_health_check=[HealthCheck.too_slow])
@given(programs())
def test_programs_made_by_the_grammar(text: str) -> None:
    """`tests.parser.agreement` and `tests.parser.round_trip` hold more of them."""
    assert accepted(text)
    hold("a made program", text)
