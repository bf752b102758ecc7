"""The worker that checks libraries, without a client: `rapc.lsp.project`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from queue import Queue

import pytest

pytest.importorskip("lsprotocol", reason="the extra `lsp` is not installed")

from lsprotocol import types

from rapc.lsp.project import Delays, Snapshot, Syntax, Worker
from rapc.lsp.workspace import Workspace, aliases
from tests.lsp.programs import RAPS, WORLD

PATIENCE = 60.0
"""How many seconds an answer may take."""


class Buffers:
    """An open file, and the results that the worker publishes."""

    def __init__(self, folder: Path) -> None:
        self.workspace = Workspace(False, [str(folder)])
        self.uri = (folder / "raps.rap").as_uri()
        self.name = self.workspace.open(self.uri, RAPS, 1)
        self.results: Queue[Snapshot | Syntax] = Queue()
        put = self.results.put
        self.worker = Worker(Delays(0, 0), put, put, lambda gone: None, print)
        self.worker.start()
        self.worker.tell(self.workspace.work())
        self.receive()

    def edit(self, text: str) -> None:
        document = self.workspace.documents[self.name]
        document.edit([types.TextDocumentContentChangeWholeDocument(text)], 2)
        self.worker.tell(self.workspace.work(), aliases(self.name), typed=True)

    def receive(self) -> type:
        """Wait for a result, use the result and return its type."""
        result = self.results.get(timeout=PATIENCE)
        if isinstance(result, Snapshot):
            self.workspace.receive(result)
        else:
            self.workspace.receive_syntax(result)
        return type(result)

    def rules(self) -> list[str]:
        return [one.rule.name for _, one in self.workspace.latest(self.uri)]


@pytest.fixture
def buffers(tmp_path: Path) -> Iterator[Buffers]:
    (tmp_path / "world.rap").write_text(WORLD)
    (tmp_path / "raps.rap").write_text(RAPS)
    made = Buffers(tmp_path)
    yield made
    made.worker.stop()


def test_syntax_errors_precede_the_check(buffers: Buffers) -> None:
    assert buffers.rules() == []
    wrong = RAPS.replace("(drive ?place)", "(drove ?place)")
    buffers.edit(wrong.replace("(t1 (go kitchen))", "(t1 (go kitchen)"))
    assert buffers.receive() is Syntax
    syntax = buffers.rules()
    assert syntax
    assert buffers.receive() is Snapshot
    assert {*buffers.rules()} > {*syntax}


def test_other_findings_stay_until_the_check(buffers: Buffers) -> None:
    wrong = RAPS.replace("(t1 (go kitchen))", "(t1 (goo kitchen))")
    buffers.edit(wrong)
    assert [buffers.receive() for _ in "12"] == [Syntax, Snapshot]
    assert buffers.rules() == ["unknown-rap"]
    buffers.edit(f"; Drive.\n{wrong})")
    assert buffers.receive() is Syntax
    found = {
        one.rule.name: view.range(one.diagnostic.span).start
        for view, one in buffers.workspace.latest(buffers.uri)
    }
    assert found["unknown-rap"].line == wrong[: wrong.index("goo")].count("\n") + 1
    assert found["surplus-parenthesis"].line == wrong.count("\n") + 1
    assert buffers.receive() is Snapshot


def test_suppressed_syntax_errors_stay_silent(buffers: Buffers) -> None:
    said = "; rapc: file-ignore[surplus-parenthesis] a test\n"
    buffers.edit(f"{said}{RAPS})")
    assert buffers.receive() is Syntax
    assert buffers.rules() == []
