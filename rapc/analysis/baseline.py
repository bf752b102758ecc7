"""Findings that a project knows of and leaves for later: a baseline.

A baseline is a JSON file with the fingerprints of findings
(`rapc.analysis.fingerprints`) and enough besides for a reader to see what they are. A
finding that is in it is not reported; a new one is, on the same line too.
"""

from __future__ import annotations

import os
from pathlib import Path

import msgspec

from rapc.analysis.driver import CheckReport
from rapc.analysis.fingerprints import fingerprints
from rapc.base.files import read_text, seen_from
from rapc.errors import Error

FORMAT = 1


class BaselineError(Error):
    """A file that holds no baseline of this rapc."""


class KnownFinding(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One finding that is known."""

    fingerprint: str
    filename: str
    rule: str
    message: str


class _File(msgspec.Struct, frozen=True, rename="kebab", forbid_unknown_fields=True):
    rapc_baseline: int
    findings: tuple[KnownFinding, ...]


def baseline_text(report: CheckReport, file: str) -> str:
    """Return what a baseline file says of all findings of a report.

    Args:
        report: the report.
        file: the file that the text is for; paths in it are seen from its folder.
    """
    root = os.path.dirname(os.path.abspath(file))
    rows = [
        KnownFinding(
            print_,
            seen_from(root, finding.diagnostic.span.file),
            finding.rule.name,
            finding.diagnostic.message,
        )
        for print_, finding in zip(
            fingerprints(report, root), report.findings, strict=True
        )
    ]
    data = msgspec.json.encode(_File(FORMAT, tuple(rows)))
    return msgspec.json.format(data, indent=1).decode() + "\n"


def read_baseline(file: Path) -> tuple[KnownFinding, ...]:
    """Return the findings in a baseline file.

    Raises:
        BaselineError: for a file that holds none.
        LoadError: for one that cannot be read.
    """
    content = read_text(file)
    try:
        found = msgspec.json.decode(content, type=_File)
    except (msgspec.DecodeError, RecursionError) as error:
        message = f"`{file}` holds no baseline: `--write-baseline` writes one"
        raise BaselineError(message) from error
    if found.rapc_baseline != FORMAT:
        message = (
            f"`{file}` holds a baseline of format {found.rapc_baseline}, not {FORMAT}"
        )
        raise BaselineError(message)
    return found.findings


class Compared(msgspec.Struct, frozen=True):
    """A report beside a baseline."""

    #: The report, without the findings that are known.
    report: CheckReport
    #: How many were left out.
    known: int
    #: How many of the baseline were not found again.
    gone: int


def compare(report: CheckReport, file: Path) -> Compared:
    """Return a report without the findings that a baseline file knows.

    Raises:
        BaselineError: for a file that holds no baseline.
        LoadError: for one that cannot be read.
    """
    known = {one.fingerprint for one in read_baseline(file)}
    root = os.path.dirname(os.path.abspath(file))
    prints = fingerprints(report, root)
    left = tuple(
        finding
        for print_, finding in zip(prints, report.findings, strict=True)
        if print_ not in known
    )
    there = known.intersection(prints)
    left_out = len(report.findings) - len(left)
    return Compared(
        msgspec.structs.replace(report, findings=left), left_out, len(known - there)
    )
