"""The server with texts that are no programs, and with edits at random."""

from __future__ import annotations

import asyncio
import json
import logging
import random
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.lsp.client import PATIENCE, Editor  # before lsprotocol: it skips without it

from lsprotocol import types  # isort: skip

from rapc.lsp.navigation import RefusedRequestError
from rapc.lsp.server import is_fault, make_server
from tests.lsp.edits import assert_findings_are_fresh, type_keys
from tests.lsp.programs import RAPS, WORLD

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.xdist_group("lsp-robust")


@pytest.fixture
def editor(tmp_path: Path) -> Iterator[Editor]:
    (tmp_path / "world.rap").write_text(WORLD)
    (tmp_path / "raps.rap").write_text(RAPS)
    made = Editor(tmp_path)
    yield made
    assert made.close() == 0


def ask_all(editor: Editor, uri: str) -> None:
    """Ask for all that an editor asks about a file by itself."""
    document = types.TextDocumentIdentifier(uri)
    start = types.Position(0, 0)
    everything = types.Range(start, types.Position(100_000, 0))
    options = types.FormattingOptions(2, True)
    context = types.CodeActionContext([])
    for method, params in (
        (types.TEXT_DOCUMENT_HOVER, types.HoverParams(document, start)),
        (types.TEXT_DOCUMENT_COMPLETION, types.CompletionParams(document, start)),
        (types.TEXT_DOCUMENT_DEFINITION, types.DefinitionParams(document, start)),
        (
            types.TEXT_DOCUMENT_SIGNATURE_HELP,
            types.SignatureHelpParams(document, types.Position(5, 20)),
        ),
        (types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, types.DocumentSymbolParams(document)),
        (types.TEXT_DOCUMENT_FOLDING_RANGE, types.FoldingRangeParams(document)),
        (
            types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL,
            types.SemanticTokensParams(document),
        ),
        (
            types.TEXT_DOCUMENT_FORMATTING,
            types.DocumentFormattingParams(document, options),
        ),
        (types.TEXT_DOCUMENT_CODE_LENS, types.CodeLensParams(document)),
        (types.TEXT_DOCUMENT_INLAY_HINT, types.InlayHintParams(document, everything)),
        (
            types.TEXT_DOCUMENT_CODE_ACTION,
            types.CodeActionParams(document, everything, context),
        ),
    ):
        editor.ask(method, params)


