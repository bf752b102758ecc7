"""Kinds of output files of commands, and the check before one is replaced.

An output may replace a file of its own kind and an empty file.
Not here: writing files (`rapc.base.writing`).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

import msgspec

from rapc.base.files import COMPILED, path_of, same_file
from rapc.errors import WriteError, reason

_HEAD = 8192
"""The number of bytes at the beginning of a file that determine its kind."""

_SUFFIXES = {
    ".rap": "RAP file",
    ".py": "Python file",
    ".toml": "configuration file",
}
"""The suffixes of files that users write, with the kind of the file."""


class Output(msgspec.Struct, frozen=True):
    """A kind of file that commands write."""

    #: The kind in words: "a trace".
    name: str
    #: The beginning of a file of the kind.
    begins: re.Pattern[bytes]


def _kind(name: str, begins: bytes) -> Output:
    return Output(name, re.compile(begins))


_XML = rb"<\?xml[^>]*>\s*"

TRACE = _kind("a trace", rb'\{"event":"| *[-+.e0-9]+ run of ')
BUG = _kind("a bug report", rb'\{"line":"bug"')
JUNIT = _kind("a JUnit report", _XML + b"<testsuites?[ >]")
COVERAGE = _kind("a coverage report", rb'\{\s*"format": *[0-9]')
COMPILED_LIBRARY = _kind("a compiled library", re.escape(COMPILED))
SAVED_STATE = _kind("a saved state", b"rapc-state ")
BASELINE = _kind("a baseline", rb'\{\s*"rapc-baseline":')
BREAKPOINTS = _kind("a list of breakpoints", rb'\[\s*(\{\s*"kind":|\]\s*\Z)')
FINDINGS = _kind(
    "a report of findings",
    rb"([^\n]*:\n)?[^\n]*\b(error|warning|info)\[RAP[0-9]+ "  # full, concise, grouped
    rb"|::(error|warning|notice) file=| *[0-9]+  RAP[0-9]+ "  # github, statistics
    rb'|(\[\s*)?\{\s*"code": *"RAP|\[\]\s*\Z'  # json, json-lines
    rb'|\{\s*"\$schema": *"[^"]*sarif|' + JUNIT.begins.pattern,
)
TABLES = _kind("a table of results", rb"## ")
RUN_COMMANDS = _kind("a list of commands", rb"# [^\n]*\n[^\n]*\brapc run ")
SVG = _kind("an SVG picture", _XML + rb"(<![^>]*>\s*)*<svg")
CHROME = _kind("a Chrome trace", rb'\{"traceEvents":')
MCAP = _kind("an MCAP file", rb"\x89MCAP0\r\n")
RESULTS_PAGE = _kind(
    "a page of results", rb"<!doctype html>\n<!-- an experiment, by rapc view -->"
)
PAGE = _kind("a page of a run", rb"<!doctype html>\n<!-- a run, by rapc view -->")
PNG = _kind("a PNG picture", rb"\x89PNG")


def check_output(
    file: str | Path,
    output: Output,
    *inputs: tuple[Iterable[str | Path | None], str],
) -> None:
    """Check that an output may be written to a file.

    Args:
        file: the output file; a missing file may be written.
        output: the kind of the output.
        inputs: groups of input files, each with the message for its files, for example
            "is a file of the library"; None is no file.

    Raises:
        WriteError: for an input file, a name with the suffix of a source or of a
            configuration, a folder, and a file of a different kind that is not empty.
    """
    for read, told in inputs:
        paths = [path_of(str(each)) for each in read if each is not None]
        if any(same_file(file, path) for path in paths):
            raise WriteError(f"`{file}` {told}")
    for name in (str(file), os.path.realpath(file)):
        suffix = os.path.splitext(name)[1].lower()
        if suffix in _SUFFIXES:
            raise WriteError(
                f"cannot write `{file}`: `{suffix}` is the suffix of a "
                f"{_SUFFIXES[suffix]}",
                "choose another file",
            )
    if os.path.isdir(file):
        raise WriteError(f"cannot write `{file}`: it is a folder")
    head = _head(file)
    if head and not output.begins.match(head):
        raise WriteError(
            f"cannot write `{file}`: the file is not {output.name}",
            "choose another file, or remove this one",
        )


def _head(file: str | Path) -> bytes:
    """Return the first bytes of a regular file; none for any other path."""
    try:
        if not os.path.isfile(file):
            return b""
        with open(file, "rb") as stream:
            return stream.read(_HEAD)
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else str(error)
        raise WriteError(f"cannot write `{file}`: {why}") from None
