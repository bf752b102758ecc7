"""Argument places of a library: the terms, constants and kinds at each of them.

A place is an argument of a predicate, a RAP, a primitive, a skill, an event or a datum.
Two places are linked in a form where one variable stands at both: what is told of the
values at one holds for the other. Declarations take part as forms of their own, with
their variables. Kinds of places are declared, or learned from the use of an input.

Some checks compare a form with all others: where else a constant stands, which places
go together. They read the census, and never walk over other forms themselves.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from types import MappingProxyType
from typing import NewType

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.analysis.facts.kinds import INFERRED, InferredKinds
from rapc.analysis.facts.names import MISUSES
from rapc.base.values import format_atom
from rapc.ir import nodes
from rapc.library.signatures import Signatures, Use

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


def _places(run: Pass) -> Places:
    wrong = {id(misuse.used.node) for misuse in run.result(MISUSES).found}
    return Places(run.result(INDEX), wrong)


PLACES = Fact(_places)
"""Gathers what stands at each argument place of the library."""


Inputs = Mapping[str, tuple[str | None, ...]]
"""The kinds of the inputs of RAPs by name; RAPs of whose inputs none is known lack."""


def kinds_of_inputs(raps: Iterable[nodes.DefineRap], inferred: InferredKinds) -> Inputs:
    """Return the kinds of the inputs of some RAPs, declared or learned.

    Args:
        raps: the RAPs.
        inferred: what was learned of inputs for which no kind is declared.
    """
    found: dict[str, tuple[str | None, ...]] = {}
    for rap in raps:
        learned = inferred.inputs.get(rap.name, ())
        if rap.kinds or any(learned):
            declared = {one.variable: one.kind for one in rap.kinds}
            kinds = [one.kind if one is not None else None for one in learned]
            kinds += [None] * len(rap.inputs)  # of one defined twice fewer are learned
            pairs = zip(rap.inputs, kinds, strict=False)
            found[rap.name] = tuple([declared.get(v.name, kind) for v, kind in pairs])
    return found


class PlaceKinds:
    """Tells of which kinds the values at argument places are, declared or learned.

    Args:
        signatures: what is declared.
        inputs: the kinds of the inputs of RAPs.
    """

    def __init__(self, signatures: Signatures, inputs: Inputs) -> None:
        self.inputs = inputs
        self._tables = {
            "predicate": signatures.predicates,
            "primitive": signatures.primitives,
            "datum": signatures.data,
            "skill": signatures.skills,
            "event": signatures.events,
        }
        self._known: dict[Place, str | None] = {}

    def of(self, places: Sequence[Place]) -> tuple[str, ...]:
        """Return the kinds of places of which one is known, each once."""
        found = [self._one(place) for place in places]
        return tuple(dict.fromkeys(kind for kind in found if kind is not None))

    def _one(self, place: Place) -> str | None:
        if place not in self._known:
            self._known[place] = self._look_up(place)
        return self._known[place]

    def _look_up(self, place: Place) -> str | None:
        space, name, position = place_parts(place)
        if space == "RAP":
            kinds = self.inputs.get(name, ())
            return kinds[position] if position < len(kinds) else None
        declared = self._tables[space].get(name)
        args = declared.args if declared is not None else None
        if args is None or position >= len(args):
            return None
        return args[position].kind


def _place_kinds(run: Pass) -> PlaceKinds:
    inputs = kinds_of_inputs(run.library.raps.values(), run.result(INFERRED))
    return PlaceKinds(run.signatures, inputs)


PLACE_KINDS = Fact(_place_kinds)
"""Works out of which kinds the values at argument places are."""


MOST_PLACES = 12
"""Of the places of a variable in a form only the first so many are told."""

PLAIN = ("unknown", "true", "false", "nil", "t", "okay")
"""Constants that stand anywhere."""

TRUTH = ("true", "false", "t", "nil")
"""Constants that answer a question."""

_Weights = Mapping[int, int]
"""How much each form counts, by the id of the form."""


class Census:
    """Where constants stand, and which places go together.

    Args:
        places: the places of the library.
        forms: its forms, in the order of files and text.
    """

    def __init__(self, places: Places, forms: Iterable[Form]) -> None:
        self._by_word: dict[str, list[Constant]] = {}
        self._by_place: dict[Place, list[Constant]] = {}
        for one in _in_order(places.constants, forms):
            self._by_word.setdefault(one.written, []).append(one)
            for place in one.places:
                self._by_place.setdefault(place, []).append(one)
        #: For each variable of a form that form; `_at` has the variables at a place.
        self._owners: list[Form] = []
        self._at: dict[Place, set[int]] = {}
        for form, names in places.forms():
            for there in names.values():
                for place in islice(there, MOST_PLACES):
                    self._at.setdefault(place, set()).add(len(self._owners))
                self._owners.append(form)
        self._together: dict[tuple[Place, Place], tuple[int, _Weights]] = {}
        self._beside: dict[tuple[str, Place], frozenset[int]] = {}

    def together_elsewhere(
        self, one: Place, other: Place, form: Form | None = None
    ) -> int:
        """Return in how many forms but one a variable stands at both places.

        A declaration counts as two RAPs do.
        """
        pair = (one, other)
        found = self._together.get(pair)
        if found is None:
            forms = self._forms_with_both(one, other)
            found = self._together[pair] = sum(forms.values()), forms
        count, forms = found
        return count - forms.get(id(form), 0)

    def beside_elsewhere(self, written: str, place: Place, form: Form) -> int:
        """Return in how many forms but one a constant itself stands at a place."""
        pair = (written, place)
        forms = self._beside.get(pair)
        if forms is None:
            there = [one for one in self.standing(written) if one.count]
            forms = frozenset([id(one.form) for one in there if place in one.places])
            self._beside[pair] = forms
        return len(forms) - (id(form) in forms)

    def written(self) -> Iterable[str]:
        """Return the constants of the library as they are written, each once."""
        return self._by_word

    def standing(self, written: str) -> Sequence[Constant]:
        """Return where a constant stands, in the order of files."""
        return self._by_word.get(written, ())

    def at(self, place: Place) -> Sequence[Constant]:
        """Return the constants at a place."""
        return self._by_place.get(place, ())

    def _forms_with_both(self, one: Place, other: Place) -> _Weights:
        """Return the forms in which one variable stands at both places."""
        if one == other:
            return {}
        small, large = sorted((self._at.get(p, set()) for p in (one, other)), key=len)
        forms = [self._owners[variable] for variable in small if variable in large]
        return {id(form): 1 if isinstance(form, _SINGLE) else 2 for form in forms}


_SINGLE = (nodes.DefineRap, nodes.DefineTest)
"""The forms that count once."""


def _in_order(constants: Iterable[Constant], forms: Iterable[Form]) -> list[Constant]:
    """Return constants file by file."""
    order: dict[str, int] = {}
    for form in forms:
        order.setdefault(form.span.file, len(order))
    return sorted(constants, key=lambda one: order[one.form.span.file])


def _census(run: Pass) -> Census:
    places = run.result(PLACES)
    if run.result(MISUSES).found:
        # Where a name does not meet its declaration, its arguments count all the same.
        places = Places(run.result(INDEX), ())
    return Census(places, (*run.library.forms, *run.library.tests))


CENSUS = Fact(_census)
"""Gathers what forms tell of places and constants."""


def sort_of(written: str) -> str:
    """Return the sort of a constant by how it is written; nothing for `unknown`.

    A number is one, a text has quotes, and `true` or `nil` are truth values.
    """
    if written[:1] == '"':
        return "text"
    if written in TRUTH:
        return "truth value"
    if _NUMERAL.fullmatch(written):
        return "number"
    return "" if written in PLAIN else "word"


_NUMERAL = re.compile(r"-?[0-9]+(\.[0-9]+)?")
