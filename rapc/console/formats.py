"""Findings for other programs: JSON, JSON Lines, SARIF, GitHub, JUnit.

Rows and columns count from 1, columns in code points, ends are exclusive. Paths are as
the user wrote them; in SARIF, paths are relative to the working directory.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import groupby
from typing import Any
from urllib.parse import quote

from rapc.analysis import registry
from rapc.analysis.baseline import fingerprints
from rapc.analysis.driver import CheckReport, Finding
from rapc.base.diagnostics import Applicability, Diagnostic, Fix, Rule, Severity
from rapc.base.files import seen_from
from rapc.base.source import SourceFile, Span
from rapc.base.version import VERSION
from rapc.base.visible import visible, visible_lines
from rapc.console import findings as text
from rapc.console.junit import COUNTS, JUnitCase
from rapc.console.junit import junit as junit_xml

Files = Mapping[str, SourceFile]


# --- JSON ---------------------------------------------------------------------------


def json_text(report: CheckReport) -> str:
    """Return all findings as a JSON array."""
    rows = [_json(finding, report.files) for finding in report.findings]
    return _indented(rows)


def json_lines(report: CheckReport) -> str:
    """Return each finding as a JSON object on a line of its own."""
    rows = (_json(finding, report.files) for finding in report.findings)
    return _lines(json.dumps(row, ensure_ascii=False) for row in rows)


def _indented(value: object) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"


def _lines(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _json(finding: Finding, files: Files) -> dict[str, Any]:
    rule, said = finding.rule, finding.diagnostic
    return {
        "code": rule.code,
        "name": rule.name,
        "severity": finding.severity.word,
        "message": said.message,
        "filename": said.span.file,
        **_location(said.span, files),
        "fix": None if said.fix is None else _json_fix(said.fix, files),
        "labels": [
            {
                "message": label.message,
                "filename": label.span.file,
                **_location(label.span, files),
            }
            for label in said.labels
        ],
        "notes": _notes(said),
        "url": f"reference/rules/{rule.name}.md",
    }


def _json_fix(fix: Fix, files: Files) -> dict[str, Any]:
    return {
        "applicability": fix.applicability.value,
        "message": fix.message,
        "edits": [
            {"content": edit.content, **_location(edit.span, files)}
            for edit in fix.edits
        ],
    }


def _location(span: Span, files: Files) -> dict[str, dict[str, int]]:
    (row, column), (last, end) = _rows(span, files)
    return {
        "location": {"row": row, "column": column},
        "end_location": {"row": last, "column": end},
    }


def _rows(span: Span, files: Files) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the row and column of a span's start and of its end."""
    source = files.get(span.file)
    if source is None:
        return (1, 1), (1, 1)
    start, end = source.position(span.start), source.position(span.end)
    return (start.row, start.column), (end.row, end.column)


# --- SARIF 2.1.0 --------------------------------------------------------------------

_SARIF_LEVELS = {
    Severity.ERROR: "error",
    Severity.WARNING: "warning",
    Severity.INFO: "note",
}


def sarif(report: CheckReport) -> str:
    """Return a SARIF log with one run: every rule, and a result for each finding."""
    rules = list(registry.rules().values())
    places = {rule.name: at for at, rule in enumerate(rules)}
    driver = {
        "name": "rapc",
        "semanticVersion": VERSION,
        "rules": [_sarif_rule(rule) for rule in rules],
    }
    results = [
        _sarif_result(finding, places[finding.rule.name], print_, report.files)
        for finding, print_ in zip(report.findings, fingerprints(report), strict=True)
    ]
    log = {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [
            {
                "tool": {"driver": driver},
                "columnKind": "unicodeCodePoints",
                "results": results,
            }
        ],
    }
    return _indented(log)


def _sarif_rule(rule: Rule) -> dict[str, Any]:
    page = rule.page
    text = visible_lines(
        f"{page.why}\n\nExample:\n\n{page.example}\nUse instead:\n\n{page.better}"
    )
    return {
        "id": rule.code,
        "name": rule.name,
        "shortDescription": {"text": rule.summary},
        "fullDescription": {"text": page.why},
        "help": {"text": text},
        "defaultConfiguration": {
            "enabled": not rule.opt_in,
            "level": _SARIF_LEVELS[rule.severity],
        },
    }


def _sarif_result(
    finding: Finding, rule_at: int, fingerprint: str, files: Files
) -> dict[str, Any]:
    said = finding.diagnostic
    more = [*said.notes, *([said.help] if said.help else [])]
    result = {
        "ruleId": finding.rule.code,
        "ruleIndex": rule_at,
        "level": _SARIF_LEVELS[finding.severity],
        "message": {"text": "\n".join([said.message, *more])},
        "locations": [_sarif_place(said.span, files)],
        "partialFingerprints": {"rapc/v1": fingerprint},
    }
    if said.labels:
        result["relatedLocations"] = [
            {**_sarif_place(label.span, files), "message": {"text": label.message}}
            for label in dict.fromkeys(said.labels)
        ]
    if said.fix is not None and said.fix.applicability is Applicability.SAFE:
        result["fixes"] = [_sarif_fix(said.fix, files)]
    return result


