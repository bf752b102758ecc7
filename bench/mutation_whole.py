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


KINDS: Mapping[str, tuple[str, Kind]] = {
    "`require` dropped": ("names", _require_dropped),
}
"""Every kind of slip here, with the group that it is of."""
