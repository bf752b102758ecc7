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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.asking import Asking, asking
from rapc.analysis.index import INDEX, Form, Index
from rapc.analysis.places import PLACES, Place, Places
from rapc.base.source import Span
from rapc.base.values import format_atom
from rapc.ir import nodes
from rapc.library.library import Library

ENOUGH = 5
"""How far forms are counted."""

MOST_PLACES = 12
"""Of the places of a variable in a form only the first so many are told."""

PLAIN = ("unknown", "true", "false", "nil", "t", "okay")
"""Constants that stand anywhere."""

TRUTH = ("true", "false", "t", "nil")
"""Constants that answer a question."""

FormKey = tuple[str, int]
"""A form by its file and by where it begins."""


class Standing(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A constant where it stands."""

    #: As it is written, so that a text has its quotes.
    written: str
    #: Where its form begins.
    form: int
    start: int
    end: int
    #: Whether it stands at its place itself; else it is compared with a variable.
    filled: bool
    #: The place that it is at, or those of the variable that it is compared with.
    places: tuple[str, ...]


class FileCensus(msgspec.Struct, array_like=True):
    """What the forms of one file tell; a place is told by the words of its parts.

    The variables of forms are numbered, as `groups`.
    """

    #: For each place the variables that stand at it.
    groups: dict[str, list[int]] = {}
    #: For each variable where its form begins.
    owners: list[int] = []
    constants: list[Standing] = []
    #: The names of facts that RAPs bring about or take away.
    changed: list[str] = []
    #: What RAPs ask for.
    asking: list[Asking] = []
    #: The RAPs that agendas ask for.
    given: list[str] = []
    #: Where its first form begins.
    first: int = 0
    #: Where the forms begin that are tests, and those that are neither that nor RAPs.
    tests: list[int] = []
    others: list[int] = []


def key_of(form: Form) -> FormKey:
    """Return what tells a form from all others of its library."""
    return form.span.file, form.span.start


def gather(library: Library, index: Index, places: Places) -> Mapping[str, FileCensus]:
    """Return what each file with forms or tests tells.

    Args:
        library: the files.
        index: their nodes.
        places: what stands at their places.
    """
    made: dict[str, FileCensus] = {}
    for form in (*library.forms, *library.tests):
        here = made.get(form.span.file)
        if here is None:
            here = made[form.span.file] = FileCensus(first=form.span.start)
        if isinstance(form, nodes.DefineTest):
            here.tests.append(form.span.start)
        elif isinstance(form, nodes.DefineRap):
            here.asking.append(asking(form))
        else:
            here.others.append(form.span.start)
        if isinstance(form, nodes.DefineAgenda):
            here.given += [task.goal.name for task in form.tasks]
    words = _Words()
    for form, names in places.forms():
        here, start = made[form.span.file], form.span.start
        for there in names.values():
            group = len(here.owners)
            here.owners.append(start)
            for place in list(dict.fromkeys(there))[:MOST_PLACES]:
                here.groups.setdefault(words.of(place), []).append(group)
    for one in _standing(index, places, words):
        made[one[0]].constants.append(one[1])
    for file, name in dict.fromkeys(_changed(index)):
        made[file].changed.append(name)
    return made


class _Words:
    """The words of places, each made once."""

    def __init__(self) -> None:
        self._made: dict[Place, str] = {}

    def of(self, place: Place) -> str:
        made = self._made.get(place)
        if made is None:
            made = self._made[place] = _word(place)
        return made


def _word(place: Place) -> str:
    return f"{place.space} {place.name} {place.position}"


def _place(word: str) -> Place:
    space, name, position = word.split(" ")
    return Place(space, name, int(position))


def _standing(
    index: Index, places: Places, words: _Words
) -> Iterator[tuple[str, Standing]]:
    for one in places.filled:
        if isinstance(one.term, nodes.Const):
            at = words.of(one.place)
            yield one.form.span.file, _one(one.term, one.form, (at,), filled=True)
    for test in index.of(nodes.Compare):
        for const, other in compared(test.node):
            found = dict.fromkeys(places.of(test.owner, other.name))
            there = tuple(map(words.of, found))
            yield test.owner.span.file, _one(const, test.owner, there, filled=False)


def compared(test: nodes.Compare) -> Iterator[tuple[nodes.Const, nodes.Var]]:
    """Yield a constant that is compared with a variable, and the variable."""
    for one, other in ((test.left, test.right), (test.right, test.left)):
        if isinstance(one, nodes.Const) and isinstance(other, nodes.Var):
            yield one, other


def _one(
    const: nodes.Const, form: Form, there: tuple[str, ...], *, filled: bool
) -> Standing:
    span, written = const.span, format_atom(const.value)
    return Standing(written, form.span.start, span.start, span.end, filled, there)


def _changed(index: Index) -> Iterator[tuple[str, str]]:
    for one in index.uses():
        if one.use in ("asserted", "erased") and type(one.owner) is nodes.DefineRap:
            yield one.owner.span.file, one.name


# --- of all files ---------------------------------------------------------------------


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
        self._first: list[tuple[int, FileCensus]] = []
        self._owners: list[FormKey] = []
        self._double: set[FormKey] = set()
        self._tests: set[FormKey] = set()
        for name, one in files.items():
            self._first.append((len(self._owners), one))
            self._owners += [(name, start) for start in one.owners]
            self._double.update([(name, start) for start in one.others])
            self._tests.update([(name, start) for start in one.tests])
        self._merged: dict[str, list[int]] | None = None
        self._sets: dict[Place, frozenset[int]] = {}
        self._together: dict[tuple[Place, Place], int] = {}
        self._beside: dict[tuple[str, Place], int] = {}
        self._places: dict[str, Place] = {}
        self._standing: dict[str, tuple[Found, ...]] = {}
        self._by_word: dict[str, list[tuple[str, Standing]]] | None = None
        self._by_place: dict[str, list[tuple[str, Standing]]] | None = None
        self._changed: frozenset[str] | None = None
        self._requested: frozenset[str] | None = None

    def together(
        self, one: Place, other: Place, but: frozenset[FormKey] = frozenset()
    ) -> int:
        """Return in how many forms one variable stands at both places.

        A declaration counts as two RAPs do; forms in `but` are left out.
        """
        if but:
            return self._count(one, other, but)
        pair = (one, other)
        count = self._together.get(pair)
        if count is None:
            count = self._together[pair] = self._count(one, other, but)
        return count

    def beside(self, written: str, place: Place) -> int:
        """Return in how many forms a constant itself stands at a place."""
        pair = (written, place)
        count = self._beside.get(pair)
        if count is None:
            there = [one for one in self.standing(written) if one.filled]
            forms = {one.form for one in there if place in one.places}
            count = self._beside[pair] = min(len(forms), ENOUGH)
        return count

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
                    for word in one.places:
                        self._by_place.setdefault(word, []).append((file, one))
        return self._by_place.get(_word(place), ())

    def is_changed(self, name: str) -> bool:
        """Whether any RAP brings or takes away facts of a name."""
        if self._changed is None:
            every = [name for one in self.files.values() for name in one.changed]
            self._changed = frozenset(every)
        return name in self._changed

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
            one.filled,
            tuple([self._place(word) for word in one.places]),
            (file, one.form) in self._tests,
        )

    def _place(self, word: str) -> Place:
        place = self._places.get(word)
        if place is None:
            place = self._places[word] = _place(word)
        return place

    def _set(self, place: Place) -> frozenset[int]:
        found = self._sets.get(place)
        if found is None:
            found = self._sets[place] = frozenset(self._groups(_word(place)))
        return found

    def _groups(self, word: str) -> Iterable[int]:
        """Return the variables at a place; what all files tell is put together late."""
        if self._merged is None and len(self._sets) < _FEW:
            return [
                first + group
                for first, one in self._first
                for group in one.groups.get(word, ())
            ]
        if self._merged is None:
            self._merged = {}
            for first, one in self._first:
                for place, groups in one.groups.items():
                    there = self._merged.setdefault(place, [])
                    there += [first + group for group in groups]
        return self._merged.get(word, ())

    def _count(self, one: Place, other: Place, but: frozenset[FormKey]) -> int:
        if one == other:
            return 0
        small, large = sorted((self._set(one), self._set(other)), key=len)
        forms: set[FormKey] = set()
        count = 0
        for group in small:
            owner = self._owners[group]
            if group in large and owner not in forms and owner not in but:
                forms.add(owner)
                count += 2 if owner in self._double else 1
                if count >= ENOUGH:
                    return ENOUGH
        return count


_FEW = 300
"""For so many places files are looked through one by one."""


def _run(run: Pass) -> Census:
    return Census(gather(run.library, run.result(INDEX), run.result(PLACES)))


CENSUS = Analyzer(
    name="census",
    doc="Gathers by files what forms tell of places and constants.",
    run=_run,
    needs=(INDEX, PLACES),
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
