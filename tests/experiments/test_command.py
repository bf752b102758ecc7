"""`rapc experiment` as a command: what it prints and keeps, and how it may end."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from rapc.experiments.store import sole_user
from tests.cli.command import rapc
from tests.effort import first

from .small_experiment import TRUCK, on_a_terminal, rows, session, wait_for, watched

pytestmark = pytest.mark.xdist_group("experiment")

NAPS = """\
world = "naps:Naps"
library = "naps.rap"
tasks = ["(nap-well)"]
until = 100
seeds = 1
time-limit = 4
[[part]]
name = "naps"
vary = "naps.how"
values = ["well", "killed", "for-ever", "error"]
"""

NAPS_RAP = """\
(declare-primitive nap () (okay))
(define-rap (nap-well) (method (primitive (nap))))
"""

NAPS_PY = '''\
import os, signal
from rapc.world import Handlers, Kit, Offer, Option, Reply, World

class Naps(World):
    """Naps, from some of which nobody wakes."""
    name = "naps"
    def __init__(self, rng, options):
        self.time, self.how = 0, options["how"]
    kit = Kit(
        Offer({"nap": (0, ("okay",))}),
        options=(Option("how", "symbol", "well", "", "how it goes"),),
    )
    def now(self): return self.time
    def perform(self, ticket, request):
        self.time += 2
        if self.how == "killed": os.kill(os.getpid(), signal.SIGKILL)
        if self.how == "error": raise KeyError("pillow")
        while self.how == "for-ever": pass
        return Reply("okay")
    def next_time(self): return None
    def advance(self, to): self.time = to
    def messages(self): return []
'''


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small experiment that has been run, in `out`."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "truck.toml").write_text(TRUCK)
    done = rapc("experiment", "truck.toml", "--out", "out", "--jobs", "2", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    (folder / "printed").write_text(done.stdout)
    return folder


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    """A copy of that folder, to be worked on."""
    return shutil.copytree(finished, tmp_path / "copied")


@pytest.fixture
def truck(tmp_path: Path) -> Path:
    """A folder with the same experiment, not yet run."""
    (tmp_path / "truck.toml").write_text(TRUCK)
    return tmp_path


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


def test_what_is_left_in_the_folder(finished: Path) -> None:
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
        r"\(done\) at time ([\d.]+) .*Primitives: (\d+), of which (\d+) failed",
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


@pytest.mark.slow
def test_killed_and_started_again_it_does_the_rest(finished: Path, truck: Path) -> None:
    args = ("-v", "experiment", "truck.toml", "--out", "out", "--jobs", "2")
    with watched(*args, cwd=truck) as process:
        wait_for(process, "done in", 6)
        process.kill()
        assert process.wait() == -signal.SIGKILL
    before = len(rows(truck / "out"))
    assert 6 <= before < 20
    again = rapc(*args, cwd=truck)
    assert again.returncode == 0
    assert f"\n{20 - before} runs are missing\n" in again.stderr
    assert rows(truck / "out") == rows(finished / "out")
    for name in ("tables.md", "drops.svg", "drops.png", "slow.svg"):
        theirs = (finished / "out" / name).read_bytes()
        assert (truck / "out" / name).read_bytes() == theirs


def test_ctrl_c_keeps_what_there_is(truck: Path) -> None:
    args = ("-v", "experiment", "truck.toml", "--out", "out", "--jobs", "2")
    with watched(*args, cwd=truck) as process:
        wait_for(process, "done in", 3)
        os.killpg(process.pid, signal.SIGINT)
        last = wait_for(process, "interrupted: ")
        assert process.stderr is not None
        assert process.stderr.read() == ""
        assert process.wait() == 130
    told = re.fullmatch(
        r"error: interrupted: (\d+) of 20 runs are done, the same command does the "
        r"others\n",
        last,
    )
    assert told
    assert len(rows(truck / "out")) == int(told[1])


@pytest.mark.parametrize("jobs", first(1, ["1", "2", "3", "4", "5", "6"]))
def test_ctrl_c_while_processes_are_started(truck: Path, jobs: str) -> None:
    """It reaches all processes: one says so, in a line."""
    args = ("-v", "experiment", "truck.toml", "--out", "out", "--jobs", jobs)
    with watched(*args, cwd=truck) as process:
        wait_for(process, "runs are missing")
        os.killpg(process.pid, signal.SIGINT)
        _, told = process.communicate()
    assert process.returncode == 130
    assert re.fullmatch(
        r"error: interrupted: \d+ of 20 runs are done, the same command does the "
        r"others\n",
        told,
    )


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


@pytest.fixture
def naps(tmp_path: Path) -> Path:
    for name, text in (("toml", NAPS), ("rap", NAPS_RAP), ("py", NAPS_PY)):
        (tmp_path / f"naps.{name}").write_text(text)
    return tmp_path


@pytest.mark.slow
def test_runs_that_fail_are_told_and_the_others_kept(naps: Path) -> None:
    done = rapc("experiment", "naps.toml", "--jobs", "2", cwd=naps)
    assert done.returncode == 1
    assert re.search(r"^well +1 +0 +2 +1\.0 ", done.stdout, re.M)
    assert re.search(r"^killed +0/1 +0 +- ", done.stdout, re.M)
    faults = re.findall(
        r"^error: a run has no result: part `naps`, naps.how (\S+), seed 0: (.*)\n"
        r"  to see it again: (.*)$",
        done.stderr,
        re.M,
    )
    reasons = {how: reason for how, reason, _ in faults}
    assert sorted(reasons) == ["error", "for-ever", "killed"]
    told = "PortError: the world `naps` failed at naps.py:17: KeyError: 'pillow'"
    assert reasons["error"] == told
    assert reasons["for-ever"] == "it took longer than the time limit"
    assert reasons["killed"].startswith("its worker was lost 3 times, at last with ")
    [command] = [command for how, _, command in faults if how == "error"]
    again = rapc(*shlex.split(command)[1:], cwd=naps)
    assert again.returncode == 2
    assert "KeyError: 'pillow'" in again.stderr
    assert [seed for _, seed, _ in rows(naps / "naps-results")] == [0]


@pytest.mark.slow
def test_without_matplotlib_there_are_tables(truck: Path) -> None:
    """A module that cannot be imported stands in for one that is not installed."""
    blocked = "raise ModuleNotFoundError(name='matplotlib')\n"
    (truck / "matplotlib.py").write_text(blocked)
    args = ("experiment", "truck.toml", "--part", "usual", "--seeds", "1")
    done = rapc(*args, cwd=truck, PYTHONPATH=str(truck))
    assert (done.returncode, done.stderr) == (
        0,
        "no plots: install `rapc[viz]` to have them drawn\n",
    )
    assert (truck / "truck-results" / "tables.md").exists()


@pytest.mark.slow
def test_results_that_cannot_be_kept_or_read(copied: Path) -> None:
    args = ("experiment", "truck.toml", "--out", "out", "--jobs", "1")
    file = copied / "out" / "results.sqlite"
    base = sqlite3.connect(file)
    base.execute("delete from result where seed = 4")
    base.execute(
        "create trigger full before insert on result "
        "begin select raise(abort, 'no room'); end"
    )
    base.commit()
    done = rapc(*args, cwd=copied)
    assert done.returncode == 1
    assert done.stderr == (
        "error: `out/results.sqlite` cannot be used: no room: "
        "0 of 4 runs are done, the same command does the others\n"
    )
    base.execute("drop trigger full")
    base.execute("update result set counts = '3'")
    base.commit()
    base.close()
    done = rapc(*args, cwd=copied)
    assert done.returncode == 2
    assert done.stderr.startswith("error: `out/results.sqlite` cannot be used: Expec")


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (
            ["chapter"],
            "error: there is no experiment `chapter`\n  did you mean `chapter6`?\n",
        ),
        (["none.toml"], "error: cannot read `none.toml`: no such file or directory\n"),
        (
            ["truck.toml", "--part", "drop"],
            "error: the experiment `truck` has no part `drop`\n"
            "  did you mean `drops`?\n",
        ),
        (["truck.toml", "--seeds", "0"], "error: invalid value for '--seeds': "),
        (["truck.toml", "--out", "truck.toml/x"], "error: cannot make `truck.toml/x`"),
        (["bad.toml"], "error: bad.toml: there is no key `worlds`\n  did you mean"),
        (
            ["truck.toml", "--out", "base"],
            "error: `base/results.sqlite` cannot be used",
        ),
        (
            ["truck.toml", "--cluster", "tcp://127.0.0.1:1"],
            "error: no Dask scheduler answers at `tcp://127.0.0.1:1`\n",
        ),
        (
            ["truck.toml", "--cluster", "x", "--jobs", "1"],
            "error: --jobs is for this machine, --cluster for others\n",
        ),
    ],
)
def test_what_cannot_be_tried_exits_2(truck: Path, args: list[str], told: str) -> None:
    (truck / "bad.toml").write_text(TRUCK.replace("world =", "worlds ="))
    (truck / "base").mkdir()
    (truck / "base" / "results.sqlite").write_text("no database at all" * 100)
    done = rapc("experiment", *args, cwd=truck)
    assert done.returncode == 2
    assert done.stderr.startswith(told)
    assert done.stdout == ""


def test_a_library_with_errors_is_not_run(truck: Path) -> None:
    (truck / "bad.rap").write_text("(define-rap (x) (method (primitive (y))))")
    library = re.sub(r"library = .*", 'library = "bad.rap"', TRUCK)
    (truck / "bad.toml").write_text(library)
    done = rapc("experiment", "bad.toml", cwd=truck)
    assert done.returncode == 2
    assert "bad.rap:1:" in done.stdout


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


@pytest.mark.slow
def test_tables_that_cannot_be_written_are_printed_all_the_same(copied: Path) -> None:
    (copied / "out" / "tables.md").unlink()
    (copied / "out" / "tables.md").mkdir()
    done = rapc("experiment", "truck.toml", "--out", "out", cwd=copied)
    assert done.returncode == 2
    assert done.stderr == "error: cannot write in `out`: is a directory\n"
    printed = (copied / "printed").read_text()
    assert done.stdout == printed.removesuffix(
        "Results, tables and plots are in `out`.\n"
    )
