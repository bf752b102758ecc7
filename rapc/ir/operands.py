"""What a formula holds, and what becomes of the variables there.

It is told by the types with which the fields of a node are declared: `Used` or
`Matched` terms, parts that hand out what they bind, `Closed` ones that do not. Of the
kinds in `_BY_VALUE` the operands have a say, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import Any

import msgspec

from rapc.ir import nodes
from rapc.ir.fields import declared, names_in_type


class Operands(msgspec.Struct, frozen=True):
    """The operands of a formula by what becomes of the variables in them."""

    #: Terms that need their values.
    used: tuple[nodes.Term, ...] = ()
    #: Terms that are held against values, all at once; variables take these.
    matched: tuple[nodes.Term, ...] = ()
    #: Formulas that must all hold, from left to right, each handing on what it binds.
    parts: tuple[nodes.Formula, ...] = ()
    #: Formulas that hand nothing out.
    closed: tuple[nodes.Formula, ...] = ()


def operands(formula: nodes.Formula) -> Operands:
    """Return what a formula holds; the parts of an `or` are among `parts`."""
    kind = type(formula)
    by_value = _BY_VALUE.get(kind)
    if by_value is not None:
        return by_value(formula)
    return _TAKEN[kind](formula)


_ROLES: Mapping[str, str] = {
    "Used": "used",
    "Matched": "matched",
    "Term": "matched",
    "Formula": "parts",
    "Proposition": "parts",
    "Closed": "closed",
}
"""What the types of fields say."""


def _fields(kind: type[nodes.Node]) -> tuple[tuple[str, ...], ...]:
    """The fields of a kind of formula for each field of `Operands`."""
    said = {
        field: {
            _ROLES[word]
            for word in names_in_type(declared(kind, field)) & _ROLES.keys()
        }
        for field in kind.__struct_fields__
    }
    return tuple(
        tuple([field for field, roles in said.items() if role in roles])
        for role in Operands.__struct_fields__
    )


def _held(
    kind: type[nodes.Node], fields: tuple[str, ...]
) -> Callable[[nodes.Node], tuple[Any, ...]]:
    """Return what takes the values of some fields from a node, as one tuple."""
    takes = [attrgetter(field) for field in fields]
    rows = [declared(kind, field).startswith("tuple[") for field in fields]
    if len(fields) == 1 and rows[0]:
        return takes[0]
    if len(fields) > 1 and not any(rows):
        return attrgetter(*fields)
    return lambda node: tuple(
        one
        for take, row in zip(takes, rows, strict=True)
        for one in (take(node) if row else (take(node),))
    )


_FIELDS = {kind: _fields(kind) for kind in nodes.Formula.__args__}


def _taken(
    kind: type[nodes.Node], roles: tuple[tuple[str, ...], ...]
) -> Callable[[nodes.Node], Operands]:
    """Return what takes the operands from a formula of a kind, by role."""
    held = {at: _held(kind, fields) for at, fields in enumerate(roles) if fields}
    if len(held) == 1:
        ((at, only),) = held.items()
        made: Callable[..., Operands] = Operands
        before = ((),) * at
        return lambda formula: made(*before, only(formula))
    names = Operands.__struct_fields__
    return lambda formula: Operands(
        **{names[at]: take(formula) for at, take in held.items()}
    )


_TAKEN = {kind: _taken(kind, fields) for kind, fields in _FIELDS.items()}

PARTS: Mapping[type, tuple[str, ...]] = {
    kind: (*fields[2], *fields[3]) for kind, fields in _FIELDS.items()
}
"""For each kind of formula, the fields that hold formulas."""


def _history_test(formula: nodes.HistoryTest) -> Operands:
    """Return the method of a question about history, and the result asked for."""
    if formula.query == "method-tried":
        return Operands(used=formula.args)
    return Operands(used=formula.args[:-1], matched=formula.args[-1:])


def _sensor_name(formula: nodes.SensorName) -> Operands:
    """Of what is out of sight there is no end: it has to be named."""
    value = formula.value
    if type(value) is nodes.Const and value.value == "false":
        return Operands(used=(formula.item,))
    return Operands(matched=(formula.item, value))


_BY_VALUE: Mapping[type, Callable[[Any], Operands]] = {
    nodes.HistoryTest: _history_test,
    nodes.SensorName: _sensor_name,
}
