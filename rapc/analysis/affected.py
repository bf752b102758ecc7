"""Which forms of a library have to be looked at again when some of them have changed.

A finding may depend on its form and on all that this leads to, so a RAP that shows
something else than before has all that ask for it looked at again, directly or not.
Of what forms tell about places and constants (`rapc.analysis.census`) passes ask how
often something is so, up to `ENOUGH`: where a change leaves such an answer as it was,
nobody is concerned; else all forms are that may have asked.

Where the answer would be long, or something has changed on which everything depends,
there is none: the library is checked as a whole.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from itertools import islice

from rapc.analysis.census import ENOUGH, Census, sort_of
from rapc.analysis.change import Change
from rapc.analysis.close_names import is_one_slip
from rapc.analysis.file_census import FormKey
from rapc.analysis.kept import AGENDAS, FileState, State, form_at
from rapc.analysis.moving import spans_of
from rapc.analysis.places import Place, place_parts
from rapc.base.source import SourceFile, Span

MOST = 400
"""So many forms are looked at again; of more the whole library is."""


class Affected:
    """The forms that have to be looked at again.

    Args:
        old: the library as it was.
        files: its files now, in the order in which they are read.
        change: what has changed.
        census: what the files tell now.
        sources: their texts.
    """

    def __init__(
        self,
        old: State,
        files: Mapping[str, FileState],
        change: Change,
        census: Census,
        sources: Mapping[str, SourceFile],
    ) -> None:
        self._old = old
        self._files = files
        self._change = change
        self._census = census
        self._texts = {name: source.text.lower() for name, source in sources.items()}
        self._before = {one.name: one for one in old.files}
        self._users: dict[tuple[str, str], frozenset[FormKey]] = {}
        self._fresh = frozenset(change.fresh)

    def all(self) -> set[FormKey] | None:
        """Return them, with `AGENDAS` if all agendas are; None for everything."""
        if self._told_apart() or self._changes_known():
            return None
        found = set(self._fresh)
        found.update(self._callers())
        for one in (*self._labelled(), *self._old.watched):
            found.update(self._change.now(one))
        found.update(self._believing())
        changed = (*self._change.gone.values(), *self._change.fresh.values())
        if any(one.sort == "agenda" for one in changed):
            found.add(AGENDAS)
        found.update(self._by_constants())
        found.update(self._by_places())
        crowded = {file for file, _ in found}.intersection(self._old.watched_files)
        for name in crowded:
            found.update((name, form.start) for form in self._files[name].forms)
        return found if len(found) <= MOST else None

    def _told_apart(self) -> bool:
        """Whether two RAPs have one name."""
        names = [f.rap for file in self._files.values() for f in file.forms if f.rap]
        return len(names) != len(set(names))

    def _changes_known(self) -> bool:
        """Whether RAPs change or ask for other facts or primitives than before."""
        return _wanted(self._old.files) != _wanted(self._files.values())

    # --- downwards --------------------------------------------------------------------

    def _callers(self) -> Iterator[FormKey]:
        """Yield the forms that lead to a RAP that shows something else than before."""
        was, now = (
            {one.rap: one.shown for one in forms.values() if one.rap}
            for forms in (self._change.gone, self._change.fresh)
        )
        waiting = [name for name in {*was, *now} if was.get(name) != now.get(name)]
        if not waiting:
            return
        callers: dict[str, list[tuple[FormKey, str]]] = {}
        places = {
            form.rap: (name, form.start)
            for name, file in self._files.items()
            for form in file.forms
        }
        for _, one in self._census.asking():
            for callee in one.calls:
                callers.setdefault(callee, []).append((places[one.rap], one.rap))
        seen = set(waiting)
        while waiting:
            for key, rap in callers.get(waiting.pop(), ()):
                yield key
                if rap not in seen:
                    seen.add(rap)
                    waiting.append(rap)
        yield from self._mentioning(seen)

    def _mentioning(self, raps: set[str]) -> Iterator[FormKey]:
        """Yield the forms that are no RAPs and have a word among some."""
        for name, file in self._files.items():
            for form in file.forms:
                if not form.rap:
                    text = self._texts[name][form.start : form.end]
                    if not raps.isdisjoint(words_of(text)):
                        yield AGENDAS if form.sort == "agenda" else (name, form.start)

    def _labelled(self) -> Iterator[FormKey]:
        """Yield the forms of which is said what shows a place that has changed."""
        for owner, one in self._old.found:
            for span in spans_of(one):
                if span.file in self._change.files:
                    key = span.file, self._form_before(span)
                    if key not in self._change.moved:
                        yield owner

    def _form_before(self, span: Span) -> int:
        forms = self._before[span.file].forms
        return form_at([(one.start, one.end) for one in forms], span)

    def _believing(self) -> Iterator[FormKey]:
        """Yield the forms that ask how old a belief is, if it is sensed otherwise."""
        was, now = (
            {
                *(
                    one.asked()
                    for name in self._change.files & files.keys()
                    for one in files[name].census.asking
                ),
                *(
                    one
                    for name in self._change.files & files.keys()
                    for one in files[name].census.given
                ),
            }
            for files in (self._before, self._files)
        )
        if was != now:
            yield from self._with_text("believe")

    # --- sideways: constants ----------------------------------------------------------

    def _by_constants(self) -> Iterator[FormKey]:
        # told by RAPs: one that goes from a RAP to another may now be the first
        turned: Counter[tuple[str, str, int, tuple[Place, ...]]] = Counter()
        for sign, files, keys in (
            (-1, self._before, self._change.gone),
            (1, self._files, self._change.fresh),
        ):
            for name in self._change.files:
                for one in files[name].census.constants if name in files else ():
                    form = keys.get((name, one.form))
                    if form is not None:
                        turned[form.rap, one.written, one.count, one.places] += sign
        sorts: dict[Place, Counter[str]] = {}
        words: dict[str, list[tuple[bool, tuple[Place, ...]]]] = {}
        for (_, written, count, places), number in turned.items():
            sort = sort_of(written)
            if number and sort != "number":
                words.setdefault(written, []).append((count > 0, places))
            for place in places if sort else ():
                sorts.setdefault(place, Counter())[sort] += number
        for written, where in words.items():
            yield from self._by_word(written, where)
        for place, counts in sorts.items():
            yield from self._by_sorts(place, counts)

    def _by_word(
        self, written: str, where: Iterable[tuple[bool, tuple[Place, ...]]]
    ) -> Iterator[FormKey]:
        yield from self._with_text(f"?{written.lower()}")
        there = self._census.standing(written)
        rest = [one for one in there if one.form not in self._fresh]
        first = bool(there) and there[0].form in self._fresh
        if not first and all(
            _is_enough(
                [
                    one.form
                    for one in rest
                    if one.filled is filled and set(one.places).issuperset(places)
                ]
            )
            for filled, places in where
        ):
            return
        twins = (written, f'"{written}"', *self._close_to(written))
        for twin in twins:
            for one in self._census.standing(twin):
                yield one.form

    def _close_to(self, written: str) -> Iterator[str]:
        if sort_of(written) == "word":
            for other in self._census.written():
                if other[:1] == written[:1] and is_one_slip(written, other):
                    yield other

    def _by_sorts(self, place: Place, counts: Mapping[str, int]) -> Iterator[FormKey]:
        """Yield the forms with constants at a place, if sorts there have changed."""
        there = self._census.at(place)
        for sort, number in counts.items():
            if not number:
                continue
            rest = (
                one
                for file, one in there
                if sort_of(one.written) == sort and (file, one.form) not in self._fresh
            )
            if len(list(islice(rest, ENOUGH))) < ENOUGH:
                yield from [(file, one.form) for file, one in there]
                return

    def by_constants_of(self, raps: Iterable[str], but: Container[FormKey]) -> bool:
        """Whether any form, besides some, is concerned by what inputs of RAPs are.

        Such is one with a constant that is, or may be meant by, one for an input.
        """
        places = [at for name in raps for at in self._census.places_of("RAP", name)]
        words = {one.written for at in places for _, one in self._census.at(at)}
        for written in words:
            if self.mentions(f"?{written}", but):
                return True
            twins = (written, *self._close_to(written))
            for twin in twins if sort_of(written) == "word" else ():
                if any(one.form not in but for one in self._census.standing(twin)):
                    return True
        return False

    def mentions(self, text: str, but: Container[FormKey]) -> bool:
        """Whether any form has a text in it, besides some."""
        return any(key not in but for key in self._with_text(text.lower()))

    def _with_text(self, text: str) -> Iterator[FormKey]:
        for name, whole in self._texts.items():
            if text in whole and name in self._files:
                for form in self._files[name].forms:
                    if text in whole[form.start : form.end]:
                        yield name, form.start

    # --- sideways: places -------------------------------------------------------------

    def _by_places(self) -> Iterator[FormKey]:
        turned: Counter[tuple[Place, Place]] = Counter()
        for sign, files, keys in (
            (-1, self._before, self._change.gone),
            (1, self._files, self._change.fresh),
        ):
            for pairs in _pairs(files, self._change.files, keys):
                for pair in pairs:
                    turned[pair] += sign
        for (one, other), number in turned.items():
            if number:
                rest = self._census.together(one, other, self._fresh)
                if rest < ENOUGH:
                    yield from self._with(one) & self._with(other)

    def _with(self, place: Place) -> frozenset[FormKey]:
        """Return the forms that use the name of a place."""
        space, name, _ = place_parts(place)
        users = self._users.get((space, name))
        if users is None:
            every = self._census.places_of(space, name)
            forms = [form for at in every for form in self._census.forms_with(at)]
            users = self._users[space, name] = frozenset(forms)
        return users


_WORD = re.compile(r"[^\s()\";']+")


def words_of(text: str) -> list[str]:
    """Return the words of a text as symbols are read: in small letters."""
    return _WORD.findall(text.lower())


def _wanted(files: Iterable[FileState]) -> tuple[set[str], set[str], set[str]]:
    changed: set[str] = set()
    conditions: set[str] = set()
    requested: set[str] = set()
    for file in files:
        changed.update(file.census.changed)
        conditions.update(file.census.conditions)
        for one in file.census.asking:
            requested.update(one.requests)
    return changed, requested, conditions


def _is_enough(forms: Sequence[FormKey]) -> bool:
    return len(set(forms)) >= ENOUGH


def _pairs(
    files: Mapping[str, FileState], changed: Iterable[str], forms: Iterable[FormKey]
) -> Iterator[set[tuple[Place, Place]]]:
    """Yield for each of some forms the pairs of places that it puts together."""
    wanted = frozenset(forms)
    for name in changed:
        census = files[name].census if name in files else None
        groups: dict[int, list[Place]] = {}
        for place, there in census.groups.items() if census else ():
            for group in there:
                assert census is not None
                if (name, census.owners[group]) in wanted:
                    groups.setdefault(group, []).append(place)
        by_form: dict[int, set[tuple[Place, Place]]] = {}
        for group, places in groups.items():
            assert census is not None
            found = by_form.setdefault(census.owners[group], set())
            found.update((a, b) for a in places for b in places if a < b)
        yield from by_form.values()
