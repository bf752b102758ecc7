"""Argument places of a library: the terms, constants and kinds at each place.

A place is an argument of a predicate, a RAP, a primitive, a skill, an event or a datum.
Two places are linked in a form if one variable occurs at both places: knowledge of the
values at one place applies to the other place. A declaration counts as a form, with its
own variables. The kind of a place is declared, or inferred from the use of an input.

A check that compares a form with all other forms reads these tables, and does not walk
over other forms itself.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice
from typing import NamedTuple

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.facts.index import INDEX, Form
from rapc.analysis.facts.kinds import INFERRED
from rapc.analysis.facts.names import MISUSES
from rapc.analysis.facts.statistics import LIMITS
from rapc.base.values import format_atom
from rapc.ir import nodes
from rapc.library.signatures import Use


class Place(NamedTuple):
    """An argument place: `Place("predicate", "location", 1)` is the value of a fact."""

    #: The name space, a value of `SPACES`.
    space: str
    name: str
    #: The index of the argument, from 0.
    position: int


class Constant(msgspec.Struct, frozen=True, gc=False):
    """A constant at a place, or compared with a variable."""

    const: nodes.Const
    #: The constant as written: a text includes its quotes.
    written: str
    #: The top-level form around the constant.
    form: Form
    #: The number of arguments at the place; 0 if the constant is compared with a
    #: variable.
    count: int
    #: The place of the constant, or the places of the compared variable.
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
"""The name space for each use of a name."""

_USES: Mapping[str, Use] = {s: use for use, s in reversed([*SPACES.items()])}

_DECLARED: Mapping[str, type[nodes.Node]] = {
    "predicate": nodes.DefineQuery,
    "primitive": nodes.DeclarePrimitive,
    "datum": nodes.DeclareDatum,
    "skill": nodes.DeclareSkill,
}
"""The declarations with more information on arguments than their number."""

_WithArguments = (
    nodes.DefineQuery | nodes.DeclarePrimitive | nodes.DeclareDatum | nodes.DeclareSkill
)


class Usage:
    """The argument places of a library, with the terms at each place.

    Args:
        run: the pass.
        wrong: the ids of the nodes to leave out.
    """

    def __init__(self, run: Pass, wrong: Container[int] = ()) -> None:
        #: The constants at places, in the order of uses, then the compared constants.
        self.constants: list[Constant] = []
        self._library = run.library
        self._signatures = run.signatures
        self._inferred = run.result(INFERRED).inputs
        self._rows: dict[tuple[str, str], list[Place]] = {}
        #: By the id of a form: the form, and for each variable its places, each once.
        self._of: dict[int, tuple[Form, dict[str, dict[Place, None]]]] = {}
        self._kinds: dict[Place, str | None] = {}
        self._together: dict[tuple[Place, Place], Mapping[int, int]] = {}
        self._beside: dict[tuple[str, Place], frozenset[int]] = {}
        index = run.result(INDEX)
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
            sides = (test.node.left, test.node.right)
            for one, other in (sides, sides[::-1]):
                if type(one) is nodes.Const and type(other) is nodes.Var:
                    places = tuple(self.of(test.owner, other.name))
                    self._constant(one, test.owner, 0, places)

    # --- places -----------------------------------------------------------------------

    def row(self, space: str, name: str, count: int) -> Sequence[Place]:
        """Return the first places of a name: at least `count` places."""
        found = self._rows.setdefault((space, name), [])
        while len(found) < count:
            found.append(Place(space, name, len(found)))
        return found

    def of(self, form: Form, name: str) -> Collection[Place]:
        """Return the places of a variable in a form, each once."""
        _, names = self._of.get(id(form), (form, {}))
        return names.get(name, ())

    def kinds(self, places: Sequence[Place]) -> tuple[str, ...]:
        """Return the known kinds of some places, each once."""
        for place in places:
            if place not in self._kinds:
                self._kinds[place] = self._kind(place)
        found = [self._kinds[place] for place in places]
        return tuple(dict.fromkeys(kind for kind in found if kind is not None))

    def together_elsewhere(
        self, one: Place, other: Place, form: Form | None = None
    ) -> int:
        """Return the number of other forms with a variable at both places.

        A declaration counts like two RAPs.
        """
        pair = (one, other)
        forms = self._together.get(pair)
        if forms is None:
            forms = self._together[pair] = self._forms_with_both(one, other)
        return sum(forms.values()) - forms.get(id(form), 0)

    def is_named_elsewhere(self, name: str, place: Place, form: Form) -> bool:
        """Return whether another form has a variable of this name at a place."""
        there = self._at.get(place, {})
        return any(other == name and key != id(form) for key, other in there)

    def _kind(self, place: Place) -> str | None:
        table = self._signatures.table(_USES[place.space])
        declared = table.get(place.name)
        args = (declared.args if declared is not None else None) or ()
        kind = args[place.position].kind if place.position < len(args) else None
        if kind is None and place.space == "RAP" and place.position < len(args):
            learned = self._inferred.get(place.name, ())[place.position :]
            return learned[0].kind if learned and learned[0] is not None else None
        return kind

    @cached_property
    def _at(self) -> dict[Place, dict[tuple[int, str], Form]]:
        """Return the variables at each place, with their forms."""
        found: dict[Place, dict[tuple[int, str], Form]] = {}
        for key, (form, names) in self._of.items():
            for name, there in names.items():
                for place in islice(there, LIMITS.places):
                    found.setdefault(place, {})[key, name] = form
        return found

    def _forms_with_both(self, one: Place, other: Place) -> Mapping[int, int]:
        """Return the forms with a variable at both places, each with its weight."""
        if one == other:
            return {}
        small, large = sorted((self._at.get(p, {}) for p in (one, other)), key=len)
        forms = [form for variable, form in small.items() if variable in large]
        return {id(form): 1 if isinstance(form, _SINGLE) else 2 for form in forms}

    def _fill(
        self,
        space: str,
        name: str,
        terms: Sequence[nodes.Term],
        form: Form,
        count: int,
    ) -> None:
        """Record the terms at the places of a name."""
        _, own = self._of.setdefault(id(form), (form, {}))
        row = self.row(space, name, len(terms))
        for place, term in zip(row, terms, strict=False):
            if type(term) is nodes.Var:
                if not term.anonymous:
                    own.setdefault(term.name, {})[place] = None
            elif type(term) is nodes.Const:
                self._constant(term, form, count, (place,))

    def _constant(
        self, const: nodes.Const, form: Form, count: int, places: tuple[Place, ...]
    ) -> None:
        written = format_atom(const.value)
        self.constants.append(Constant(const, written, form, count, places))

    # --- constants --------------------------------------------------------------------

    def standing(self, written: str) -> Sequence[Constant]:
        """Return the occurrences of a constant, in the order of files."""
        return self._by_word.get(written, ())

    def at(self, place: Place) -> Sequence[Constant]:
        """Return the constants at a place."""
        return self._by_place.get(place, ())

    def beside_elsewhere(self, written: str, place: Place, form: Form) -> int:
        """Return the number of other forms with a constant itself at a place."""
        pair = (written, place)
        forms = self._beside.get(pair)
        if forms is None:
            there = [one for one in self.standing(written) if one.count]
            forms = frozenset([id(one.form) for one in there if place in one.places])
            self._beside[pair] = forms
        return len(forms) - (id(form) in forms)

    def words(self) -> Iterator[str]:
        """Yield the constants that are used or declared, as written."""
        yield from dict.fromkeys((*self._by_word, *self._listed))

    def count(self, written: str) -> int:
        """Return the number of occurrences of a constant in the library.

        An occurrence in a declaration counts twice.
        """
        return len(self.standing(written)) + 2 * len(self._listed.get(written, ()))

    def counts(self, written: str) -> tuple[Counter[Place], Counter[str]]:
        """Return the number of occurrences of a constant by place and by kind."""
        found = self._counts.get(written)
        if found is None:
            found = self._counts[written] = Counter(), Counter()
            for one in self.standing(written):
                found[0].update(one.places)
                found[1].update(self.kinds(one.places))
            found[1].update({k: 2 for k in self._listed.get(written, ()) if k})
        return found

    def sorts(self, place: Place) -> Counter[str]:
        """Return the number of constants of each sort at a place."""
        found = self._sorts.get(place)
        if found is None:
            every = [sort_of(one.written) for one in self.at(place)]
            found = self._sorts[place] = Counter(every)
        return found

    @cached_property
    def _counts(self) -> dict[str, tuple[Counter[Place], Counter[str]]]:
        return {}

    @cached_property
    def _sorts(self) -> dict[Place, Counter[str]]:
        return {}

    @cached_property
    def _listed(self) -> Mapping[str, Sequence[str]]:
        """Return the declared constants with their kinds; a result has no kind."""
        found: dict[str, list[str]] = {}
        for name, form in self._library.kinds.items():
            for value in form.values or ():
                found.setdefault(format_atom(value), []).append(name)
        for primitive in self._library.primitives.values():
            for result in primitive.results:
                found.setdefault(result, []).append("")
        return found

    @cached_property
    def _by_word(self) -> Mapping[str, Sequence[Constant]]:
        """Return the occurrences of each constant, in the order of files."""
        order: dict[str, int] = {}
        for form in (*self._library.forms, *self._library.tests):
            order.setdefault(form.span.file, len(order))
        found: dict[str, list[Constant]] = {}
        for one in sorted(self.constants, key=lambda one: order[one.form.span.file]):
            found.setdefault(one.written, []).append(one)
        return found

    @cached_property
    def _by_place(self) -> Mapping[Place, Sequence[Constant]]:
        found: dict[Place, list[Constant]] = {}
        for there in self._by_word.values():
            for one in there:
                for place in one.places:
                    found.setdefault(place, []).append(one)
        return found


_SINGLE = (nodes.DefineRap, nodes.DefineTest)
"""The types of forms that count once."""


def _usage(run: Pass) -> Usage:
    wrong = {id(misuse.used.node) for misuse in run.result(MISUSES)}
    return Usage(run, wrong)


USAGE = Fact(_usage)
"""The terms at places, without uses that do not match their declaration."""


def _census(run: Pass) -> Usage:
    return Usage(run) if run.result(MISUSES) else run.result(USAGE)


CENSUS = Fact(_census)
"""The terms at places, in all uses of names."""


TRUTH = ("true", "false", "t", "nil")
"""The truth values."""

PLAIN = ("unknown", *TRUTH, "okay")
"""The constants that may occur at any place."""


def sort_of(written: str) -> str:
    """Return the sort of a constant by its spelling; empty for `unknown`.

    The sorts are numbers, texts with quotes, truth values such as `true` or `nil`, and
    words.
    """
    if written[:1] == '"':
        return "text"
    if written in TRUTH:
        return "truth value"
    if _NUMERAL.fullmatch(written):
        return "number"
    return "" if written in PLAIN else "word"


_NUMERAL = re.compile(r"-?[0-9]+(\.[0-9]+)?")
