"""The language server with a real client: pytest-lsp."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.lsp.client import PATIENCE, Editor  # before lsprotocol: it skips without it

from lsprotocol import types  # isort: skip
from pygls.exceptions import JsonRpcException  # isort: skip

from tests.lsp.programs import PYTHON, RAPS, TESTS, WORLD

pytestmark = pytest.mark.xdist_group("lsp")


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    folder = tmp_path_factory.mktemp("robot")
    (folder / "world.rap").write_text(WORLD)
    (folder / "raps.rap").write_text(RAPS)
    (folder / "raps.test.rap").write_text(TESTS)
    (folder / "robot.py").write_text(PYTHON)
    made = Editor(folder)
    yield made
    assert made.close() == 0


@pytest.fixture
def raps(editor: Editor) -> Iterator[str]:
    uri = editor.open(editor.folders[0] / "raps.rap")
    editor.findings(uri)
    yield uri
    editor.shut(uri)


def test_findings_follow_edits(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(go kitchen)", "(goo kitchen)")
    assert "unknown-rap" in editor.findings(raps)
    (found,) = [d for d in editor.client.diagnostics[raps] if d.code == "unknown-rap"]
    assert found.message == "unknown RAP `goo`\nhelp: did you mean `go`?"
    assert found.severity == types.DiagnosticSeverity.Error
    assert found.code_description is not None
    assert found.code_description.href.endswith("/rules/unknown-rap.md")
    editor.edit(raps, "(goo kitchen)", "(go kitchen)")
    assert "unknown-rap" not in editor.findings(raps)


def test_hover_names_the_declaration(editor: Editor, raps: str) -> None:
    found = editor.ask(
        types.TEXT_DOCUMENT_HOVER, types.HoverParams(**editor.of(raps, "go hall"))
    )
    assert "(go ?place)" in found.contents.value


def test_definition_leads_to_another_file(editor: Editor, raps: str) -> None:
    where = types.DefinitionParams(**editor.of(raps, "drive"))
    (found,) = editor.ask(types.TEXT_DOCUMENT_DEFINITION, where)
    assert found.uri == (editor.folders[0] / "world.rap").as_uri()
    assert found.range.start == types.Position(1, 19)


def ask(
    editor: Editor, method: str, params: type, uri: str, at: str, **more: Any
) -> Any:
    """Ask about the first occurrence of a text."""
    return editor.ask(method, params(**editor.of(uri, at), **more))


def apply(editor: Editor, uri: str, edit: types.WorkspaceEdit) -> str:
    """Return the text of an open file after an edit."""
    (change,) = [
        one
        for one in edit.document_changes or ()
        if isinstance(one, types.TextDocumentEdit) and one.text_document.uri == uri
    ]
    return applied(
        editor, uri, [e for e in change.edits if isinstance(e, types.TextEdit)]
    )


def applied(editor: Editor, uri: str, edits: Sequence[types.TextEdit]) -> str:
    text = editor.texts[uri]
    starts = [0, *(at + 1 for at, char in enumerate(text) if char == "\n")]
    for one in sorted(edits, key=lambda e: e.range.start, reverse=True):
        start = starts[one.range.start.line] + one.range.start.character
        end = starts[one.range.end.line] + one.range.end.character
        text = text[:start] + one.new_text + text[end:]
    return text


def actions(
    editor: Editor, uri: str, old: str, **more: Any
) -> dict[str, types.CodeAction]:
    """Return the code actions for a text, by title."""
    start = editor.texts[uri].index(old)
    place = types.Range(editor.at(uri, start), editor.at(uri, start + len(old)))
    document = types.TextDocumentIdentifier(uri)
    context = types.CodeActionContext([], **more)
    params = types.CodeActionParams(document, place, context)
    return {
        one.title: one for one in editor.ask(types.TEXT_DOCUMENT_CODE_ACTION, params)
    }


def document(uri: str) -> types.TextDocumentIdentifier:
    return types.TextDocumentIdentifier(uri)


def test_hover_shows_comment_effects_and_callers(editor: Editor, raps: str) -> None:
    found = ask(
        editor, types.TEXT_DOCUMENT_HOVER, types.HoverParams, raps, "go kitchen"
    )
    text = found.contents.value
    assert text.startswith("```rap\n(go ?place)\n```\n\nGo to a place.")
    assert "may change: `at`" in text
    assert "used 3 times: `tour`, `drives`" in text


def test_hover_does_not_count_all_of_many_uses(editor: Editor, raps: str) -> None:
    steps = "".join(f"(s{n} (go hall))" for n in range(120))
    editor.edit(
        raps, "; Go to", f"(define-rap (trip) (method (task-net {steps})))\n; Go to"
    )
    editor.findings(raps)
    params = types.HoverParams(**editor.of(raps, "(go ?place)"))
    params.position.character += 1
    found = editor.ask(types.TEXT_DOCUMENT_HOVER, params)
    assert "used at least 101 times: `trip`, ..." in found.contents.value


def test_hover_on_a_finding_shows_its_rule(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(go kitchen)", "(goo kitchen)")
    assert "unknown-rap" in editor.findings(raps)
    found = ask(editor, types.TEXT_DOCUMENT_HOVER, types.HoverParams, raps, "goo")
    assert "unknown-rap.md" in found.contents.value


def test_hover_on_a_word_shows_its_purpose(editor: Editor, raps: str) -> None:
    found = ask(editor, types.TEXT_DOCUMENT_HOVER, types.HoverParams, raps, "succeed")
    assert "whether a task has succeeded" in found.contents.value


def test_declaration_of_a_primitive_leads_to_python(editor: Editor, raps: str) -> None:
    world = editor.open(editor.folders[0] / "world.rap")
    (found,) = ask(
        editor, types.TEXT_DOCUMENT_DEFINITION, types.DefinitionParams, world, "drive"
    )
    assert found.uri.endswith("robot.py")
    assert found.range.start.line == PYTHON[: PYTHON.index("def driven")].count("\n")
    python = editor.open(editor.folders[0] / "robot.py")
    (back,) = ask(
        editor, types.TEXT_DOCUMENT_DEFINITION, types.DefinitionParams, python, "driven"
    )
    assert back.uri == world
    assert back.range.start.line == 1
    editor.shut(world)
    editor.shut(python)


def test_definition_of_a_require_is_its_file(editor: Editor, raps: str) -> None:
    (found,) = ask(
        editor, types.TEXT_DOCUMENT_DEFINITION, types.DefinitionParams, raps, '"world"'
    )
    assert found.uri.endswith("world.rap")
    (link,) = editor.ask(
        types.TEXT_DOCUMENT_DOCUMENT_LINK, types.DocumentLinkParams(document(raps))
    )
    assert link.target == found.uri
    assert (link.range.start.character, link.range.end.character) == (9, 16)


def test_references_are_in_all_files(editor: Editor, raps: str) -> None:
    context = types.ReferenceContext(include_declaration=True)
    found = ask(
        editor,
        types.TEXT_DOCUMENT_REFERENCES,
        types.ReferenceParams,
        raps,
        "go kitchen",
        context=context,
    )
    files = [one.uri.rpartition("/")[2] for one in found]
    assert files == ["raps.rap"] * 3 + ["raps.test.rap"]


def test_highlights_are_of_one_scope(editor: Editor, raps: str) -> None:
    found = ask(
        editor,
        types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT,
        types.DocumentHighlightParams,
        raps,
        "?place",
    )
    assert len(found) == 3


def test_rename_changes_all_files(editor: Editor, raps: str) -> None:
    where = (types.TEXT_DOCUMENT_PREPARE_RENAME, types.PrepareRenameParams)
    found = ask(editor, *where, raps, "go kitchen")
    assert found.placeholder == "go"
    edit = ask(
        editor,
        types.TEXT_DOCUMENT_RENAME,
        types.RenameParams,
        raps,
        "go kitchen",
        new_name="travel",
    )
    text = apply(editor, raps, edit)
    assert text.count("(travel ") == 3
    assert len(edit.document_changes) == 2
    with pytest.raises(JsonRpcException, match="the name `tour` is in use"):
        ask(
            editor,
            types.TEXT_DOCUMENT_RENAME,
            types.RenameParams,
            raps,
            "go kitchen",
            new_name="tour",
        )


def test_name_in_the_code_of_a_world_is_not_renamed(tmp_path: Path) -> None:
    (tmp_path / "world.rap").write_text(WORLD)
    (tmp_path / "raps.rap").write_text(RAPS)
    tested = TESTS.replace("(script", '(world "robot:Robot")\n  (script')
    (tmp_path / "raps.test.rap").write_text(tested)
    (tmp_path / "robot.py").write_text(PYTHON)
    editor = Editor(tmp_path)
    uri = editor.open(tmp_path / "world.rap")
    editor.findings(uri)
    where = types.TEXT_DOCUMENT_RENAME, types.RenameParams, uri, "drive"
    with pytest.raises(JsonRpcException, match=r"cannot rename `drive`: .*robot\.py"):
        ask(editor, *where, new_name="travel")
    editor.close()


def test_calls_lead_both_ways(editor: Editor, raps: str) -> None:
    (item,) = ask(
        editor,
        types.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY,
        types.CallHierarchyPrepareParams,
        raps,
        "go ?place",
    )
    method = types.CALL_HIERARCHY_INCOMING_CALLS
    (caller,) = editor.ask(method, types.CallHierarchyIncomingCallsParams(item))
    assert caller.from_.name == "tour"
    assert len(caller.from_ranges) == 2
    method = types.CALL_HIERARCHY_OUTGOING_CALLS
    (called,) = editor.ask(method, types.CallHierarchyOutgoingCallsParams(caller.from_))
    assert called.to.name == "go"


def test_symbols_are_a_tree(editor: Editor, raps: str) -> None:
    params = types.DocumentSymbolParams(document(raps))
    go, tour = editor.ask(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, params)
    assert (go.name, tour.name) == ("go", "tour")
    assert [one.name for one in tour.children[0].children] == ["t1 go", "t2 go"]
    found = editor.ask(types.WORKSPACE_SYMBOL, types.WorkspaceSymbolParams("driv"))
    assert {one.name for one in found} == {"drive", "drives"}


def test_folding_has_forms_and_comments(editor: Editor, raps: str) -> None:
    params = types.FoldingRangeParams(document(raps))
    found = editor.ask(types.TEXT_DOCUMENT_FOLDING_RANGE, params)
    rows = [(one.start_line, one.end_line) for one in found]
    assert rows == [(3, 6), (5, 6), (8, 12), (9, 12), (10, 12)]


def test_semantic_tokens_cover_the_text(editor: Editor, raps: str) -> None:
    params = types.SemanticTokensParams(document(raps))
    data = editor.ask(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, params).data
    provider = editor.server.capabilities.semantic_tokens_provider
    kinds = provider.legend.token_types
    words = []
    row = column = 0
    lines = editor.texts[raps].split("\n")
    for at in range(0, len(data), 5):
        down, along, size, kind, _ = data[at : at + 5]
        row, column = row + down, along if down else column + along
        words.append((lines[row][column : column + size], kinds[kind]))
    assert words[:3] == [
        ("require", "keyword"),
        ('"world"', "string"),
        ("; Go to a place.", "comment"),
    ]
    assert ("go", "function") in words
    assert ("?place", "variable") in words


def test_formatting_of_file_range_and_line(editor: Editor, raps: str) -> None:
    editor.edit(raps, "  (succeed (at robot ?place))", " (succeed  (at robot\n?place))")
    options = types.FormattingOptions(2, True)
    params = types.DocumentFormattingParams(document(raps), options)
    edits = editor.ask(types.TEXT_DOCUMENT_FORMATTING, params)
    assert applied(editor, raps, edits) == RAPS
    start = editor.of(raps, "(define-rap (go")["position"]
    place = types.Range(start, start)
    range_ = types.DocumentRangeFormattingParams(document(raps), place, options)
    edits = editor.ask(types.TEXT_DOCUMENT_RANGE_FORMATTING, range_)
    assert applied(editor, raps, edits) == RAPS
    where = editor.of(raps, "?place))\n")["position"]
    typed = types.DocumentOnTypeFormattingParams(document(raps), where, "\n", options)
    (edit,) = editor.ask(types.TEXT_DOCUMENT_ON_TYPE_FORMATTING, typed)
    assert edit.new_text == " " * 13


def test_completion_offers_words_and_names(editor: Editor, raps: str) -> None:
    def labels(at: str) -> set[str]:
        found = ask(
            editor, types.TEXT_DOCUMENT_COMPLETION, types.CompletionParams, raps, at
        )
        return {one.label for one in found.items}

    assert {"drive", "enable"} <= labels("drive ?place")
    assert "?place" in labels("?place))))")
    assert {"go", "tour"} <= labels("go hall")
    assert "preconditions" in labels("succeed (at")
    editor.edit(raps, '"world"', '"')
    start = editor.texts[raps].index('"') + 1
    params = types.CompletionParams(document(raps), editor.at(raps, start))
    found = editor.ask(types.TEXT_DOCUMENT_COMPLETION, params)
    labels_of_files = {one.label for one in found.items}
    assert {"world", "truck"} <= labels_of_files
    assert "raps" not in labels_of_files  # the file itself


def test_signature_help_marks_the_argument(editor: Editor, raps: str) -> None:
    found = ask(
        editor,
        types.TEXT_DOCUMENT_SIGNATURE_HELP,
        types.SignatureHelpParams,
        raps,
        "?place))\n",
    )
    (shown,) = found.signatures
    assert shown.label == "(at ?thing ?place)"
    assert shown.documentation == "Where a thing is."
    assert found.active_parameter == 1


def test_lenses_count_callers_and_run_tests(editor: Editor, raps: str) -> None:
    params = types.CodeLensParams(document(raps))
    found = editor.ask(types.TEXT_DOCUMENT_CODE_LENS, params)
    assert [one.command.title for one in found] == ["2 callers", "0 callers"]
    tests = editor.open(editor.folders[0] / "raps.test.rap")
    params = types.CodeLensParams(document(tests))
    (found,) = editor.ask(types.TEXT_DOCUMENT_CODE_LENS, params)
    assert found.command.title == "run test"
    command = types.ExecuteCommandParams(
        found.command.command, arguments=found.command.arguments
    )
    assert editor.ask(types.WORKSPACE_EXECUTE_COMMAND, command) is True
    assert editor.client.messages[-1].message.startswith("test `drives`: passed")
    editor.shut(tests)


def test_quick_fix_corrects_a_name(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(go kitchen)", "(goo kitchen)")
    assert "unknown-rap" in editor.findings(raps)
    found = actions(editor, raps, "goo")
    edit = found["Write `go`"].edit
    assert edit is not None
    assert apply(editor, raps, edit) == RAPS


def test_unknown_step_becomes_a_rap(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(go hall)", "(inspect ?room hall => ?seen)")
    assert "unknown-rap" in editor.findings(raps)
    edit = actions(editor, raps, "inspect")["Define the RAP `inspect`"].edit
    assert edit is not None
    assert apply(editor, raps, edit).endswith(
        "\n\n(define-rap (inspect ?room ?arg2 => ?seen)\n  (method (task-net)))\n"
    )


def test_missing_declaration_is_added(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(succeed (at robot ?place))", "(succeed (seen ?place north))")
    assert "undeclared-predicate" in editor.findings(raps)
    edit = actions(editor, raps, "seen")["Declare the proposition `seen`"].edit
    assert edit is not None
    declared = "(declare-memory-proposition seen (?place ?arg2))"
    assert declared in apply(editor, raps, edit)


def test_finding_of_a_former_text_has_no_actions(tmp_path: Path) -> None:
    (tmp_path / "world.rap").write_text(WORLD)
    (tmp_path / "raps.rap").write_text(RAPS.replace("go hall", "goo hall"))
    editor = Editor(tmp_path, options={"errorDelay": 60_000, "delay": 60_000})
    uri = editor.open(tmp_path / "raps.rap")
    assert "unknown-rap" in editor.findings(uri)
    assert "Define the RAP `goo`" in actions(editor, uri, "goo")
    editor.edit(uri, "goo hall", "go hall")
    assert "Define the RAP `goo`" not in actions(editor, uri, "go hall")
    editor.close()


def test_finding_can_be_suppressed(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(t2 (go hall))", "(t2 (go kitchen))")
    assert "copied-step" in editor.findings(raps)
    found = actions(editor, raps, "(t2 (go kitchen))")
    edit = found["Ignore copied-step here"].edit
    assert edit is not None
    editor.replace(raps, apply(editor, raps, edit))
    assert "; rapc: ignore[copied-step]" in editor.texts[raps]
    assert editor.findings(raps) == []


def test_fix_all_applies_all_safe_fixes(editor: Editor, raps: str) -> None:
    editor.edit(raps, "; Go to", "; rapc: ignore[unbound-variable]\n; Go to")
    assert "unused-suppression" in editor.findings(raps)
    found = actions(editor, raps, "; Go", only=[types.CodeActionKind.SourceFixAll])
    assert list(found) == ["Apply all safe fixes"]
    params = types.ExecuteCommandParams("rapc.fixAll", arguments=[raps])
    editor.ask(types.WORKSPACE_EXECUTE_COMMAND, params)
    (edit,) = editor.applied
    assert apply(editor, raps, edit) == RAPS


def test_steps_become_a_rap_and_are_inlined(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(t1 (go kitchen))", "(t1 (go ?a) (for t2))")
    editor.edit(raps, "(tour)", "(tour ?a)")
    assert editor.findings(raps) == []
    found = actions(editor, raps, "(t1 (go ?a) (for t2))\n      (t2 (go hall))")
    edit = found["Extract the steps into a RAP"].edit
    assert edit is not None
    text = apply(editor, raps, edit)
    assert "(task-net\n      (t1 (tour-t1 ?a)))))" in text
    assert "(define-rap (tour-t1 ?a)" in text
    editor.replace(raps, text)
    assert editor.findings(raps) == []
    inlined = actions(editor, raps, "(t1 (tour")
    start = editor.of(raps, "t1 (tour-t1 ?a)")["position"]
    place = types.Range(start, start)
    context = types.CodeActionContext([])
    params = types.CodeActionParams(document(raps), place, context)
    inlined = {
        one.title: one for one in editor.ask(types.TEXT_DOCUMENT_CODE_ACTION, params)
    }
    edit = inlined["Inline `tour-t1`"].edit
    assert edit is not None
    assert "(t1 (go ?a) (for t2))" in apply(editor, raps, edit).partition("tour-t1")[0]


def test_inlay_hints_show_inferred_kinds(editor: Editor, raps: str) -> None:
    editor.edit(raps, '(require "world")', '(require "world")\n(declare-kind room)')
    assert editor.findings(raps) == []
    start = types.Position(0, 0)
    place = types.Range(start, types.Position(20, 0))
    params = types.InlayHintParams(document(raps), place)
    found = editor.ask(types.TEXT_DOCUMENT_INLAY_HINT, params)
    assert [one.label for one in found] == [": symbol"]


def test_requests_at_opening_wait_for_the_first_check(tmp_path: Path) -> None:
    (tmp_path / "raps.rap").write_text(
        '(require "world")\n(declare-kind room)\n' + RAPS
    )
    (tmp_path / "world.rap").write_text(WORLD)
    editor = Editor(tmp_path, like="visual_studio_code")
    refreshed = threading.Event()

    def refresh(params: None) -> None:
        refreshed.set()

    editor.client.feature(types.WORKSPACE_CODE_LENS_REFRESH)(refresh)

    uri = editor.open(tmp_path / "raps.rap")
    params = types.CodeLensParams(document(uri))
    assert len(editor.ask(types.TEXT_DOCUMENT_CODE_LENS, params)) == 2
    assert refreshed.wait(PATIENCE)
    place = types.Range(types.Position(0, 0), types.Position(20, 0))
    hints = types.InlayHintParams(document(uri), place)
    assert editor.ask(types.TEXT_DOCUMENT_INLAY_HINT, hints)
    editor.close()


def test_other_files_are_not_read_as_raps(editor: Editor) -> None:
    uri = editor.open(editor.folders[0] / "rapc.toml", 'libraries = ["."]\n(go  a)\n')
    params = types.SemanticTokensParams(document(uri))
    assert editor.ask(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, params) is None
    options = types.FormattingOptions(2, True)
    format_ = types.DocumentFormattingParams(document(uri), options)
    assert not editor.ask(types.TEXT_DOCUMENT_FORMATTING, format_)
    editor.shut(uri)
