"""What rapc says of its standard libraries is the same wherever it is installed."""

from __future__ import annotations

import io
import shutil
import sys
from pathlib import Path

import pytest

import rapc
from rapc.base import files
from rapc.library.saved import encode

from .command import BARE, from_the_beginning

PACKAGE = Path(rapc.__file__).parent

ORDER = """
(require "truck")
(define-rap (bring ?color)
  (method (task-net (t1 (fill-order ?color 1 factory-1)))))
"""
"""A library of the user's that requires one of rapc's."""

TESTS = """
(require "order")
(define-test brings-none
  (task (bring red))
  (until 5)
  (expect (failed)))
"""

CLASHING = '(require "truck")\n(define-rap (rescan-place ?place) (method (task-net)))\n'

COMMANDS = {
    "a run": (
        *("run", "order.rap", "--world", "truck", "--task", "(bring red)", "--seed"),
        *(
            "3",
            "--set",
            "truck.arm1-drops=90",
            "--until",
            "900",
            "--trace",
            "out.jsonl",
        ),
    ),
    "a recorded run": ("repl", "out.jsonl", "-c", ":failures", "--json"),
    "findings": ("check", "clash.rap", "-v", "--output-format", "json"),
    "findings for people": ("check", "clash.rap"),
    "a compiled library": ("compile", "order.rap", "-o", "out.rapc"),
    "coverage": ("test", "order.test.rap", "--coverage", "out.json"),
}


def _told_of_a_run() -> tuple[str, ...]:
    """What a run in which grasps fail tells, and what its library is saved as."""
    library = rapc.loads(ORDER, "order.rap")
    as_json, as_text = io.StringIO(), io.StringIO()
    run = library.start(
        "truck",
        tasks="(bring red)",
        seed=3,
        options={"arm1-drops": 90, "arm2-drops": 90},
        listeners=[rapc.JsonTrace(as_json), rapc.TextTrace(as_text)],
    )
    run.run(until=400)
    saved = encode(library.program.library, "order.rap").hex()
    return as_json.getvalue(), as_text.getvalue(), saved, *library.files


def test_a_run_tells_the_same_from_another_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = _told_of_a_run()
    assert '"place":"rapc:truck/' in here[0]
    elsewhere = tmp_path / "else where" / "libraries"
    shutil.copytree(PACKAGE / "stdlib", elsewhere)
    monkeypatch.setattr(files, "_STANDARD_LIBRARIES", elsewhere)
    assert files.path_of("rapc:truck/world.rap").is_relative_to(tmp_path)
    assert _told_of_a_run() == here


@pytest.mark.slow
def test_commands_tell_the_same_from_another_installation(tmp_path: Path) -> None:
    copy = tmp_path / "site" / "rapc"
    shutil.copytree(PACKAGE, copy)
    told = [_told(tmp_path / "one", PACKAGE), _told(tmp_path / "two", copy)]
    assert told[0] == told[1]
    assert any("rapc:truck/grasping.rap" in text for text in told[0].values())


def _told(folder: Path, package: Path) -> dict[str, str]:
    """What each command prints and writes, by its name and that of the file."""
    folder.mkdir()
    texts = {"order.rap": ORDER, "order.test.rap": TESTS, "clash.rap": CLASHING}
    for name, text in texts.items():
        (folder / name).write_text(text)
    environment = {**BARE, "PYTHONPATH": str(package.parent)}
    run = "import sys; from rapc.cli.start import main; sys.exit(main())"
    found = {}
    for name, words in COMMANDS.items():
        command = [sys.executable, "-c", run, *words]
        done = from_the_beginning(command, folder, environment, "")
        assert "Traceback" not in done.stderr
        found[name] = f"{done.returncode}\n{done.stdout}\n{done.stderr}"
    for file in folder.glob("out.*"):
        found[file.name] = file.read_bytes().decode(errors="replace")
    return found


def test_names_of_standard_libraries_are_paths() -> None:
    library = rapc.load("rapc:truck/world.rap", "rapc:hallway/world.rap")
    assert library.files == ("rapc:truck/world.rap", "rapc:hallway/world.rap")
    assert "rapc:truck-beyond/" in "".join(rapc.load("rapc:truck-beyond").files)
    above = ("rapc:..", "rapc:truck/../../cli", "rapc:/../stdlib")
    for wrong in ("rapc:truk", "rapc:truck/none.rap", *above):
        with pytest.raises(rapc.LoadError, match=f"^`{wrong}` does not exist$"):
            rapc.load(wrong)
    assert rapc.check("rapc:truck").findings == ()
