"""Tables of RAP libraries: files, declared effects, memory."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from generator.markdown import sentence, table
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.library.library import Library
from rapc.library.loader import load

ROOT = Path(__file__).parents[2]

_TITLE = re.compile(r";;; (?:[^.:;]+: )?(.*?)(?: \([TS] [^)]*\))?\.(?:\s|$)", re.S)
"""The first sentence of the comment at the head of a file, without topic and source."""


def library_files(folder: str) -> str:
    """Return the table of the files of a library, each with its RAPs."""
    home = ROOT / folder
    raps = _loaded(folder).raps.values()
    rows = []
    for path in sorted(home.glob("*.rap")):
        if not path.name.endswith(".test.rap"):
            own = [r.name for r in raps if Path(r.span.file) == path]
            title = _TITLE.match(path.read_text(encoding="utf-8"))
            said = title[1].replace("\n;;;", "") if title else ""
            rows.append((f"`{path.name}`", sentence(said), _ticked(own)))
    return table(("file", "content", "RAPs"), rows)


def effects(file: str) -> str:
    """Return the table of the effects that primitives and data have on memory."""
    known = _loaded(file)
    rows = [
        (f"`{one.name}`", f"`{on.result}`", _ticked(map(format_node, on.effects)))
        for one in known.primitives.values()
        for on in one.on
    ]
    rows += [
        (f"`{one.name}`", "datum", _ticked(map(format_node, one.on)))
        for one in known.data.values()
        if one.on
    ]
    return table(("primitive or datum", "result", "effects"), rows)


def memory(file: str) -> str:
    """Return the table of the propositions and properties of a library."""
    known = _loaded(file)
    forms: list[nodes.DeclareProposition | nodes.DeclareProperty] = [
        *known.propositions.values(),
        *known.properties.values(),
    ]
    rows = []
    for form in sorted(forms, key=lambda form: form.span.start):
        words = [form.name, *(one.variable.name for one in form.args or ())]
        rows.append((f"`({' '.join(words)})`", form.doc or ""))
    return table(("fact", "meaning"), rows)


def _loaded(path: str) -> Library:
    """Return a library of the repository."""
    return load([ROOT / path]).library


def _ticked(texts: Iterable[str]) -> str:
    return ", ".join(f"`{text}`" for text in texts)
