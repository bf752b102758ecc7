"""The signature table: each name that a library or a world declares, its arguments.

Whether a name is known where it stands, and with how many arguments, is answered here
and nowhere else: for passes, tests, faults, scripts, questions of a host, admission to
a world and compiled libraries alike, in the same words. Not here: where the use stands,
and what becomes of the answer (a finding, a refusal, an exception).

A `Use` says how a name is used; it decides in which table the name is looked up and
which kinds of declaration serve. Propositions, properties, functions and named queries
share a table, for a formula does not say which it means.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import msgspec

from rapc.base.names import Suggestions
from rapc.base.source import NOWHERE, Span
from rapc.base.values import Atom, format_list
from rapc.ir import nodes
from rapc.language.heads import CALLS, QUERIES
from rapc.library.kinds import Kinds, misfits, said_of
from rapc.library.library import Library

if TYPE_CHECKING:
    from rapc.world import Offer

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

Use = Literal[
    "goal",
    "test",
    "believed",
    "asserted",
    "erased",
    "computed",
    "primitive",
    "datum",
    "skill",
    "event",
]
"""How a name is used: to ask for a RAP; as a proposition in a formula, in a `believe`,
put into memory or taken out of it; as the function of a computed term; as what is sent
to a world or comes from there."""

_IN_MEMORY: Sequence[Kind] = ("proposition", "property")
"""The kinds of predicates of which memory holds facts."""

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
                return f"`{self.name}` has {_number(most, 'input')}, not {count}"
            bound = "at most " if erased else ""
            wanted = bound + _number(most, "argument")
        elif count < least:
            wanted = "at least " + _number(least, "argument")
        else:
            return None
        return f"`{self.name}` takes {wanted}, not {count}"


class Fault(msgspec.Struct, frozen=True):
    """Why a name cannot be used as it is."""

    #: Whether the name is unknown, or declared as something else, or takes other
    #: arguments than it is given.
    sort: Literal["unknown", "kind", "arguments", "result"]
    #: What is wrong, in one line.
    message: str
    #: What to do about it: a question, an advice, or nothing.
    help: str = ""
    #: The declaration that the use does not meet; None where there is none.
    declared: Signature | None = None
    #: What may be meant by an unknown name.
    near: Signature | None = None

    def __str__(self) -> str:
        """The message, with the name that may have been meant."""
        question = self.help.startswith(_QUESTION)
        return f"{self.message}; {self.help}" if question else self.message


class Signatures:
    """All signatures of a library, or of what a world offers, by name.

    The tables are complete and never change; what is remembered is which names were
    found to be near to an unknown one.

    Args:
        raps: the RAPs.
        predicates: the propositions, properties, functions and queries.
        primitives: the primitives.
        data: the sensor data.
        skills: the skills, their names with the colon.
        events: the events, their names with the colon.
        kinds: the kinds of values.
    """

    def __init__(
        self,
        raps: Mapping[str, Signature],
        predicates: Mapping[str, Signature],
        primitives: Mapping[str, Signature],
        data: Mapping[str, Signature],
        skills: Mapping[str, Signature],
        events: Mapping[str, Signature],
        kinds: Kinds,
    ) -> None:
        self.kinds = kinds
        self.raps = raps
        self.predicates = predicates
        #: The propositions and properties: what may stand in memory.
        self.relations = {n: s for n, s in predicates.items() if s.kind in _IN_MEMORY}
        #: The functions that are declared.
        self.functions = {n: s for n, s in predicates.items() if s.kind == "function"}
        self.primitives = primitives
        self.data = data
        self.skills = skills
        self.events = events
        self._near: dict[str, Suggestions] = {}

    @classmethod
    def of(
        cls, library: Library, raps: Mapping[str, Signature] | None = None
    ) -> Signatures:
        """Return the signatures of a linked library.

        A RAP is looked at when its signature is asked for, unless `raps` has them.
        """
        predicates = {
            **{
                n: _plain("proposition", form)
                for n, form in library.propositions.items()
            },
            **{n: _property(form) for n, form in library.properties.items()},
            **{n: _function(form) for n, form in library.functions.items()},
            **{n: _query(form) for n, form in library.queries.items()},
        }
        return cls(
            _Raps(library.raps) if raps is None else raps,
            predicates,
            {n: _primitive(form) for n, form in library.primitives.items()},
            {n: _plain("sensor datum", form) for n, form in library.data.items()},
            {n: _plain("skill", form) for n, form in library.skills.items()},
            {n: _plain("event", form) for n, form in library.events.items()},
            Kinds(library.kinds),
        )

    @classmethod
    def offered(cls, offer: Offer) -> Signatures:
        """Return the signatures of what a world offers; they have no place."""
        primitives = {
            name: Signature("primitive", name, count, count, results=tuple(results))
            for name, (count, results) in offer.primitives.items()
        }
        return cls(
            {},
            {},
            primitives,
            _counts("sensor datum", offer.data),
            _counts("skill", offer.skills),
            _counts("event", offer.events),
            Kinds({}),
        )

    def fault(
        self, use: Use, name: str, count: int, outputs: int | None = None
    ) -> Fault | None:
        """Return what is wrong with a use of a name, or None.

        Args:
            use: how the name is used.
            name: the name.
            count: how many arguments (inputs) it is given.
            outputs: how many outputs are taken of a RAP; None if none are named.
        """
        declared = self.table(use).get(name)
        if declared is None:
            return self.unknown(use, name)
        if (what := _other_kind(use, declared.kind)) is not None:
            help_ = ""
            if use == "computed":
                help_ = f"ask `{declared.written}` in a formula first and use the "
                help_ += "variable it binds"
            message = f"`{name}` is a {declared.kind} and {what}"
            return Fault("kind", message, help_, declared)
        message = declared.miscount(count, erased=use == "erased") or ""
        if outputs is not None and outputs != declared.outputs:
            amount = f"{_number(declared.outputs, 'output')}, not {outputs}"
            message = f"{message} and {amount}" if message else f"`{name}` has {amount}"
        return Fault("arguments", message, "", declared) if message else None

    def wrong_kind(self, use: Use, name: str, values: Sequence[Atom]) -> str | None:
        """Return what is wrong with the kinds of the values given to a name, or None.

        A name that is not declared, and arguments without kinds, hold nothing.
        """
        declared = self.table(use).get(name)
        args = declared.args if declared is not None else None
        if declared is None or not args or all(arg.kind is None for arg in args):
            return None
        if declared.leaves_value_out(len(values)) and use != "erased":
            values = (*values, "true")
        for arg, value in misfits(self.kinds, args, values):
            return f"{said_of(arg, value)} in `{declared.written}`"
        return None

    def no_result(self, name: str, result: str) -> Fault | None:
        """Return what is wrong with `result` as a result of a primitive, or None.

        A primitive that is not declared has no results to hold it against.
        """
        declared = self.primitives.get(name)
        if declared is None or result in declared.results:
            return None
        help_ = Suggestions(declared.results).did_you_mean(result)
        message = f"`{result}` is no result of `{name}`"
        return Fault("result", message, help_, declared)

    def table(self, use: Use) -> Mapping[str, Signature]:
        """Return the signatures among which a name used so is looked up."""
        return _TABLES[use](self)

    def unknown(self, use: Use, name: str) -> Fault:
        """Return what to say about a name that is not declared, used so."""
        space = _SPACES.get(use, "predicate")
        near = self._near.get(use)
        if near is None:
            near = Suggestions((*self._meant(use), *_BUILT_IN.get(use, ())))
            self._near[use] = near
        message = _MESSAGES[space].format(name)
        advice = self._meant_elsewhere(use, name)
        if advice:
            return Fault("unknown", message, advice)
        meant = self.table(use).get(near.near(name) or "")
        help_ = near.did_you_mean(name, _ADVICE[space])
        return Fault("unknown", message, help_, near=meant)

    def _meant_elsewhere(self, use: Use, name: str) -> str:
        """Return what to do about a name that is known in another place, or nothing."""
        if use == "goal" and name in self.primitives:
            return (
                f"`{name}` is a primitive, and a step asks for a RAP: define one with "
                f"the method `(primitive ({name} ...))`"
            )
        if use == "primitive" and name in self.raps:
            return (
                f"`{name}` is a RAP: what asks for it is a step, "
                f"`(task-net (t1 ({name} ...)))`"
            )
        meant = _OPERATORS.get(name)
        return f"write `{meant}`" if meant else ""

    def _meant(self, use: Use) -> Iterable[str]:
        """The declared names that may be meant by an unknown one."""
        return self.functions if use == "computed" else self.table(use)


class _Raps(Mapping[str, Signature]):
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
                [nodes.Argument(v, kinds.get(v.name), v.span) for v in rap.inputs]
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


def _plain(
    kind: Kind,
    form: nodes.DeclareProposition
    | nodes.DeclareDatum
    | nodes.DeclareSkill
    | nodes.DeclareEvent,
) -> Signature:
    count = None if form.args is None else len(form.args)
    return Signature(kind, form.name, count or 0, count, form.args, form.span)


def _query(form: nodes.DefineQuery) -> Signature:
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


def _property(form: nodes.DeclareProperty) -> Signature:
    """A property needs a value, which may be left out where something precedes it."""
    count = None if form.args is None else len(form.args)
    least = max(1, (count or 0) - 1)
    return Signature(
        "property", form.name, least, count, form.args, form.span, default=form.default
    )


def _function(form: nodes.DeclareFunction) -> Signature:
    count = None if form.args is None else len(form.args)
    return Signature(
        "function", form.name, count or 0, count, form.args, form.span, reads=form.reads
    )


def _primitive(form: nodes.DeclarePrimitive) -> Signature:
    count = len(form.args)
    return Signature(
        "primitive", form.name, count, count, form.args, form.span, results=form.results
    )


def _counts(kind: Kind, offered: Mapping[str, int]) -> dict[str, Signature]:
    return {name: Signature(kind, name, n, n) for name, n in offered.items()}


# --- words ----------------------------------------------------------------------------

_QUESTION = "did you mean"

_TABLES: Mapping[Use, Callable[[Signatures], Mapping[str, Signature]]] = {
    "goal": lambda all_: all_.raps,
    "test": lambda all_: all_.predicates,
    "believed": lambda all_: all_.predicates,
    "asserted": lambda all_: all_.predicates,
    "erased": lambda all_: all_.predicates,
    "computed": lambda all_: all_.predicates,
    "primitive": lambda all_: all_.primitives,
    "datum": lambda all_: all_.data,
    "skill": lambda all_: all_.skills,
    "event": lambda all_: all_.events,
}

_BUILT_IN: Mapping[Use, Iterable[str]] = {
    "test": QUERIES,
    "believed": QUERIES,
    "asserted": QUERIES,
    "erased": QUERIES,
    "computed": CALLS,
}
"""Names of the language that may be meant by an unknown one."""

_SPACES: Mapping[Use, str] = {
    "goal": "RAP",
    "computed": "function",
    "primitive": "primitive",
    "datum": "sensor datum",
    "skill": "skill",
    "event": "event",
}
"""For each use the word for what is unknown; all others ask for a predicate."""

_MESSAGES: Mapping[str, str] = {
    **{space: f"no {space} is called `{{}}`" for space in _SPACES.values()},
    "predicate": "`{}` is not declared",
}

_ADVICE: Mapping[str, str] = {
    "RAP": "define it, or `require` the file that does",
    "predicate": "declare it, or `require` the file that does",
    "function": "declare it with `declare-memory-function`",
    "primitive": "declare it with `declare-primitive`, or `require` the file that does",
    "sensor datum": "declare it with `declare-sensor-datum`, or `require` the file "
    "that does",
    "skill": "declare it with `declare-skill`, or `require` the file that does",
    "event": "declare it with `declare-event`, or `require` the file that does",
}

_OPERATORS: Mapping[str, str] = {"!=": "n=", "<>": "n=", "/=": "n=", "==": "="}
"""What other languages call a comparison, and what it is called here."""

_NO_FACT: Mapping[Use, str] = {
    "believed": "has no age",
    "asserted": "cannot be asserted",
    "erased": "cannot be erased",
}


def _other_kind(use: Use, kind: Kind) -> str | None:
    """Say why a predicate of a kind does not serve a use; None where it does."""
    if kind == "function" or (kind == "query" and use != "computed"):
        return _NO_FACT.get(use)
    return "computes nothing" if use == "computed" else None


def _number(count: int, word: str) -> str:
    return f"{count or 'no'} {word}{'' if count == 1 else 's'}"
