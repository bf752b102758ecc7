"""rapc beside its peers: what is made of the figures, without the peers themselves."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest

import rapc
from bench.adapter_rows import classes
from bench.beside import (
    ADAPTER,
    PEERS,
    compared,
    told,
)
from bench.child import take
from bench.profiles import LINES, text
from bench.results import Measured, Results, from_script, noise
from bench.targets import DEPTHS, MONITORS, TARGETS, table

CHECKOUT = Path(__file__).parents[1]

SCRIPT = """\
{"peers": {"rapc": {"version": "1"}},
 "results": [
  {"workload": "W3", "peer": "rapc", "params": {"n": 10},
   "figures": {"fire": {"median": 4e-6, "min": 3e-6, "max": 5e-6, "spread": 0.5},
               "setup_s": 0.1, "rss_kb": 9, "bytes_per_monitor": 900}},
  {"workload": "W4", "peer": "rapc", "params": {"b": 3, "d": 8},
   "figures": {"task": {"median": 2e-6, "spread": 0.1}, "tasks_per_s": 5e5}},
  {"workload": "W3", "peer": "agentspeak", "params": {"n": 100000},
   "figures": {"error": "timeout after 75 s"}}]}
"""


def _fire(peer: str, micros: dict[int, float]) -> list[Measured]:
    return [
        Measured("W3", peer, size, {"fire": value * 1e-6})
        for size, value in micros.items()
    ]


def _tasks(peer: str, rate: float) -> list[Measured]:
    return [Measured("W4", peer, depth, {"tasks_per_s": rate}) for depth in DEPTHS]


RESULTS = Results(
    day="2026-11-21",
    machine="a machine",
    versions={"hand": "3.11", "py_trees": "2.6", "rapc": "0.1"},
    noise=0.123,
    measured=(
        *_fire("hand", dict.fromkeys(MONITORS, 2.0)),
        *_fire("rapc", dict.fromkeys(MONITORS, 4.0) | {100: 6.0}),
        *_fire("rapc-traced", dict.fromkeys(MONITORS, 8.0) | {1000: 10.0}),
        *_fire("py_trees", {100_000: 120_000.0}),
        *_tasks("rapc", 300_000.0),
        *_tasks("py_trees", 125_000.0),
    ),
    elsewhere=(
        *_fire("hand", dict.fromkeys(MONITORS, 1.0)),
        *_fire("bt.cpp", {1000: 1.5, 10_000: 800.0, 100_000: 20_000.0}),
        Measured("W3", "jason", 10_000, {"bytes_per_monitor": 4000.0}),
    ),
    costs={"help.wall": 0.11, "help.cpu": 0.1, "truck.peak": 81.0},
    profiles="W3: all of it",
)


def _row(area: str, what: str) -> str:
    [row] = [row for row in table(RESULTS) if row.startswith(f"| {area} | {what} |")]
    return row


def test_the_script_s_medians_are_kept_and_failures_have_none() -> None:
    found = list(from_script(msgspec.json.decode(SCRIPT)))
    assert found == [
        Measured("W3", "rapc", 10, {"fire": 4e-6, "bytes_per_monitor": 900}),
        Measured("W4", "rapc", 8, {"tasks_per_s": 5e5}),
        Measured("W3", "agentspeak", 100_000, {}),
    ]
    assert noise([msgspec.json.decode(SCRIPT)]) == pytest.approx(0.3)


def test_figures_from_elsewhere_are_scaled_by_the_yardstick_but_for_memory() -> None:
    assert RESULTS.at("W3", "bt.cpp", 1000, "fire") == pytest.approx(3e-6)
    assert RESULTS.at("W3", "jason", 10_000, "bytes_per_monitor") == 4000
    assert RESULTS.at("W3", "jason", 10_000, "fire") is None
    assert RESULTS.is_from_elsewhere("bt.cpp")
    assert not RESULTS.is_from_elsewhere("hand")


@pytest.mark.parametrize(
    ("area", "what", "cells"),
    [
        ("W3", "one firing", "6 us | at 100 | at most 5 us | **no**"),
        (
            "W3",
            "one firing, `py_trees` over ours",
            "30,000 x | at 100,000: 120,000 us / 4 us | at least 20,000 x | yes",
        ),
        (
            "W3",
            "one firing, `bt.cpp` over ours",
            "0.75 x | at 1,000: 3 us / 4 us | at least 1 x | **no**",
        ),
        ("W3", "one firing, `jason` over ours", "not measured |  | at least 1 x | "),
        ("W4", "tasks a second", "300,000 /s | at 6 | at least 300,000 /s | yes"),
        (
            "W4",
            "tasks, rate over `py_trees`",
            "2.4 x | at 6: 300,000/s / 125,000/s | at least 2.5 x | **no**",
        ),
        (
            "W5",
            "a dormant task, of 10,000",
            "not measured |  | at most 1,200 bytes | ",
        ),
        (
            "trace",
            "firings a second, events kept over not",
            "0.4 x | at 1,000: 4 us / 10 us | at least 0.5 x | **no**",
        ),
        (
            "start",
            "`rapc --help`",
            "0.11 s | 0.1 s of processor | at most 0.12 s | yes",
        ),
        ("truck", "peak memory of it", "81 MB |  | at most 80 MB | **no**"),
    ],
)
def test_targets_are_judged_at_the_worst_size(area: str, what: str, cells: str) -> None:
    assert _row(area, what) == f"| {area} | {what} | {cells} |"


def test_times_of_a_shared_machine_have_no_row() -> None:
    shared = msgspec.structs.replace(RESULTS, shared=True)
    units = {row.split(" | ")[4].split()[-1] for row in list(table(shared))[2:]}
    assert units == {"x", "bytes", "MB"}
    assert "other jobs ran on the machine" in told(shared).replace("\n", " ")


def test_every_target_has_a_row_of_its_own() -> None:
    rows = list(table(RESULTS))[2:]
    assert len(rows) == len(TARGETS)
    assert len({tuple(row.split(" | ")[:2]) for row in rows}) == len(rows)


@pytest.fixture(scope="module")
def adapter() -> dict[str, Any]:
    """The classes of the adapter, by name."""
    return classes(ADAPTER)


ADAPTER_CLASSES = (
    "Rapc",
    "RapcTraced",
    "RapcWritten",
    "RapcInputs",
    "RapcIr",
    "RapcLoad",
)


@pytest.mark.parametrize("name", ADAPTER_CLASSES)
def test_adapter_is_available(adapter: dict[str, Any], name: str) -> None:
    assert adapter[name]().available() == rapc.__version__


def test_adapter_classes_are_those_measured(adapter: dict[str, Any]) -> None:
    names = {adapter[name].name for name in ADAPTER_CLASSES}
    measured = {name for row in PEERS.values() for name in row.split(",")}
    assert names == {name for name in measured if name.startswith("rapc")}


@pytest.mark.parametrize("name", ["Rapc", "RapcIr", "RapcLoad"])
def test_adapter_reads_all_definitions(adapter: dict[str, Any], name: str) -> None:
    text = adapter["RapcLoad"]().w1_text(4)
    words = 0 if name == "RapcLoad" else text.count("\n(") + 1 - 4
    assert adapter[name]().w1(text) == 4 + words


def test_adapter_answers_from_memory(adapter: dict[str, Any]) -> None:
    made = adapter["Rapc"]()
    made.w2_setup(
        [
            ("small", "here", "rock", "red", 3),
            ("large", "here", "rock", "red", 4),
            ("other", "here", "bush", "red", 9),
            ("away", "there", "rock", "red", 9),
        ]
    )
    assert (made.w2_first("here"), made.w2_all("here")) == ("large", 1)
    assert (made.w2_first("nowhere"), made.w2_all("nowhere")) == (None, 0)


@pytest.mark.parametrize("name", ["Rapc", "RapcTraced", "RapcWritten"])
def test_adapter_wakes_one_monitor_again_and_again(
    adapter: dict[str, Any], name: str
) -> None:
    made = adapter[name]()
    made.fired = 0
    made.w3_setup(5)
    for count in (1, 2, 3):
        made.w3_fire(2)
        assert made.fired == count
    _close(made)


@pytest.mark.parametrize("name", ["Rapc", "RapcTraced", "RapcWritten", "RapcInputs"])
def test_adapter_carries_out_a_tree_of_tasks(
    adapter: dict[str, Any], name: str
) -> None:
    made = adapter[name]()
    made.w4_setup(3, 2)
    assert made.w4_run() == 1 + 3 + 9
    _close(made)


def _close(made: Any) -> None:
    """Close the trace that `RapcWritten` writes."""
    if made.name == "rapc-written":
        made.trace.close()


def test_comparison_without_rapc_is_refused(tmp_path: Path) -> None:
    script = tmp_path / "peers.py"
    script.write_text(
        "import json, sys\n"
        "file = sys.argv[sys.argv.index('--json') + 1]\n"
        "open(file, 'w').write(json.dumps({'peers': {'hand': {}}, 'results': []}))\n"
    )
    with pytest.raises(SystemExit, match="left out rapc, rapc-ir, rapc-load"):
        compared(script, "W1", quick=True)


@pytest.mark.slow
def test_table_and_chart_are_made_again_of_saved_figures(tmp_path: Path) -> None:
    (tmp_path / "beside.json").write_bytes(msgspec.json.encode(RESULTS))
    command = [sys.executable, "-m", "bench.beside", "--out", str(tmp_path)]
    done = subprocess.run(
        command, cwd=CHECKOUT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == told(RESULTS) + "\n"
    assert (tmp_path / "beside.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "beside.svg").read_text(encoding="utf-8").endswith("</svg>\n")


def test_profiles_are_of_the_whole_way_of_a_firing_and_a_task() -> None:
    shares = [float(share) for share in re.findall(r"^ *([\d.]+)% ", text(True), re.M)]
    assert len(shares) == 2 * LINES
    for part in (shares[:LINES], shares[LINES:]):
        assert part == sorted(part, reverse=True)
        assert 30 < sum(part) <= 100
    for name in ("run_loop", "run_cycle", "try_method"):
        assert name in text(True)


def test_a_command_s_costs_are_its_own() -> None:
    spent = [sys.executable, "-c", "x = bytearray(50_000_000); print(len(x) * 'y')"]
    taken = take(spent, {})
    assert taken["cpu"] > 0
    assert taken["wall"] > 0
    assert 50 < taken["peak"] < 200
    with pytest.raises(subprocess.CalledProcessError):
        take([sys.executable, "-c", "raise SystemExit(3)"], {})
