"""What terms are worth: constants, variables, arithmetic, resources, functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Text, format_atom, number
from rapc.ir import nodes
from tests.reference.memory import Memory

Bindings = Mapping[str, Value]

Functions = Mapping[str, Callable[..., Any]]


OWN = "~"
"""Behind it stands which use of a named query a variable belongs to."""


class Fault(Exception):
    """A term that is unbound or of the wrong kind; the message says which."""


def unfit(value: object, wanted: str) -> Fault:
    """The fault of a value that is not what is wanted."""
    return Fault(f"`{format_atom(value)}` is not {wanted}")


class Terms:
    """Computes terms over a memory and the registered functions."""

    def __init__(self, memory: Memory, functions: Functions) -> None:
        self.memory = memory
        self.functions = functions

    def term(self, term: nodes.Term, env: Bindings) -> Value:
        """The value of a term. Raises Fault if it has none."""
        if isinstance(term, nodes.Const):
            return term.value
        if isinstance(term, nodes.Var):
            if term.name not in env:
                raise Fault(f"{term.name.partition(OWN)[0]} is not bound")
            return env[term.name]
        values = [self.term(arg, env) for arg in term.args]
        if term.function == "value":
            if not isinstance(values[0], Counter):
                raise unfit(values[0], "a counter")
            return values[0].value
        if term.function == "size-of":
            return len(members(values[0]))
        if term.function in ("+", "-", "*", "/"):
            return arithmetic(term.function, values)
        return self.call(term.function, values)

    def call(self, name: str, values: list[Value]) -> Value:
        """What a declared function returns, in the one form of its kind."""
        result = self.functions[name](self.memory, *values)
        if isinstance(result, float):
            return number(result)
        assert isinstance(result, str | int | Text)
        return result


def members(value: Value) -> Mapping[Any, None]:
    """The members of a set. Raises Fault for anything else."""
    if not isinstance(value, SetResource):
        raise unfit(value, "a set")
    return value.members


def arithmetic(sign: str, values: list[Value]) -> Value:
    """`+ - * /`, from left to right. Raises Fault."""
    numbers: list[int | float] = []
    for value in values:
        if not isinstance(value, int | float):
            raise unfit(value, "a number")
        numbers.append(value)
    total, *rest = numbers
    if not rest:
        return number(-total)
    for each in rest:
        if sign == "/" and each == 0:
            raise Fault("division by zero")
        try:
            total = number(
                total + each
                if sign == "+"
                else total - each
                if sign == "-"
                else total * each
                if sign == "*"
                else total / each
            )
        except (OverflowError, ValueError):
            raise Fault("the result is too large") from None
        if abs(total) > 2**1000:
            raise Fault("the result is too large")
    return total
