"""Completion: the words and names that fit at a position, and files after `require`."""

from __future__ import annotations

import re
from collections.abc import Mapping

from lsprotocol import types

from rapc.analysis.completion import Candidate, completion
from rapc.base.files import path_of
from rapc.library.loader import names_beside, standard_libraries
from rapc.lsp.workspace import View

_Kind = types.CompletionItemKind

_KINDS: Mapping[str, types.CompletionItemKind] = {
    "word": _Kind.Keyword,
    "RAP": _Kind.Function,
    "method": _Kind.Method,
    "tag": _Kind.Reference,
    "predicate": _Kind.Field,
    "primitive": _Kind.Interface,
    "result": _Kind.EnumMember,
    "datum": _Kind.Struct,
    "skill": _Kind.Interface,
    "event": _Kind.Event,
    "kind": _Kind.Enum,
    "agenda": _Kind.Module,
    "class": _Kind.Class,
    "thing": _Kind.Unit,
    "variable": _Kind.Variable,
    "value": _Kind.Value,
}
"""The kinds of the protocol by name space."""

_REQUIRE = re.compile(r'\(require\s+"([^"\n]*)$')


MOST = 100
"""The number of completions in an answer; the editor asks again for a longer word."""


def completions(view: View, position: types.Position) -> list[types.CompletionItem]:
    """Return the completions at a position, the most likely first, `MOST` at most."""
    text = view.text
    offset = text.offset(position)
    row = text.position(offset).row
    line = text.text[text.line_starts[row - 1] : offset]
    required = _REQUIRE.search(line)
    if required is not None:
        place = text.range(offset - len(required[1]), offset)
        file = path_of(view.name)
        others = {*names_beside(file), *standard_libraries()} - {file.stem}
        return [
            types.CompletionItem(
                name, kind=_Kind.File, text_edit=types.TextEdit(place, name)
            )
            for name in sorted(others)
        ]
    part = view.part
    found = completion(part.library, part.signatures, text.text, offset, MOST)
    place = text.range(found.start, offset)
    return [_item(one, at, place) for at, one in enumerate(found.candidates)]


def _item(found: Candidate, at: int, place: types.Range) -> types.CompletionItem:
    """Return a candidate; editors sort by a text, which keeps the order."""
    return types.CompletionItem(
        found.text,
        kind=_KINDS[found.space],
        detail=found.detail or found.space,
        documentation=found.doc or None,
        sort_text=f"{at:05}",
        text_edit=types.TextEdit(place, found.text),
    )
