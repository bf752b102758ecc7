"""The language server with a real client: pytest-lsp."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.lsp.client import Editor  # before lsprotocol: it skips without it

from lsprotocol import types  # isort: skip

from tests.lsp.programs import RAPS, WORLD

pytestmark = pytest.mark.xdist_group("lsp")


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    folder = tmp_path_factory.mktemp("robot")
    (folder / "world.rap").write_text(WORLD)
    (folder / "raps.rap").write_text(RAPS)
    made = Editor(folder)
    yield made
    assert made.close() == 0


@pytest.fixture
def raps(editor: Editor) -> Iterator[str]:
    uri = editor.open(editor.folders[0] / "raps.rap")
    yield uri
    editor.shut(uri)


def test_findings_follow_edits(editor: Editor, raps: str) -> None:
    editor.edit(raps, "(go kitchen)", "(goo kitchen)")
    editor.findings(raps, lambda found: "unknown-rap" in found)
    (found,) = [d for d in editor.client.diagnostics[raps] if d.code == "unknown-rap"]
    assert found.message == "unknown RAP `goo`\nhelp: did you mean `go`?"
    assert found.severity == types.DiagnosticSeverity.Error
    assert found.code_description is not None
    assert found.code_description.href.endswith("/rules/unknown-rap.md")
    editor.edit(raps, "(goo kitchen)", "(go kitchen)")
    editor.findings(raps, lambda found: "unknown-rap" not in found)


def test_hover_names_the_declaration(editor: Editor, raps: str) -> None:
    found = editor.ask(
        types.TEXT_DOCUMENT_HOVER, types.HoverParams(**editor.of(raps, "go hall"))
    )
    assert "(go ?place)" in found.contents.value


def test_definition_leads_to_another_file(editor: Editor, raps: str) -> None:
    where = types.DefinitionParams(**editor.of(raps, "drive"))
    found = editor.ask(types.TEXT_DOCUMENT_DEFINITION, where)
    assert found.uri == (editor.folders[0] / "world.rap").as_uri()
    assert found.range.start == types.Position(1, 19)
