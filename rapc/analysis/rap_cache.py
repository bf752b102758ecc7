"""Values about RAPs, kept from one check of a library to the next.

A value about a RAP depends on the RAP, on the RAPs that its steps reach and on the
declarations (`rapc.analysis.check.RapFact`). The value is kept while all of these are
the same nodes, at the same places. If a declaration changes, all values are dropped.

The nodes of a file are the same after an edit as far as the text before the edit goes,
and in all other files (`rapc.library.loader.Units`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from operator import is_

from rapc.base.graph import components
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import Library, calls_of

Values = dict[object, object]
"""The values about a RAP, by fact."""

_Key = tuple[object, ...]
"""What the values about a RAP depend on, by identity."""


class RapCache:
    """The values about the RAPs of a library at its last check."""

    def __init__(self) -> None:
        #: The forms of the last check: while they live, an `id` stays unique.
        self._raps: Sequence[nodes.DefineRap] = ()
        self._others: Sequence[nodes.TopForm] = ()
        self._complete = True
        self._values: dict[_Key, Values] = {}

    def values(
        self, library: Library, complete: bool, unsure: Callable[[Span], bool]
    ) -> dict[int, Values]:
        """Return the values about the RAPs of a library that are still valid.

        The values that the caller adds are kept.

        Args:
            library: the library.
            complete: whether every file that the library requires was found.
            unsure: whether a syntax error may affect the text at a place.

        Returns:
            the values by the `id` of the RAP.
        """
        raps = [one for one in library.forms if isinstance(one, nodes.DefineRap)]
        others = [one for one in library.forms if not isinstance(one, _BESIDE)]
        same = complete is self._complete and len(others) == len(self._others)
        if not same or not all(map(is_, others, self._others)):
            self._values = {}
        values: dict[_Key, Values] = {}
        found: dict[int, Values] = {}
        for rap, key in _keys(library, raps, unsure, found):
            found[id(rap)] = values[key] = self._values.get(key, {})
        self._raps, self._others, self._complete = raps, others, complete
        self._values = values
        return found


_BESIDE = nodes.DefineRap | nodes.Require
"""The forms on which the values about other RAPs do not depend."""


def _keys(
    library: Library,
    raps: Iterable[nodes.DefineRap],
    unsure: Callable[[Span], bool],
    found: Mapping[int, Values],
) -> Iterator[tuple[nodes.DefineRap, _Key]]:
    """Yield each RAP with its key, after the RAPs that its steps call.

    The key has the RAP, the RAPs that call each other together with it, and the values
    about the RAPs that these call: the same values mean the same RAPs below.

    Args:
        library: the library.
        raps: its RAPs, also those with the name of another one.
        unsure: whether a syntax error may affect the text at a place.
        found: the values about the RAPs yielded before, added by the caller.
    """
    known = library.raps
    calls = {name: calls_of(rap, known) for name, rap in known.items()}

    def below(names: Iterable[str]) -> tuple[int | None, ...]:
        raps = [known.get(name) for name in names]
        return tuple([id(found.get(id(rap))) if rap else None for rap in raps])

    for names in components(known, lambda name: calls.get(name, ())):
        group = [known[name] for name in names if name in known]
        members = tuple([(id(one), unsure(one.span)) for one in group])
        inside = {*names}
        outside = [n for one in group for n in calls[one.name] if n not in inside]
        key = members, below(outside)
        for at, rap in enumerate(group):
            yield rap, (at, key)
    for rap in raps:
        if known.get(rap.name) is not rap:
            yield rap, (id(rap), unsure(rap.span), below(calls_of(rap, known)))
