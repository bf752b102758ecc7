"""Slips that show only where the whole library is looked at: files, agendas, sensing.

As in `bench.mutation_words`, a kind yields every place where the slip can be made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os.path import basename

from bench.mutation_base import Base, Edit, Kind
from rapc.ir import nodes


def _require_dropped(base: Base) -> Iterator[Edit]:
    for form in base.library.forms:
        if isinstance(form, nodes.Require):
            yield Edit(form.span, "", f"{basename(form.name)}.rap")


def _goal_of_loop_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if rap.repeat_while is not None and rap.succeed is not None:
            yield Edit(base.around(rap.succeed.span), "", rap.name)


def _round_remembers_nothing(base: Base) -> Iterator[Edit]:
    """A loop over things does not remember which it has dealt with."""
    for rap in base.raps:
        loop = rap.repeat_while
        if isinstance(loop, nodes.And):
            for part in loop.parts:
                if isinstance(part, nodes.Not) and isinstance(part.part, nodes.SetTest):
                    yield Edit(part.span, "")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "`require` dropped": ("names", _require_dropped),
    "`succeed` of a loop dropped": ("loops", _goal_of_loop_dropped),
    "loop remembers nothing": ("loops", _round_remembers_nothing),
}
"""Every kind of slip here, with the group that it is of."""
