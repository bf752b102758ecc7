"""`rapc repl` where there is no terminal: inputs from options and standard input."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.command import rapc

TRUCK = ("examples/rock-order.rap", "--world", "truck", "--task", "(rock-order red 1)")


def test_inputs_come_from_options() -> None:
    done = rapc("repl", *TRUCK, "-c", ":show none", "-c", ":step 5")
    assert done.returncode == 0
    assert done.stdout.endswith("cycle 5, time 0\n")
    assert done.stderr == ""


def test_inputs_come_from_standard_input() -> None:
    done = rapc("repl", *TRUCK, stdin=":show none\n\n:step\n:back\n:quit\n:step\n")
    assert done.returncode == 0
    assert done.stdout.splitlines()[1:] == ["cycle 1, time 0", "cycle 0, time 0"]


def test_failed_command_sets_exit_status_1() -> None:
    done = rapc("repl", *TRUCK, "-c", ":stpe", "-c", ":step")
    assert done.returncode == 1
    assert "did you mean `:step`?" in done.stdout
    assert "cycle 1, time 0" in done.stdout


def test_answers_come_as_json() -> None:
    done = rapc("repl", *TRUCK, "--json", "-c", ":step 9", "-c", ":chain 9", "-c", ":x")
    records = [json.loads(line) for line in done.stdout.splitlines()]
    assert [record["failed"] for record in records] == [False, False, True]
    assert records[1]["input"] == ":chain 9"
    assert records[1]["rows"][-1] == {
        "task": 1,
        "goal": "(rock-order red 1)",
        "method": "red",
    }


def test_background_tasks_alone_go_on_until_the_limit(tmp_path: Path) -> None:
    library = tmp_path / "signs.rap"
    library.write_text(
        "(define-rap (rest) (succeed true))"
        "(define-rap (tick) (succeed nil) (monitor-time now 10 20)"
        "  (method (task-net (t1 (rest)))))"
    )
    args = ("repl", str(library), "--task", "(tick) :background true")
    for more, end in (((), "time 0, run ended (done)"), (("--until", "35"), "(until)")):
        done = rapc(*args, *more, "-c", ":show none", "-c", ":run")
        assert (done.returncode, end in done.stdout) == (0, True), done.stdout


def test_library_without_primitives_needs_no_world(tmp_path: Path) -> None:
    library = tmp_path / "signs.rap"
    text = "(declare-memory-proposition lit (?lamp))\n"
    text += "(define-rap (wait ?lamp) (succeed (lit ?lamp)))\n"
    library.write_text(text)
    args = ("repl", str(library), "--task", "(wait hall)", "--fact", "(lit hall)")
    done = rapc(*args, "--set", "rapc.futile-limit=3", "-c", ":run")
    assert (done.returncode, done.stderr) == (0, "")
    assert "task accomplished (wait hall) [1]" in done.stdout
    library.write_text(f"{text}(declare-primitive shine (?lamp) (okay))\n")
    done = rapc(*args, "-c", ":run")
    assert (done.returncode, "missing --world" in done.stderr) == (2, True)


def test_invalid_start_is_reported() -> None:
    done = rapc("repl", "examples/rock-order.rap", "--world", "truk")
    assert done.returncode == 2
    assert "did you mean `truck`" in done.stderr
