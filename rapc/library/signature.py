"""The signature of a declared name, from a form or from the offer of a world.

Not here: the table of all names and the check of uses (`rapc.library.signatures`).
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Literal

import msgspec

from rapc.base.names import plural
from rapc.base.source import NOWHERE, Span
from rapc.base.values import Atom, format_list
from rapc.ir import nodes

Kind = Literal[
    "RAP",
    "proposition",
    "property",
    "function",
    "query",
    "primitive",
    "sensor datum",
    "skill",
    "event",
]
"""The kind of a declaration."""

Declared = (
    nodes.DeclareProposition
    | nodes.DeclareProperty
    | nodes.DeclareFunction
    | nodes.DefineQuery
    | nodes.DeclarePrimitive
    | nodes.DeclareDatum
    | nodes.DeclareSkill
    | nodes.DeclareEvent
)
"""Declarations of names with arguments."""


class Signature(msgspec.Struct, frozen=True):
    """The signature of a declared name."""

    kind: Kind
    name: str
    #: The fewest arguments (inputs of a RAP) that a use may have.
    least: int
    #: The most arguments; None if the declaration has no list (T A.1).
    most: int | None
    #: The declared arguments with their kinds; None if the declaration has no list.
    args: tuple[nodes.Argument, ...] | None = None
    #: The span of the declaration; for a RAP, of its name in the index.
    span: Span = NOWHERE
    #: The number of outputs of a RAP.
    outputs: int = 0
    #: The results of a primitive.
    results: tuple[str, ...] = ()
    #: The default value of a property; None for all other kinds.
    default: Atom | None = None
    #: The function that computes the default value of a property.
    default_function: str | None = None
    #: The predicates that a function reads; None if not declared.
    reads: tuple[str, ...] | None = None
    #: The formula of a query; None for all other kinds.
    formula: nodes.Formula | None = None

    @property
    def is_property(self) -> bool:
        """Whether the name is a property: its last argument is its value."""
        return self.kind == "property"

    @property
    def written(self) -> str:
        """The name with the names of its arguments, in the form of a use."""
        args = self.args or ()
        return format_list([self.name, *(arg.variable.name for arg in args)])

    def full(self, terms: Sequence[nodes.Term]) -> tuple[nodes.Term, ...]:
        """Return the arguments of a use, with a left-out value `true` added.

        A property without its last argument has the value `true` [L 2.11].
        """
        if self.leaves_value_out(len(terms)):
            return (*terms, nodes.Const("true"))
        return tuple(terms)

    def leaves_value_out(self, count: int) -> bool:
        """Return whether a use with `count` arguments leaves out a property's value."""
        return self.kind == "property" and count > 0 and count + 1 == self.most

    def miscount(self, count: int, *, erased: bool = False) -> str | None:
        """Return the message for a wrong number of arguments, or None.

        An `erased` pattern is a prefix, which may be shorter than the declaration.
        """
        least, most = 0 if erased else self.least, self.most
        if most is not None and (count > most or count < least):
            if self.kind == "RAP":
                return f"`{self.name}` has {amount(most, 'input')}, not {count}"
            bound = "at most " if erased else ""
            wanted = bound + amount(most, "argument")
        elif count < least:
            wanted = "at least " + amount(least, "argument")
        else:
            return None
        return f"`{self.name}` takes {wanted}, not {count}"


# --- from declarations ----------------------------------------------------------------


def of_declaration(
    kind: Kind, form: Declared, functions: Container[object] = ()
) -> Signature:
    """Return the signature of a declaration.

    The value of a property may be left out after an argument [L 2.11]. The default of a
    property is the name of a function if it is in `functions`.
    """
    default = getattr(form, "default", None)
    is_computed = default in functions
    count = None if form.args is None else len(form.args)
    is_property = isinstance(form, nodes.DeclareProperty)
    return Signature(
        kind,
        form.name,
        max(1, (count or 0) - 1) if is_property else count or 0,
        count,
        form.args,
        getattr(form, "name_span", form.span),
        results=getattr(form, "results", ()),
        default=None if is_computed else default,
        default_function=default if is_computed else None,
        reads=getattr(form, "reads", None),
        formula=getattr(form, "formula", None),
    )


def of_rap(rap: nodes.DefineRap) -> Signature:
    """Return the signature of a RAP."""
    kinds = {one.variable: one.kind for one in rap.kinds}
    args = tuple(
        [nodes.Argument(v, kinds.get(v.name), span=v.span) for v in rap.inputs]
    )
    count, outputs = len(args), len(rap.outputs)
    return Signature("RAP", rap.name, count, count, args, rap.name_span, outputs)


def of_counts(kind: Kind, offered: Mapping[str, int]) -> dict[str, Signature]:
    """Return the signatures of offered names, with only the number of arguments."""
    return {name: Signature(kind, name, n, n) for name, n in offered.items()}


def amount(count: int, word: str) -> str:
    """Return a number with its noun: `no inputs`, `1 input`, `2 inputs`."""
    return plural(count, word) if count else f"no {word}s"
