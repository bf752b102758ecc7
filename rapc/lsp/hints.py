"""Signature help, and hints in the text: kinds of inputs, callers, tests to run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from lsprotocol import types

from rapc.analysis.facts.kinds import INFERRED
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.language.grammar import GRAMMAR
from rapc.language.heads import rules_by_head, spelling
from rapc.language.highlight import tokens
from rapc.library.library import KINDS
from rapc.library.signature import Signature
from rapc.library.signatures import Use
from rapc.lsp.hover import documentation
from rapc.lsp.positions import Text
from rapc.lsp.workspace import View
from rapc.lsp.worlds import worlds_of

# --- signature help -------------------------------------------------------------------

_SEARCHED: tuple[Use, ...] = (
    *("goal", "test", "primitive", "datum", "skill", "event"),
)
"""The uses whose tables are searched for the first word of a list, in this order."""


class Call(NamedTuple):
    """The list at a position, up to the position."""

    #: The words before the position, the first word first.
    words: list[str]
    #: The number of the argument at the position, from 0.
    argument: int


def call_at(text: Text, offset: int) -> Call | None:
    """Return the innermost list at an offset."""
    form = text.text.rfind("\n(", 0, offset) + 1
    stack: list[list[str]] = []
    ended = True
    for kind, said in tokens(text.text[form:offset]):
        ended = kind in ("space", "comment") or said in "()"
        if said == "(":
            if stack:
                stack[-1].append("(")
            stack.append([])
        elif said == ")":
            if stack:
                stack.pop()
        elif stack and kind not in ("space", "comment"):
            stack[-1].append(said.lower())
    if not stack or not stack[-1]:
        return None
    words = stack[-1]
    return Call(words, len(words) - 1 - (not ended))


def signature_help(view: View, position: types.Position) -> types.SignatureHelp | None:
    """Return the signature of the list at a position."""
    text = view.text
    call = call_at(text, text.offset(position))
    if call is None or call.argument < 0:
        return None
    name = call.words[0]
    for use in _SEARCHED:
        declared = view.part.signatures.table(use).get(name)
        if declared is not None:
            return _signature(view, declared, call.argument)
    rule = rules_by_head("formula").get(name)
    if rule is None:
        return None
    shown = types.SignatureInformation(spelling(rule), GRAMMAR[rule].says)
    return types.SignatureHelp([shown], 0, None)


def _signature(view: View, declared: Signature, argument: int) -> types.SignatureHelp:
    args = [
        arg.variable.name if arg.kind is None else f"({arg.variable.name} {arg.kind})"
        for arg in declared.args or ()
    ]
    rap = view.part.library.raps.get(declared.name) if declared.kind == "RAP" else None
    outputs = [] if rap is None or not rap.outputs else ["=>"]
    outputs += [] if rap is None else [one.name for one in rap.outputs]
    label = f"({' '.join([declared.name, *args, *outputs])})"
    parameters = []
    at = len(declared.name) + 2
    for arg in args:
        parameters.append(types.ParameterInformation((at, at + len(arg))))
        at += len(arg) + 1
    tables = [
        getattr(view.part.library, field)
        for field, _, word in KINDS.values()
        if word == declared.kind
    ]
    forms = [one[declared.name] for one in tables if declared.name in one]
    doc = documentation(view, forms[0]) if forms else ""
    return types.SignatureHelp(
        [types.SignatureInformation(label, doc or declared.kind, parameters)],
        0,
        argument if argument < len(args) else None,
    )


# --- hints in the text ----------------------------------------------------------------


def inlay_hints(view: View, start: int, end: int) -> list[types.InlayHint]:
    """Return the inferred kinds of inputs of RAPs, between two offsets."""
    known_kinds = view.part.run.known(INFERRED)
    inferred = {} if known_kinds is None else known_kinds.inputs
    found = []
    for form in view.part.library.forms:
        if (
            not isinstance(form, nodes.DefineRap)
            or form.span.file != view.name
            or form.span.start > end
            or form.span.end < start
        ):
            continue
        declared = {one.variable for one in form.kinds}
        known = inferred.get(form.name, ())
        for variable, kind in zip(form.inputs, known, strict=False):
            if kind is not None and variable.name not in declared:
                place = view.range(variable.span).end
                label = types.InlayHintKind.Type
                found.append(types.InlayHint(place, f": {kind.kind}", label))
    return found


RUN_TESTS = "rapc.runTests"
"""The command that runs the tests of a file: its address and the name of a test."""

RUN_AGENDA = "rapc.runAgenda"
"""The command that runs an agenda: the address of its file, its name and a world."""

SHOW_CALLERS = "rapc.showCallers"
"""The command of the editor that lists callers: address, position and locations."""


def lenses(view: View, shows_callers: bool) -> list[types.CodeLens]:
    """Return the commands above tests, agendas and RAPs of a file."""
    return [
        *_of_tests(view),
        *_of_agendas(view),
        *_of_raps(view, shows_callers),
    ]


def _lens(
    view: View, span: Span, title: str, name: str, *args: object
) -> types.CodeLens:
    start = view.range(span).start
    uri = view.workspace.uri(view.name)
    command = types.Command(title, name, arguments=[uri, *args])
    return types.CodeLens(types.Range(start, start), command)


def _of_tests(view: View) -> Iterator[types.CodeLens]:
    for part in view.snapshot.parts:
        for test in part.library.tests:
            if test.span.file == view.name:
                yield _lens(view, test.span, "run test", RUN_TESTS, test.name)


def _of_agendas(view: View) -> Iterator[types.CodeLens]:
    worlds = worlds_of(view)
    world = worlds.pop() if len(worlds) == 1 else ""
    for form in view.part.library.agendas.values() if world else ():
        if form.span.file == view.name:
            title = f"run in {world}"
            yield _lens(view, form.span, title, RUN_AGENDA, form.name, world)


def _of_raps(view: View, shows_callers: bool) -> Iterator[types.CodeLens]:
    files = view.part.loaded.files
    for rap in view.part.library.raps.values():
        if rap.span.file != view.name:
            continue
        uses = view.part.index.uses_of("goal", rap.name)
        title = "1 caller" if len(uses) == 1 else f"{len(uses)} callers"
        if shows_callers:
            places = [view.location(one.place(files)) for one in uses]
            at = view.range(rap.name_span).start
            yield _lens(view, rap.span, title, SHOW_CALLERS, at, places)
        else:
            yield _lens(view, rap.span, title, "")
