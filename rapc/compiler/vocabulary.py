"""What the declarations of a library say about names, in the form queries need.

Built once for a linked library; whether the declarations make sense is for
`rapc.analysis` to say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from rapc.ir import nodes
from rapc.library.library import Library

CONSTANT_DEFAULTS = ("unknown", "true", "false")
"""Defaults that are values; any other default names a registered function."""


class Relation(msgspec.Struct, frozen=True):
    """A declared proposition or property.

    `arity` counts the arguments, a property's value among them; None where the
    declaration gives no list. `default` is the default value of a property, or the
    name of the function that computes it; None for propositions.
    """

    name: str
    arity: int | None
    is_property: bool
    default: str | None = None

    @property
    def default_function(self) -> str | None:
        """The name of the default function, if the default is not a value."""
        return None if self.default in CONSTANT_DEFAULTS else self.default

    def full(self, args: Sequence[nodes.Term]) -> tuple[nodes.Term, ...]:
        """The arguments of a pattern, with the value `true` left out put in.

        A property one argument short means the value `true` (semantics 2).
        """
        if self.is_property and self.arity and len(args) == self.arity - 1 > 0:
            return (*args, nodes.Const("true"))
        return tuple(args)


class Vocabulary(msgspec.Struct, frozen=True):
    """The relations and functions that a library declares, by name."""

    relations: Mapping[str, Relation]
    functions: Mapping[str, nodes.DeclareFunction]

    @classmethod
    def of(cls, library: Library) -> Vocabulary:
        """The vocabulary of a linked library."""
        relations: dict[str, Relation] = {}
        for proposition in library.propositions.values():
            relations[proposition.name] = Relation(
                proposition.name, _arity(proposition.args), False
            )
        for declared in library.properties.values():
            relations[declared.name] = Relation(
                declared.name, _arity(declared.args), True, declared.default
            )
        return cls(relations, dict(library.functions))


def _arity(args: Sequence[nodes.Argument] | None) -> int | None:
    return None if args is None else len(args)
