"""Check a library again of which little has changed since it was checked.

The forms that have to be looked at again (`rapc.analysis.affected`) and all that they
lead to are a small library of their own: its forms are read from where they stand, and
the passes run over it as over any other. Passes that hold a form against all others ask
the census (`rapc.analysis.census`), which is of the whole library. What was found in
other forms is kept, and shown where these forms are now.

Findings are those of a whole check, byte for byte. Where that is not certain there is
no answer, and the library is checked as a whole.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis import suite
from rapc.analysis.affected import Affected, words_of
from rapc.analysis.census import CENSUS, Census
from rapc.analysis.change import Change, change_of, requires_the_same
from rapc.analysis.damage import Damage
from rapc.analysis.driver import (
    Analysis,
    CheckReport,
    Written,
    reported,
    reporting,
)
from rapc.analysis.file_census import FileCensus, FormKey, gather
from rapc.analysis.index import USES, Index
from rapc.analysis.kept import (
    AGENDAS,
    FileState,
    FormState,
    State,
    entangled_in,
    file_state,
    form_at,
)
from rapc.analysis.moving import Moving
from rapc.analysis.passes.constants import ANALYZER as CONSTANTS
from rapc.analysis.place_kinds import PLACE_KINDS
from rapc.analysis.places import Places
from rapc.analysis.selection import Selection
from rapc.base.diagnostics import Diagnostic
from rapc.base.gc_paused import gc_paused
from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.library import library
from rapc.library.library import Library
from rapc.library.loader import Loaded, Parse
from rapc.library.signature import RapSignatures
from rapc.parser.parse import parse
from rapc.parser.unit import SourceUnit


class Again(msgspec.Struct, frozen=True):
    """What a check of a part has come to."""

    report: CheckReport
    #: What to keep for the next check; None for what was kept before.
    state: State | None


@gc_paused()
def check_again(
    old: State,
    sketched: Loaded,
    parser: Parse,
    chosen: Selection,
    digest: Callable[[SourceFile], str],
) -> Again | None:
    """Return the report on a library, and what to keep; None if all is to be checked.

    Args:
        old: what was kept of it.
        sketched: the library now, of which files and what they require are known.
        parser: makes units of files.
        chosen: the rules that may report, the same as before.
        digest: tells the text of a file from others.
    """
    if any(one.of_all for one in reporting(chosen.enabled)):
        return None
    sources = sketched.files
    both = {one.name for one in old.files} & sources.keys()
    if not requires_the_same(old.required, sketched.required, both):
        return None
    read = _read(old, sources, parser, digest)
    change = None if read is None else change_of(old, read.files)
    if read is None or change is None:
        return None
    return _Part(old, read, change, sketched).checked(chosen)


class _Read(msgspec.Struct, frozen=True):
    """The files of a library as they are now."""

    #: What each of them tells, in the order in which they are read.
    files: Mapping[str, FileState]
    #: Those with another text than before, by their names.
    units: Mapping[str, SourceUnit]


def _read(
    old: State,
    sources: Mapping[str, SourceFile],
    parser: Parse,
    digest: Callable[[SourceFile], str],
) -> _Read | None:
    """Return the files as they are now; None if there are tests in one."""
    known = {one.name: one for one in old.files}
    files: dict[str, FileState | None] = {}
    units: dict[str, SourceUnit] = {}
    digests: dict[str, str] = {}
    for name, source in sources.items():
        told = digest(source)
        one = known.get(name)
        files[name] = one if one is not None and one.digest == told else None
        if files[name] is None:
            unit = parser(source)
            if unit.tests:
                return None
            units[name], digests[name] = unit, told
    written = Written.of(units.values(), suite.rules())
    linked, _ = library.link([*units.values()])
    index = Index(linked)
    censuses = gather(linked, index, Places(index, ()))
    entangled = entangled_in(index)
    now = {
        name: one
        or file_state(
            units[name],
            digests[name],
            censuses.get(name, FileCensus()),
            written,
            entangled,
        )
        for name, one in files.items()
    }
    return _Read(now, units)


class _Part:
    """The part of a library that is looked at again.

    Args:
        old: the library as it was.
        read: its files now.
        change: what has changed.
        sketched: the library now.
    """

    def __init__(
        self, old: State, read: _Read, change: Change, sketched: Loaded
    ) -> None:
        files = read.files
        self._old = old
        self._files = files
        self._units = read.units
        #: What is wrong with the texts: nothing was when the state was kept.
        self._slips = [one for unit in read.units.values() for one in unit.diagnostics]
        self._is_whole = not self._slips and not any(
            unit.partial for unit in read.units.values()
        )
        self._damage = Damage(read.units.values())
        self._change = change
        self._sources = sketched.files
        self._required = sketched.required
        censuses = {name: one.census for name, one in files.items()}
        self._census = Census(censuses)
        self._affected = Affected(old, files, change, self._census, sketched.files)
        self._moving = Moving(old, change)
        self._forms = {
            (name, one.start): one for name, file in files.items() for one in file.forms
        }
        self._raps = {one.rap: key for key, one in self._forms.items() if one.rap}

    def checked(self, chosen: Selection) -> Again | None:
        """Return what a whole check would find; None if that is not certain."""
        dirty = self._affected.all()
        below = None if dirty is None else self._below(self._with_agendas(dirty))
        if dirty is None or below is None:
            return None
        part = self._library(below, agendas=AGENDAS in dirty)
        if part is None:
            return None
        self._census.unmarked = frozenset(
            [(key, name) for key, name in self._unmarked() if key not in dirty]
        )
        known = {CENSUS.name: self._census, USES.name: self._census.uses()}
        raps = RapSignatures(_Raps(part, self._raps, self._rap))
        self._census.inputs = {
            name: kinds
            for name, kinds in self._old.inputs.items()
            if name in self._raps and name not in part.raps
        }
        unsure = self._damage.reaches
        analysis = Analysis(part, True, unsure, self._required, known, raps)
        analysis.run(reporting(chosen.enabled))
        if not self._is_certain(analysis, dirty):
            return None
        found = [*self._kept(dirty), *self._new(analysis, dirty)]
        report = self._report([one for _, one in found], chosen)
        if not self._is_whole:
            return Again(report, None)
        state = State(
            tuple(self._files.values()),
            tuple(found),
            tuple(sorted(dirty & analysis.watched)),
            tuple(sorted(self._watched_files(analysis, dirty))),
            tuple(sorted(self._unmarked_now(analysis, dirty))),
            self._required,
            analysis.result(PLACE_KINDS).inputs,
        )
        return Again(report, state)

    def _with_agendas(self, dirty: set[FormKey]) -> set[FormKey]:
        """Add all agendas to some forms if one of them is concerned."""
        agendas = [key for key, one in self._forms.items() if one.sort == "agenda"]
        if AGENDAS in dirty or not dirty.isdisjoint(agendas):
            dirty.update((AGENDAS, *agendas))
        return dirty

    # --- what is looked at ------------------------------------------------------------

    def _below(self, dirty: Iterable[FormKey]) -> set[FormKey] | None:
        """Return the RAPs among some forms and all that these lead to.

        None if one of them may be entangled with forms that it does not lead to.
        """
        waiting: list[str] = []
        for key in dirty:
            form = self._forms.get(key)
            if form is not None and form.rap:
                waiting.append(form.rap)
            elif form is not None and form.is_entangled:
                return None
            elif form is not None:
                words = words_of(self._sources[key[0]].text[form.start : form.end])
                waiting += [word for word in words if word in self._raps]
        calls = {one.rap: one.calls for _, one in self._census.asking()}
        found: set[FormKey] = set()
        seen = set(waiting)
        while waiting:
            at = self._raps.get(waiting.pop())
            if at is None:
                continue  # a pass will say so
            if self._forms[at].is_entangled:
                return None
            found.add(at)
            new = [name for name in calls[self._forms[at].rap] if name not in seen]
            seen.update(new)
            waiting += new
        return found

    def _library(self, raps: set[FormKey], *, agendas: bool) -> Library | None:
        """Return the library of some RAPs and of all declarations and rules.

        None if two forms have one name.
        """
        units = []
        for name, file in self._files.items():
            wanted = [
                one
                for one in file.forms
                if (name, one.start) in raps
                or (not one.rap and (agendas or one.sort != "agenda"))
            ]
            if all(one.sort == "require" for one in wanted):
                wanted = []
            units.append(self._unit(self._sources[name], wanted))
        linked, wrong = library.link(units)
        return None if wrong else linked

    def _unit(self, source: SourceFile, wanted: Sequence[FormState]) -> SourceUnit:
        """Return a unit with some forms of a file, each in its place."""
        starts = {one.start for one in wanted}
        if not starts:
            return SourceUnit(source)
        whole = self._units.get(source.name)
        if whole is None:
            pieces, at = [], 0
            for one in wanted:
                pieces += [" " * (one.start - at), source.text[one.start : one.end]]
                at = one.end
            whole = parse(SourceFile(source.name, "".join(pieces)))
        forms = tuple([one for one in whole.forms if one.span.start in starts])
        return SourceUnit(source, forms)

    def _rap(self, name: str) -> nodes.DefineRap:
        """Return a RAP of the whole library."""
        at = self._raps[name]
        (form,) = self._unit(self._sources[at[0]], [self._forms[at]]).forms
        assert isinstance(form, nodes.DefineRap)
        return form

    # --- what is found ----------------------------------------------------------------

    def _is_certain(self, analysis: Analysis, dirty: set[FormKey]) -> bool:
        """Whether no form left out has a variable for which a constant stands now.

        Nor may it have one for which a constant stands no more, or a constant that
        stands where RAPs take values of another kind than before.
        """
        now = {(k, n) for (_, n), k in analysis.result(CONSTANTS).items() if k in dirty}
        turned = now ^ {(key, name) for key, name in self._unmarked() if key in dirty}
        others = {name for _, name in turned}
        others.update(n for key, n in self._old.unmarked if key in self._change.gone)
        if any(self._affected.mentions(name, dirty) for name in others):
            return False
        before, after = self._old.inputs, analysis.result(PLACE_KINDS).inputs
        raps = {*before, *after}
        changed = [name for name in raps if before.get(name) != after.get(name)]
        return not self._affected.by_constants_of(changed, dirty)

    def _watched_files(self, analysis: Analysis, dirty: set[FormKey]) -> set[str]:
        looked_at = {file for file, _ in dirty}
        kept = set(self._old.watched_files) - looked_at
        return kept | (analysis.watched_files & looked_at)

    def _unmarked(self) -> Iterator[tuple[FormKey, str]]:
        for key, name in self._old.unmarked:
            for now in self._change.now(key):
                yield now, name

    def _unmarked_now(
        self, analysis: Analysis, dirty: set[FormKey]
    ) -> Iterator[tuple[FormKey, str]]:
        for key, name in self._unmarked():
            if key not in dirty:
                yield key, name
        for (_, name), key in analysis.result(CONSTANTS).items():
            if key in dirty:
                yield key, name

    def _kept(self, dirty: set[FormKey]) -> Iterator[tuple[FormKey, Diagnostic]]:
        for owner, one in self._old.found:
            for now in self._change.now(owner):
                if now not in dirty:
                    yield now, self._moving.moved(one)

    def _new(
        self, analysis: Analysis, dirty: set[FormKey]
    ) -> Iterator[tuple[FormKey, Diagnostic]]:
        ranges = {
            name: [(one.start, one.end) for one in file.forms]
            for name, file in self._files.items()
        }
        for analyzer, one in analysis.found:
            there = one.span.file, form_at(ranges[one.span.file], one.span)
            owner = AGENDAS if analyzer.by_agendas else there
            silenced = self._damage.silences(one, analyzer.needs_whole)
            if owner in dirty and not silenced:
                yield owner, one

    def _report(self, found: Sequence[Diagnostic], chosen: Selection) -> CheckReport:
        written = Written(
            {name: one.suppressions for name, one in self._files.items()},
            {name: one.wrong for name, one in self._files.items()},
        )
        left = written.applied(
            [*self._slips, *found], self._sources, chosen, self._damage.lies_in
        )
        raps = Counter(key[0] for key in self._raps.values())
        return reported(left, self._sources, raps, chosen)


class _Raps(Mapping[str, nodes.DefineRap]):
    """All RAPs of a library, of which those that are no part of it are read late.

    Args:
        part: the part.
        names: the names of all RAPs.
        read: reads one of them.
    """

    def __init__(
        self,
        part: Library,
        names: Mapping[str, FormKey],
        read: Callable[[str], nodes.DefineRap],
    ) -> None:
        self._part = part.raps
        self._names = names
        self._read = read

    def __getitem__(self, name: str) -> nodes.DefineRap:
        return self._part[name] if name in self._part else self._read(name)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
