"""Code actions: fixes of findings, suppression, and declarations of unknown names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lsprotocol import types

from rapc.analysis.driver import Finding
from rapc.analysis.facts.index import NameUse
from rapc.base.diagnostics import Applicability, Fix
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.signatures import Use
from rapc.lsp.diagnostics import diagnostic
from rapc.lsp.navigation import workspace_edit
from rapc.lsp.refactor import refactorings
from rapc.lsp.workspace import View
from rapc.parser.syntax import Datum, List

FIX_ALL = "rapc.fixAll"
"""The command that applies all safe fixes in a file: its address."""

_QUICK = types.CodeActionKind.QuickFix


def actions(
    view: View, place: types.Range, wanted: Sequence[str] | None
) -> list[types.CodeAction]:
    """Return the actions for a range of a file.

    Args:
        view: the file.
        place: the range.
        wanted: the kinds of actions that the editor wants; None for all.
    """
    found: list[types.CodeAction] = []
    uri = view.workspace.uri(view.name)
    fixable = False
    for other, finding in view.workspace.findings(uri):
        fixable |= _is_safe(finding.diagnostic.fix)
        span = finding.diagnostic.span
        there = other.range(span)
        near = there.start <= place.end and place.start <= there.end
        if near and other.unchanged(span):
            found += _of_finding(other, finding)
    if fixable:
        command = types.Command("Fix all", FIX_ALL, arguments=[uri])
        kind = types.CodeActionKind.SourceFixAll
        found.append(types.CodeAction("Apply all safe fixes", kind, command=command))
    found += refactorings(view, place)
    if wanted is None:
        return found
    return [one for one in found if any(_is_of(one.kind, kind) for kind in wanted)]


def _is_of(kind: str | None, wanted: str) -> bool:
    value = str(getattr(kind, "value", kind))
    word = str(getattr(wanted, "value", wanted))
    return value == word or value.startswith(f"{word}.") or not word


def _is_safe(fix: Fix | None) -> bool:
    return fix is not None and fix.applicability is Applicability.SAFE


def _of_finding(view: View, finding: Finding) -> Iterator[types.CodeAction]:
    told = [diagnostic(view, finding)]
    fix = finding.diagnostic.fix
    if fix is not None and fix.edits:
        edit = _edits(view, [(one.span, one.content) for one in fix.edits])
        if edit is not None:
            yield types.CodeAction(
                _title(fix.message),
                _QUICK,
                diagnostics=told,
                is_preferred=_is_safe(fix) or None,
                edit=edit,
            )
    for title, span, text in _declarations(view, finding):
        edit = _edits(view, [(span, text)])
        if edit is not None:
            yield types.CodeAction(title, _QUICK, diagnostics=told, edit=edit)
    if finding.rule.ignore:
        title = f"Ignore {finding.rule.name} here"
        edit = _edits(view, [_suppression(view, finding)])
        if edit is not None:
            yield types.CodeAction(title, _QUICK, diagnostics=told, edit=edit)


def _title(message: str) -> str:
    return f"{message[:1].upper()}{message[1:]}"


def _edits(view: View, edits: Sequence[tuple[Span, str]]) -> types.WorkspaceEdit | None:
    """Return edits of a snapshot for the editor; None if a text has changed since."""
    changes: dict[str, list[types.TextEdit]] = {}
    for span, text in edits:
        there = view.beside(span.file)
        if not there.unchanged(span):
            return None
        uri = view.workspace.uri(span.file)
        changes.setdefault(uri, []).append(types.TextEdit(there.range(span), text))
    return workspace_edit(view, changes)


# --- suppression ----------------------------------------------------------------------


def _suppression(view: View, finding: Finding) -> tuple[Span, str]:
    """Return the insertion of a comment above the innermost list of a finding."""
    span = finding.diagnostic.span
    unit = view.part.units[span.file]
    start = _innermost(unit.data, span.start)
    row = unit.file.row(start)
    at = unit.file.line_starts[row - 1]
    line = unit.file.line(row)
    indent = line[: len(line) - len(line.lstrip())]
    text = f"{indent}; rapc: ignore[{finding.rule.name}]\n"
    return unit.file.span(at, at), text


def _innermost(data: Sequence[Datum], offset: int) -> int:
    """Return the start of the innermost list at an offset, or the offset."""
    found = offset
    here: Sequence[Datum] = data
    while True:
        for one in here:
            if isinstance(one, List) and one.start <= offset < one.end:
                found, here = one.start, one.items
                break
        else:
            return found


# --- declarations ---------------------------------------------------------------------

_FORMS: Mapping[str, tuple[str, str]] = {
    "undeclared-predicate": (
        "Declare the proposition",
        "(declare-memory-proposition {name} ({args}))",
    ),
    "undeclared-function": (
        "Declare the function",
        "(declare-memory-function {name} ({args}))",
    ),
    "undeclared-primitive": (
        "Declare the primitive",
        "(declare-primitive {name} ({args}) (okay))",
    ),
    "undeclared-datum": (
        "Declare the datum",
        "(declare-sensor-datum {name} ({args}))",
    ),
    "unknown-rap": (
        "Define the RAP",
        "(define-rap ({name}{inputs}{outputs})\n  (method (task-net)))",
    ),
}
"""By rule: the title of the action and the form that defines the unknown name."""

_SIGNALS: Mapping[Use, tuple[str, str]] = {
    "skill": ("Declare the skill", "(declare-skill {name} ({args}))"),
    "event": ("Declare the event", "(declare-event {name} ({args}))"),
}


def _declarations(view: View, finding: Finding) -> Iterator[tuple[str, Span, str]]:
    """Yield a title and the insertion that declares the unknown name of a finding."""
    rule, span = finding.rule.name, finding.diagnostic.span
    if rule not in _FORMS and rule != "undeclared-signal":
        if rule == "unknown-kind":
            yield from _kind(view, finding)
        return
    use = _use(view, span)
    if use is None:
        return
    title, form = _SIGNALS.get(use.use) or _FORMS.get(rule, ("", ""))
    if not form:
        return
    arguments = _arguments(use.node.args)
    outputs = _arguments(getattr(use.node, "outputs", ()), len(arguments))
    text = form.format(
        name=use.name,
        args=" ".join(arguments),
        inputs="".join(f" {one}" for one in arguments),
        outputs=" => " + " ".join(outputs) if outputs else "",
    )
    yield f"{title} `{use.name}`", *_after(view, use.owner.span, text)


def _kind(view: View, finding: Finding) -> Iterator[tuple[str, Span, str]]:
    span = finding.diagnostic.span
    for one in view.part.index.kinds():
        if one.span == span or span.contains(one.span):
            place, text = _after(view, one.owner.span, f"(declare-kind {one.kind})")
            yield f"Declare the kind `{one.kind}`", place, text
            return


def _use(view: View, span: Span) -> NameUse | None:
    files = view.part.loaded.files
    for one in view.part.index.uses():
        if one.span.contains(span) and span in (one.span, one.place(files)):
            return one
    return None


def _arguments(terms: Sequence[nodes.Term], before: int = 0) -> list[str]:
    """Return variables for the arguments of a use, each with its own name."""
    found: list[str] = []
    for at, term in enumerate(terms, before + 1):
        name = term.name if isinstance(term, nodes.Var) else "?"
        found.append(f"?arg{at}" if name == "?" or name in found else name)
    return found


def _after(view: View, owner: Span, form: str) -> tuple[Span, str]:
    """Return the insertion of a form after the form that uses its name."""
    return Span(owner.file, owner.end, owner.end), f"\n\n{form}"
