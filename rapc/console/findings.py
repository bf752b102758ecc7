"""Findings as text for people, on a terminal or not.

`full` prints each finding with the source around it, by the contract of the command
line; `concise` prints one line each, `grouped` names each file once.
`rapc.analysis.driver` determines findings and severity. Formats for other programs are
in `rapc.console.formats`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import TextIO

import msgspec
from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from rapc.analysis.driver import CheckReport, Finding
from rapc.base.diagnostics import Applicability, Diagnostic, Edit, Fix, Label, Severity
from rapc.base.source import SourceFile, Span, place
from rapc.base.visible import visible
from rapc.console.lines import wrapped

Files = Mapping[str, SourceFile]

_STYLES = {
    Severity.ERROR: "bold red",
    Severity.WARNING: "bold yellow",
    Severity.INFO: "bold cyan",
}
_MARGIN = "blue"
_LEAST_ROOM = 20
_MOST_LINES = 10
"""The highest number of lines of a fix on each side."""


def write_lines(lines: Iterable[Text], stream: TextIO, *, color: bool) -> None:
    """Write lines to a stream, in colour or plain."""
    if not color:
        stream.writelines(f"{line.plain}\n" for line in lines)
        return
    console = Console(
        file=stream, force_terminal=True, color_system="standard", no_color=False
    )
    for line in lines:
        console.print(line, soft_wrap=True, highlight=False)


def concise(report: CheckReport) -> Iterator[str]:
    """Yield each finding as one line: position, severity, rule, message."""
    for finding in report.findings:
        where = _place(finding.diagnostic.span, report.files)
        yield f"{where}: {_title(finding)}: {visible(finding.diagnostic.message)}"


def grouped(report: CheckReport) -> Iterator[str]:
    """Yield each file with its findings below, one line each, and a blank line."""
    for file, findings in groupby(
        report.findings, key=lambda finding: finding.diagnostic.span.file
    ):
        yield f"{visible(file)}:"
        for finding in findings:
            where = _place(finding.diagnostic.span, report.files)
            where = where.removeprefix(f"{visible(file)}:")
            message = visible(finding.diagnostic.message)
            yield f"  {where}: {_title(finding)}: {message}"
        yield ""


def full(report: CheckReport, width: int) -> Iterator[Text]:
    """Yield each finding with source, labels, notes, help, fix, and a blank line.

    Source lines are cut to `width` cells, around the marked columns.
    """
    for finding in report.findings:
        yield from _page(finding, report.files, width)
        yield Text()


def _title(finding: Finding) -> str:
    rule = finding.rule
    return f"{finding.severity.word}[{rule.code} {rule.name}]"


def _place(span: Span, files: Files) -> str:
    return visible(place(span, files))


# --- full: a finding with its source --------------------------------------------------


class _Mark(msgspec.Struct, frozen=True):
    """A label within one line: columns from 0, the end exclusive."""

    row: int
    start: int
    end: int
    message: str
    primary: bool


class _Layout(msgspec.Struct, frozen=True):
    """The layout of a finding: width of row numbers, width of source, style."""

    margin: int
    room: int
    style: str

    def numbered(self, row: int, text: str, mark: str = "|", style: str = "") -> Text:
        """Return a line of source with its row."""
        return self._line(f"{row:>{self.margin}} {mark}", text, style)

    def bar(self, text: str = "", style: str = "") -> Text:
        """Return a line below a line of source."""
        return self._line(f"{'':{self.margin}} |", text, style)

    def _line(self, margin: str, text: str, style: str) -> Text:
        line = Text().append(margin, _MARGIN)
        return line.append(f" {text}", style or None) if text else line

    def arrow(self, arrow: str, place: str) -> Text:
        """Return the line that names a position."""
        return Text().append(f"{'':{self.margin}}{arrow} ", _MARGIN).append(place)

    def remark(self, word: str, text: str) -> Text:
        """Return the line of a note or help."""
        line = Text().append(f"{'':{self.margin}} = ", _MARGIN)
        return line.append(f"{word}: ", "bold").append(visible(text))


def _page(finding: Finding, files: Files, width: int) -> Iterator[Text]:
    said = finding.diagnostic
    marks = _marks(said, files)
    blocks = list(_blocks(said.fix, files))
    rows = [mark.row for group in marks.values() for mark in group]
    rows += [row + len(old) for _, row, old, _ in blocks]
    margin = len(str(max(rows, default=1)))
    room = max(width - margin - 3, _LEAST_ROOM)
    layout = _Layout(margin, room, _STYLES[finding.severity])
    head = Text().append(_title(finding), layout.style)
    yield head.append(f": {visible(said.message)}", "bold")
    for file, group in marks.items():
        first = group[0]
        where = f"{visible(file)}:{first.row}:{first.start + 1}"
        yield layout.arrow("-->" if first.primary else ":::", where)
        yield layout.bar()
        yield from _source(group, files[file], layout)
    for note in said.notes:
        yield layout.remark("note", note)
    if said.help:
        yield layout.remark("help", said.help)
    if said.fix is not None:
        yield from _fix(said.fix, blocks, layout)


def _marks(said: Diagnostic, files: Files) -> dict[str, list[_Mark]]:
    """Return the marks by file: the finding's own file and position first."""
    marks: dict[str, list[_Mark]] = {}
    for at, label in enumerate((Label(said.span, said.label), *said.labels)):
        source = files.get(label.span.file)
        if source is None:
            continue
        start, end = source.position(label.span.start), source.position(label.span.end)
        last = end.column - 1 if end.row == start.row else len(source.line(start.row))
        mark = _Mark(start.row, start.column - 1, last, label.message, at == 0)
        marks.setdefault(source.name, []).append(mark)
    return marks


