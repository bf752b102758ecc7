"""`rapc experiment` where something is wrong: what is told, and what is kept."""

from __future__ import annotations

import re
import shlex
import signal
import sqlite3
from pathlib import Path

import pytest

from tests.cli.command import PATIENCE, rapc
from tests.effort import first

from .small_experiment import TRUCK, rows, wait_for, watched

pytestmark = pytest.mark.xdist_group("experiment")

NAPS = """\
world = "naps:Naps"
library = "naps.rap"
tasks = ["(nap-well)"]
until = 100
seeds = 1
time-limit = 20
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
import os, signal, sys
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
        while self.how == "for-ever":
            print("napping", file=sys.stderr, flush=True)
            signal.pause()
        return Reply("okay")
    def next_time(self): return None
    def advance(self, to): self.time = to
    def messages(self): return []
'''


@pytest.fixture
def naps(tmp_path: Path) -> Path:
    for name, text in (("toml", NAPS), ("rap", NAPS_RAP), ("py", NAPS_PY)):
        (tmp_path / f"naps.{name}").write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("tasks.md", "a table of results"),
        ("tables.md", "a table of results"),
        ("commands.txt", "a list of commands"),
        ("naps.svg", "an SVG picture"),
        ("naps.png", "a PNG picture"),
    ],
)
def test_a_file_of_the_user_in_the_folder_is_kept(
    naps: Path, name: str, kind: str
) -> None:
    """Before any run is begun."""
    (naps / name).write_text("# Mine\nas this\n")
    done = rapc("experiment", "naps.toml", "--out", ".", cwd=naps)
    assert (done.returncode, done.stdout) == (2, "")
    said = f"error: cannot write `{name}`: the file is not {kind}\n"
    assert done.stderr.startswith(said)
    assert (naps / name).read_text() == "# Mine\nas this\n"
    assert not (naps / "results.sqlite").exists()


@pytest.mark.slow
def test_failed_runs_are_reported_and_others_kept(naps: Path) -> None:
    done = rapc("experiment", "naps.toml", "--jobs", "2", cwd=naps)
    assert done.returncode == 1
    assert re.search(r"^well +1 +0 +2 +1\.0 ", done.stdout, re.M)
    assert re.search(r"^killed +0/1 +0 +- ", done.stdout, re.M)
    faults = re.findall(
        r"^error: run without a result: part `naps`, naps.how (\S+), seed 0: (.*)\n"
        r"  to repeat the run: (.*)$",
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


@pytest.mark.parametrize("number", first(1, [signal.SIGKILL, signal.SIGTERM]))
def test_killed_command_leaves_no_process(naps: Path, number: signal.Signals) -> None:
    """The processes that it has started have its standard error, whose end they are."""
    text = re.sub(r"values = .*", 'values = ["for-ever"]', NAPS)
    text = text.replace("seeds = 1", "seeds = 2").replace("limit = 20", "limit = 9999")
    (naps / "naps.toml").write_text(text)
    with watched("experiment", "naps.toml", "--jobs", "2", cwd=naps) as process:
        wait_for(process, "napping", 2)
        process.send_signal(number)
        process.communicate(timeout=PATIENCE)
    assert process.returncode == -number


@pytest.mark.slow
def test_without_matplotlib_there_are_tables(truck: Path) -> None:
    """A module that cannot be imported stands in for one that is not installed."""
    blocked = "raise ModuleNotFoundError(name='matplotlib')\n"
    (truck / "matplotlib.py").write_text(blocked)
    args = ("experiment", "truck.toml", "--part", "usual", "--seeds", "1")
    done = rapc(*args, cwd=truck, PYTHONPATH=str(truck))
    assert (done.returncode, done.stderr) == (
        0,
        "plots not drawn: install `rapc[viz]`\n",
    )
    assert (truck / "truck-results" / "tables.md").exists()


@pytest.mark.slow
def test_unwritable_or_unreadable_results(copied: Path) -> None:
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
        "0 of 4 runs finished; run the command again for the rest\n"
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
            "error: unknown experiment `chapter`\n  did you mean `chapter6`?\n",
        ),
        (["none.toml"], "error: cannot read `none.toml`: missing file or folder\n"),
        (
            ["truck.toml", "--part", "drop"],
            "error: the experiment `truck` has no part `drop`\n"
            "  did you mean `drops`?\n",
        ),
        (["truck.toml", "--seeds", "0"], "error: --seeds: 0 is not in the range"),
        (
            ["truck.toml", "--out", "truck.toml"],
            "error: cannot create `truck.toml`: the file exists\n",
        ),
        (
            ["truck.toml", "--out", "truck.toml/x"],
            "error: cannot create `truck.toml/x`: a part of the path is a file\n",
        ),
        (["bad.toml"], "error: bad.toml: unknown key `worlds`\n  did you mean"),
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
            "error: cannot combine --jobs and --cluster\n",
        ),
    ],
)
def test_untestable_input_exits_2(truck: Path, args: list[str], told: str) -> None:
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


@pytest.mark.slow
def test_unwritable_tables_are_printed(copied: Path) -> None:
    (copied / "out" / "tables.md").unlink()
    (copied / "out" / "tables.md").symlink_to("/dev/full")
    done = rapc("experiment", "truck.toml", "--out", "out", cwd=copied)
    assert done.returncode == 2
    assert done.stderr == "error: cannot write in `out`: no space left on device\n"
    printed = (copied / "printed").read_text()
    assert done.stdout == printed.removesuffix("results, tables and plots: `out`\n")
