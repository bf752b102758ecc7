"""What a page shows of a run beside its trace: sources, sensors and wrong beliefs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import msgspec

from rapc.base.source import Span
from rapc.base.values import format_list
from rapc.compiler.program import Program
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.questions.differences import compared, first_difference, this_run
from rapc.debug.questions.ends import why_end
from rapc.debug.questions.times import sensors_of
from rapc.debug.recording import Recording
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.runtime.events.trace import JsonTrace, Writable
from rapc.view.pictures import Pictures, scene_at
from rapc.view.scene import Scene

_NO_SOURCES: dict[str, Any] = {"sources": {}, "raps": {}, "uses": {}}


class _First(msgspec.Struct):
    """The serial number of the first event of a trace."""

    n: int


class Viewed(msgspec.Struct):
    """A run to view.

    Without a program, or without a history that is a run, the page shows less.
    """

    #: The name of the run, and a note for the reader; may be empty.
    name: str
    note: str
    #: The events, as lines of JSON.
    trace: bytes
    history: History
    #: The library, if it is the library of the run.
    program: Program | None
    pictures: Pictures
    #: The file of a recorded run. A run again of a recording that was cut off ends
    #: before the last cycle.
    recording: Recording | None = None

    def events(self) -> Iterable[ToldEvent]:
        """Return the events of the run, all that are recorded."""
        if self.recording is None:
            return self.history.scan()
        return self.recording.scan(0, self.recording.rows)

    def scene_at(self, cycle: int | None) -> Scene | None:
        """Return the drawing of the end of a cycle, or of the run.

        Returns:
            The drawing; None if there is no picture, and memory knows no place.

        Raises:
            LoadError: if the trace has an invalid picture.
        """
        return scene_at(self.events(), self.pictures.changes, cycle)

    def more(self) -> dict[str, Any]:
        """Return what the page knows beside the trace, as plain data."""
        return {
            "name": self.name,
            "note": self.note,
            "sensors": sorted(sensors_of(self.history)),
            **(_NO_SOURCES if self.program is None else sources(self.program)),
            "symptoms": why_end(self.history).lines[1:],
            "beliefs": _beliefs(self.history, self.first),
            "pictures": [(n - self.first, o) for n, o in self.pictures.changes],
        }

    @property
    def first(self) -> int:
        """The serial number of the first event; the page counts events from 0."""
        return msgspec.json.decode(self.trace.partition(b"\n")[0], type=_First).n


def stream_trace(history: History, stream: Writable) -> None:
    """Write the trace of a run from its start, also while the history goes on."""
    trace = JsonTrace(stream)
    for told in history.scan():
        trace.raw(*told)
    history.follow(lambda told: trace.raw(*told))


def comparison(before: Viewed, after: Viewed) -> dict[str, Any]:
    """Return the comparison of two runs, as plain data.

    `first` has the position of the first different decision among the events of a run.
    """
    here, there = (this_run(v.history, v.name) for v in (before, after))
    answer = compared(here, there).answer
    found = first_difference(here, there)
    pair = () if found is None else (found.here, found.there)
    table = answer.table
    return {
        "lines": answer.lines,
        "columns": () if table is None else table.columns,
        "rows": () if table is None else table.rows,
        "notes": answer.notes,
        "first": [
            None if one is None else one.serial - view.first
            for view, one in zip((before, after), pair, strict=False)
        ],
    }


def _beliefs(history: History, first: int) -> list[dict[str, Any]]:
    """Return the wrong beliefs of a run, in the order of their start.

    Args:
        history: the run.
        first: the serial number of the first event.
    """
    if not history.is_run:
        return []
    return [
        {
            "fact": format_list(one.belief.fact),
            "truth": [format_list(fact) for fact in one.belief.truth],
            "n": one.first_serial - first,
            "end": None if one.end_serial is None else one.end_serial - first,
        }
        for one in history.branch.discrepancies.all
    ]


def sources(program: Program) -> dict[str, Any]:
    """Return the texts and the RAPs of a library, as plain data."""
    files = program.library.files
    texts = {name: source.text for name, source in files.items()}
    return {"sources": texts, "raps": _raps(program), "uses": _uses(program)}


def _raps(program: Program) -> dict[str, Any]:
    """Return the rows of each RAP, its methods and their steps."""
    return {
        name: {
            **_rows(program, rap.span),
            "methods": {
                method.traced_name: _method(program, method) for method in rap.methods
            },
        }
        for name, rap in program.library.raps.items()
    }


def _uses(program: Program) -> dict[str, Any]:
    """Return the arguments of each primitive and skill that uses things, and these."""
    library = program.library
    declared: list[nodes.DeclarePrimitive | nodes.DeclareSkill] = [
        *library.primitives.values(),
        *library.skills.values(),
    ]
    return {
        node.name: {
            "args": [one.variable.name for one in node.args],
            "things": [format_formula(thing) for thing in node.uses],
        }
        for node in declared
        if node.uses
    }


def _method(program: Program, method: nodes.Method) -> dict[str, Any]:
    steps = method.body.steps if isinstance(method.body, nodes.TaskNet) else ()
    return {
        **_rows(program, method.span),
        "claims": [format_formula(thing) for thing in method.claims],
        "steps": {step.tag: _rows(program, step.span)["rows"] for step in steps},
    }


def _rows(program: Program, span: Span) -> dict[str, Any]:
    """Return the file and the first and last row of a span."""
    source = program.library.files.get(span.file)
    rows = (0, 0) if source is None else (source.row(span.start), source.row(span.end))
    return {"file": span.file, "rows": rows}