def _source(
    marks: Sequence[_Mark], source: SourceFile, layout: _Layout
) -> Iterator[Text]:
    """Yield the marked lines of one file, each followed by its marks."""
    for row in sorted({mark.row for mark in marks}):
        here = [mark for mark in marks if mark.row == row]
        shown = _Shown(source.line(row), here[0].start, layout.room)
        yield layout.numbered(row, shown.text)
        for mark in sorted(here, key=lambda mark: mark.start):
            yield from _underline(mark, shown, layout)


def _underline(mark: _Mark, shown: _Shown, layout: _Layout) -> Iterator[Text]:
    style = layout.style if mark.primary else _MARGIN
    start = shown.cell(mark.start)
    length = max(1, shown.cell(mark.end) - start)
    line = " " * start + ("^" if mark.primary else "-") * length
    message = visible(mark.message)
    if message and start + length + 1 + cell_len(message) <= layout.room:
        line, message = f"{line} {message}", ""
    yield layout.bar(line, style)
    for part in wrapped(message, layout.room):
        yield layout.bar(part, style)


class _Shown:
    """The visible part of a line, and the cells of its columns.

    Args:
        line: the line as it is in the file.
        focus: the column, from 0, that must be visible.
        room: the number of cells.
    """

    def __init__(self, line: str, focus: int, room: int) -> None:
        far = focus > room * 2 // 3 and len(line) > room
        self._left = focus - room // 3 if far else 0
        pieces = ["…"] if far else []
        cells = len(pieces)
        self._cells = [cells]
        for column in range(self._left, len(line)):
            piece = visible(line[column])
            end = cells + cell_len(piece)
            if end > room - (column < len(line) - 1):
                pieces.append("…")
                break
            pieces.append(piece)
            cells = end
            self._cells.append(cells)
        self.text = "".join(pieces).rstrip()

    def cell(self, column: int) -> int:
        """Return the cell at which a column begins; the edge for a cut column."""
        at = min(max(column - self._left, 0), len(self._cells) - 1)
        return self._cells[at]


# --- full: a fix as a diff -----------------------------------------------------------

_Block = tuple[str, int, list[str], list[str]]
"""A file, the first row of a block, the present lines, the fixed lines."""


def _blocks(fix: Fix | None, files: Files) -> Iterator[_Block]:
    """Yield the blocks of lines that a fix changes."""
    edits = sorted(fix.edits if fix else (), key=lambda e: (e.span.file, e.span.start))
    group: list[Edit] = []
    last = 0
    for edit in edits:
        source = files[edit.span.file]
        row = source.position(edit.span.start).row
        if group and (edit.span.file != group[0].span.file or row > last):
            yield _block(group, files[group[0].span.file])
            group = []
        group.append(edit)
        last = source.position(edit.span.end).row
    if group:
        yield _block(group, files[group[0].span.file])


def _block(edits: Sequence[Edit], source: SourceFile) -> _Block:
    """Return the lines that some edits change, without unchanged lines."""
    row = source.position(edits[0].span.start).row
    last = source.position(edits[-1].span.end).row
    begin = source.line_starts[row - 1]
    end = source.line_starts[last - 1] + len(source.line(last))
    pieces, at = [], begin
    for edit in edits:
        pieces += [source.text[at : edit.span.start], edit.content]
        at = edit.span.end
    old = source.text[begin:end].split("\n")
    new = "".join([*pieces, source.text[at:end]]).split("\n")
    while old and new and old[-1] == new[-1]:
        old, new = old[:-1], new[:-1]
    while old and new and old[0] == new[0]:
        old, new, row = old[1:], new[1:], row + 1
    return source.name, row, old, new


def _fix(fix: Fix, blocks: Iterable[_Block], layout: _Layout) -> Iterator[Text]:
    word = {Applicability.SAFE: "fix", Applicability.UNSAFE: "unsafe fix"}
    yield layout.remark(word.get(fix.applicability, "suggestion"), fix.message)
    for _, row, old, new in blocks:
        focus = _first_change("".join(old[:1]), "".join(new[:1]))
        for mark, lines, style in (("-", old, "red"), ("+", new, "green")):
            for at, line in enumerate(lines[:_MOST_LINES]):
                shown = _Shown(line, focus, layout.room)
                yield layout.numbered(row + at, shown.text, mark, style)


def _first_change(old: str, new: str) -> int:
    """Return the column of the first difference between two lines."""
    for column, (one, other) in enumerate(zip(old, new, strict=False)):
        if one != other:
            return column
    return min(len(old), len(new))
