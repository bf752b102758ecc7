"""What all forms of a library tell of places and constants, gathered file by file.

Some passes hold a form against all others: where else a constant stands, which places
go together. They ask the census, and never walk over other forms themselves. What one
file tells is a `FileCensus`, made of its text alone, so that it can be kept from one
check to the next (`rapc.analysis.again`); the `Census` answers for all files together.

Numbers are told up to `ENOUGH` only: no pass asks for more, and so a form more or less
among many changes no answer.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.asking import Asking
from rapc.analysis.file_census import (
    FileCensus,
    FormKey,
    Standing,
    gather,
)
from rapc.analysis.index import INDEX, Uses
from rapc.analysis.named import MISUSES
from rapc.analysis.places import PLACES, Place, Places, place_parts
from rapc.base.source import Span

ENOUGH = 5
"""How far forms are counted."""

PLAIN = ("unknown", "true", "false", "nil", "t", "okay")
"""Constants that stand anywhere."""

TRUTH = ("true", "false", "t", "nil")
"""Constants that answer a question."""


class Found(NamedTuple):
    """A constant where it stands, with its file."""

    span: Span
    form: FormKey
    filled: bool
    places: tuple[Place, ...]
    #: Whether a test holds it.
    in_test: bool


class Census:
    """What all files of a library tell.

    Args:
        files: what each of them tells, in the order in which they are read.
    """

    def __init__(self, files: Mapping[str, FileCensus]) -> None:
        self.files = files
        #: The variables for which constants stand (`passes.constants`), with their
        #: forms, where these are not checked now.
        self.unmarked: frozenset[tuple[FormKey, str]] = frozenset()
        #: The kinds of the inputs of RAPs (`place_kinds`) that are not checked now.
        self.inputs: Mapping[str, tuple[str | None, ...]] = {}
        self._first: list[tuple[int, FileCensus]] = []
        self._owners: list[FormKey] = []
        self._double: set[FormKey] = set()
        self._tests: set[FormKey] = set()
        for name, one in files.items():
            self._first.append((len(self._owners), one))
            self._owners += [(name, start) for start in one.owners]
            self._double.update([(name, start) for start in one.others])
            self._tests.update([(name, start) for start in one.tests])
        self._merged: dict[Place, list[int]] | None = None
        self._sets: dict[Place, frozenset[int]] = {}
        self._together: dict[
            tuple[Place, Place], tuple[int, Mapping[FormKey, int]]
        ] = {}
        self._beside: dict[tuple[str, Place], tuple[FormKey, ...]] = {}
        self._standing: dict[str, tuple[Found, ...]] = {}
        self._by_word: dict[str, list[tuple[str, Standing]]] | None = None
        self._by_place: dict[Place, list[tuple[str, Standing]]] | None = None
        self._of_name: dict[tuple[str, str], list[Place]] | None = None
        self._changed: frozenset[str] | None = None
        self._requested: frozenset[str] | None = None

    def together(self, one: Place, other: Place, but: Container[FormKey]) -> int:
        """Return in how many forms, besides some, one variable stands at both places.

        A declaration counts as two RAPs do.
        """
        forms = self._forms_with_both(one, other, but)
        return min(sum(forms.values()), ENOUGH)

    def together_elsewhere(self, one: Place, other: Place, form: FormKey) -> int:
        """Return in how many forms but one a variable stands at both places."""
        pair = (one, other)
        found = self._together.get(pair)
        if found is None:
            forms = self._forms_with_both(one, other, ())
            found = self._together[pair] = min(sum(forms.values()), ENOUGH), forms
        count, forms = found
        return count if count >= ENOUGH else count - forms.get(form, 0)

    def beside_elsewhere(self, written: str, place: Place, form: FormKey) -> int:
        """Return in how many forms but one a constant itself stands at a place."""
        pair = (written, place)
        forms = self._beside.get(pair)
        if forms is None:
            there = [one for one in self.standing(written) if one.filled]
            every = dict.fromkeys(one.form for one in there if place in one.places)
            forms = self._beside[pair] = tuple(every)[: ENOUGH + 1]
        return min(len(forms) - (form in forms), ENOUGH)

    def uses(self) -> Uses:
        """Return how often names are used."""
        return Uses([one.uses for one in self.files.values()])

    def written(self) -> Iterator[str]:
        """Yield the constants of the library as they are written, each once."""
        yield from self._words()

    def standing(self, written: str) -> Sequence[Found]:
        """Return where a constant stands, in the order of forms."""
        found = self._standing.get(written)
        if found is None:
            there = self._words().get(written, ())
            found = tuple([self._found(file, one) for file, one in there])
            self._standing[written] = found
        return found

    def at(self, place: Place) -> Sequence[tuple[str, Standing]]:
        """Return the constants at a place, each with its file."""
        if self._by_place is None:
            self._by_place = {}
            for file, census in self.files.items():
                for one in census.constants:
                    for there in one.places:
                        self._by_place.setdefault(there, []).append((file, one))
        return self._by_place.get(place, ())

    def is_changed(self, name: str) -> bool:
        """Whether any RAP brings or takes away facts of a name."""
        if self._changed is None:
            every = [name for one in self.files.values() for name in one.changed]
            self._changed = frozenset(every)
        return name in self._changed

    def conditions(self) -> Iterator[str]:
        """Yield the names of what RAPs ask for in conditions of work."""
        for one in self.files.values():
            yield from one.conditions

    def is_requested(self, primitive: str) -> bool:
        """Whether any RAP requests a primitive."""
        if self._requested is None:
            self._requested = frozenset(
                [name for _, one in self.asking() for name in one.requests]
            )
        return primitive in self._requested

    def asking(self) -> Iterator[tuple[str, Asking]]:
        """Yield what RAPs ask for, each with its file."""
        for file, one in self.files.items():
            for row in one.asking:
                yield file, row

    def given(self) -> Iterator[str]:
        """Yield the RAPs that agendas ask for."""
        for one in self.files.values():
            yield from one.given

    def places_of(self, space: str, name: str) -> Sequence[Place]:
        """Return the places of a name at which variables or constants stand."""
        if self._of_name is None:
            places: set[Place] = set()
            for one in self.files.values():
                places.update(one.groups)
                places.update(place for row in one.constants for place in row.places)
            self._of_name = {}
            for place in places:
                found, its, _ = place_parts(place)
                self._of_name.setdefault((found, its), []).append(place)
        return self._of_name.get((space, name), ())

    def forms_with(self, place: Place) -> Iterator[FormKey]:
        """Yield the forms that have a variable or a constant at a place."""
        for group in self._set(place):
            yield self._owners[group]
        for file, one in self.at(place):
            yield file, one.form

    def _words(self) -> Mapping[str, Sequence[tuple[str, Standing]]]:
        if self._by_word is None:
            self._by_word = {}
            for file, census in self.files.items():
                for one in census.constants:
                    self._by_word.setdefault(one.written, []).append((file, one))
        return self._by_word

    def _found(self, file: str, one: Standing) -> Found:
        return Found(
            Span(file, one.start, one.end),
            (file, one.form),
            one.count > 0,
            one.places,
            (file, one.form) in self._tests,
        )

    def _set(self, place: Place) -> frozenset[int]:
        found = self._sets.get(place)
        if found is None:
            found = self._sets[place] = frozenset(self._groups(place))
        return found

    def _groups(self, place: Place) -> Iterable[int]:
        """Return the variables at a place; what all files tell is put together late."""
        if self._merged is None and len(self._sets) < _FEW:
            return [
                first + group
                for first, one in self._first
                for group in one.groups.get(place, ())
            ]
        if self._merged is None:
            self._merged = {}
            for first, one in self._first:
                for at, groups in one.groups.items():
                    there = self._merged.setdefault(at, [])
                    there += [first + group for group in groups]
        return self._merged.get(place, ())

    def _forms_with_both(
        self, one: Place, other: Place, but: Container[FormKey]
    ) -> Mapping[FormKey, int]:
        """Return the first forms in which one variable stands at both places.

        More than are `ENOUGH` are left out; each is told with what it counts.
        """
        small, large = sorted((self._set(one), self._set(other)), key=len)
        forms: dict[FormKey, int] = {}
        count = 0
        for group in small if one != other else ():
            owner = self._owners[group]
            if group in large and owner not in forms and owner not in but:
                forms[owner] = 2 if owner in self._double else 1
                count += forms[owner]
                if count >= ENOUGH:
                    break
        return forms


_FEW = 300
"""For so many places files are looked through one by one."""


def _run(run: Pass) -> Census:
    index, places = run.result(INDEX), run.result(PLACES)
    if run.result(MISUSES).found:
        places = Places(index, ())  # all of it, so that it is told by the text alone
    return Census(gather(run.library, index, places))


CENSUS = Analyzer(
    name="census",
    doc="Gathers by files what forms tell of places and constants.",
    run=_run,
    needs=(INDEX, MISUSES, PLACES),
)


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
