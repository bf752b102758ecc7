"""Requests with an unknown outcome that the user decides on: `ask`."""

from __future__ import annotations

import json
from pathlib import Path

import pexpect
import pytest

from rapc.durable.resuming import LOST
from tests.cli.command import BARE, COMMAND
from tests.cli.command import rapc as command

ROBOT = """
import os
from rapc.live import Driver, SimulatedClock
from rapc.world import Kit, Offer

class Robot(Driver):
    name = "robot"
    kit = Kit(
        Offer(
            {"work": (1, ("okay",))},
            not_atomic=["work"],
            after_crash={"work": "ask"},
        )
    )

    def __init__(self, rng, options):
        super().__init__(rng, options, SimulatedClock())

    def do_work(self, action, n):
        action.sleep(3)
        if not os.path.exists("crashed"):
            open("crashed", "w").close()
            os._exit(9)
        print("work", n)
"""

LIBRARY = """
(declare-primitive work (?n) (okay) :atomic false :on (okay (done ?n)))
(declare-memory-proposition done (?n))
(define-rap (work-p ?n) (succeed (done ?n)) (method (primitive (work ?n))))
"""

TASKS = ("--task", "(work-p 1) :priority 2", "--task", "(work-p 2)")
RESUME = ("run", "--resume", "j", "-q")


@pytest.fixture
def crashed(tmp_path: Path) -> Path:
    """Return the folder of a run that ended with two requests under way."""
    (tmp_path / "robot.py").write_text(ROBOT)
    (tmp_path / "robot.rap").write_text(LIBRARY)
    args = ("robot.rap", "--world", "robot:Robot", *TASKS, "--journal", "j")
    done = command("run", *args, "-q", "--trace", "t.jsonl", cwd=tmp_path)
    assert done.returncode == 9
    return tmp_path


def _refused(folder: Path) -> list[tuple[str, str]]:
    lines = (folder / "t.jsonl").read_text().splitlines()
    events = [json.loads(line) for line in lines]
    return [
        (one["request"], one["because"])
        for one in events
        if one["event"] == "request-refused"
    ]


def test_command_without_a_terminal_requires_a_decision(crashed: Path) -> None:
    for _ in range(2):
        done = command(*RESUME, cwd=crashed)
        assert (done.returncode, done.stdout) == (3, "")
        assert done.stderr.splitlines() == [
            "error: cannot resume: (work 1) was under way, and its outcome is unknown",
            "  use --after-crash work=repeat or --after-crash work=fail",
        ]
    done = command(*RESUME, "--after-crash", "work=repeat", cwd=crashed)
    assert done.returncode == 0
    assert done.stdout.startswith("work 1\nwork 2\n")
    assert _refused(crashed) == []


def test_user_on_a_terminal_decides_on_each_request(crashed: Path) -> None:
    child = pexpect.spawn(
        str(COMMAND), [*RESUME], cwd=crashed, env=BARE, encoding="utf-8", timeout=60
    )
    asked = r"{} was under way, and its outcome is unknown \(repeat, fail\): "
    child.expect(asked.format(r"\(work 1\)"))
    child.sendline("perhaps")
    child.expect(asked.format(r"\(work 1\)"))
    child.sendline("fail")
    child.expect(asked.format(r"\(work 2\)"))
    child.sendline("repeat")
    child.expect(pexpect.EOF)
    child.close()
    assert child.exitstatus == 0
    assert _refused(crashed) == [("(work 1)", LOST)]


def test_abandoned_decision_leaves_the_journal_as_it_was(crashed: Path) -> None:
    child = pexpect.spawn(
        str(COMMAND), [*RESUME], cwd=crashed, env=BARE, encoding="utf-8", timeout=60
    )
    child.expect(r"\(repeat, fail\): ")
    child.sendeof()
    child.expect(pexpect.EOF)
    child.close()
    assert "Traceback" not in str(child.before)
    assert child.exitstatus == 130
    done = command(*RESUME, "--after-crash", "*=repeat", cwd=crashed)
    assert done.returncode == 0
