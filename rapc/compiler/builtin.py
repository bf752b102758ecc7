"""What compiled queries and terms call at run time: arithmetic, comparison, sets.

A helper that cannot do its work raises `Fault`; who called it says which clause it
was (semantics 2: such a query fails and that is traced).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce

from rapc.resources import Counter, SetResource, Value
from rapc.terms import Number, Text, format_atom, number


class Fault(Exception):
    """An unbound variable or a value of the wrong kind met in a computation.

    The text says which.
    """


class Unbound:
    """The type of the mark of a variable without a value."""

    def __repr__(self) -> str:
        return "UNBOUND"


UNBOUND = Unbound()


def _numbers(args: Sequence[object]) -> list[Number]:
    for arg in args:
        if type(arg) is not int and type(arg) is not float:
            raise Fault(f"`{format_atom(arg)}` is not a number")
    return list(args)  # type: ignore[arg-type]  # the loop has seen to it


def _finite(value: float) -> Number:
    try:
        return number(value)
    except (ValueError, OverflowError):
        raise Fault("the result is too large") from None


def add(args: Sequence[object]) -> Number:
    """`(+ a b ...)`. Raises Fault on anything but numbers."""
    return _finite(sum(_numbers(args)))


def subtract(args: Sequence[object]) -> Number:
    """`(- a b ...)`; `(- a)` is the negative. Raises Fault as `add`."""
    first, *rest = _numbers(args)
    return _finite(first - sum(rest)) if rest else _finite(-first)


def multiply(args: Sequence[object]) -> Number:
    """`(* a b ...)`. Raises Fault as `add`, and on results beyond measure."""
    values = _numbers(args)
    if sum(v.bit_length() for v in values if isinstance(v, int)) > 1024:
        raise Fault("the result is too large")
    return _finite(reduce(lambda a, b: a * b, values))


def divide(args: Sequence[object]) -> Number:
    """`(/ a b ...)`; exact quotients are integers. Raises Fault on zero."""
    first, *rest = _numbers(args)
    result: Number = first
    for divisor in rest:
        if divisor == 0:
            raise Fault("division by zero")
        if isinstance(result, int) and isinstance(divisor, int):
            whole, left = divmod(result, divisor)
            result = whole if left == 0 else _quotient(result, divisor)
        else:
            result = _finite(result / divisor)
    return result


def _quotient(a: int, b: int) -> Number:
    try:
        return _finite(a / b)
    except OverflowError:
        raise Fault("the result is too large") from None


def size_of(args: Sequence[object]) -> Number:
    """`(size-of ?set)`. Raises Fault on anything but a set."""
    return len(set_members(args[0]))


def value_of(args: Sequence[object]) -> Number:
    """`(value ?counter)`. Raises Fault on anything but a counter."""
    counter = args[0]
    if not isinstance(counter, Counter):
        raise Fault(f"`{format_atom(counter)}` is not a counter")
    return counter.value


def set_members(value: object) -> Mapping[object, None]:
    """The members of a set resource. Raises Fault on anything else."""
    if not isinstance(value, SetResource):
        raise Fault(f"`{format_atom(value)}` is not a set")
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


def less(a: object, b: object) -> bool:
    """`(< a b)`: false on anything but two numbers."""
    return _comparable(a, b) and a < b  # type: ignore[operator]  # both are numbers


def less_equal(a: object, b: object) -> bool:
    """`(<= a b)`: false on anything but two numbers."""
    return _comparable(a, b) and a <= b  # type: ignore[operator]  # both are numbers


def _comparable(a: object, b: object) -> bool:
    kinds = (int, float)
    return type(a) in kinds and type(b) in kinds


def as_value(result: object) -> Value:
    """What a registered function returned as the value of a term.

    Raises Fault for what is no value of the language, None and `bool` among it.
    """
    if type(result) is float:
        return _finite(result)
    kinds = (str, int, Text, Counter, SetResource)
    if isinstance(result, kinds) and not isinstance(result, bool):
        return result
    raise Fault(f"`{result}` is not a value")


def holds(result: object) -> bool:
    """Whether what a declared function returned counts as true when it is a test."""
    return result not in (None, False, "false", "nil")
