"""Completion in a file: the words and names that fit at a position, with their types.

The grammar determines which words and kinds of names fit (`rapc.language.complete`).
The library supplies its names; the form around the position supplies variables, tags
and methods. If an argument has a kind, the variables and values of the kind come first.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import Literal

import msgspec

from rapc.base.source import SourceFile
from rapc.base.values import format_atom
from rapc.ir import nodes
from rapc.language.complete import fits, last_form
from rapc.language.results import RESULTS
from rapc.library.kinds import KNOWN_KINDS
from rapc.library.library import Library
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures
from rapc.parser.names import SPACE_OF, Named, Space, names_in
from rapc.parser.reader import read
from rapc.parser.syntax import Datum, List, Symbol, Variable


class Candidate(msgspec.Struct, frozen=True):
    """A completion of the word at a position."""

    text: str
    #: The name space; `word` for a word of the language, `value` for a value of a kind.
    space: Space | Literal["word", "value"]
    #: The name with its arguments, or the kind of a variable or value.
    detail: str = ""
    #: The documentation in the declaration.
    doc: str = ""


class Completion(msgspec.Struct, frozen=True):
    """The completions at a position, the most likely first."""

    #: The start of the word that a candidate replaces.
    start: int
    candidates: tuple[Candidate, ...]


def completion(
    library: Library,
    signatures: Signatures,
    text: str,
    offset: int,
    most: int | None = None,
) -> Completion:
    """Return the completions at an offset of a file.

    Args:
        library: the library of the file, as last read.
        signatures: the signatures of the library.
        text: the text of the file.
        offset: the offset.
        most: the number of candidates to stop after; None for no limit.
    """
    before = text[:offset]
    fit = fits(before)
    here = _Place(library, signatures, text, fit.start, fit.prefix)
    candidates = chain(
        *(here.results(), here.methods(), here.values()),
        *map(here.named, sorted(fit.kinds)),
        (Candidate(word, "word") for word in fit.words),
    )
    found: dict[str, Candidate] = {}
    for one in candidates:
        if len(found) == most:
            break
        if one.text.startswith(fit.prefix):
            found.setdefault(one.text, one)
    return Completion(fit.start, tuple(found.values()))


class _Word(msgspec.Struct, frozen=True):
    """A word before the position; a list counts as the word at its front."""

    text: str
    start: int
    is_list: bool = False


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|;[^\n]*|[()]|[^\s()";]+', re.S)


class _Place:
    """The text and names around a position."""

    def __init__(
        self,
        library: Library,
        signatures: Signatures,
        text: str,
        offset: int,
        prefix: str,
    ) -> None:
        self._prefix = prefix
        self._library = library
        self._signatures = signatures
        start = last_form(text[:offset])
        end = text.find("\n(", offset)
        self._text = text[start : end if end >= 0 else len(text)]
        self._offset = offset - start

    @cached_property
    def _forms(self) -> Sequence[Datum]:
        return [one.datum for one in read(SourceFile("", self._text)).forms]

    @cached_property
    def _names(self) -> Sequence[Named]:
        return [one for form in self._forms for one in names_in("", form)]

    @cached_property
    def _around(self) -> Sequence[Sequence[_Word]]:
        """The words before the position in each list around it, innermost first."""
        stack: list[list[_Word]] = [[]]
        for token in _TOKEN.finditer(self._text, 0, self._offset):
            text = token[0].lower()
            if text == "(":
                stack.append([])
            elif text == ")":
                inner = stack.pop() if len(stack) > 1 else []
                front = inner[0] if inner else _Word("", token.start())
                stack[-1].append(_Word(front.text, front.start, is_list=True))
            elif text[0] != ";":
                stack[-1].append(_Word(text, token.start()))
        return stack[::-1]

    def _head(self, level: int) -> str:
        """Return the first word of a list around the position, or no text."""
        words = self._around[level] if level < len(self._around) else ()
        return words[0].text if words and not words[0].is_list else ""

    @property
    def _position(self) -> int:
        """The number of words before the position in the innermost list."""
        return len(self._around[0])

    # --- results and methods ----------------------------------------------------------

    def results(self) -> Iterator[Candidate]:
        """Yield the results that fit: of a primitive, or of a RAP."""
        at, words = (self._head(0), self._position), self._around[0]
        outer = self._around[1] if len(self._around) > 1 else ()
        primitives: Iterable[str] = ()
        if at in (("last-result", 1), ("result-with-method", 2)):
            primitives = self._requested()
        elif at == ("fails", 2):
            primitives = self._library.primitives
        elif self._head(1) == "match-result" and not words:
            index = self._around[2][1:2] if len(self._around) > 2 else ()
            primitives = _requested_by(self._library, [one.text for one in index])
        elif self._head(1) == "script" and len(words) == 1 and words[0].is_list:
            yield from self._results_of(words[0].text)
            return
        elif outer and outer[-1].text == ":on" and not words:
            if self._head(1) == "declare-primitive":
                found = [one.name for one in self._names if one.space == "result"]
                yield from _candidates(found, "result", "")
            return
        else:
            return
        for name in primitives:
            yield from self._results_of(name)
        yield from _candidates(RESULTS, "result", "result of a task")

    def _results_of(self, primitive: str) -> Iterator[Candidate]:
        declared = self._signatures.primitives.get(primitive)
        results = () if declared is None else declared.results
        return _candidates(results, "result", f"result of {primitive}")

    def _requested(self) -> Iterator[str]:
        """Yield the primitives in the form, and in the RAP that the form extends."""
        for one in self._names:
            if one.space == "primitive":
                yield one.name
        yield from _requested_by(self._library, self._raps)

    @property
    def _raps(self) -> Sequence[str]:
        """The RAP that the form defines or extends, as a list of one."""
        return [one.name for one in self._names if one.space == "RAP"][:1]

    def methods(self) -> Iterator[Candidate]:
        """Yield the methods that fit: those of the RAP around, or of a named RAP."""
        at, words = (self._head(0), self._position), self._around[0]
        raps: Sequence[str] = ()
        if at in (("method-tried", 1), ("result-with-method", 1)):
            for one in self._names:
                if one.space == "method" and one.defines:
                    yield Candidate(one.name, "method", f"method of {one.rap}")
            raps = self._raps
        elif at == ("method", 2) and self._head(1) == "expect":
            raps = [words[1].text]
        for rap in raps:
            known = self._library.raps.get(rap)
            for method in () if known is None else known.methods:
                yield Candidate(method.traced_name, "method", f"method of {rap}")

    # --- arguments --------------------------------------------------------------------

    def values(self) -> Iterator[Candidate]:
        """Yield variables, and the values of the kind of the argument."""
        words = self._around[0]
        if self._head(1) in ("define-rap", "index"):
            return
        signature = self._signature(words[0]) if words else None
        kind = _kind_of(signature, len(words) - 1)
        if kind is None:
            return
        fitting = {kind, *self._below(kind)}
        yield from (one for one in self._variables() if one.detail in fitting)
        for value in self._signatures.kinds.values(kind) or ():
            yield Candidate(format_atom(value), "value", kind)

    def _below(self, kind: str) -> Iterator[str]:
        kinds = self._signatures.kinds
        return (one for one in self._library.kinds if kind in kinds.above(one))

    def _signature(self, word: _Word) -> Signature | None:
        """Return the signature of the name at a word."""
        spaces = self._spaces.get(word.start)
        table = _TABLES.get(spaces or "")
        found = getattr(self._signatures, table, {}) if table else {}
        return found.get(word.text)

    @cached_property
    def _spaces(self) -> Mapping[int, Space]:
        return {one.span.start: one.space for one in self._names}

    def _variables(self) -> Iterator[Candidate]:
        """Yield the variables before the position, the last one first."""
        for one in reversed(self._names):
            is_before = one.span.end < self._offset
            if one.space == "variable" and is_before and self._is_known(one):
                yield Candidate(one.name, "variable", self._kinds.get(one.name, ""))

    def _is_known(self, named: Named) -> bool:
        """Return whether the position is in the scope of a tag or variable."""
        scope = named.scope
        return scope is None or scope.start < self._offset <= scope.end

    @cached_property
    def _kinds(self) -> Mapping[str, str]:
        """The kinds of the variables, by the arguments at which they occur."""
        found: dict[str, str] = {}
        left = list(self._forms)
        while left:
            datum = left.pop()
            if not isinstance(datum, List):
                continue
            left.extend(datum.items)
            match datum.items:
                case (Variable(name), Symbol(kind)) if kind in self._signatures.kinds:
                    found[name] = kind
                case (first, *args) if not isinstance(first, List):
                    word = _Word(
                        self._text[first.start : first.end].lower(), first.start
                    )
                    signature = self._signature(word)
                    for at, arg in enumerate(args):
                        named = _kind_of(signature, at)
                        if isinstance(arg, Variable) and named is not None:
                            found.setdefault(arg.name, named)
        return found

    # --- names ------------------------------------------------------------------------

    def named(self, terminal: str) -> Iterator[Candidate]:
        """Yield the names of a kind of the grammar, except where a name is defined."""
        head, position = self._head(0), self._position
        if terminal == "VARIABLE":
            yield from self._variables()
        elif terminal == "TAG" and position:
            yield from self._tags()
        elif terminal == "KIND" and (head, position) != ("declare-kind", 1):
            yield from _candidates(KNOWN_KINDS, "kind", "built-in kind")
            yield from self._declared("kinds", "kind")
        elif terminal == "THING":
            yield from _candidates(self._things(), "thing", "")
        elif terminal in FIELDS and not self._defines():
            for field in FIELDS[terminal]:
                yield from self._declared(field, SPACE_OF[terminal])

    def _defines(self) -> bool:
        """Return whether the name at the position is a new one."""
        head, position = self._head(0), self._position
        is_index = self._head(1) == "define-rap" and not position
        is_name = head.startswith("declare-") or head in ("index", "define-agenda")
        return is_index or self._head(1) == "index" or (is_name and position == 1)

    def _tags(self) -> Iterator[Candidate]:
        for one in self._names:
            if one.space == "tag" and one.defines and self._is_known(one):
                yield Candidate(one.name, "tag")

    def _things(self) -> Iterator[str]:
        library = self._library
        for primitive in library.primitives.values():
            yield from (thing.name for thing in primitive.uses)
        for skill in library.skills.values():
            yield from (thing.name for thing in skill.uses)

    def _declared(self, field: str, space: Space) -> Iterator[Candidate]:
        table = _TABLES.get(space)
        known = getattr(self._signatures, table) if table else {}
        declared = getattr(self._library, field)
        for name in declared:
            if name.startswith(self._prefix):
                detail = known[name].written if name in known else ""
                doc = getattr(declared[name], "doc", "")
                yield Candidate(name, space, detail, doc)


_TABLES: Mapping[str, str] = {
    "RAP": "raps",
    "predicate": "predicates",
    "primitive": "primitives",
    "datum": "data",
    "skill": "skills",
    "event": "events",
}
"""The table of signatures of a name space."""

FIELDS: Mapping[str, Sequence[str]] = {
    "RAP": ("raps",),
    "PREDICATE": ("propositions", "properties", "functions", "queries"),
    "FUNCTION": ("functions",),
    "PRIMITIVE": ("primitives",),
    "DATUM": ("data",),
    "SKILL": ("skills",),
    "SIGNAL": ("events",),
    "KIND": ("kinds",),
    "AGENDA": ("agendas",),
    "CLASS": ("indistinct",),
}
"""The tables of a library that contain each kind of name."""


def _candidates(names: Iterable[str], space: Space, detail: str) -> Iterator[Candidate]:
    return (Candidate(name, space, detail) for name in names)


def _requested_by(library: Library, raps: Iterable[str]) -> Iterator[str]:
    """Yield the primitives that the methods of RAPs request."""
    for name in raps:
        rap = library.raps.get(name)
        for method in () if rap is None else rap.methods:
            if isinstance(method.body, nodes.Primitive):
                yield method.body.request.name


def _kind_of(signature: Signature | None, at: int) -> str | None:
    """Return the kind of an argument, or None."""
    args = signature.args if signature is not None else None
    return args[at].kind if args is not None and 0 <= at < len(args) else None
