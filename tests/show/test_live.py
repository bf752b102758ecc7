"""`rapc run --show`: frames on a terminal, the last one elsewhere, and its refusals."""

from __future__ import annotations

import io
import os
import pty
import re
import signal
import subprocess
import sys
import termios
from contextlib import suppress
from pathlib import Path

import pytest

import rapc
from rapc.console.show.live import LiveView
from rapc.world import Drawable
from tests.cli.command import BARE, COMMAND
from tests.cli.command import rapc as command

CHECKOUT = Path(__file__).parents[2]
EXAMPLE = CHECKOUT / "examples" / "rock-order.rap"
RUN = (str(EXAMPLE), "--world", "truck", "--task", "(rock-order red 2)", "--seed", "7")
ALTERNATE_ON, ALTERNATE_OFF = "\x1b[?1049h", "\x1b[?1049l"
LEGEND = "= as believed   ≠ what is believed instead\n"


class Terminal(io.StringIO):
    """What says that it is a terminal."""

    def isatty(self) -> bool:
        return True


def _show(stream: io.StringIO, *, color: bool, until: int = 30, every: int = 0) -> str:
    world = rapc.open_world("truck", seed=7)
    run = rapc.Interpreter(rapc.load(EXAMPLE).program, world, 7)
    assert isinstance(world, Drawable)
    view = LiveView(
        run, world.picture, stream, lambda: (80, 24), color=color, every=every, pace=0
    )
    with view:
        run.listen(view)
        run.submit("(rock-order red 2)")
        run.run(until=until)
    return stream.getvalue()


def test_a_terminal_gets_a_frame_for_each_request_and_keeps_the_last() -> None:
    shown = _show(Terminal(), color=False)
    live, last = shown.split(ALTERNATE_OFF)
    assert live.startswith(ALTERNATE_ON)
    drawn = re.findall(r"\n  (\([^)]+\)) - okay", live)
    assert len(set(drawn)) > 2
    assert last.endswith(LEGEND)


def test_elsewhere_there_is_the_last_frame_alone() -> None:
    shown = _show(io.StringIO(), color=False)
    assert shown.startswith("time 30 ")
    assert shown.count("\n") == 24
    assert "\x1b" not in shown


def test_every_so_many_frames_follow_one_another() -> None:
    every, alone = (
        _show(io.StringIO(), color=False, until=90, every=n) for n in (3, 0)
    )
    times = re.findall(r"^time ([\d.]+) ", every, re.M)
    assert len(times) > 2
    assert times == sorted(times, key=float)
    assert every.endswith("\n\n" + alone)
    assert every.count("\n") == 24 * len(times) + len(times) - 1


def test_how_often_to_show_is_said_of_a_show() -> None:
    done = command("run", *RUN, "--show-every", "3")
    assert done.returncode == 2
    assert "--show-every requires --show" in done.stderr


def test_colour_tells_right_from_unknown() -> None:
    """After its first trips the truck stands at the quarry, and sees the rocks."""
    shown = _show(io.StringIO(), color=True, until=150)
    assert re.search(r"\x1b\[33m≠ nothing", shown)
    assert re.search(r"\x1b\[32m=", shown)


def test_a_piped_run_ends_with_frame_and_report() -> None:
    done = command("run", *RUN, "--show", "--until", "60")
    frame, _ = done.stdout.split("Run over (until)")
    assert (done.returncode, done.stderr) == (1, "")
    assert frame.startswith("time 60 ")
    assert frame.endswith(LEGEND)
    assert frame.count("\n") == 24
    assert "--> considering" not in done.stdout


def test_the_trace_can_be_written_besides(tmp_path: Path) -> None:
    files = [tmp_path / "shown.jsonl", tmp_path / "plain.jsonl"]
    for file, show in zip(files, (["--show"], ["-q"]), strict=True):
        command("run", *RUN, *show, "--until", "60", "--trace", str(file))
    shown, plain = (file.read_bytes() for file in files)
    assert shown == plain


def test_colour_is_as_asked_for() -> None:
    shown = ("run", *RUN, "--show", "--until", "20")
    assert "\x1b" in command(*shown, "--color", "always").stdout
    assert "\x1b" not in command(*shown, "--color", "never").stdout


def test_the_world_is_drawn_behind_faults() -> None:
    fault = "(eye-scan ?) eye-cant-find"
    done = command("run", *RUN, "--show", "--until", "20", "--fault", fault)
    assert "= as believed" in done.stdout
    assert re.search(r"\[[↑↗→↘↓↙←↖][a-z]", done.stdout)


def test_a_world_without_a_picture_is_refused(tmp_path: Path) -> None:
    lamps = CHECKOUT / "tests" / "worlds" / "lamps"
    trace = tmp_path / "trace.jsonl"
    done = command(
        *("run", str(lamps), "--world", "lamps:LampWorld", "--task", "(light-all)"),
        *("--show", "--trace", str(trace)),
        cwd=lamps,
    )
    assert (done.returncode, done.stdout) == (2, "")
    said = "error: cannot show world `lamps:LampWorld`: it has no `picture` method\n"
    assert done.stderr == said
    assert not trace.exists()


def test_a_picture_that_fails_is_blamed_on_its_world(tmp_path: Path) -> None:
    lamps = CHECKOUT / "tests" / "worlds" / "lamps"
    (tmp_path / "dim.py").write_text(
        "from lamps import LampWorld\nclass Dim(LampWorld):\n"
        "    def picture(self):\n        return 1 / 0\n"
    )
    done = command(
        *("run", str(lamps), "--world", "dim:Dim", "--task", "(light-all)", "--show"),
        cwd=tmp_path,
        PYTHONPATH=f"{lamps}:{CHECKOUT}",
    )
    assert (done.returncode, done.stdout) == (2, "")
    said = "error: the world `lamps` failed at dim.py:4: ZeroDivisionError: "
    assert done.stderr == f"{said}division by zero\n"


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_ctrl_c_leaves_the_screen_and_reports() -> None:
    """The run waits for its terminal when nobody reads: it is not done too early."""
    terminal, follower = pty.openpty()
    termios.tcsetwinsize(follower, (24, 80))
    with subprocess.Popen(
        [COMMAND, "run", *RUN, "--show"],
        env={**BARE, "TERM": "xterm"},
        stdin=follower,
        stdout=follower,
        stderr=follower,
    ) as process:
        os.close(follower)
        shown = b""
        while b"- okay" not in shown:
            shown += os.read(terminal, 4096)
        process.send_signal(signal.SIGINT)
        with suppress(OSError):  # the other side has been closed
            while more := os.read(terminal, 4096):
                shown += more
    os.close(terminal)
    text = shown.decode()
    assert process.returncode == 1
    assert "Run over (cancelled)" in text.partition(ALTERNATE_OFF)[2]
    assert "Traceback" not in text
