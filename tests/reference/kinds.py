"""Kinds, held wherever a fact, a goal, a datum or a signal comes in from outside [L 7].

What a library puts together itself is held by nobody.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rapc.base.values import Atom, Fact, Text, is_number
from rapc.ir import nodes
from rapc.library.library import Library
from tests.reference.run import Run


class WrongKind(Exception):
    """A value from outside is not of the kind that was declared for its place."""


class Broken(Exception):
    """A world has sent what it may not send: the run is over."""


_KNOWN: Mapping[str, Callable[[object], bool]] = {
    "number": is_number,
    "text": lambda value: isinstance(value, Text),
    "item": lambda value: isinstance(value, str),
    "symbol": lambda value: isinstance(value, str),
}


def is_of(library: Library, kind: str, value: Atom) -> bool:
    """Whether a value is of a kind."""
    if value == "unknown":
        return True
    if kind in _KNOWN:
        return _KNOWN[kind](value)
    declared = library.kinds[kind]
    if declared.values is None:
        own = _KNOWN[root(library, kind)](value)
    else:
        own = value in declared.values
    below = [name for name, form in library.kinds.items() if form.above == kind]
    return own or any(is_of(library, name, value) for name in below)


def root(library: Library, kind: str) -> str:
    """The known kind that all values of a kind are of."""
    above = library.kinds[kind].above or "symbol"
    return above if above in _KNOWN else root(library, above)


def hold_all(
    library: Library, args: Sequence[nodes.Argument] | None, values: Fact
) -> None:
    """See that values are of the kinds declared for them. Raises WrongKind."""
    for arg, value in zip(args or (), values, strict=False):
        if arg.kind is not None and not is_of(library, arg.kind, value):
            raise WrongKind(f"{value} is no {arg.kind}")


def hold_fact(library: Library, fact: Fact) -> None:
    """See that a fact is of its kinds. Raises WrongKind."""
    name = str(fact[0])
    declared = library.properties.get(name) or library.propositions[name]
    short = name in library.properties and len(fact) == len(declared.args or ())
    hold_all(library, declared.args, (*fact[1:], "true") if short else fact[1:])


def hold_goal(library: Library, goal: Fact) -> None:
    """See that the inputs of a goal are of their kinds. Raises WrongKind."""
    rap = library.raps[str(goal[0])]
    kinds = {one.variable: one.kind for one in rap.kinds}
    args = [nodes.Argument(input_, kinds.get(input_.name)) for input_ in rap.inputs]
    hold_all(library, args, goal[1:])


def hold_data(run: Run, data: Sequence[Fact]) -> None:
    """See that data of the world are of their kinds. Raises Broken."""
    for content in data:
        declared = run.library.data.get(str(content[0]))
        hold_sent(run, declared.args if declared is not None else (), content)


def hold_event(library: Library, content: Fact) -> None:
    """See that a signal is of its kinds. Raises WrongKind."""
    hold_all(library, library.events[str(content[0])].args, content[1:])


def hold_signal(run: Run, content: Fact) -> None:
    """See that a signal of the world is of its kinds. Raises Broken."""
    hold_sent(run, run.library.events[str(content[0])].args, content)


def hold_sent(run: Run, args: Sequence[nodes.Argument] | None, content: Fact) -> None:
    """See that what a world sends is of its kinds. Raises Broken."""
    try:
        hold_all(run.library, args, content[1:])
    except WrongKind as wrong:
        raise Broken(str(wrong)) from None
