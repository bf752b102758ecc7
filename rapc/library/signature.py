"""What one declaration says about a name: a signature, of a form or of what is offered.

Not here: which names there are, and what is wrong with a use of one
(`rapc.library.signatures`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import msgspec

from rapc.base.names import plural
from rapc.base.source import NOWHERE, Span
from rapc.base.values import format_list
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
"""What a name is declared to be."""

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

CONSTANT_DEFAULTS = ("unknown", "true", "false")
"""Defaults of properties that are values; any other names a registered function."""


class Signature(msgspec.Struct, frozen=True):
    """What one declaration says about a name."""

    kind: Kind
    name: str
    #: The fewest arguments (inputs of a RAP) that a use may have.
    least: int
    #: The most arguments; None where the declaration gives no list (T A.1).
    most: int | None
    #: The declared arguments with their kinds; None where there is no list of them.
    args: tuple[nodes.Argument, ...] | None = None
    #: The declaration; of a RAP, its name in the index.
    span: Span = NOWHERE
    #: The number of outputs of a RAP.
    outputs: int = 0
    #: The results of a primitive.
    results: tuple[str, ...] = ()
    #: A property's default value, or the name of the function that computes it.
    default: str | None = None
    #: The predicates that a function reads; None where nothing is said of them.
    reads: tuple[str, ...] | None = None
    #: What a query stands for; None for all else.
    formula: nodes.Formula | None = None

    @property
    def is_property(self) -> bool:
        """Whether this is a property, so that its last argument is its value."""
        return self.kind == "property"

    @property
    def default_function(self) -> str | None:
        """The name of the default function, if the default is not a value."""
        return None if self.default in CONSTANT_DEFAULTS else self.default

    @property
    def written(self) -> str:
        """The name with its arguments' names, as a use would write them."""
        args = self.args or ()
        return format_list([self.name, *(arg.variable.name for arg in args)])

    def full(self, terms: Sequence[nodes.Term]) -> tuple[nodes.Term, ...]:
        """Return the arguments of a use with the value `true` that was left out.

        A property one argument short means the value `true` [L 2.11].
        """
        if self.leaves_value_out(len(terms)):
            return (*terms, nodes.Const("true"))
        return tuple(terms)

    def leaves_value_out(self, count: int) -> bool:
        """Whether a use with `count` arguments is a property without its value."""
        return self.kind == "property" and count > 0 and count + 1 == self.most

    def miscount(self, count: int, *, erased: bool = False) -> str | None:
        """Say what is wrong with `count` arguments, or return None.

        What is `erased` is a prefix, which may be shorter than what is declared.
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


def of_declaration(kind: Kind, form: Declared) -> Signature:
    """Return the signature of a declaration.

    The value of a property may be left out where an argument precedes it [L 2.11].
    """
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
        default=getattr(form, "default", None),
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
    """Return signatures of which a world tells the numbers of arguments alone."""
    return {name: Signature(kind, name, n, n) for name, n in offered.items()}


def amount(count: int, word: str) -> str:
    """Return a number with a noun in the number it asks for: `no inputs`, `1 input`."""
    return plural(count, word) if count else f"no {word}s"
