"""How findings look: golden output, and what must hold for any text and width.

To make the golden files anew, in tests/cli/golden:
`rapc check program.rap --output-format full > full.txt`, and so on.
"""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from rich.cells import cell_len

from rapc.analysis.driver import CheckReport, check_library
from rapc.console import findings as render
from rapc.console import formats
from rapc.library.loader import load_text

from .command import rapc

GOLDEN = Path(__file__).parent / "golden"


@pytest.mark.parametrize("name", ["full", "concise", "json"])
def test_output_is_golden(name: str) -> None:
    done = rapc("check", "program.rap", "--output-format", name, cwd=GOLDEN)
    assert done.returncode == 1
    assert done.stdout == (GOLDEN / f"{name}.txt").read_text(encoding="utf-8")


def test_output_does_not_depend_on_the_hash_seed() -> None:
    one, other = (
        rapc("check", ".", "--fail-level", "info", cwd=GOLDEN, PYTHONHASHSEED=seed)
        for seed in ("1", "2")
    )
    assert one.stdout == other.stdout


def test_colour_changes_no_letter() -> None:
    done = rapc("check", "program.rap", "--color", "always", cwd=GOLDEN)
    plain = rapc("check", "program.rap", "--color", "never", cwd=GOLDEN)
    assert "\x1b[1;31merror[RAP013 unknown-rap]\x1b[0m" in done.stdout
    assert "\x1b[1;36minfo[RAP017 implied-true]\x1b[0m" in done.stdout
    assert _without_colour(done.stdout) == plain.stdout


def _without_colour(text: str) -> str:
    first, *rest = text.split("\x1b[")
    return first + "".join(part.partition("m")[2] for part in rest)


def test_json_has_the_contract_s_keys() -> None:
    done = rapc("check", "program.rap", "--output-format", "json", cwd=GOLDEN)
    for one in json.loads(done.stdout):
        assert list(one) == [
            "code",
            "name",
            "severity",
            "message",
            "filename",
            "location",
            "end_location",
            "fix",
            "labels",
            "notes",
            "url",
        ]
        assert one["fix"] is None or list(one["fix"]) == [
            "applicability",
            "message",
            "edits",
        ]


def _report(text: str) -> CheckReport:
    return check_library(load_text(text, "test.rap"))


def _lines(text: str, width: int) -> list[str]:
    stream = io.StringIO()
    render.write_lines(render.full(_report(text), width), stream, color=False)
    return stream.getvalue().split("\n")


@pytest.mark.parametrize(
    "before",
    ["", "\t", "\t \t", "日本語", "e\u0301\u0301", "\U0001f916", "\u200b", "x" * 300],
)
@pytest.mark.parametrize("width", [20, 40, 80, 1000])
def test_marks_are_below_their_text(before: str, width: int) -> None:
    text = (
        "(declare-memory-proposition p (?x ?y))\n"
        f'(define-rap (a) (succeed (and (p "{before}" 1) (qq))))'
    )
    lines = _lines(text, width)
    at = next(row for row, line in enumerate(lines) if "^" in line)
    source, marks = lines[at - 1], lines[at]
    start = cell_len(marks[: marks.index("^")])
    length = marks.count("^")
    assert _cells(source, start, length).strip("…") in ("qq", "q")
    assert all(cell_len(line) <= max(width, 24) for line in (source, marks))


def _cells(line: str, start: int, length: int) -> str:
    """What of a line stands in some cells of the terminal."""
    out, at = "", 0
    for character in line:
        if start <= at < start + length:
            out += character
        at += cell_len(character)
    return out


def test_mark_of_a_form_ends_with_its_first_line() -> None:
    lines = _lines(
        "(define-rap (a)\n  (method (task-net\n    (t1 (a b\n      c)))))", 80
    )
    at = next(row for row, line in enumerate(lines) if "^" in line)
    assert lines[at - 1] == "3 |     (t1 (a b"
    assert lines[at] == "  |         ^^^^"


def test_long_messages_go_below_their_marks() -> None:
    lines = _lines("(define-rap (abc))\n(define-rap (abcd ?e))\n(define-rap (abc))", 26)
    at = next(row for row, line in enumerate(lines) if "---" in line)
    assert lines[at] == "  |              ---"
    assert lines[at + 1] == "  | first defined here"


def test_fix_shows_only_the_lines_it_changes() -> None:
    text = (
        "(declare-memory-property open (?door ?is) unknown)\n"
        "(define-rap (a)\n  (succeed (open\n     front)))"
    )
    lines = _lines(text, 80)
    assert [line for line in lines if line[2:4] in ("- ", "+ ")] == [
        "4 -      front)))",
        "4 +      front true)))",
    ]


def test_control_characters_are_not_acted_upon() -> None:
    report = _report('(require "\x1b[31m")')
    for lines in (
        [line.plain for line in render.full(report, 80)],
        list(render.concise(report)),
        [formats.json_text(report)],
    ):
        assert "\x1b" not in "".join(lines)
        assert "\N{REPLACEMENT CHARACTER}[31m" in "".join(lines)
