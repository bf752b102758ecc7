"""Which files the outputs of commands replace: their own kind, and no other."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from rapc.base.outputs import (
    BASELINE,
    BREAKPOINTS,
    COMPILED_LIBRARY,
    COVERAGE,
    FINDINGS,
    JUNIT,
    TRACE,
    Output,
    check_output,
)
from rapc.errors import WriteError

from .command import rapc

RUN = ("go.rap", "--world", "truck", "--task", "(go)", "-q")
REPL = ("repl", *RUN[:-1], "-c")

FORMATS = (
    *("full", "concise", "grouped", "json", "json-lines", "sarif", "github", "junit"),
)

WAYS: dict[str, Sequence[str]] = {
    "trace": ("run", *RUN, "--trace", "{}"),
    "trace as text": ("run", *RUN, "--trace-format", "text", "--trace", "{}"),
    "junit": ("test", "go.test.rap", "--junit", "{}"),
    "coverage": ("test", "go.test.rap", "--coverage", "{}"),
    "compile": ("compile", "go.rap", "-o", "{}"),
    "baseline": ("check", "go.rap", "--write-baseline", "{}"),
    "statistics": ("check", "bad.rap", "--statistics", "--output-file", "{}"),
    "record": (*REPL, ":record {}"),
    "breakpoints": (*REPL, ":break time 3", "-c", ":break save {}"),
    **{
        form: ("check", "bad.rap", "--output-format", form, "--output-file", "{}")
        for form in FORMATS
    },
}
"""Commands that write a file."""

NAMES = {"coverage": ".json"}
"""The suffixes of files that commands take for an output at all."""

OTHERS = {
    "text": b"notes of mine\n",
    "markup": b'<?xml version="1.0"?>\n<project>mine</project>\n',
    "object": b'{"name": "mine", "format": "mine"}\n',
    "list": b'["mine"]\n',
    "binary": b"\0mine",
}
"""Files of other kinds than any output."""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("project")
    (folder / "go.rap").write_text('(require "truck")\n(define-rap (go) (succeed t))\n')
    (folder / "bad.rap").write_text("(define-rap (go) (succeed (nowhere)))\n")
    test = '(require "go")\n(define-test it (task (go)) (expect (succeeds (go))))\n'
    (folder / "go.test.rap").write_text(test)
    return folder


def _write(way: str, file: str, project: Path) -> tuple[int, str]:
    """Write an output to a file; return the status, and all that is printed."""
    done = rapc(*(word.format(file) for word in WAYS[way]), cwd=project)
    return done.returncode, " ".join((done.stdout + done.stderr).split())


@pytest.mark.parametrize("way", WAYS)
def test_outputs_replace_no_file_of_another_kind(way: str, project: Path) -> None:
    for name, content in OTHERS.items():
        file = project / f"{name}{NAMES.get(way, '')}"
        file.write_bytes(content)
        status, told = _write(way, file.name, project)
        assert status != 0
        assert f"cannot write `{file.name}`: the file is not " in told
        assert file.read_bytes() == content


@pytest.mark.parametrize("way", [way for way in WAYS if way not in NAMES])
def test_outputs_have_no_name_of_a_source_or_configuration(
    way: str, project: Path
) -> None:
    """Whether there is a file of this name or not, also behind a link."""
    for name in ("mine.py", "mine.toml", "MINE.Rap", "new.py"):
        file = project / name
        if not name.startswith("new"):
            file.touch()
        link = project / "link"
        link.unlink(missing_ok=True)
        link.symlink_to(name)
        for one in (file, link):
            status, told = _write(way, one.name, project)
            assert status != 0
            suffix = f"`{file.suffix.lower()}`"
            assert f"cannot write `{one.name}`: {suffix} is the suffix of a " in told
        assert not file.exists() or file.read_bytes() == b""


@pytest.mark.parametrize("way", WAYS)
def test_outputs_replace_their_kind_and_empty_files(way: str, project: Path) -> None:
    file = project / f"out of {way}{NAMES.get(way, '')}".replace(" ", "-")
    file.touch()
    for _ in range(2):
        _write(way, file.name, project)
        first = file.read_bytes()
        assert first
        file.write_bytes(first + b"\n")
    _write(way, file.name, project)
    assert file.read_bytes() == first


def test_findings_may_change_their_format(project: Path) -> None:
    (project / "found").touch()
    for way in (*FORMATS, "statistics", *reversed(FORMATS)):
        before = (project / "found").read_bytes()
        _write(way, "found", project)
        assert (project / "found").read_bytes() != before


def test_an_output_of_another_sort_is_another_kind(project: Path) -> None:
    kinds: dict[str, Output] = {
        "trace": TRACE,
        "coverage": COVERAGE,
        "compile": COMPILED_LIBRARY,
        "baseline": BASELINE,
        "breakpoints": BREAKPOINTS,
        "json": FINDINGS,
    }
    for way in kinds:
        file = project / f"{way}.json"
        file.unlink(missing_ok=True)
        _write(way, file.name, project)
        fits = [other for other, kind in kinds.items() if _may(file, kind)]
        assert fits == [way]


def _may(file: Path, kind: Output) -> bool:
    try:
        check_output(file, kind)
    except WriteError:
        return False
    return True


def test_devices_and_pipes_are_no_files_to_lose(project: Path) -> None:
    fifo = project / "pipe"
    os.mkfifo(fifo)
    for kind in (TRACE, JUNIT, COMPILED_LIBRARY):
        check_output("/dev/null", kind)
        check_output(fifo, kind)