def _sarif_place(span: Span, files: Files) -> dict[str, Any]:
    place = {"artifactLocation": _sarif_file(span), "region": _region(span, files)}
    return {"physicalLocation": place}


def _sarif_file(span: Span) -> dict[str, str]:
    return {"uri": quote(seen_from("", span.file), safe="/")}


def _region(span: Span, files: Files) -> dict[str, int]:
    (row, column), (last, end) = _rows(span, files)
    return {
        "startLine": row,
        "startColumn": column,
        "endLine": last,
        "endColumn": end,
    }


def _sarif_fix(fix: Fix, files: Files) -> dict[str, Any]:
    edits = sorted(fix.edits, key=lambda edit: (edit.span.file, edit.span.start))
    return {
        "description": {"text": fix.message},
        "artifactChanges": [
            {
                "artifactLocation": {"uri": quote(seen_from("", file), safe="/")},
                "replacements": [
                    {
                        "deletedRegion": _region(edit.span, files),
                        "insertedContent": {"text": edit.content},
                    }
                    for edit in group
                ],
            }
            for file, group in groupby(edits, key=lambda edit: edit.span.file)
        ],
    }


# --- GitHub -------------------------------------------------------------------------

_GITHUB_LEVELS = {
    Severity.ERROR: "error",
    Severity.WARNING: "warning",
    Severity.INFO: "notice",
}


def github(report: CheckReport) -> str:
    """Return each finding as a workflow command, which GitHub shows at its line."""
    return _lines(_commands(report))


def _commands(report: CheckReport) -> Iterator[str]:
    for finding in report.findings:
        said = finding.diagnostic
        (row, column), (last, end) = _rows(said.span, report.files)
        keys = {"file": seen_from("", said.span.file), "line": row, "endLine": last}
        keys["col"] = column
        if last == row:  # GitHub accepts columns for one line only
            keys["endColumn"] = end
        keys["title"] = f"{finding.rule.code} {finding.rule.name}"
        told = ",".join(f"{key}={_property(str(value))}" for key, value in keys.items())
        text = said.message + (f"\n{said.help}" if said.help else "")
        yield f"::{_GITHUB_LEVELS[finding.severity]} {told}::{_escaped(text)}"


def _escaped(text: str) -> str:
    """Return text in the form of a workflow command; GitHub knows no other escapes."""
    text = text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    return visible(text)


def _property(text: str) -> str:
    return _escaped(text).replace(":", "%3A").replace(",", "%2C")


# --- JUnit --------------------------------------------------------------------------


def junit(report: CheckReport) -> str:
    """Return JUnit XML: a suite for each file, a failed case for each finding.

    A file without findings has one case that passes.
    """
    found: dict[str, list[JUnitCase]] = {file: [] for file in report.files}
    for finding in report.findings:
        said = finding.diagnostic
        (row, column), _ = _rows(said.span, report.files)
        title = f"{finding.rule.code} {finding.rule.name} {row}:{column}"
        told = {"type": finding.severity.word, "message": said.message}
        text = "\n".join([said.message, *_notes(said)])
        case = JUnitCase(title, "failure", told, text)
        found.setdefault(said.span.file, []).append(case)
    suites = [(file, found[file] or [JUnitCase("no findings")]) for file in found]
    return junit_xml("rapc check", suites, COUNTS[:2], COUNTS[:3])


def _notes(said: Diagnostic) -> list[str]:
    return [*said.notes, *([f"help: {said.help}"] if said.help else [])]


# --- statistics, and the table of formats ------------------------------------------


def statistics(report: CheckReport, output_format: str) -> str:
    """Return the number of findings of each rule, highest number first.

    Args:
        report: the report.
        output_format: `json`, or any other for a table.
    """
    counts = Counter(finding.rule.name for finding in report.findings)
    rules = {finding.rule.name: finding.rule for finding in report.findings}
    mendable = Counter(
        finding.rule.name
        for finding in report.findings
        if (fix := finding.diagnostic.fix) and fix.applicability is Applicability.SAFE
    )
    ranked = sorted(rules.values(), key=lambda rule: (-counts[rule.name], rule.code))
    rows = [(counts[r.name], r, mendable[r.name]) for r in ranked]
    if output_format == "json":
        return _indented(
            [
                {
                    "code": rule.code,
                    "name": rule.name,
                    "severity": rule.severity.word,
                    "count": count,
                    "fixable": fixable,
                }
                for count, rule, fixable in rows
            ]
        )
    width = len(str(max(counts.values(), default=0)))
    return _lines(
        f"{count:{width}}  {rule.code} {rule.name} ({rule.severity.word})"
        + (f", {fixable} fixable" if fixable else "")
        for count, rule, fixable in rows
    )


WRITERS: Mapping[str, Callable[[CheckReport], str]] = {
    "concise": lambda report: _lines(text.concise(report)),
    "grouped": lambda report: _lines(text.grouped(report)),
    "json": json_text,
    "json-lines": json_lines,
    "sarif": sarif,
    "github": github,
    "junit": junit,
}
"""The writers of findings in each format except `full`."""
