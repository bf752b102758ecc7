"""What was read of clauses and options, as fields of the node that they are of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from itertools import chain
from operator import itemgetter
from typing import Any

import msgspec

from rapc.ir import nodes
from rapc.ir.fields import declared
from rapc.ir.productions import parts, unsaid
from rapc.language.heads import heads


class Slots(msgspec.Struct, frozen=True):
    """The fields of a node that clauses and options fill."""

    #: Fields that hold one thing, by the words of their clauses.
    single: Mapping[str, str]
    #: Fields that hold a tuple of them.
    rows: Mapping[str, str]
    #: What the fields hold where nothing is said.
    unsaid: Mapping[str, Any]
    #: Gives the values of all fields, in their order, of a mapping by name.
    in_order: Callable[[Mapping[str, Any]], tuple[Any, ...]]


@cache
def slots(rule: str, kind: type[nodes.Node]) -> Slots:
    """Return the fields that the clauses and options of a rule fill in its node."""
    single: dict[str, str] = {}
    rows: dict[str, str] = {}
    empty: dict[str, Any] = {}
    for part in parts(rule, kind):
        if part.field:
            clause = str(part.shape)
            many = declared(kind, part.field).startswith("tuple[")
            (rows if many else single)[heads(clause)[0]] = part.field
            empty[part.field] = unsaid(clause, kind, part.field)
    return Slots(single, rows, empty, itemgetter(*kind.__struct_fields__))


def filled(into: Slots, read: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    """Return the fields by name, of what was read of each clause or option by its word.

    What could not be read is None. Of several things for a field that holds one the
    first counts; rows are joined.
    """
    made = dict(into.unsaid)
    for word, values in read.items():
        field = into.single.get(word)
        if field is None:
            field = into.rows[word]
            rows = [_row(value, field) for value in values if value is not None]
            if rows:
                made[field] = (*(made[field] or ()), *chain.from_iterable(rows))
        elif values[0] is not None:
            made[field] = values[0]
    return made


def _row(value: Any, field: str) -> Iterable[Any]:
    """A row as it is, that of a node which holds one of the same name, or one thing."""
    if isinstance(value, nodes.Node):
        held: Iterable[Any] = getattr(value, field, (value,))
        return held
    return value if type(value) is tuple else (value,)
