"""Forms to IR: programs that name their findings, and what becomes of sound ones.

`; expect: rule, rule` at the end of a line names the findings on that line; missing and
surplus ones both fail. Beside each program lies `<name>.ir`: the IR of what is sound
in it. After a change that is meant, write them anew with
`python -m tests.parser.test_forms`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.base.source import SourceFile
from rapc.parser.parse import parse
from rapc.parser.unit import SourceUnit
from tests.expected import expected

from .dump import dump

PROGRAMS = sorted((Path(__file__).parent / "forms").glob("*.rap"))


def _stem(path: Path) -> str:
    return path.stem


def _parsed(path: Path) -> tuple[SourceFile, SourceUnit]:
    source = SourceFile(path.name, path.read_text(encoding="utf-8"))
    return source, parse(source)


def _sound(path: Path) -> str:
    """The IR of the forms of a program in which nothing is found."""
    _, made = _parsed(path)
    sound = [
        form
        for form in (*made.forms, *made.tests)
        if not any(
            form.span.start <= found.span.start < form.span.end
            for found in made.diagnostics
        )
    ]
    return "".join(dump(form) for form in sound)


def test_there_are_programs() -> None:
    assert len(PROGRAMS) > 4


@pytest.mark.parametrize("program", PROGRAMS, ids=_stem)
def test_program_has_the_findings_it_names(program: Path) -> None:
    source, made = _parsed(program)
    actual = [(source.position(d.span.start).row, d.rule) for d in made.diagnostics]
    assert sorted(actual) == expected(source.text)


@pytest.mark.parametrize("program", PROGRAMS, ids=_stem)
def test_sound_forms_become_this_ir(program: Path) -> None:
    golden = program.with_suffix(".ir").read_text(encoding="utf-8")
    assert _sound(program) == golden


@pytest.mark.parametrize("program", PROGRAMS, ids=_stem)
def test_every_node_knows_its_place(program: Path) -> None:
    source, made = _parsed(program)
    for form in made.forms:
        assert form.span.file == source.name
        assert source.text[form.span.start] == "("
        assert source.text[form.span.end - 1] == ")"


if __name__ == "__main__":
    for one in PROGRAMS:
        one.with_suffix(".ir").write_text(_sound(one), encoding="utf-8")
