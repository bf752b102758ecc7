"""Writing of changed RAP files: `rapc fmt` and `check --fix`."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from rapc.base.files import decoded, fold_line_ends, read_bytes
from rapc.base.source import SourceFile
from rapc.base.writing import changed, replace
from rapc.language.comments import strings

_LINE_END = re.compile(r"\r\n|\r|\n")


def write_back(file: Path, read: str, text: str) -> None:
    """Replace the text of a file, unless a different program has changed it meanwhile.

    A byte order mark stays. Line ends in strings stay, and all other line ends stay if
    they are of the same kind.

    Args:
        file: the file.
        read: the old text, the result of `rapc.base.files.read_text`.
        text: the new text.

    Raises:
        LoadError: if the file is missing.
        WriteError: if the text of the file is not `read`, or the file cannot be
            written.
    """
    before = read_bytes(file)
    if decoded(str(file), before) != read:
        raise changed(file)
    mark = codecs.BOM_UTF8 * before.startswith(codecs.BOM_UTF8)
    ended = _with_line_ends(before.decode("utf-8-sig"), text)
    replace(file, before, mark + ended.encode("utf-8"))


def _with_line_ends(before: str, text: str) -> str:
    """Return a text with the line ends of its old text."""
    if "\r" not in before:
        return text
    ends: list[str] = _LINE_END.findall(before)
    outside = list(ends)
    of_strings: dict[str, list[list[str]]] = {}
    for string, rows in reversed(_strings(fold_line_ends(before))):
        of_strings.setdefault(string, []).append(ends[rows])
        del outside[rows]
    usual = outside[0] if len(set(outside)) == 1 else "\n"
    made = [usual] * text.count("\n")
    for string, rows in _strings(text):
        if of_strings.get(string):
            made[rows] = of_strings[string].pop()
    lines = text.split("\n")
    return "".join(line + end for line, end in zip(lines, [*made, ""], strict=True))


def _strings(text: str) -> list[tuple[str, slice]]:
    """Return the strings in a text, each with the numbers of its line ends."""
    source = SourceFile("", text)
    return [
        (text[start:end], slice(source.row(start) - 1, source.row(end) - 1))
        for start, end in strings(text)
    ]
