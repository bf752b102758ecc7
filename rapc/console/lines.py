"""Lines of text with their kinds: what is told of tests and of experiments."""

from __future__ import annotations

from typing import Literal

import msgspec

Kind = Literal["title", "head", "place", "source", "mark", "text", "trace"]


class Line(msgspec.Struct, frozen=True):
    """A line of text with its kind, by which it is coloured."""

    kind: Kind
    text: str
