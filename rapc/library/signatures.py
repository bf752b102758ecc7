"""The signature table: each name that a library or a world declares, with arguments.

This module alone checks whether a name is known and has the right number of arguments.
The check serves passes, tests, faults, scripts, host queries, admission to a world and
compiled libraries, with the same messages. Not here: the position of the use, and the
form of the report (a finding, a refusal, an exception).

A `Use` selects the table for the lookup and the kinds of declaration that are valid.
Propositions, properties, functions and named queries share a table, because a formula
does not tell them apart.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, cast

import msgspec

from rapc.base.names import Suggestions, is_slip
from rapc.base.values import Atom
from rapc.language.heads import CALLS, QUERIES
from rapc.library.kinds import Kinds, Test, said_of
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
"""The use of a name: as a goal; as a proposition in a formula or in a `believe`,
asserted or erased; as the function of a computed term; as a request to a world or a
message from it."""

SPACES = ("RAP", "predicate", "primitive", "datum", "skill", "event")
"""The name spaces of names with arguments."""

_IN_MEMORY: Sequence[Kind] = ("proposition", "property")
"""The kinds of predicates that have facts in memory."""


class Fault(msgspec.Struct, frozen=True):
    """An invalid use of a name."""

    #: The sort of fault: the name is unknown, of a wrong kind, or has wrong arguments;
    #: or a result is unknown.
    sort: Literal["unknown", "kind", "arguments", "result"]
    #: The message, in one line.
    message: str
    #: The help: a question, an advice, or nothing.
    help: str = ""
    #: The declaration that the use violates; None if the name is not declared.
    declared: Signature | None = None
    #: The declaration of a similar name, if there is one.
    near: Signature | None = None
    #: The invalid name.
    name: str = ""
    #: The name to write in its place; None if there is none.
    meant: str | None = None

    def __str__(self) -> str:
        """Return the message, with the question about a similar name."""
        question = self.help.startswith(_QUESTION)
        return f"{self.message}; {self.help}" if question else self.message


OF_INTERPRETER: Mapping[str, int] = {":resumed": 1, ":long-cycle": 1}
"""The signals of the interpreter itself, with their numbers of arguments.

