"""Baseline: the findings that a project knows and leaves for later.

A baseline is a JSON file with the fingerprint of each finding, and with the rule, file
and message for the reader. A finding in the baseline is not reported; a new finding is
reported, even on the same line. A fingerprint stays the same when the text around the
finding changes. The fingerprint depends on:

- the rule,
- the path of the file as seen from the working directory,
- the text of the line of the finding, without its indent,
- the number of earlier findings with the same rule, file and line text.

Row and column are not part of the fingerprint.
"""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from pathlib import Path

import msgspec

from rapc.analysis.driver import CheckReport
from rapc.base.decoding import UNREADABLE
from rapc.base.files import read_text, seen_from
from rapc.errors import Error

FORMAT = 1


class BaselineError(Error):
    """A file that is not a baseline of this version of rapc."""


class KnownFinding(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One known finding."""

    fingerprint: str
    filename: str
    rule: str
    message: str


class _File(msgspec.Struct, frozen=True, rename="kebab", forbid_unknown_fields=True):
    rapc_baseline: int
    findings: tuple[KnownFinding, ...]


def baseline_text(report: CheckReport, file: str) -> str:
    """Return the text of a baseline file with all findings of a report.

    Args:
        report: the report.
        file: the file for the text; paths in the text are relative to its folder.
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
        BaselineError: if the file is not a baseline.
        LoadError: if the file cannot be read.
    """
    content = read_text(file)
    try:
        found = msgspec.json.decode(content, type=_File)
    except UNREADABLE as error:
        message = f"`{file}` is not a baseline; `--write-baseline` writes a baseline"
        raise BaselineError(message) from error
    if found.rapc_baseline != FORMAT:
        message = (
            f"`{file}` is a baseline of format {found.rapc_baseline}, not {FORMAT}"
        )
        raise BaselineError(message)
    return found.findings


class Compared(msgspec.Struct, frozen=True):
    """The result of a comparison of a report with a baseline."""

    #: The report without the known findings.
    report: CheckReport
    #: The number of findings left out.
    known: int
    #: The number of findings in the baseline that the report does not have.
    gone: int


def compare(report: CheckReport, file: Path) -> Compared:
    """Return a report without the findings in a baseline file.

    Raises:
        BaselineError: if the file is not a baseline.
        LoadError: if the file cannot be read.
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


_LENGTH = 20
"""Hexadecimal digits of a fingerprint: 80 bits."""


def fingerprints(report: CheckReport, root: str = "") -> tuple[str, ...]:
    """Return the fingerprint of each finding of a report, in the order of findings.

    Args:
        report: the report.
        root: the folder that paths are relative to; empty for the working directory.
    """
    seen: Counter[tuple[str, str, str]] = Counter()
    prints = []
    for finding in report.findings:
        span = finding.diagnostic.span
        source = report.files.get(span.file)
        line = source.line(source.row(span.start)).strip() if source else ""
        key = (finding.rule.name, seen_from(root, span.file), line)
        text = "\0".join((*key, str(seen[key])))
        seen[key] += 1
        prints.append(hashlib.sha256(text.encode()).hexdigest()[:_LENGTH])
    return tuple(prints)
