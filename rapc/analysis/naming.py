"""The definition and all occurrences of a name, and the edits that rename it.

A name means the same in all files of a library. Libraries that have a file in common
may share names; two libraries without a common file may use one name for two things.
Variables, tags and methods belong to a form, a method or a RAP.

Not here: the names in one form (`rapc.parser.names`), the nodes (`facts/index.py`).
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from types import MappingProxyType

from rapc.base.diagnostics import Edit, edited
from rapc.base.files import STANDARD
from rapc.base.source import SourceFile
from rapc.errors import Error
from rapc.language.results import RESULTS
from rapc.library.kinds import KNOWN_KINDS
from rapc.library.library import BUILTIN_NAMES
from rapc.library.loader import Loaded
from rapc.parser.names import Named, Space, names_in
from rapc.parser.parse import parse
from rapc.parser.reader import read
from rapc.parser.syntax import Datum, Keyword, List, Symbol, Variable
from rapc.parser.unit import SourceUnit

LOCAL: Sequence[Space] = ("variable", "tag")
"""The name spaces whose names are local to a form or to a RAP."""

_AT_HEAD: Sequence[Space] = (
    "RAP",
    "predicate",
    "primitive",
    "datum",
    "kind",
    "agenda",
)
"""The name spaces of names that the second word of a form defines."""

_OWN: Sequence[Space] = ("method", "tag", "agenda")
"""The name spaces of names that the code of a world does not use.