`(:resumed SECONDS)` reports that a run was resumed after the end of its process.
`(:long-cycle MILLISECONDS)` reports a cycle that made a driver of `rapc.live` wait.
"""


class Signatures:
    """All signatures of a library, or of the offer of a world, by name.

    The tables are complete and never change. Similar names for unknown names are
    cached.

    Args:
        tables: the signatures by name space and name; the names of skills and events
            have their colon.
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
        #: The propositions and properties, which may have facts in memory.
        self.relations = {n: s for n, s in predicates.items() if s.kind in _IN_MEMORY}
        #: The declared functions.
        self.functions = {n: s for n, s in predicates.items() if s.kind == "function"}
        self.primitives = self._tables["primitive"]
        self.data = self._tables["datum"]
        self.skills = self._tables["skill"]
        self.events = self._tables["event"]
        self._near: dict[str, Suggestions] = {}

    @classmethod
    def of(cls, library: Library) -> Signatures:
        """Return the signatures of a linked library.

        The signature of a RAP is made at its first use.
        """
        tables: dict[str, dict[str, Signature]] = {}
        for field, space, word in KINDS.values():
            if space in SPACES and space != "RAP":
                forms: Mapping[str, Declared] = getattr(library, field)
                found = {
                    name: of_declaration(cast(Kind, word), form, library.functions)
                    for name, form in forms.items()
                }
                tables.setdefault(space, {}).update(found)
        raps = Lazy(library.raps, lambda name: of_rap(library.raps[name]))
        return cls({**tables, "RAP": raps}, Kinds(library.kinds))

    @classmethod
    def offered(cls, offer: Offer) -> Signatures:
        """Return the signatures of the offer of a world, which have no span."""
        primitives = {
            name: Signature("primitive", name, count, count, results=tuple(results))
            for name, (count, results) in offer.primitives.items()
        }
        tables = {
            "primitive": primitives,
            "datum": of_counts("sensor datum", offer.data),
            "skill": of_counts("skill", offer.skills),
            "event": of_counts("event", {**OF_INTERPRETER, **offer.events}),
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
        """Return the fault in a use of a name, or None.

        Args:
            use: the use.
            name: the name.
            count: the number of arguments (inputs).
            outputs: the number of outputs of a goal; None if the goal has none.
            within: the RAP that uses the name, or nothing.
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
                help_ = f"query `{declared.written}` in a formula before and use the "
                help_ += "bound variable"
            message = f"`{name}` is a {declared.kind} and {what}"
            return Fault("kind", message, help_, declared)
        message = _miscount(declared, use, count, outputs)
        return Fault("arguments", message, "", declared) if message else None

    def wrong_kind(
        self, use: Use, name: str, values: Sequence[Atom | None]
    ) -> str | None:
        """Return the message for an argument of a wrong kind, or None.

        An undeclared name and arguments without kinds have no fault. The value None is
        a value that is not known yet.
        """
        declared = self.table(use).get(name)
        args = declared.args if declared is not None else None
        if declared is None or not args or all(arg.kind is None for arg in args):
            return None
        if declared.leaves_value_out(len(values)) and use != "erased":
            values = (*values, "true")
        for arg, value in zip(args, values, strict=False):
            if value is None or arg.kind is None or self.kinds.holds(arg.kind, value):
                continue
            return f"{said_of(arg, value)} in `{declared.written}`"
        return None

    def no_result(self, name: str, result: str) -> Fault | None:
        """Return the fault in the `result` of a primitive, or None.

        The result of an undeclared primitive is not checked.
        """
        declared = self.primitives.get(name)
        if declared is None or result in declared.results:
            return None
        results = Suggestions(declared.results)
        message = f"`{result}` is not a result of `{name}`"
        return Fault(
            "result",
            message,
            results.did_you_mean(result),
            declared,
            name=result,
            meant=results.near(result),
        )

    def table(self, use: Use) -> Mapping[str, Signature]:
        """Return the signatures for a use."""
        return self._tables[_SPACE_OF.get(use, use)]

    def unknown(self, use: Use, name: str, within: str = "") -> Fault:
        """Return the fault for an undeclared name.

        The RAP `within` is suggested only if the name is a slip: few RAPs use
        themselves.
        """
        word = _word(use)
        near = self._near.get(use)
        if near is None:
            built_in = QUERIES if use in _OF_PREDICATES else ()
            built_in = CALLS if use == "computed" else built_in
            near = Suggestions((*self._meant(use), *built_in))
            self._near[use] = near
        message = f"unknown {word} `{name}`"
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
        """Return the help for a name that is valid for a different use, or nothing."""
        if use == "goal" and name == "wait-for":
            return "add it to a step with a task: `(t1 (TASK) (wait-for (:event)))`"
        if use == "goal" and name in self.primitives:
            return (
                f"`{name}` is a primitive, not a RAP; define a RAP with the "
                f"method `(primitive ({name} ...))`"
            )
        if use == "primitive" and name in self.raps:
            return (
                f"`{name}` is a RAP; call the RAP in a step: `(task-net (t1 "
                f"({name} ...)))`"
            )
        meant = _OPERATORS.get(name)
        return f"write `{meant}`" if meant else ""

    def _meant(self, use: Use) -> Iterable[str]:
        """Return the declared names to search for a similar name."""
        return self.functions if use == "computed" else self.table(use)


# --- messages ------------------------------------------------------------------------

_QUESTION = "did you mean"

_OF_PREDICATES: Sequence[Use] = ("test", "believed", "asserted", "erased", "computed")
"""The uses of propositions, properties, functions and queries."""

_SPACE_OF: Mapping[Use, str] = {
    **dict.fromkeys(_OF_PREDICATES, "predicate"),
    "goal": "RAP",
}
"""The name space of a use; for uses not listed, the space of the same name."""


def _word(use: Use) -> str:
    """Return the word in messages for an unknown name of a use."""
    if use == "computed":
        return "function"
    return "sensor datum" if use == "datum" else _SPACE_OF.get(use, use)


def _advice(word: str) -> str:
    """Return the help for an unknown name."""
    if word == "function":
        return "declare it with `declare-memory-function`"
    forms = {"RAP": "define it", "predicate": "declare it"}
    form = forms.get(word, f"declare it with `declare-{word.replace(' ', '-')}`")
    return f"{form}, or `require` its file"


_OPERATORS: Mapping[str, str] = {"!=": "n=", "<>": "n=", "/=": "n=", "==": "="}
"""Comparison operators of other languages, with their names in RAP."""

_NO_FACT: Mapping[Use, str] = {
    "believed": "has no age",
    "asserted": "cannot be asserted",
    "erased": "cannot be erased",
}


def kind_tests(
    kinds: Kinds, table: Mapping[str, Signature]
) -> dict[Atom, tuple[tuple[int, Test], ...]]:
    """Return tests of the arguments with declared kinds, with positions, by name."""
    found: dict[Atom, tuple[tuple[int, Test], ...]] = {}
    for name, declared in table.items():
        args = enumerate(declared.args or (), 1)
        tests = [(at, kinds.test(arg.kind)) for at, arg in args if arg.kind is not None]
        if tests:
            found[name] = tuple(tests)
    return found


_COMPUTED: Container[Kind] = ("function", "query")
"""The kinds of names that are evaluated and have no facts in memory."""


def _miscount(declared: Signature, use: Use, count: int, outputs: int | None) -> str:
    """Return the message for wrong numbers of arguments and outputs, or nothing."""
    message = declared.miscount(count, erased=use == "erased") or ""
    if outputs is None or outputs == declared.outputs:
        return message
    wrong = f"{amount(declared.outputs, 'output')}, not {outputs}"
    return f"{message}, and {wrong}" if message else f"`{declared.name}` has {wrong}"


def _other_kind(use: Use, kind: Kind) -> str | None:
    """Return the reason why a predicate of a kind is invalid for a use, or None."""
    if kind == "function" or (kind == "query" and use != "computed"):
        return _NO_FACT.get(use)
    return "does not compute a value" if use == "computed" else None
