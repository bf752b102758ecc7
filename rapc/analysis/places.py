"""Where values stand: each argument place of the library, with the terms that fill it.

A place is an argument of a predicate, a RAP, a primitive, a skill, an event or a datum.
Two places are linked in a form where one variable stands at both: what is told of the
values at one holds for the other. From this the passes about constants and swapped
arguments draw; declarations take part as forms of their own, with their variables.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from typing import NamedTuple

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX, Form, Index
from rapc.analysis.named import MISUSES
from rapc.ir import nodes
from rapc.library.signatures import Use


class Place(NamedTuple):
    """An argument place: of what space of names, of which name, the how-manieth."""

    space: str
    name: str
    position: int


class Filled(msgspec.Struct, frozen=True, gc=False):
    """A term at a place."""

    place: Place
    term: nodes.Term
    form: Form
    #: How many arguments stand with it.
    count: int


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
        #: Every term at a place, in the order of uses.
        self.filled: Sequence[Filled] = tuple(_filled(index, wrong))
        self._of: dict[int, dict[str, list[Place]]] = {}
        self._forms: dict[int, Form] = {}
        for one in self.filled:
            if isinstance(one.term, nodes.Var) and not one.term.anonymous:
                names = self._of.setdefault(id(one.form), {})
                self._forms[id(one.form)] = one.form
                names.setdefault(one.term.name, []).append(one.place)

    def of(self, form: Form, name: str) -> Sequence[Place]:
        """Return the places at which a variable stands in a form."""
        return self._of.get(id(form), {}).get(name, ())

    def forms(self) -> Iterator[tuple[Form, Mapping[str, Sequence[Place]]]]:
        """Yield the forms with their variables, and the places of each."""
        for key, names in self._of.items():
            yield self._forms[key], names


def _filled(index: Index, wrong: Container[int]) -> Iterator[Filled]:
    for used in index.uses():
        if id(used.node) in wrong:
            continue
        space = SPACES[used.use]
        terms = used.node.args
        if isinstance(used.node, nodes.Goal):
            terms = (*terms, *used.node.outputs)
        for at, term in enumerate(terms):
            yield Filled(Place(space, used.name, at), term, used.owner, used.count)
    for rap in index.of(nodes.DefineRap):
        for at, variable in enumerate((*rap.node.inputs, *rap.node.outputs)):
            count = len(rap.node.inputs)
            yield Filled(Place("RAP", rap.node.name, at), variable, rap.owner, count)
    for space, kind in _DECLARED.items():
        for form in index.of(kind):
            node = form.node
            assert isinstance(node, _WithArguments)
            for at, arg in enumerate(node.args):
                count, place = len(node.args), Place(space, node.name, at)
                yield Filled(place, arg.variable, form.owner, count)


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


PLACES = Analyzer(
    name="places",
    doc="Gathers what stands at each argument place of the library.",
    run=_run,
    needs=(INDEX, MISUSES),
)
