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

from collections.abc import Container, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, cast

import msgspec

from rapc.base.names import Suggestions, is_slip
from rapc.base.values import Atom
from rapc.language.heads import CALLS, QUERIES
from rapc.library.kinds import Kinds, misfits, said_of
from rapc.library.lazy import Lazy
from rapc.library.library import KINDS, Library
from rapc.library.signature import (
    Declared,
    Kind,
    Signature,
    amount,
    of_counts,
    of_declaration,
    of_rap,
)

if TYPE_CHECKING:
    from rapc.world import Offer

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

SPACES = ("RAP", "predicate", "primitive", "datum", "skill", "event")
"""The spaces that names with arguments share."""

_IN_MEMORY: Sequence[Kind] = ("proposition", "property")
"""The kinds of predicates of which memory holds facts."""


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
    #: What may be meant by an unknown name, if it is declared.
    near: Signature | None = None
    #: The name at fault.
    name: str = ""
    #: The name that can be written in its place; None if there is none.
    meant: str | None = None

    def __str__(self) -> str:
        """The message, with the name that may have been meant."""
        question = self.help.startswith(_QUESTION)
        return f"{self.message}; {self.help}" if question else self.message


class Signatures:
    """All signatures of a library, or of what a world offers, by name.

    The tables are complete and never change; what is remembered is which names were
    found to be near to an unknown one.

    Args:
        tables: the signatures by the space that their names share, and by name; the
            names of skills and events have their colon.
        kinds: the kinds of values.
    """

    def __init__(
        self, tables: Mapping[str, Mapping[str, Signature]], kinds: Kinds
    ) -> None:
        self.kinds = kinds
        self._tables = {space: tables.get(space, {}) for space in SPACES}
        self.raps = self._tables["RAP"]
        #: The propositions, properties, functions and queries.
        self.predicates = predicates = self._tables["predicate"]
        #: The propositions and properties: what may stand in memory.
        self.relations = {n: s for n, s in predicates.items() if s.kind in _IN_MEMORY}
        #: The functions that are declared.
        self.functions = {n: s for n, s in predicates.items() if s.kind == "function"}
        self.primitives = self._tables["primitive"]
        self.data = self._tables["datum"]
        self.skills = self._tables["skill"]
        self.events = self._tables["event"]
        self._near: dict[str, Suggestions] = {}

    @classmethod
    def of(cls, library: Library) -> Signatures:
        """Return the signatures of a linked library.

        A RAP is looked at when its signature is asked for.
        """
        tables: dict[str, dict[str, Signature]] = {}
        for field, space, word in KINDS.values():
            if space in SPACES and space != "RAP":
                forms: Mapping[str, Declared] = getattr(library, field)
                found = {n: of_declaration(cast(Kind, word), forms[n]) for n in forms}
                tables.setdefault(space, {}).update(found)
        raps = Lazy(library.raps, lambda name: of_rap(library.raps[name]))
        return cls({**tables, "RAP": raps}, Kinds(library.kinds))

    @classmethod
    def offered(cls, offer: Offer) -> Signatures:
        """Return the signatures of what a world offers; they have no place."""
        primitives = {
            name: Signature("primitive", name, count, count, results=tuple(results))
            for name, (count, results) in offer.primitives.items()
        }
        tables = {
            "primitive": primitives,
            "datum": of_counts("sensor datum", offer.data),
            "skill": of_counts("skill", offer.skills),
            "event": of_counts("event", offer.events),
        }
        return cls(tables, Kinds({}))

    def fault(
        self,
        use: Use,
        name: str,
        count: int,
        outputs: int | None = None,
        within: str = "",
    ) -> Fault | None:
        """Return what is wrong with a use of a name, or None.

        Args:
            use: how the name is used.
            name: the name.
            count: how many arguments (inputs) it is given.
            outputs: how many outputs are taken of a RAP; None if none are named.
            within: the RAP that asks for the name; nothing if none does.
        """
        declared = self.table(use).get(name)
        if declared is None:
            fault = self.unknown(use, name, within)
            fits = fault.near is None or not _miscount(fault.near, use, count, outputs)
            return fault if fits else msgspec.structs.replace(fault, meant=None)
        computed = use == "computed" or declared.kind in _COMPUTED
        if computed and (what := _other_kind(use, declared.kind)) is not None:
            help_ = ""
            if use == "computed":
                help_ = f"ask `{declared.written}` in a formula first and use the "
                help_ += "variable it binds"
            message = f"`{name}` is a {declared.kind} and {what}"
            return Fault("kind", message, help_, declared)
        message = _miscount(declared, use, count, outputs)
        return Fault("arguments", message, "", declared) if message else None

    def wrong_kind(
        self, use: Use, name: str, values: Sequence[Atom | None]
    ) -> str | None:
        """Return what is wrong with the kinds of the values given to a name, or None.

        A name that is not declared, and arguments without kinds, hold nothing. None
        stands for a value that is not known yet.
        """
        declared = self.table(use).get(name)
        args = declared.args if declared is not None else None
        if declared is None or not args or all(arg.kind is None for arg in args):
            return None
        if declared.leaves_value_out(len(values)) and use != "erased":
            values = (*values, "true")
        for arg, value in misfits(self.kinds, args, values):
            if value is not None:
                return f"{said_of(arg, value)} in `{declared.written}`"
        return None

    def no_result(self, name: str, result: str) -> Fault | None:
        """Return what is wrong with `result` as a result of a primitive, or None.

        A primitive that is not declared has no results to hold it against.
        """
        declared = self.primitives.get(name)
        if declared is None or result in declared.results:
            return None
        results = Suggestions(declared.results)
        message = f"`{result}` is no result of `{name}`"
        return Fault(
            "result",
            message,
            results.did_you_mean(result),
            declared,
            name=result,
            meant=results.near(result),
        )

    def table(self, use: Use) -> Mapping[str, Signature]:
        """Return the signatures among which a name used so is looked up."""
        return self._tables[_SPACE_OF.get(use, use)]

    def unknown(self, use: Use, name: str, within: str = "") -> Fault:
        """Return what to say about a name that is not declared, used so.

        The RAP `within` which the name stands is meant only if the name is a slip: few
        RAPs ask for themselves.
        """
        word = _word(use)
        near = self._near.get(use)
        if near is None:
            built_in = QUERIES if use in _OF_PREDICATES else ()
            built_in = CALLS if use == "computed" else built_in
            near = Suggestions((*self._meant(use), *built_in))
            self._near[use] = near
        message = f"no {word} is called `{name}`"
        if word == "predicate":
            message = f"`{name}` is not declared"
        advice = self._meant_elsewhere(use, name)
        if advice:
            return Fault("unknown", message, advice)
        meant = near.near(name)
        if meant == within and not is_slip(name, within):
            return Fault("unknown", message, _advice(word))
        declared = self.table(use).get(meant or "")
        help_ = near.did_you_mean(name, _advice(word))
        return Fault("unknown", message, help_, near=declared, name=name, meant=meant)

    def _meant_elsewhere(self, use: Use, name: str) -> str:
        """Return what to do about a name that is known in another place, or nothing."""
        if use == "goal" and name in self.primitives:
            return (
                f"`{name}` is a primitive, and a RAP is wanted here: define one with "
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


# --- words ---------------------------------------------------------------------------

_QUESTION = "did you mean"

_OF_PREDICATES: Sequence[Use] = ("test", "believed", "asserted", "erased", "computed")
"""The uses of propositions, properties, functions and queries."""

_SPACE_OF: Mapping[Use, str] = {
    **dict.fromkeys(_OF_PREDICATES, "predicate"),
    "goal": "RAP",
}
"""The space in which a name used so is looked up; that of its own name for others."""


def _word(use: Use) -> str:
    """Return the word for what is unknown if a name used so is."""
    if use == "computed":
        return "function"
    return "sensor datum" if use == "datum" else _SPACE_OF.get(use, use)


def _advice(word: str) -> str:
    """Return what to do about an unknown name."""
    if word == "function":
        return "declare it with `declare-memory-function`"
    forms = {"RAP": "define it", "predicate": "declare it"}
    form = forms.get(word, f"declare it with `declare-{word.replace(' ', '-')}`")
    return f"{form}, or `require` the file that does"


_OPERATORS: Mapping[str, str] = {"!=": "n=", "<>": "n=", "/=": "n=", "==": "="}
"""What other languages call a comparison, and what it is called here."""

_NO_FACT: Mapping[Use, str] = {
    "believed": "has no age",
    "asserted": "cannot be asserted",
    "erased": "cannot be erased",
}


_COMPUTED: Container[Kind] = ("function", "query")
"""What is asked for without standing in memory."""


def _miscount(declared: Signature, use: Use, count: int, outputs: int | None) -> str:
    """Say what is wrong with the numbers of arguments and outputs, or nothing."""
    message = declared.miscount(count, erased=use == "erased") or ""
    if outputs is None or outputs == declared.outputs:
        return message
    wrong = f"{amount(declared.outputs, 'output')}, not {outputs}"
    return f"{message} and {wrong}" if message else f"`{declared.name}` has {wrong}"


def _other_kind(use: Use, kind: Kind) -> str | None:
    """Say why a predicate of a kind does not serve a use; None where it does."""
    if kind == "function" or (kind == "query" and use != "computed"):
        return _NO_FACT.get(use)
    return "computes nothing" if use == "computed" else None