TEXTS = {
    "bytes": random.Random(1).randbytes(3000).decode("latin-1"),
    "surrogates": "(define-rap (🤖 ?x) \u2028 \x0b \x0c (method (task-net)))\n🤖",
    "string": '(require "world\n(define-rap (go) (method (primitive (drive a))))',
    "comment": "#| (define-rap",
    "open": "(" * 10_000,
    "closed": ")" * 10_000,
    "empty": "",
    "returns": RAPS.replace("\n", "\r\n"),
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_any_text_is_answered(editor: Editor, text: str) -> None:
    uri = editor.open(editor.folders[0] / "raps.rap")
    editor.replace(uri, text)
    ask_all(editor, uri)
    editor.findings(uri)
    ask_all(editor, uri)
    editor.replace(uri, RAPS)
    assert editor.findings(uri) == []


def test_file_that_cannot_be_read_has_a_finding(editor: Editor) -> None:
    (editor.folders[0] / "odd.rap").write_bytes(b"\xff\xfe\x00")
    uri = editor.open(editor.folders[0] / "raps.rap")
    assert editor.findings(uri) == []
    (found,) = editor.messages((editor.folders[0] / "odd.rap").as_uri())
    assert "binary file" in found


def test_removed_files_are_forgotten(editor: Editor) -> None:
    uri = editor.open(editor.folders[0] / "raps.rap")
    (editor.folders[0] / "world.rap").unlink()
    editor.edit(uri, "; Go", "; Drive")
    assert "unresolved-require" in editor.findings(uri)
    (editor.folders[0] / "raps.rap").unlink()
    editor.shut(uri)
    other = editor.open(editor.folders[0] / "new.rap", "(define-rap (wait))")
    assert editor.findings(other) == []


def test_missing_library_of_the_configuration_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "rapc.toml"
    file.write_text('libraries = ["nowhere"]\n')
    editor = Editor(tmp_path)
    (message,) = editor.messages(file.as_uri())
    assert message == f"`{tmp_path / 'nowhere'}` does not exist"
    assert editor.close() == 0


def test_refused_request_logs_no_fault(caplog: pytest.LogCaptureFixture) -> None:
    log = logging.getLogger("rapc-lsp-refusals")
    log.addFilter(is_fault)
    for error in (RefusedRequestError("no name"), ValueError("a fault")):
        log.error("request failed", exc_info=error)
    (record,) = caplog.records
    assert record.exc_info is not None
    assert isinstance(record.exc_info[1], ValueError)


def test_folders_of_one_name_are_apart(tmp_path: Path) -> None:
    folders = [tmp_path / side / "robot" for side in ("left", "right")]
    for folder in folders:
        folder.mkdir(parents=True)
        (folder / "world.rap").write_text(WORLD)
    (folders[0] / "raps.rap").write_text(RAPS)
    (folders[1] / "raps.rap").write_text(RAPS.replace("(go hall)", "(goo hall)"))
    editor = Editor(*folders)
    assert editor.findings(editor.open(folders[0] / "raps.rap")) == []
    right = editor.open(folders[1] / "raps.rap")
    assert editor.findings(right) == ["unknown-rap"]
    params = types.DefinitionParams(**editor.of(right, "drive"))
    (found,) = editor.ask(types.TEXT_DOCUMENT_DEFINITION, params)
    assert found.uri == (folders[1] / "world.rap").as_uri()
    assert editor.close() == 0


def test_folder_with_200_libraries(tmp_path: Path) -> None:
    (tmp_path / "world.rap").write_text(WORLD)
    for number in range(200):
        (tmp_path / f"raps-{number}.rap").write_text(RAPS)
    editor = Editor(tmp_path)
    uri = editor.open(tmp_path / "raps-150.rap")
    assert editor.findings(uri) == []
    world = editor.open(tmp_path / "world.rap")
    params = types.ReferenceParams(
        context=types.ReferenceContext(include_declaration=False),
        **editor.of(world, "drive"),
    )
    assert editor.findings(world) == []
    found: set[str] = set()
    while len(found) < 200:  # the server checks a library after the other
        places = editor.ask(types.TEXT_DOCUMENT_REFERENCES, params)
        found = {one.uri for one in places}
    assert editor.close() == 0


def test_positions_in_utf_32_if_the_client_accepts_them(tmp_path: Path) -> None:
    units = types.PositionEncodingKind
    text = '(define-rap (go) (method (task-net (t "🤖" (wait)))))'
    for encodings in ([units.Utf16, units.Utf32], [units.Utf8, units.Utf16]):
        editor = Editor(tmp_path, encodings=encodings)
        uri = editor.open(tmp_path / "raps.rap", text)
        editor.findings(uri)
        wide = units.Utf32 not in encodings
        assert (editor.server.capabilities.position_encoding == units.Utf16) is wide
        found = editor.client.diagnostics[uri][-1]
        at = editor.at(uri, text.index("(t "))
        assert found.range.start >= at
        editor.edit(uri, "(wait)", "(go)")
        editor.findings(uri)
        assert editor.close() == 0


def test_ctrl_c_ends_the_server() -> None:
    """Although the editor keeps the standard input of the server open."""
    params: dict[str, object] = {"processId": None, "rootUri": None, "capabilities": {}}
    request = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": params}
    text = json.dumps(request)
    command = [sys.executable, "-m", "rapc", "lsp"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        server.stdin.write(f"Content-Length: {len(text)}\r\n\r\n{text}")
        server.stdin.flush()
        assert server.stdout.readline().startswith("Content-Length: ")
        server.send_signal(signal.SIGINT)
        assert server.wait(PATIENCE) == -signal.SIGINT


def test_results_after_the_end_of_a_session_are_dropped() -> None:
    server = make_server()

    async def begin() -> None:
        server.begin(types.InitializeParams(types.ClientCapabilities()))

    asyncio.run(begin())
    server.worker._log("a check has ended after its editor")
    server.worker.stop()


# --- edits at random ------------------------------------------------------------------

PIECES = ("(", ")", " ", "\n", "?x", "go", '"', "; ", "(method", "😀", "#|", "and")


def random_edits(editor: Editor, files: list[Path], count: int, seed: int) -> None:
    """Make edits at random, and compare the findings with those of a fresh check."""
    rng = random.Random(seed)
    opened = {editor.open(file): file for file in files}
    uris = list(opened)
    for number in range(count):
        uri = rng.choice(uris)
        text = editor.texts[uri]
        start = rng.randrange(len(text) + 1)
        end = min(len(text), start + rng.choice((0, 0, 0, 1, 3, 20)))
        editor.change(
            uri, start, end, rng.choice((*PIECES, "", text[start : start + 9]))
        )
        if number % 50 == 49:
            back = rng.choice(range(len(uris)))
            editor.replace(uris[back], files[back].read_text())
        if number % 100 == 99:
            assert_findings_are_fresh(editor, opened)


@pytest.mark.parametrize(
    "count",
    [
        40,
        pytest.param(300, marks=pytest.mark.slow),
        pytest.param(10_000, marks=pytest.mark.nightly),
    ],
)
def test_findings_after_edits_are_those_of_a_fresh_check(
    tmp_path: Path, count: int
) -> None:
    shutil.copytree(ROOT / "examples" / "courier", tmp_path / "courier")
    editor = Editor(tmp_path)
    random_edits(editor, sorted((tmp_path / "courier").glob("*.rap")), count, seed=1)
    assert editor.close() == 0


@pytest.mark.slow
def test_answers_while_typing_are_right(editor: Editor) -> None:
    uri = editor.open(editor.folders[0] / "raps.rap")
    editor.findings(uri)
    type_keys(editor, uri, "go", 120, pause=0.02)
    assert_findings_are_fresh(editor, {uri: editor.folders[0] / "raps.rap"})
