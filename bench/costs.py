"""What rapc itself takes: commands as a person waits for them, and a run of the truck.

The truck's run is that of T 6.3.1, nine orders in the still world: as the command that
`rapc experiment` tells of, from sources and from a compiled library, and in this
process with the library loaded.
"""

from __future__ import annotations

import os
import shlex
import statistics
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from bench import chapter6, compiled
from bench.child import take
from rapc import host
from rapc.library.saved import encode

RAPC = (sys.executable, "-c", "from rapc.cli.start import main; main()")
STDLIB = Path(__file__).parents[1] / "stdlib"

_LOADING = {
    "read and check sources": "sources",
    "read a compiled library": "artifact",
    "the same, and each RAP": "artifact-all",
}


def costs(quick: bool = False) -> dict[str, float]:
    """Everything, by name: seconds of processor or clock, MB, milliseconds to load."""
    rounds = 1 if quick else 7
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, command in _commands(Path(folder)).items():
            found |= _medians(name, command, _installed(folder), rounds)
    session = chapter6.session()
    still = session.points[0].config
    chapter6.run(still, 0)
    runs = [chapter6.run(still, seed).cpu for seed in range(2 * rounds)]
    found["truck-again.cpu"] = statistics.median(runs)
    for figure in compiled.figures(quick):
        size = "truck" if "truck" in figure.size else "generated"
        found[f"load-{size}.{_LOADING[figure.what]}"] = figure.value
    return found


def _installed(folder: str) -> dict[str, str]:
    """An environment in which bytecode is at hand, as it is once rapc is installed."""
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    return {**kept, "PYTHONPYCACHEPREFIX": str(Path(folder, "bytecode"))}


def _commands(folder: Path) -> Mapping[str, Sequence[str]]:
    compiled_truck = folder / "truck"
    compiled_truck.write_bytes(
        encode(host.load(STDLIB / "truck").program.library, "truck")
    )
    return {
        "help": ("--help",),
        "check": ("check", str(STDLIB)),
        "truck": _truck(STDLIB / "truck"),
        "truck-compiled": _truck(compiled_truck),
    }


def _truck(library: Path) -> list[str]:
    """The words after `rapc` that repeat the still run, nothing printed."""
    session = chapter6.session()
    words = shlex.split(session.command(session.points[0], 0))[1:]
    return [words[0], str(library), *words[2:], "--quiet"]


def _medians(
    name: str, command: Sequence[str], environment: Mapping[str, str], rounds: int
) -> dict[str, float]:
    """What a command takes; a first time, which writes the bytecode, is left out."""
    words = [*RAPC, *command]
    take(words, environment)
    taken = [take(words, environment) for _ in range(rounds)]
    return {
        f"{name}.cpu": statistics.median(one["cpu"] for one in taken),
        f"{name}.wall": statistics.median(one["wall"] for one in taken),
        f"{name}.peak": statistics.median(one["peak"] for one in taken),
    }
