"""Formatting of a file, of a range of forms, and of a form while it is typed."""

from __future__ import annotations

from lsprotocol import types

from rapc.base.source import SourceFile
from rapc.language.highlight import indentation
from rapc.lsp.positions import Text, difference
from rapc.parser.formatter import formatted
from rapc.parser.reader import read


def format_file(text: Text) -> list[types.TextEdit]:
    """Return the edits that format a file; none if the file has syntax errors."""
    return edits_to(text, formatted(text).text)


def format_range(text: Text, place: types.Range) -> list[types.TextEdit]:
    """Return the edits that format the forms in a range."""
    start, end = text.stretch(place)
    forms = [
        one.datum
        for one in read(text).forms
        if one.datum.start <= end and start <= one.datum.end and not one.damaged
    ]
    if not forms:
        return []
    first, last = forms[0].start, forms[-1].end
    made = formatted(SourceFile(text.name, text.text[first:last])).text.rstrip("\n")
    return edits_to(text, f"{text.text[:first]}{made}{text.text[last:]}")


def edits_to(text: Text, new: str) -> list[types.TextEdit]:
    """Return the smallest single edit that makes a text of another."""
    if new == text.text:
        return []
    start, end, length = difference(text.text, new)
    made = new[start : start + length]
    return [types.TextEdit(text.range(start, end), made)]


def format_typed(text: Text, position: types.Position) -> list[types.TextEdit]:
    """Return the edits that indent the line of a position, after a line end."""
    offset = text.offset(types.Position(position.line, 0))
    line = text.line(position.line + 1)
    blank = len(line) - len(line.lstrip(" \t"))
    form = text.text.rfind("\n(", 0, offset) + 1
    wanted = " " * indentation(text.text[form:offset])
    if line[:blank] == wanted:
        return []
    return [types.TextEdit(text.range(offset, offset + blank), wanted)]
