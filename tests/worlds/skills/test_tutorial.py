"""docs/tutorials/skill-world.md, followed word by word in an empty folder."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.command import rapc

PAGE = (Path(__file__).parents[3] / "docs" / "tutorials" / "skill-world.md").read_text(
    encoding="utf-8"
)


def _blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}(?: .*?)?\n(.*?)^```", PAGE, re.M | re.S)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all that the page has written so far."""
    folder = tmp_path_factory.mktemp("kettle")
    (folder / "kettle.py").write_text("\n\n".join(_blocks("python")), encoding="utf-8")
    [library] = _blocks("rap")
    (folder / "kettle.rap").write_text(library, encoding="utf-8")
    declared = _run("rapc worlds kettle:Kettle --declare", folder)
    (folder / "words.rap").write_text(declared, encoding="utf-8")
    return folder


def _run(command: str, folder: Path) -> str:
    """Run a command of the page, which succeeds, and return what it prints."""
    name, *args = shlex.split(command)
    done = rapc(*args, cwd=folder)
    assert (name, done.returncode, done.stderr) == ("rapc", 0, "")
    return done.stdout


def test_the_world_declares_itself_as_shown(folder: Path) -> None:
    [shown] = _blocks("console")
    declared = (folder / "words.rap").read_text(encoding="utf-8")
    assert shown == f"$ rapc worlds kettle:Kettle --declare\n{declared}"


def test_the_world_keeps_to_the_port(folder: Path) -> None:
    done = rapc("worlds", "kettle:Kettle", "--test", "kettle.rap", cwd=folder)
    assert "broken" not in done.stdout
    assert done.returncode == 0, done.stdout
    assert "150 requests with each of 3 seeds" in done.stdout


@pytest.mark.slow
def test_the_commands_do_what_the_page_says(folder: Path) -> None:
    commands = "".join(_blocks("sh")).splitlines()
    done = {
        command: _run(command, folder) for command in commands if ">" not in command
    }
    day, night = (text for text in done.values() if "Run over" in text)
    [shown] = _blocks("text")
    assert shown in day
    assert re.search(r"1098\.7 .* signal \(:warm 95\)", night)
    assert _blocks("mermaid") == [done[commands[-1]]]


def test_the_world_is_as_short_as_the_page_says() -> None:
    assert 80 <= len("\n\n".join(_blocks("python")).splitlines()) <= 99


def test_the_conflict_of_the_page_is_told(folder: Path, tmp_path: Path) -> None:
    for name in ("kettle.rap", "words.rap"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    text = (folder / "kettle.py").read_text(encoding="utf-8")
    text = text.replace("outputs = (LIMIT,)", "outputs = (LIMIT, POWER)")
    (tmp_path / "kettle.py").write_text(text, encoding="utf-8")
    task = ("--task", "(make-tea-at-night)")
    done = rapc("run", "kettle.rap", "--world", "kettle:Kettle", *task, cwd=tmp_path)
    assert done.returncode == 1
    assert (
        "primitive operation (:heat 95) - refused: `save-power 0.5` and `heat 95` both "
        "write `power`"
    ) in done.stdout
