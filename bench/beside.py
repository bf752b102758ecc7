"""rapc beside its peers: one run, the targets judged, a table and a chart.

    python -m bench.beside --peers PEERS.PY     measure, judge, write
    python -m bench.beside                      write again what was measured last

On a machine that others use, set the clock of PEERS.PY to processor time and add
`--shared`: then only ratios are judged.

PEERS.PY is a script that measures other systems and `bench/rapc_adapter.py` on five
workloads; it is not part of rapc. It is run by the Python that runs this, which has to
have the peers installed, and matplotlib. A file `baseline.json` beside it has figures
of peers that are not installed. What the script cannot see is measured by `bench.costs`
right before it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from textwrap import fill
from typing import Any

import msgspec

from bench.chart import draw
from bench.costs import costs
from bench.profiles import text
from bench.results import YARDSTICK, Results, from_script, noise
from bench.run import machine
from bench.targets import table

CHECKOUT = Path(__file__).parents[1]
ADAPTER = CHECKOUT / "bench" / "rapc_adapter.py"
GENERATE = CHECKOUT / "docs" / "generate.py"
FIGURES = CHECKOUT / "docs" / "figures"

PEERS = {
    "W1": "hand,hand+pos,rapc,rapc-ir,rapc-load,clips",
    "W2": "hand,rapc,swipl,sqlite3",
    "W3": "hand,rapc,rapc-traced,rapc-written,py_trees,agentspeak,clips,swipl",
    "W4": "hand,hand+agenda,rapc,rapc-traced,rapc-written,rapc-inputs,py_trees,"
    "agentspeak,clips",
}
"""Who is measured at what; W5 is seen in W3."""

ELSEWHERE = {
    "W1": ("jason", YARDSTICK),
    "W3": ("jason", "bt.cpp", YARDSTICK),
    "W4": ("jason", "bt.cpp", YARDSTICK),
}
"""Whose figures from elsewhere are shown, and what they are scaled by."""

SHARED = "Ratios of processor time: other jobs ran on the machine."

SLOWNESS = (
    "The yardstick of W3 took {:.2g} times as long as in the figures from elsewhere."
)

WIDTH = 90
"""How long a line of the page is."""

TIMEOUT = 75
"""Seconds for one measurement; what takes longer has no figure."""


def main() -> None:
    """Read the command line, measure if asked to, and write."""
    parser = argparse.ArgumentParser(description="rapc beside its peers.")
    parser.add_argument("--peers", type=Path, help="the script that measures peers")
    parser.add_argument("--quick", action="store_true", help="small sizes, to try it")
    parser.add_argument(
        "--shared", action="store_true", help="judge only ratios: other jobs run, too"
    )
    parser.add_argument(
        "--out", type=Path, help="folder for figures and table instead of docs/"
    )
    args = parser.parse_args()
    if args.quick and args.out is None:
        parser.error("--quick wants --out: its figures are not for docs/")
    folder: Path = args.out or FIGURES
    folder.mkdir(parents=True, exist_ok=True)
    kept = folder / "beside.json"
    if args.peers is None:
        results = read(kept)
    else:
        results = measured(args.peers.resolve(), args.quick)
        results = msgspec.structs.replace(results, shared=args.shared)
        told_all = msgspec.json.format(msgspec.json.encode(results), indent=1)
        kept.write_bytes(told_all + b"\n")
    print(told(results))
    draw(results, folder / "beside")
    if args.out is None:
        subprocess.run([sys.executable, GENERATE], check=True)


def read(file: Path) -> Results:
    """Return stored results."""
    return msgspec.json.decode(file.read_bytes(), type=Results)


def measured(script: Path, quick: bool) -> Results:
    """Measure what the peers' script cannot, then run it for each workload."""
    found = costs(quick)
    parts = [compared(script, workload, quick) for workload in PEERS]
    baseline = script.with_name("baseline.json")
    elsewhere = json.loads(baseline.read_bytes()) if baseline.exists() else {}

    versions = {
        name: peer["version"] for told in parts for name, peer in told["peers"].items()
    }
    return Results(
        datetime.now(UTC).date().isoformat(),
        f"{machine()}, rapc {_made()}",
        dict(sorted(versions.items())),
        noise(parts),
        tuple(one for told in parts for one in from_script(told)),
        tuple(
            one
            for one in from_script({"results": elsewhere.get("results", ())})
            if one.figures and one.peer in ELSEWHERE.get(one.workload, ())
        ),
        found,
        text(quick),
    )


def _made() -> str:
    """Whether the modules of a cycle have been compiled."""
    crank = find_spec("rapc.runtime.interpreter")
    assert crank is not None
    return "in pure Python" if (crank.origin or "").endswith(".py") else "compiled"


def compared(script: Path, workload: str, quick: bool) -> Mapping[str, Any]:
    """What the script reports of one workload; its own output is shown meanwhile.

    Raises:
        SystemExit: if the script leaves out a class of the adapter.
    """
    paths = [str(CHECKOUT), os.environ.get("PYTHONPATH", "")]
    environment = {
        **os.environ,
        "RAPC_ADAPTER": str(ADAPTER),
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "told.json")
        command = [sys.executable, str(script), "--workloads", workload]
        command += ["--peers", PEERS[workload], "--json", str(file)]
        command += ["--quick"] if quick else ["--timeout", str(TIMEOUT)]
        subprocess.run(command, env=environment, cwd=folder, check=True)
        told: Mapping[str, Any] = json.loads(file.read_bytes())
    names = PEERS[workload].split(",")
    out = [n for n in names if n.startswith("rapc") and n not in told["peers"]]
    if out:
        raise SystemExit(f"{script.name} left out {', '.join(out)} in {workload}")
    return told


def told(results: Results) -> str:
    """What the page says of a measurement: where and when, and the targets."""
    slowness = results.slowness("W3", 1000, "fire")
    names = ", ".join(
        f"{name} {version}"
        for name, version in results.versions.items()
        if not name.startswith(("rapc", YARDSTICK))
    )
    where = [
        f"Taken on {results.day} with {results.machine}, beside {names}.",
        f"Samples of one figure lie {results.noise:.0%} apart (median of all).",
        *([SHARED] if results.shared else []),
        *([] if slowness is None else [SLOWNESS.format(slowness)]),
    ]
    return "\n".join([fill(" ".join(where), WIDTH), "", *table(results), ""])


if __name__ == "__main__":
    main()
