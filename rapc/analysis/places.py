"""Where values stand: each argument place of the library, with the terms that fill it.

A place is an argument of a predicate, a RAP, a primitive, a skill, an event or a datum.
Two places are linked in a form where one variable stands at both: what is told of the
values at one holds for the other. From this the passes about constants and swapped
arguments draw; declarations take part as forms of their own, with their variables.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import NewType

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.index import INDEX, Form, Index
from rapc.analysis.named import MISUSES
from rapc.base.values import format_atom
from rapc.ir import nodes
from rapc.library.signatures import Use

Place = NewType("Place", str)
"""An argument place in words: the space of names, the name, the argument's number.

The number counts from 0: `predicate location 1` is the value of `location`. Names have
no spaces in them.
"""


def argument_place(space: str, name: str, position: int) -> Place:
    """Return the place of an argument of a name."""
    return Place(f"{space} {name} {position}")


def place_parts(place: Place) -> tuple[str, str, int]:
    """Return the space of names of a place, the name, and the argument's number."""
    space, name, position = place.split(" ")
    return space, name, int(position)


class Constant(msgspec.Struct, frozen=True, gc=False):
    """A constant where it stands, at a place or beside a variable."""

    const: nodes.Const
    #: As it is written, so that a text has its quotes.
    written: str
    #: The top-level form that it stands in.
    form: Form
    #: With how many arguments it stands at its place; 0 if it is compared with a
    #: variable.
    count: int
    #: The place that it is at, or those of the variable that it is compared with.
    places: tuple[Place, ...]


SPACES: Mapping[Use, str] = {
    "goal": "RAP",
    "test": "predicate",
    "believed": "predicate",
    "asserted": "predicate",
    "erased": "predicate",
    "computed": "predicate",
    "primitive": "primitive",
    "datum": "datum",
    "skill": "skill",
    "event": "event",
}
"""The space of names in which a name used so is looked up."""


class Places:
    """The places of a library.

    Args:
        index: its nodes.
        wrong: the ids of the nodes that do not meet the declaration of their name.
    """

    def __init__(self, index: Index, wrong: Container[int]) -> None:
        #: The constants at places in the order of uses, then those that are compared.
        self.constants: list[Constant] = []
        self._rows: dict[tuple[str, str], list[Place]] = {}
        #: By the id of a form: for each variable its places, each once.
        self._of: dict[int, dict[str, dict[Place, None]]] = {}
        self._forms: dict[int, Form] = {}
        for used in index.uses():
            if id(used.node) not in wrong:
                terms = used.node.args
                if type(used.node) is nodes.Goal:
                    terms = (*terms, *used.node.outputs)
                self._fill(SPACES[used.use], used.name, terms, used.owner, used.count)
        for rap in index.of(nodes.DefineRap):
            own, count = rap.node, len(rap.node.inputs)
            self._fill("RAP", own.name, (*own.inputs, *own.outputs), rap.owner, count)
        for space, kind in _DECLARED.items():
            for form in index.of(kind):
                node = form.node
                assert isinstance(node, _WithArguments)
                variables = [arg.variable for arg in node.args]
                self._fill(space, node.name, variables, form.owner, len(variables))
        for test in index.of(nodes.Compare):
            self._compare(test.node, test.owner)

    def row(self, space: str, name: str, count: int) -> Sequence[Place]:
        """Return the first places of a name: as many as are wanted, or more."""
        found = self._rows.setdefault((space, name), [])
        while len(found) < count:
            found.append(argument_place(space, name, len(found)))
        return found

    def of(self, form: Form, name: str) -> Collection[Place]:
        """Return the places at which a variable stands in a form, each once."""
        return self._of.get(id(form), _NOWHERE).get(name, ())

    def forms(self) -> Iterator[tuple[Form, Mapping[str, Collection[Place]]]]:
        """Yield the forms with their variables, and the places of each."""
        for key, names in self._of.items():
            yield self._forms[key], names

    def _fill(
        self,
        space: str,
        name: str,
        terms: Sequence[nodes.Term],
        form: Form,
        count: int,
    ) -> None:
        """Note the terms at the places of a name."""
        own = self._of.get(id(form))
        if own is None:
            own = self._of[id(form)] = {}
            self._forms[id(form)] = form
        row = self.row(space, name, len(terms))
        for place, term in zip(row, terms, strict=False):
            if type(term) is nodes.Var:
                if not term.anonymous:
                    own.setdefault(term.name, {})[place] = None
            elif type(term) is nodes.Const:
                self._constant(term, form, count, (place,))

    def _compare(self, test: nodes.Compare, form: Form) -> None:
        """Note the constants that are compared with variables."""
        for one, other in ((test.left, test.right), (test.right, test.left)):
            if type(one) is nodes.Const and type(other) is nodes.Var:
                self._constant(one, form, 0, tuple(self.of(form, other.name)))

    def _constant(
        self, const: nodes.Const, form: Form, count: int, places: tuple[Place, ...]
    ) -> None:
        written = format_atom(const.value)
        self.constants.append(Constant(const, written, form, count, places))


_NOWHERE: Mapping[str, Collection[Place]] = MappingProxyType({})

_DECLARED: Mapping[str, type[nodes.Node]] = {
    "predicate": nodes.DefineQuery,
    "primitive": nodes.DeclarePrimitive,
    "datum": nodes.DeclareDatum,
    "skill": nodes.DeclareSkill,
}
"""The declarations that say more of their arguments than that there are so many."""

_WithArguments = (
    nodes.DefineQuery | nodes.DeclarePrimitive | nodes.DeclareDatum | nodes.DeclareSkill
)


def _run(run: Pass) -> Places:
    wrong = {id(misuse.used.node) for misuse in run.result(MISUSES).found}
    return Places(run.result(INDEX), wrong)


PLACES = Fact(_run)
"""Gathers what stands at each argument place of the library."""