A problem solver may use a RAP, and the variables of the RAP.
"""

_BUILT_IN = {"predicate": BUILTIN_NAMES, "kind": KNOWN_KINDS, "result": RESULTS}
"""The names that a program cannot define, by name space."""


_KINDS: Mapping[Space, tuple[type, str]] = {
    "variable": (Variable, "a variable that begins with `?`"),
    "event": (Keyword, "a name that begins with `:`"),
    "skill": (Keyword, "a name that begins with `:`"),
}
"""The kinds of names that are no symbols."""


class NamingError(Error):
    """A name that cannot be renamed; the message states the reason."""


class Naming:
    """The names of some libraries.

    Args:
        libraries: the libraries, those of tests included; they may share files.
        is_own: whether a file may be changed; by default, no standard library may.
    """

    def __init__(
        self,
        libraries: Iterable[Loaded],
        *,
        is_own: Callable[[str], bool] = lambda file: not file.startswith(STANDARD),
    ) -> None:
        self._libraries = tuple(libraries)
        self._is_own = is_own
        self._units: dict[str, SourceUnit] = {}
        self._beside: dict[str, dict[str, None]] = {}
        for loaded in self._libraries:
            files = dict.fromkeys(unit.file.name for unit in loaded.units)
            for unit in loaded.units:
                self._units.setdefault(unit.file.name, unit)
                self._beside.setdefault(unit.file.name, {}).update(files)

    # --- where a name stands ----------------------------------------------------------

    def at(self, file: str, offset: int) -> Named | None:
        """Return the name at an offset of a file, or that ends there."""
        unit = self._units.get(file)
        if unit is None:
            return None
        near = [one for at in (offset, offset - 1) for one in self._form_at(unit, at)]
        found = [one for form in near for one in self._names(unit, form)]
        here = [one for one in found if one.span.start <= offset <= one.span.end]
        return max(here, key=lambda one: one.span.start) if here else None

    def definitions(self, named: Named) -> tuple[Named, ...]:
        """Return where a name is defined; of a variable, the first occurrence."""
        if named.space in _AT_HEAD:
            return tuple([one for one in self._at_heads(named) if one.defines])
        found = self.occurrences(named)
        defining = tuple([one for one in found if one.defines])
        return defining if defining or named.space != "variable" else found[:1]

    def occurrences(self, named: Named, most: int | None = None) -> tuple[Named, ...]:
        """Return all occurrences of a name, its definitions among them.

        The occurrences are in the order of the files of the libraries, and of the text.

        Args:
            named: an occurrence of the name.
            most: the number of occurrences to stop after; None for no limit.
        """
        return tuple(islice(self._matching(named, named.name), most))

    def occurrences_beside(self, named: Named) -> tuple[Named, ...]:
        """Return the occurrences of a name in the same file."""
        file = named.span.file
        if named.space not in LOCAL and named.space != "method":
            found = self._in_files((file,), named.space, named.name)
            return tuple(found)
        return tuple([one for one in self.occurrences(named) if one.span.file == file])

    def names(self, file: str) -> Iterator[Named]:
        """Yield the names of a file, in the order of the text."""
        unit = self._units.get(file)
        for form in () if unit is None else unit.data:
            assert unit is not None
            yield from self._names(unit, form)

    def _names(self, unit: SourceUnit, form: Datum) -> Iterator[Named]:
        """Yield the names of a form; a property may have a function as its default."""
        for one in names_in(unit.file.name, form):
            if not one.may_be_value or self._is_function(one):
                yield one

    def _is_function(self, named: Named) -> bool:
        return any(
            named.name in loaded.library.functions
            for loaded in self._libraries
            if named.span.file in loaded.files
        )

    def _form_at(self, unit: SourceUnit, offset: int) -> Iterator[Datum]:
        data = unit.data
        at = bisect_right(data, offset, key=lambda form: form.start) - 1
        if at >= 0 and offset < data[at].end:
            yield data[at]

    def _matching(self, named: Named, name: str) -> Iterator[Named]:
        """Yield the names that mean the same as `named` would with the name `name`."""
        if named.space in LOCAL:
            found = self._local(named, name)
            is_wide = any(one.scope is None for one in found)
            yield from (one for one in found if is_wide or one.scope == named.scope)
            return
        is_method = named.space == "method"
        only = self._only_rap_with(named) if is_method else ""
        for one in self._shared(named, name):
            if not is_method or (one.rap or only) == (named.rap or only):
                yield one

    def _shared(self, named: Named, name: str) -> Iterator[Named]:
        """Yield the names in the space of `named`, in the files that share its name."""
        yield from self._in_files(self._sharing(named), named.space, name)

    def _in_files(
        self, files: Iterable[str], space: Space, name: str
    ) -> Iterator[Named]:
        for file in files:
            unit = self._units[file]
            for form in _forms_with(unit, name):
                for one in self._names(unit, form):
                    if one.space == space and one.name == name:
                        yield one

    def _at_heads(self, named: Named) -> Iterator[Named]:
        """Yield the occurrences of a name in forms with the name at their head."""
        for file in self._sharing(named):
            unit = self._units[file]
            text = unit.file.lowered
            for form in unit.data if named.name in text else ():
                word = _word(_word(form, 1), 0)
                if text[word.start : word.end] == named.name:
                    for one in self._names(unit, form):
                        if one.space == named.space and one.name == named.name:
                            yield one

    def _only_rap_with(self, named: Named) -> str:
        """Return the RAP that alone has a method of a name; if several, no text.

        A query or a test that states no RAP means this method.
        """
        raps = {one.rap for one in self._shared(named, named.name) if one.rap}
        return raps.pop() if len(raps) == 1 else ""

    def _local(self, named: Named, name: str) -> list[Named]:
        """Return the variables or tags of a name in the form or the RAP of `named`."""
        files, word = [named.span.file], name
        if named.rap and named.space == "variable":
            files = list(self._sharing(Named("RAP", named.rap, named.span, named.form)))
            word = named.rap
        return [
            one
            for file in files
            for form in _forms_with(self._units[file], word)
            for one in names_in(file, form)
            if one.space == named.space and one.name == name and one.rap == named.rap
            if named.rap or one.form == named.form
        ]

    def _sharing(self, named: Named) -> dict[str, None]:
        """Return the files in which a name of a file may mean the same.

        These are the files of all libraries with the file. A library that shares a file
        with the name with one of these libraries belongs to them.
        """
        found: dict[str, None] = {}
        left = [named.span.file]
        word = named.name
        while left:
            for file in self._beside.get(left.pop(), ()):
                if file not in found:
                    found[file] = None
                    if next(_places(self._units[file].file, word), None) is not None:
                        left.append(file)
        return {file: None for file in self._units if file in found}

    # --- renaming ---------------------------------------------------------------------

    def renamed(
        self,
        named: Named,
        new: str,
        in_code: Mapping[str, Path] = MappingProxyType({}),
    ) -> tuple[Edit, ...]:
        """Return the edits that give a name another name, everywhere.

        Args:
            named: an occurrence of the name.
            new: the other name.
            in_code: the names that the code of worlds uses, each with its file.

        Raises:
            NamingError: if the new name is not valid or is in use, if the name is known
                outside of the libraries, or if a file must not be changed.
        """
        new = new.lower()
        old = named.name
        self._refuse_name(named, new)
        found = self.occurrences(named)
        for one in found:
            if not self._is_own(one.span.file):
                text = f"cannot rename `{old}`: `{one.span.file}` uses it"
                raise NamingError(text, "the file is not part of this project")
        is_local = named.space in _OWN or named.scope is not None
        code = in_code.get(old) or in_code.get(old.removeprefix(":"))
        if code is not None and not is_local:
            text = f"cannot rename `{old}`: `{code}` uses it"
            raise NamingError(text, "the code of a world knows the name")
        if self._is_taken(named, found, new):
            raise NamingError(f"cannot rename `{old}`: the name `{new}` is in use")
        edits = tuple([self._edit(one, new) for one in found])
        self._refuse_other_meaning(named, found, edits, new)
        return edits

    def _is_taken(self, named: Named, found: Sequence[Named], new: str) -> bool:
        """Return whether a name is in use where the name of `found` is known."""
        if named.space in LOCAL and any(one.scope is None for one in found):
            return bool(self._local(named, new))
        return any(True for _ in self._matching(named, new))

    def _refuse_name(self, named: Named, new: str) -> None:
        """Refuse a new name that is no name of its space, and names of the language."""
        data = read(SourceFile("", new)).forms
        kind, what = _KINDS.get(named.space, (Symbol, "a symbol"))
        found = [(type(one.datum), one.datum.end - one.datum.start) for one in data]
        if found != [(kind, len(new))] or new == "?":
            raise NamingError(f"expected {what}, not `{new}`")
        reserved = _BUILT_IN.get(named.space, ())
        for name in (named.name, new):
            if name in reserved:
                raise NamingError(f"cannot rename `{named.name}`: `{name}` is reserved")
        if named.space == "class":
            text = f"cannot rename `{named.name}`: a class is a value in facts"
            raise NamingError(text)

    def _edit(self, one: Named, new: str) -> Edit:
        text = self._units[one.span.file].file.text
        bare = new[0] == ":" and text[one.span.start] != ":"
        return Edit(one.span, new[1:] if bare else new)

    def _refuse_other_meaning(
        self, named: Named, found: Sequence[Named], edits: Sequence[Edit], new: str
    ) -> None:
        """Refuse edits after which a name would be read as a word of the language."""
        for file in dict.fromkeys(one.span.file for one in found):
            before = self._units[file]
            here = [edit for edit in edits if edit.span.file == file]
            after = parse(SourceFile(file, edited(before.file.text, here)))
            spans = {edit.span for edit in here}
            expected = [
                (one.space, new if one.span in spans else one.name)
                for form in before.data
                for one in names_in(file, form)
            ]
            names = [one for form in after.data for one in names_in(file, form)]
            actual = [(one.space, one.name) for one in names]
            faults = len(after.diagnostics) - len(before.diagnostics)
            if actual != expected or faults > 0:
                text = f"cannot rename `{named.name}`: `{new}` has a meaning here"
                raise NamingError(text, f"`{file}` would be read in another way")


def _word(datum: Datum, at: int) -> Datum:
    """Return an item of a list; of a shorter list or a word, the datum itself."""
    items = datum.items if isinstance(datum, List) else ()
    return items[at] if at < len(items) else datum


_PART = re.compile(r"[^\s()\";']")
"""A character of a name."""


def _places(source: SourceFile, name: str) -> Iterator[int]:
    """Yield where a name stands in a text; an event may lack its colon.

    The search for a text is much faster than that for an expression.
    """
    bare = name.removeprefix(":")
    text, at = source.lowered, -1
    while (at := text.find(bare, at + 1)) >= 0:
        before = text[at - 1 : at] if at else ""
        if before == ":" and bare != name:
            before = text[at - 2 : at - 1] if at > 1 else ""
        if not _PART.match(before) and not _PART.match(text, at + len(bare)):
            yield at


def _forms_with(unit: SourceUnit, name: str) -> Iterator[Datum]:
    """Yield the forms of a file that may have a name, in the order of the text."""
    data = unit.data
    last = -1
    for found in _places(unit.file, name):
        at = bisect_right(data, found, key=lambda form: form.start) - 1
        if at > last and found < data[at].end:
            last = at
            yield data[at]
