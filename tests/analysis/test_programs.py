"""Programs that say in comments what is to be found in them.

`; expect: rule, rule` at the end of a line names the findings on that line. Missing and
surplus ones both fail. A new pass brings `tests/analysis/<fault>.rap`, no new test. The
folders in `tests/analysis/several` are libraries of several files each.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.analysis.driver import check_library
from rapc.analysis.selection import Selection, by_default, rule_names
from rapc.library.loader import load
from tests.expected import expected, opted_in

PROGRAMS = sorted(
    [
        *Path(__file__).parent.glob("*.rap"),
        *Path(__file__).parent.joinpath("several").iterdir(),
    ]
)


def _texts(program: Path) -> dict[str, str]:
    """Return the texts of a program by the names of their files."""
    files = sorted(program.glob("*.rap")) if program.is_dir() else [program]
    return {file.name: file.read_text(encoding="utf-8") for file in files}


def _stem(path: Path) -> str:
    return path.stem


def test_there_are_programs() -> None:
    assert len(PROGRAMS) > 5


@pytest.mark.parametrize("program", PROGRAMS, ids=_stem)
def test_program_has_the_findings_it_names(program: Path) -> None:
    texts = _texts(program)
    asked = frozenset(name for text in texts.values() for name in opted_in(text))
    selection = Selection(by_default() | rule_names(asked))
    report = check_library(load([program]), selection)
    actual = sorted(
        (Path(span.file).name, report.files[span.file].row(span.start), f.rule.name)
        for f in report.findings
        for span in [f.diagnostic.span]
    )
    assert actual == sorted(
        (name, *found) for name, text in texts.items() for found in expected(text)
    )
