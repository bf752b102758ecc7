"""What a formula holds, and what becomes of the variables there.

It is told by the types with which the fields of a node are declared: `Used` or
`Matched` terms, parts that hand out what they bind, `Closed` ones that do not. Of the
kinds in `_BY_VALUE` the operands have a say, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
    return Operands(*[_values(formula, fields) for fields in _FIELDS[kind]])


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


_FIELDS = {kind: _fields(kind) for kind in nodes.Formula.__args__}


def _values(formula: nodes.Formula, fields: tuple[str, ...]) -> tuple[Any, ...]:
    """The values of some fields of a formula, in a row."""
    found: list[Any] = []
    for field in fields:
        value = getattr(formula, field)
        found += value if type(value) is tuple else (value,)
    return tuple(found)


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
