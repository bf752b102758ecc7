"""Completion: the words of the language and the names that fit at a position."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from lsprotocol import types

from rapc.base.files import path_of
from rapc.base.source import SourceFile
from rapc.language.complete import fits
from rapc.language.grammar import GRAMMAR
from rapc.language.heads import rules_by_head, spelling
from rapc.language.results import RESULTS
from rapc.library.loader import names_beside, standard_libraries
from rapc.lsp.hover import comment_above
from rapc.lsp.positions import Text
from rapc.lsp.workspace import View
from rapc.parser.names import Named, names_in
from rapc.parser.reader import read

_Kind = types.CompletionItemKind

_FIELDS: Mapping[str, tuple[str, ...]] = {
    "PREDICATE": ("propositions", "properties", "functions", "queries"),
    "FUNCTION": ("functions",),
    "QUERY": ("queries",),
    "PRIMITIVE": ("primitives",),
    "DATUM": ("data",),
    "SKILL": ("skills",),
    "SIGNAL": ("events",),
    "EVENT": ("events",),
    "KIND": ("kinds",),
    "AGENDA": ("agendas",),
    "RAP": ("raps",),
}
"""The tables of a library with each kind of name of the grammar."""

_KINDS: Mapping[str, types.CompletionItemKind] = {
    "raps": _Kind.Function,
    "propositions": _Kind.Field,
    "properties": _Kind.Property,
    "functions": _Kind.Operator,
    "queries": _Kind.Operator,
    "primitives": _Kind.Interface,
    "data": _Kind.Struct,
    "skills": _Kind.Interface,
    "events": _Kind.Event,
    "kinds": _Kind.Enum,
    "agendas": _Kind.Module,
}

_LOCAL: Mapping[str, str] = {
    "VARIABLE": "variable",
    "PARAMETER": "variable",
    "TAG": "tag",
    "METHOD": "method",
    "THING": "thing",
}
"""The name spaces of the kinds of names that are taken from the form itself."""

_REQUIRE = re.compile(r'\(require\s+"([^"\n]*)$')


def completions(view: View, position: types.Position) -> list[types.CompletionItem]:
    """Return the words and names that fit at a position."""
    text = view.text
    offset = text.offset(position)
    start = text.text.rfind("\n(", 0, offset) + 1
    before = text.text[start:offset]
    required = _REQUIRE.search(before)
    if required is not None:
        return _files(view, text.range(offset - len(required[1]), offset))
    fit = fits(before)
    place = text.range(start + fit.start, offset)
    items = [_word(word, place) for word in fit.words]
    for kind in sorted(fit.kinds):
        for field in _FIELDS.get(kind, ()):
            items += _declared(view, field, fit.prefix, place)
        items += _local(view, text, start, kind, fit.prefix, place)
        if kind == "RESULT":
            items += _results(view, fit.prefix, place)
    return list({(one.label, one.kind): one for one in items}.values())


def _item(
    label: str,
    kind: types.CompletionItemKind,
    place: types.Range,
    detail: str,
    doc: str,
) -> types.CompletionItem:
    edit = types.TextEdit(place, label)
    return types.CompletionItem(
        label, kind=kind, detail=detail, documentation=doc or None, text_edit=edit
    )


def _word(word: str, place: types.Range) -> types.CompletionItem:
    for group in ("_form", "define_rap", "method", "formula", "annotation"):
        rule = rules_by_head(group).get(word)
        if rule is not None:
            says = GRAMMAR[rule].says
            return _item(word, _Kind.Keyword, place, spelling(rule), says)
    return _item(word, _Kind.Keyword, place, "", "")


def _declared(
    view: View, field: str, prefix: str, place: types.Range
) -> Iterator[types.CompletionItem]:
    """Yield the names of a table of the library that begin with a prefix."""
    signatures = view.part.signatures
    for name, form in getattr(view.part.library, field).items():
        if name.startswith(prefix):
            use = "goal" if field == "raps" else "test"
            declared = signatures.table(use).get(name)  # type: ignore[arg-type]
            detail = name if declared is None else declared.written
            doc = getattr(form, "doc", None)
            if doc is None:
                doc = comment_above(view, form.span)
            yield _item(name, _KINDS[field], place, detail, doc)


def _form_names(text: Text, start: int) -> list[Named]:
    """Return the names in the form that begins at an offset."""
    end = text.text.find("\n(", start + 1)
    form = text.text[start:] if end < 0 else text.text[start:end]
    return [
        named
        for one in read(SourceFile(text.name, form)).forms
        for named in names_in(text.name, one.datum)
    ]


def _local(
    view: View, text: Text, start: int, kind: str, prefix: str, place: types.Range
) -> Iterator[types.CompletionItem]:
    """Yield the variables, tags, methods and things of the form."""
    space = _LOCAL.get(kind)
    if space is None:
        return
    cursor = text.offset(place.end) - start
    for name in dict.fromkeys(
        one.name
        for one in _form_names(text, start)
        if one.space == space and not one.span.start <= cursor <= one.span.end
    ):
        if name.startswith(prefix):
            yield _item(name, _Kind.Variable, place, space, "")


def _results(
    view: View, prefix: str, place: types.Range
) -> Iterator[types.CompletionItem]:
    primitives = view.part.library.primitives.values()
    declared = (result for one in primitives for result in one.results)
    for name in dict.fromkeys((*RESULTS, *declared)):
        if name.startswith(prefix):
            yield _item(name, _Kind.EnumMember, place, "result", "")


def _files(view: View, place: types.Range) -> list[types.CompletionItem]:
    """Return the files beside the file, and the standard libraries."""
    names = sorted({*names_beside(path_of(view.name)), *standard_libraries()})
    return [_item(name, _Kind.File, place, "", "") for name in names]
