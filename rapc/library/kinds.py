"""Kinds of values, which restrict the values of declared arguments.

The kinds `number`, `text`, `item` (any name) and `symbol` are built in. A declared kind
is open to any symbol or closed to the listed values. If a kind `:is` a parent kind, its
values are also of the parent kind. `unknown` is of every kind.

The kinds of facts and goals from outside the library are validated at run time. Inside
a library only the checker validates kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from rapc.base.values import Atom, Text, format_atom, is_number
from rapc.ir import nodes

Test = Callable[[object], bool]
"""A predicate: whether a value is of a kind."""

UNKNOWN = "unknown"
"""The value of every kind."""


def _is_name(value: object) -> bool:
    return isinstance(value, str)


def _anything(_: object) -> bool:
    return True


_KNOWN: Mapping[str, Test] = {
    "number": is_number,
    "text": lambda value: isinstance(value, Text),
    "item": _is_name,
    "symbol": _is_name,
}

KNOWN_KINDS = tuple(_KNOWN)
"""The built-in kinds."""


class Kinds:
    """The declared kinds of a library and the built-in kinds.

    Args:
        declared: the declarations by name.
    """

    def __init__(self, declared: Mapping[str, nodes.DeclareKind]) -> None:
        self._declared = declared
        self._tests: dict[str, Test] = {}
        self._below: dict[str, list[str]] = {}
        for form in declared.values():
            if form.above is not None:
                self._below.setdefault(form.above, []).append(form.name)

    def __contains__(self, name: object) -> bool:
        """Return whether a kind is declared or built in."""
        return name in _KNOWN or name in self._declared

    def __iter__(self) -> Iterator[str]:
        """Return the names of all kinds."""
        return iter([*_KNOWN, *self._declared])

    def holds(self, kind: str, value: object) -> bool:
        """Return whether a value is of a kind; an undeclared kind has all values."""
        return self.test(kind)(value)

    def test(self, kind: str) -> Test:
        """Return the predicate of a kind; see `holds`.

        The predicate is cached, because it tests each datum and each asserted fact.
        """
        found = self._tests.get(kind)
        if found is None:
            found = self._tests[kind] = self._test(kind)
        return found

    def _test(self, kind: str) -> Test:
        if kind not in self:
            return _anything
        listed = None if kind in _KNOWN else self.values(kind)
        if listed is not None:
            return (*listed, UNKNOWN).__contains__
        root = self._root(kind)
        return root if root is _is_name else lambda v: v == UNKNOWN or root(v)

    def values(self, kind: str) -> Sequence[Atom] | None:
        """Return the values of a closed kind; None for an open kind.

        The values of descendant kinds are included. A kind with an open descendant is
        open.
        """
        found: list[Atom] = []
        for name in self._with_those_below(kind):
            own = self._declared[name].values if name in self._declared else None
            if own is None:
                return None
            found.extend(own)
        return list(dict.fromkeys(found))

    def above(self, kind: str) -> Sequence[str]:
        """Return the ancestors of a kind, parent first.

        In a cycle each kind is returned once, the kind itself last.
        """
        found: dict[str, None] = {}
        declared = self._declared.get(kind)
        while declared is not None and declared.above is not None:
            if declared.above in found:
                break
            found[declared.above] = None
            declared = self._declared.get(declared.above)
        return list(found)

    def apart(self, one: str, other: str) -> bool:
        """Return whether two kinds have no common value except `unknown`."""
        if one not in self or other not in self:
            return False
        named = ({one, *self.above(one)}, {other, *self.above(other)})
        if one in named[1] or other in named[0]:
            return False
        if "item" in (one, other) or "symbol" in (one, other):
            return self._root(one) is not self._root(other)
        listed = (self.values(one), self.values(other))
        if listed[0] is None or listed[1] is None:
            return True
        return set(listed[0]).isdisjoint(listed[1])

    def _root(self, kind: str) -> Test:
        known = (name for name in (kind, *self.above(kind)) if name in _KNOWN)
        return _KNOWN[next(known, "symbol")]

    def _with_those_below(self, kind: str) -> Iterator[str]:
        seen: dict[str, None] = {kind: None}
        stack = [kind]
        while stack:
            here = stack.pop()
            yield here
            for name in self._below.get(here, ()):
                if name not in seen:
                    seen[name] = None
                    stack.append(name)


def said_of(arg: nodes.Argument, value: Atom) -> str:
    """Return the message for a value that is not of the kind of an argument."""
    assert arg.kind is not None
    named = f"`{format_atom(value)}` is not a value of kind {arg.kind}"
    return f"{named}, as declared for `{arg.variable.name}`"
