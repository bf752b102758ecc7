"""Programs that the grammar makes, whole and damaged, checked by all passes.

`python -m tests.analysis.fuzz 20000` checks so many programs, and prints those that
raise an exception or break a promise.
"""

from __future__ import annotations

import random
import sys
import traceback
from collections import Counter
from collections.abc import Iterator, Mapping

from rapc.analysis import graphs, registry
from rapc.analysis.driver import CheckReport, check_library
from rapc.analysis.effects_graph import effects_of
from rapc.analysis.selection import Selection
from rapc.base.source import SourceFile
from rapc.console import findings, formats
from rapc.console import graphs as drawn
from rapc.library.loader import Loaded, load_text
from rapc.parser.formatter import formatted
from tests.analysis.mending import broken_by_fixes
from tests.damage import with_other_tokens
from tests.parser.programs import for_each_program

EVERYTHING = Selection(frozenset(registry.rules()))
"""All rules, those that are opt-in too."""

_TEXT = "<text>"
"""What spans call the text."""


def broken(text: str) -> list[str]:
    """Return the promises that are broken for a text; may raise what a pass raises."""
    loaded = load_text(text)
    report = check_library(loaded, EVERYTHING)
    return [
        *_places(report, text),
        *_told(report),
        *_laid_out(report, text),
        *_more(loaded),
    ]


def _places(report: CheckReport, text: str) -> Iterator[str]:
    """What is said of the text lies in it; a file that it requires has its own end."""
    for finding in report.findings:
        said = finding.diagnostic
        edits = said.fix.edits if said.fix is not None else ()
        every = [said.span, *(label.span for label in said.labels)]
        every += [edit.span for edit in edits]
        spans = [span for span in every if span.file == _TEXT]
        if not all(0 <= span.start <= span.end <= len(text) + 1 for span in spans):
            yield f"{finding.rule.name} is outside of the text"


def _told(report: CheckReport) -> Iterator[str]:
    """Every format tells of each finding."""
    count = len(report.findings)
    if len(list(findings.concise(report))) != count:
        yield "concise leaves findings out"
    list(findings.full(report, 80))
    for name in formats.WRITERS:
        if count and not formats.WRITERS[name](report):
            yield f"{name} is empty"


def _laid_out(report: CheckReport, text: str) -> Iterator[str]:
    """What is laid out has the same findings, and is laid out alike again."""
    made = formatted(SourceFile(_TEXT, text))
    if made.diagnostics:
        return
    if formatted(SourceFile(_TEXT, made.text)).text != made.text:
        yield "laid out twice is not once"
    again = check_library(load_text(made.text), EVERYTHING)
    if _rules(again) != _rules(report):
        yield f"laying out changes findings: {_rules(report)} {_rules(again)}"


def _rules(report: CheckReport) -> Mapping[str, int]:
    return Counter(finding.rule.name for finding in report.findings)


def _more(loaded: Loaded) -> Iterator[str]:
    """Fixes leave nothing worse, and graphs can be drawn."""
    yield from broken_by_fixes(loaded.files[_TEXT].text, EVERYTHING)
    library = loaded.library
    made = [graphs.calls(library), graphs.monitors(library), graphs.things(library)]
    made += [graphs.task_nets(rap) for rap in library.raps.values()]
    made += [effects_of(library, name) for name in library.raps]
    for graph in made:
        for name, write in drawn.WRITERS.items():
            if not write(graph, drawn.LIBRARY) and graph.vertices:
                yield f"{name} of {graph.title} is empty"


def run(count: int, seed: int = 0) -> Iterator[str]:
    """Check so many programs, each whole and damaged; yield what is wrong with them."""
    dice = random.Random(seed)
    wrong: list[str] = []

    def hold(text: str) -> None:
        for one in (text, with_other_tokens(text, dice)):
            try:
                wrong.extend(f"{said}\n{one}" for said in broken(one))
            except Exception:  # whatever it is, it is told with the text
                wrong.append(f"{traceback.format_exc()}\n{one}")

    for_each_program(count, hold)
    yield from wrong


if __name__ == "__main__":
    faults = list(run(int(sys.argv[1])))
    print(*faults, f"{len(faults)} faults", sep="\n\n")
    sys.exit(bool(faults))
