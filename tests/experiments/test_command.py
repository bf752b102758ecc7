"""`rapc experiment` as a command: what it prints and keeps, and how it may end."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rapc.experiments.store import sole_user
from tests.cli.command import rapc
from tests.effort import first

from .small_experiment import CHECKOUT, on_a_terminal, rows, session, wait_for, watched

pytestmark = pytest.mark.xdist_group("experiment")


def test_tables_and_plots_are_printed_without_colours(finished: Path) -> None:
    printed = (finished / "printed").read_text()
    assert "\x1b" not in printed
    assert "\nThe first arm drops more and more (part `drops`)\n" in "\n" + printed
    head = "arm1-drops +runs +disasters +time each +completed +effector +sensor +failed"
    assert re.search(rf"^{head}", printed, re.M)
    assert re.search(r"^0 +5 +0 +\d+ ± \d+ +2\.0 ± 0\.0 +\d+ ± \d+ ", printed, re.M)
    assert re.search(r"^40 +5 +0 +\d+ ± \d+ / 450 !? +2\.0 ± 0\.0 / 2 ", printed, re.M)
    assert "The more drops, the longer it takes." in printed
    assert re.search(r"^40 .*\|-+o-+\|? .*x +\d+$", printed, re.M)
    assert max(map(len, printed.splitlines())) <= 120


def test_folder_contents_after_a_run(finished: Path) -> None:
    left = sorted(file.name for file in (finished / "out").iterdir())
    assert left == [
        "commands.txt",
        "drops.png",
        "drops.svg",
        "results.sqlite",
        "slow.png",
        "slow.svg",
        "tables.md",
        "tasks.md",
    ]
    tables = (finished / "out" / "tables.md").read_text()
    assert tables.startswith("## Two rocks while arms drop things\n\n### The first arm")
    assert re.search(r"^\| 40 \| 5 \| 0 \| \d+-\d+ .*\| \d+ / 900 \|", tables, re.M)
    tasks = (finished / "out" / "tasks.md").read_text()
    assert "\narm1-drops 40:\n" in tasks
    assert re.search(r"^\| \(fill-order blue 1 factory-2\) \| 5 \| \d+ ", tasks, re.M)
    assert "(part `drops`)](drops.svg)" in tables
    assert len(rows(finished / "out")) == 4 * 5


def test_a_finished_batch_is_not_run_again(copied: Path) -> None:
    args = ("experiment", "truck.toml", "--out", "out")
    again = rapc("-v", *args, cwd=copied)
    assert "\n0 runs are missing\n" in again.stderr
    assert again.stdout == (copied / "printed").read_text()


def test_fewer_seeds_and_single_parts(copied: Path) -> None:
    args = ("experiment", "truck.toml", "--out", "out", "--part", "slow")
    done = rapc("-v", *args, "--seeds", "3", cwd=copied)
    assert "\n0 runs are missing\n" in done.stderr
    assert "part `drops`" not in done.stdout
    assert re.search(r"^2 +3 +0 ", done.stdout, re.M)
    assert "(part `drops`)" in (copied / "out" / "tables.md").read_text()


def test_on_a_narrow_terminal_there_is_a_bar_and_nothing_is_too_wide(
    truck: Path,
) -> None:
    args = ("experiment", "truck.toml", "--seeds", "1", "--part", "drops")
    shown = on_a_terminal(*args, cwd=truck, columns=50)
    bar, _, tables = shown.partition("The first arm")
    assert "0/2" in bar
    assert "\x1b[4m" in tables
    lines = re.sub(r"\x1b\[[0-9;]*m", "", tables).splitlines()
    assert max(map(len, lines)) <= 50
    assert sum(line.startswith("arm1-drops ") for line in lines) == 2


def test_a_run_is_repeated_by_hand(finished: Path) -> None:
    lines = (finished / "out" / "commands.txt").read_text().splitlines()
    command = lines[lines.index("# slow 4") + 1].replace("--seed 0", "--seed 3")
    done = rapc(*shlex.split(command)[1:], "-q", cwd=finished)
    found = re.search(
        r"\(done\) at time ([\d.]+) .*Primitives: (\d+) .*, of which (\d+) failed",
        done.stdout,
        re.S,
    )
    assert found
    [point] = [p for p in session(parts=["slow"]).points if p.value == 4]
    [measures] = [
        m for d, seed, m in rows(finished / "out") if (d, seed) == (point.digest, 3)
    ]
    primitives = measures.effector + measures.sensor
    told = (measures.time, primitives, measures.failed)
    assert (float(found[1]), int(found[2]), int(found[3])) == told


WITHOUT_END = ("--seeds", "50000")
"""So many runs that a command is not done before it is interrupted, however late."""

INTERRUPTED = (
    r"error: interrupted: (\d+) of 200000 runs finished; run the command again for the "
    r"rest\n"
)
"""What is said of it then."""


@pytest.mark.slow
def test_killed_and_started_again_it_does_the_rest(finished: Path, truck: Path) -> None:
    args = ("-v", "experiment", "truck.toml", "--out", "out", "--jobs", "2")
    with watched(*args, *WITHOUT_END, cwd=truck) as process:
        wait_for(process, "done in", 6)
        process.kill()
        assert process.wait() == -signal.SIGKILL
    done = [seed for _, seed, _ in rows(truck / "out")]
    assert len(done) >= 6
    wanted = max(5, 2 + max(done))
    again = rapc(*args, "--seeds", str(wanted), cwd=truck)
    assert again.returncode == 0
    assert f"\n{4 * wanted - len(done)} runs are missing\n" in again.stderr
    assert len(rows(truck / "out")) == 4 * wanted
    assert "\n0 runs are missing\n" in rapc(*args, cwd=truck).stderr
    kept = [row for row in rows(truck / "out") if row[1] < 5]
    assert kept == rows(finished / "out")
    for name in ("tables.md", "drops.svg", "drops.png", "slow.svg"):
        theirs = (finished / "out" / name).read_bytes()
        assert (truck / "out" / name).read_bytes() == theirs


def test_ctrl_c_keeps_finished_results(truck: Path) -> None:
    args = ("-v", "experiment", "truck.toml", "--out", "out", "--jobs", "2")
    with watched(*args, *WITHOUT_END, cwd=truck) as process:
        wait_for(process, "done in", 3)
        os.killpg(process.pid, signal.SIGINT)
        last = wait_for(process, "interrupted: ")
        assert process.stderr is not None
        assert process.stderr.read() == ""
        assert process.wait() == 130
    told = re.fullmatch(INTERRUPTED, last)
    assert told
    assert len(rows(truck / "out")) == int(told[1])


@pytest.mark.parametrize("jobs", first(1, ["1", "2", "3", "4", "5", "6"]))
def test_ctrl_c_while_processes_are_started(truck: Path, jobs: str) -> None:
    """It reaches all processes: one says so, in a line."""
    args = ("-v", "experiment", "truck.toml", "--out", "out", "--jobs", jobs)
    with watched(*args, *WITHOUT_END, cwd=truck) as process:
        wait_for(process, "runs are missing")
        os.killpg(process.pid, signal.SIGINT)
        _, told = process.communicate()
    assert process.returncode == 130
    assert re.fullmatch(rf"(part .*: done in .*\n)*{INTERRUPTED}", told)


def test_a_folder_in_use_is_left_alone(truck: Path) -> None:
    args = ("experiment", "truck.toml", "--out", "out", "--jobs", "1")
    (truck / "out").mkdir()
    with sole_user(truck / "out"):
        done = rapc(*args, cwd=truck)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "error: `out` is in use by another `rapc experiment`: try again when it has "
        "ended, or give another folder with --out\n"
    )
    assert list((truck / "out").iterdir()) == []


def test_two_can_make_a_file_of_results_at_once(tmp_path: Path) -> None:
    """As they may where a folder cannot be locked."""
    file = str(tmp_path / "results.sqlite")
    code = (
        "import sys, threading; from pathlib import Path\n"
        "from rapc.experiments.store import Store\n"
        "sys.stdin.readline()\n"
        f"for _ in range(20): Store(Path({file!r})).__exit__(None, None, None)\n"
    )
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", code],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(4)
    ]
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    assert [process.communicate()[1] for process in processes] == [""] * 4


def test_help_imports_nothing_of_it() -> None:
    code = (
        "import sys\n"
        "from rapc.cli.main import main\n"
        "try: main(['-h'])\n"
        "except SystemExit: pass\n"
        "heavy = ['pebble', 'matplotlib', 'distributed', 'rapc.experiments']\n"
        "print([name for name in heavy if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines()[-1] == "[]"


SHIFT = """\
library = "slow"
world = "courier"
agenda = "shift"
until = 3000
[[part]]
name = "shift"
"""


def test_changes_against_another_library_are_printed(tmp_path: Path) -> None:
    courier = CHECKOUT / "examples" / "courier"
    (tmp_path / "slow").mkdir()
    for file in courier.glob("*.rap"):
        text = file.read_text().replace("(< ?level 48)", "(< ?level 85)")
        (tmp_path / "slow" / file.name).write_text(text)
    (tmp_path / "shift.toml").write_text(SHIFT)
    run = ("experiment", "shift.toml", "--out", "out", "--seeds", "3", "--against")
    done = rapc(*run, str(courier), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    told = done.stdout.partition(f"part `shift`: {courier} and slow\n")[2].splitlines()
    assert re.match(
        r"time: before \d+.*, after \d+.* \(\+\d+\.\d ± \d+\.\d %\)", told[0]
    )
    assert told[1] == "tasks succeeded: before 3, after 0 (-100.0 %)"
    assert re.match(r"slower in \d of 3 seeds, faster in \d, equal ", told[2])
    row = r"waiting +monitor of stay-until-charged +\d+.* \+\d+"
    assert any(re.match(row, line) for line in told)
    again = rapc("-v", *run, str(courier), cwd=tmp_path)
    assert "\n0 runs are missing\n" in again.stderr
    assert again.stdout == done.stdout


def test_coverage_of_all_runs_is_the_sum(tmp_path: Path) -> None:
    courier = CHECKOUT / "examples" / "courier"
    (tmp_path / "shift.toml").write_text(SHIFT.replace("slow", str(courier)))
    run = ("experiment", "shift.toml", "--out", "out", "--coverage", "c.json")
    counts = []
    for seeds in ("1", "3", "3"):
        done = rapc(*run, "--seeds", seeds, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        found = json.loads((tmp_path / "c.json").read_text())
        [calls] = [f for f in found["files"] if f["file"].endswith("calls.rap")]
        [helped] = [rap for rap in calls["raps"] if rap["name"] == "be-of-help"]
        counts.append((helped["row"], helped["succeeded"]))
    (row, once), three, again = counts
    assert (row, once > 0, three[1] > once, three == again) == (33, True, True, True)
    assert "\ncoverage                  methods     true" in done.stdout
    assert "tasks failed: " in done.stdout


def test_options_that_exclude_coverage(tmp_path: Path) -> None:
    (tmp_path / "shift.toml").write_text(SHIFT)
    for more, why in (
        (("--coverage", "--against", "slow"), "--coverage and --against"),
        (("--coverage", "--cluster", "tcp://a"), "--coverage and --cluster"),
        (("--coverage", "table.txt"), "must end with .json"),
    ):
        done = rapc("experiment", "shift.toml", *more, cwd=tmp_path)
        assert (done.returncode, why in done.stderr) == (2, True)
