"""What was read of clauses and options, as fields of the node that they are of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import chain
from typing import Any

import msgspec

from rapc.ir import nodes
from rapc.ir.fields import declared
from rapc.ir.productions import parts, unsaid
from rapc.language.heads import heads


class Slots(msgspec.Struct, frozen=True):
    """The fields of a node that clauses and options fill, in the order of the node."""

    #: The names of the fields.
    names: tuple[str, ...]
    #: What the fields hold where nothing is said.
    unsaid: tuple[Any, ...]
    #: The places of fields that hold one thing, by the words of their clauses.
    single: Mapping[str, int]
    #: The places of fields that hold a tuple of them.
    rows: Mapping[str, int]


@cache
def slots(rule: str, kind: type[nodes.Node]) -> Slots:
    """Return the fields that the clauses and options of a rule fill in its node."""
    known = [part for part in parts(rule, kind) if part.field]
    empty = {p.field: unsaid(str(p.shape), kind, p.field) for p in known}
    names = tuple([name for name in kind.__struct_fields__ if name in empty])
    single: dict[str, int] = {}
    rows: dict[str, int] = {}
    for part in known:
        many = declared(kind, part.field).startswith("tuple[")
        word = heads(str(part.shape))[0]
        (rows if many else single)[word] = names.index(part.field)
    return Slots(names, tuple([empty[name] for name in names]), single, rows)


def filled(into: Slots, read: Mapping[str, Sequence[Any]]) -> list[Any]:
    """Return what the fields hold, of what was read of options by their words."""
    fields = list(into.unsaid)
    for word, values in read.items():
        put(fields, into, word, values)
    return fields


def put(fields: list[Any], into: Slots, word: str, values: Sequence[Any]) -> None:
    """Put what was read of the clauses or options of a word where it belongs.

    What could not be read is None. Of several things for a field that holds one the
    first counts; rows are joined.
    """
    at = into.single.get(word)
    if at is None:
        at = into.rows[word]
        rows = [_row(value, into.names[at]) for value in values if value is not None]
        if rows:
            fields[at] = (*(fields[at] or ()), *chain.from_iterable(rows))
    elif values[0] is not None:
        fields[at] = values[0]


def _row(value: Any, field: str) -> Iterable[Any]:
    """A row as it is, that of a node which holds one of the same name, or one thing."""
    if isinstance(value, nodes.Node):
        held: Iterable[Any] = getattr(value, field, (value,))
        return held
    return value if type(value) is tuple else (value,)
