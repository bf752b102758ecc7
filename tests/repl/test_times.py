"""Times without the noise of floats, wherever a person reads them."""

from __future__ import annotations

import io
from pathlib import Path

import rapc
from rapc.debug.history import History
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell
from rapc.runtime.events.report import RunReport
from rapc.testing.run import Status
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld
from tests.repl.shells import said
from tests.repl.test_exporting import ARMS, statuses

ROWS = (
    Row(("look", "?x"), after=0.1, asserts=(("seen", "?x"),)),
    Row(("grasp", "box"), "dropped", takes=0.2, times=1),
    Row(("grasp", "?x"), takes=0.2, asserts=(("held", "?x"),)),
)


def _shell(folder: Path) -> tuple[Shell, io.StringIO, io.StringIO, RunReport]:
    path = folder / "arms.rap"
    path.write_text(ARMS, encoding="utf-8")
    library = rapc.load(path)
    ats = [At(0.1 + 0.2, asserts=(("idle", "cup"),))]
    world = ScriptedWorld(list(ROWS), ats, declared=library.program.library)
    text, exact, report = io.StringIO(), io.StringIO(), RunReport()
    listeners = [rapc.TextTrace(text), rapc.JsonTrace(exact), report]
    session = History.open(library, world, tasks=["(pick-up box)"], listeners=listeners)
    return Shell(session, commands(), [str(path)]), text, exact, report


def test_times_are_short_in_traces_for_people_only(tmp_path: Path) -> None:
    shell, text, exact, report = _shell(tmp_path)
    shell.answer(":run")
    assert '"time":0.30000000000000004' in exact.getvalue()
    lines = [*text.getvalue().splitlines(), *report.lines()]
    assert any(line.startswith("    0.3 ") for line in lines)
    assert not any("0000000" in line for line in lines)


def test_times_are_short_in_the_debugger(tmp_path: Path) -> None:
    shell = _shell(tmp_path)[0]
    shell.answer(":show none")
    assert "time 0.3" in said(shell, ":step 2")
    shell.answer(":run")
    for asked in (":timeline", ":retries", ":history (idle)"):
        told = said(shell, asked)
        assert "0000000" not in told
        assert "0.3" in told or asked == ":retries"


def test_times_are_short_in_an_exported_test(tmp_path: Path) -> None:
    shell = _shell(tmp_path)[0]
    shell.answer(":step 2")
    shell.answer("(pick-up cup)")
    shell.answer(":run")
    path = tmp_path / "noise.test.rap"
    assert "passes" in said(shell, f":export-test {path}")
    assert "(at 0.3" in "".join(path.read_text(encoding="utf-8").split("\n"))
    assert "0000000" not in path.read_text(encoding="utf-8")
    assert statuses(path) == [Status.PASSED]
