"""Values drawn by seed, written as `{name}` in tasks and options.

Each seed draws every value once, from a separate random stream, `SEED:experiment`; so
points that are compared have equal tasks under equal seeds.
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Mapping

import msgspec

from rapc.base.values import typed

Value = bool | int | float | str
"""A value of an option or setting, as in TOML."""

_PLACE = re.compile(r"\{([a-z0-9][a-z0-9-]*)\}")


class Between(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    rename={"low": "from", "high": "to"},
):
    """A uniformly distributed whole number between two bounds, both included."""

    low: int
    high: int


Draw = Between | tuple[Value, ...]
"""The source of a drawn value: a range of numbers, or a list of values."""

Draws = Mapping[str, Draw]


def drawn(draws: Draws, seed: int) -> dict[str, str]:
    """Return a value for each name of `draws` as text; equal for an equal `seed`."""
    chance = random.Random(f"{seed}:experiment")
    return {
        name: typed(
            chance.randint(draw.low, draw.high)
            if isinstance(draw, Between)
            else chance.choice(draw)
        )
        for name, draw in draws.items()
    }


def extremes(draws: Draws) -> Iterator[dict[str, str]]:
    """Yield drawings that contain each possible value; of a range, both ends."""
    all_ = {
        name: (draw.low, draw.high) if isinstance(draw, Between) else draw
        for name, draw in draws.items()
    }
    for turn in range(max(map(len, all_.values()), default=1)):
        yield {
            name: typed(values[min(turn, len(values) - 1)])
            for name, values in all_.items()
        }


def with_draws(text: str, values: Mapping[str, str]) -> str:
    """Return `text` with the drawn values in place of their names in braces."""
    return _PLACE.sub(lambda found: values.get(found[1], found[0]), text)


def names_in(text: str) -> list[str]:
    """Return the names in braces in `text`."""
    return _PLACE.findall(text)
