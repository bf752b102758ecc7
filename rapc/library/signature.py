"""What one declaration says about a name: a signature, of a form or of what is offered.

Not here: which names there are, and what is wrong with a use of one
(`rapc.library.signatures`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
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


class RapSignatures(Mapping[str, Signature]):
    """The signatures of RAPs that may be read only when they are asked for."""

    def __init__(self, raps: Mapping[str, nodes.DefineRap]) -> None:
        self._raps = raps
        self._made: dict[str, Signature] = {}

    def __getitem__(self, name: str) -> Signature:
        made = self._made.get(name)
        if made is None:
            rap = self._raps[name]
            kinds = {one.variable: one.kind for one in rap.kinds}
            args = tuple(
                [nodes.Argument(v, kinds.get(v.name), span=v.span) for v in rap.inputs]
            )
            count, outputs = len(args), len(rap.outputs)
            made = Signature("RAP", name, count, count, args, rap.name_span, outputs)
            self._made[name] = made
        return made

    def __contains__(self, name: object) -> bool:
        return name in self._raps

    def __iter__(self) -> Iterator[str]:
        return iter(self._raps)

    def __len__(self) -> int:
        return len(self._raps)


# --- from declarations ----------------------------------------------------------------


def plain_signature(
    kind: Kind,
    form: nodes.DeclareProposition
    | nodes.DeclareDatum
    | nodes.DeclareSkill
    | nodes.DeclareEvent,
) -> Signature:
    """Return the signature of a declaration that says no more than its arguments."""
    count = None if form.args is None else len(form.args)
    return Signature(kind, form.name, count or 0, count, form.args, form.span)


def of_query(form: nodes.DefineQuery) -> Signature:
    """Return the signature of a named query, with the formula it stands for."""
    count = len(form.args)
    return Signature(
        "query",
        form.name,
        count,
        count,
        form.args,
        form.name_span,
        formula=form.formula,
    )


def of_property(form: nodes.DeclareProperty) -> Signature:
    """Return the signature of a property.

    Its value may be left out where an argument precedes the value [L 2.11].
    """
    count = None if form.args is None else len(form.args)
    least = max(1, (count or 0) - 1)
    return Signature(
        "property", form.name, least, count, form.args, form.span, default=form.default
    )


def of_function(form: nodes.DeclareFunction) -> Signature:
    """Return the signature of a function, with the predicates it says it reads."""
    count = None if form.args is None else len(form.args)
    return Signature(
        "function", form.name, count or 0, count, form.args, form.span, reads=form.reads
    )


def of_primitive(form: nodes.DeclarePrimitive) -> Signature:
    """Return the signature of a primitive, with its results."""
    count = len(form.args)
    return Signature(
        "primitive", form.name, count, count, form.args, form.span, results=form.results
    )


def of_counts(kind: Kind, offered: Mapping[str, int]) -> dict[str, Signature]:
    """Return signatures of which a world tells the numbers of arguments alone."""
    return {name: Signature(kind, name, n, n) for name, n in offered.items()}


def amount(count: int, word: str) -> str:
    """Return a number with a noun in the number it asks for: `no inputs`, `1 input`."""
    return plural(count, word) if count else f"no {word}s"
