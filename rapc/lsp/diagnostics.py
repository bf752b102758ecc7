"""Findings as diagnostics of the protocol."""

from __future__ import annotations

from collections.abc import Mapping

from lsprotocol import types

from rapc.analysis.driver import Finding
from rapc.base.diagnostics import Severity
from rapc.lsp.workspace import View, Workspace, aliases, name_of

_SEVERITIES: Mapping[Severity, types.DiagnosticSeverity] = {
    Severity.ERROR: types.DiagnosticSeverity.Error,
    Severity.WARNING: types.DiagnosticSeverity.Warning,
    Severity.INFO: types.DiagnosticSeverity.Information,
}


def diagnostics(workspace: Workspace, uri: str) -> list[types.Diagnostic]:
    """Return the diagnostics of a file, moved by the edits since they were found."""
    found = [diagnostic(view, one) for view, one in workspace.latest(uri)]
    for snapshot in workspace.snapshots.values():
        for name in aliases(name_of(uri)):
            if name in snapshot.unreadable:
                found.append(_unreadable(snapshot.unreadable[name]))
    return found


def diagnostic(view: View, finding: Finding) -> types.Diagnostic:
    """Return a finding as a diagnostic."""
    one, rule = finding.diagnostic, finding.rule
    lines = [one.message, *one.notes]
    if one.help:
        lines.append(f"help: {one.help}")
    related = [
        types.DiagnosticRelatedInformation(view.location(label.span), label.message)
        for label in one.labels
        if label.span.file
    ]
    return types.Diagnostic(
        range=view.range(one.span),
        message="\n".join(lines),
        severity=_SEVERITIES[finding.severity],
        code=rule.name,
        code_description=types.CodeDescription(rule.page_file.as_uri()),
        source="rapc",
        tags=[types.DiagnosticTag.Unnecessary] if "unused" in rule.name else None,
        related_information=related or None,
    )


def _unreadable(message: str) -> types.Diagnostic:
    start = types.Position(0, 0)
    return types.Diagnostic(
        types.Range(start, start),
        message,
        severity=types.DiagnosticSeverity.Error,
        source="rapc",
    )
