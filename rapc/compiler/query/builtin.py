"""Run-time helpers of compiled queries: arithmetic, comparison, sets.

A helper raises `QueryFault` for invalid values; its caller adds the clause [L 2.46].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Number, Text, format_atom, number


class QueryFault(Exception):
    """An unbound variable or a value of the wrong kind in a computation.

    The text names the variable or value.
    """


class TooManySteps(Exception):  # an end of the search, not an error
    """A query exceeded its limit of steps back and is aborted [L 2.70]."""


class Unbound:
    """The type of the marker for a variable without a value."""

    def __repr__(self) -> str:
        return "UNBOUND"


UNBOUND = Unbound()

MOST = 2**1000
"""The largest result of a computation, so that larger values do not arise."""


def _numbers(args: Sequence[object]) -> list[Number]:
    for arg in args:
        if type(arg) is not int and type(arg) is not float:
            raise QueryFault(f"`{format_atom(arg)}` is not a number")
    return list(args)  # type: ignore[arg-type]  # the loop has checked the types


def _result(compute: Callable[[], float]) -> Number:
    """Return a computed number in canonical form. Raises QueryFault on overflow."""
    try:
        found = number(compute())
    except (ValueError, OverflowError):
        found = MOST + 1
    return _measured(found)


def _measured(found: Number) -> Number:
    if not -MOST <= found <= MOST:
        raise QueryFault("the result is too large")
    return found


def add(args: Sequence[object]) -> Number:
    """Return `(+ a b ...)`. Raises QueryFault for non-numbers, and on overflow."""
    if len(args) == 2:
        one, other = args
        if type(one) is int and type(other) is int:
            return _measured(one + other)
    values = _numbers(args)
    return _result(lambda: sum(values))


def subtract(args: Sequence[object]) -> Number:
    """Return `(- a b ...)`; `(- a)` is the negative. Raises QueryFault as `add`."""
    if len(args) == 2:
        one, other = args
        if type(one) is int and type(other) is int:
            return _measured(one - other)
    first, *rest = _numbers(args)
    return _result(lambda: first - sum(rest) if rest else -first)


def multiply(args: Sequence[object]) -> Number:
    """Return `(* a b ...)`. Raises QueryFault as `add`."""
    return reduce(_product, _numbers(args))


def _product(a: Number, b: Number) -> Number:
    return _result(lambda: a * b)


def divide(args: Sequence[object]) -> Number:
    """Return `(/ a b ...)`; an int if whole. Raises QueryFault, on 0 too."""
    return reduce(_quotient, _numbers(args))


def _quotient(a: Number, b: Number) -> Number:
    if b == 0:
        raise QueryFault("division by zero")
    if isinstance(a, int) and isinstance(b, int) and a % b == 0:
        return a // b
    return _result(lambda: a / b)


def size_of(args: Sequence[object]) -> Number:
    """Return `(size-of ?set)`. Raises QueryFault for anything but a set."""
    return len(set_members(args[0]))


def value_of(args: Sequence[object]) -> Number:
    """Return `(value ?counter)`. Raises QueryFault for anything but a counter."""
    counter = args[0]
    if not isinstance(counter, Counter):
        raise QueryFault(f"`{format_atom(counter)}` is not a counter")
    return counter.value


def set_members(value: object) -> Mapping[object, None]:
    """Return the members of a set resource. Raises QueryFault for anything else."""
    if not isinstance(value, SetResource):
        raise QueryFault(f"`{format_atom(value)}` is not a set")
    return value.members  # type: ignore[return-value]  # keys are looked up only


FUNCTIONS: Mapping[str, Callable[[Sequence[object]], Number]] = {
    "+": add,
    "-": subtract,
    "*": multiply,
    "/": divide,
    "size-of": size_of,
    "value": value_of,
}
"""The built-in functions of terms."""


def as_value(result: object) -> Value:
    """Return the result of a registered function as the value of a term.

    Raises QueryFault for a result that is not a value of the language, for example None
    or a `bool`.
    """
    if type(result) is int or type(result) is float:
        return _result(lambda: result)
    if isinstance(result, str | Text | Counter | SetResource):
        return result
    raise QueryFault(f"`{result}` is not a value")


def holds(result: object) -> bool:
    """Return whether the result of a declared function counts as true in a test."""
    return result not in (None, False, "false", "nil")
