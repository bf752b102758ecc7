"""A small experiment with the truck, and commands that are watched while they run."""

from __future__ import annotations

import os
import pty
import subprocess
import termios
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from rapc.compiler.program import Program
from rapc.experiments import definition
from rapc.experiments.definition import Experiment
from rapc.experiments.measures import Measures
from rapc.experiments.run import PointConfig
from rapc.experiments.session import Batch
from rapc.experiments.store import Store
from rapc.host import load
from tests.cli.command import COMMAND, HOME

CHECKOUT = Path(__file__).parents[2]
LIBRARY = CHECKOUT / "examples" / "rock-order.rap"

TRUCK = f"""\
title = "Two rocks while arms drop things"
library = "{LIBRARY}"
world = "truck"
until = 4000
seeds = 5
tasks = [
  "(fill-order red 1 factory-1) :priority 2",
  "(fill-order blue 1 factory-2) :priority 2 :at 60",
]
counted = ["fill-order"]
count = {{ moves = "move-thing-to", roads = "truck-move" }}

[set.truck]
fuel = 1000
fuel-capacity = 1000
arm-move-time = 2

[[part]]
name = "drops"
title = "The first arm drops more and more"
vary = "truck.arm1-drops"
values = [0, 40]
notes = ["The more drops, the longer it takes."]
mark = {{ at = 15, label = "usual" }}

[part.reference]
title = "before"
at = [40]
figures = {{ completed = [2], time = [900] }}

[[part]]
name = "slow"
vary = "truck.arm-move-time"
values = [2, 4]
set.truck.arm1-drops = 40

[[part]]
name = "usual"
"""
"""Three parts of 2, 2 and 1 points, of which one is in two parts."""


def session(
    text: str = TRUCK, parts: Sequence[str] = (), seeds: int | None = None
) -> Batch:
    """A session for the text of an experiment that lies in the checkout."""
    made: Experiment = definition.decode_experiment(text, "truck")
    return Batch(made, CHECKOUT, checked, parts, seeds)


def checked(path: str) -> Program:
    """A library without errors."""
    return load(path).program


def config(text: str = TRUCK) -> PointConfig:
    """The configuration of the first point of an experiment."""
    return session(text).points[0].config


def rows(folder: Path) -> list[tuple[str, int, Measures]]:
    """Everything in a folder's results but the time that it took."""
    with Store(folder / "results.sqlite") as store:
        return [
            (digest, seed, measures)
            for digest in store.configs()
            for seed, measures in store.measures(digest, range(1000)).items()
        ]


@contextmanager
def watched(*args: str, cwd: Path) -> Iterator[subprocess.Popen[str]]:
    """A `rapc` command that runs in a process group of its own.

    What it says on standard error can be read line by line.
    """
    with subprocess.Popen(
        [COMMAND, *args],
        cwd=cwd,
        env={"PATH": "", "LANG": "C.UTF-8", **HOME},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def on_a_terminal(*args: str, cwd: Path, columns: int) -> str:
    """What a `rapc` command shows on a terminal of so many columns."""
    leader, follower = pty.openpty()
    termios.tcsetwinsize(follower, (40, columns))
    with subprocess.Popen(
        [COMMAND, *args],
        cwd=cwd,
        env={"PATH": "", "LANG": "C.UTF-8", "TERM": "xterm", **HOME},
        stdin=follower,
        stdout=follower,
        stderr=follower,
    ):
        os.close(follower)
        shown = b""
        with suppress(OSError):  # that is how a terminal ends
            while data := os.read(leader, 65536):
                shown += data
    os.close(leader)
    return shown.decode()


def wait_for(process: subprocess.Popen[str], word: str, times: int = 1) -> str:
    """Read what a process says on standard error up to some line with a word."""
    assert process.stderr is not None
    for line in process.stderr:
        times -= word in line
        if not times:
            return line
    raise AssertionError(f"the process ended without saying `{word}` so often")
