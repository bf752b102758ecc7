"""Findings that a project knows of and leaves for later: a baseline.

A baseline is a JSON file with the fingerprints of findings and enough besides for a
reader to see what they are. A finding that is in it is not reported; a new one is, on
the same line too. A fingerprint stays the same while the text around a finding changes:
it depends on the rule, the file as seen from the working folder, the line on which the
finding stands, without its indent, and how many findings with all this in common stand
before it: neither on its row nor on other lines.
"""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from pathlib import Path

import msgspec

from rapc.analysis.driver import CheckReport
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


_LENGTH = 20
"""Hexadecimal digits of a fingerprint: 80 bits."""


def fingerprints(report: CheckReport, root: str = "") -> tuple[str, ...]:
    """Return a fingerprint for each finding of a report, in their order.

    Args:
        report: the report.
        root: the folder from which paths are seen; the working folder if empty.
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
