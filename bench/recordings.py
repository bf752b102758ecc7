"""Large recordings: what the first answers of `rapc repl FILE.jsonl` take.

    python -m bench.recordings            # recordings of 7 MB and of 324 MB
    python -m bench.recordings --sizes 1

A truck carries out as many orders as it takes to fill the recording, which is then cut
off in a line. Each command is the first input of a debugger: with the world of the
recording, and only to look at, as a recording of another world is.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TextIO

import rapc
from bench import child

COMMANDS = (":goto 100", ":tree", ":find task-failed", ":goto end")

ORDERS_PER_MB = 3
"""More orders than a recording of one MB tells of."""


class _Full(Exception):
    """The recording has its size."""


class _Limited:
    """A stream that takes so many bytes.

    Args:
        stream: where they go.
        size: how many.
    """

    def __init__(self, stream: TextIO, size: int) -> None:
        self._stream, self._left = stream, size

    def write(self, text: str) -> None:
        """Write text; raise _Full for the text that does not fit any more."""
        self._stream.write(text[: self._left])
        self._left -= len(text)
        if self._left < 0:
            raise _Full


def record(path: Path, megabytes: int) -> None:
    """Write a recording of a size."""
    orders = ["(rock-order red 4)"] * (ORDERS_PER_MB * megabytes)
    library = rapc.load("examples/rock-order.rap")
    with path.open("w", encoding="ascii") as stream:
        trace = rapc.JsonTrace(_Limited(stream, megabytes * 1_000_000))
        options = {"fuel-use": 0}
        try:
            rapc.run(library, "truck", orders, options=options, listeners=[trace])
        except _Full:
            return
    raise SystemExit(f"{len(orders)} orders are told in less than {megabytes} MB")


def of_another_world(path: Path) -> Path:
    """Return a copy of a recording whose world is not at hand."""
    copy = path.with_name("other.jsonl")
    with path.open("rb") as lines, copy.open("wb") as stream:
        stream.write(next(lines).replace(b'"world":"truck"', b'"world":"none"'))
        stream.writelines(lines)
    return copy


def main() -> None:
    """Print what the first answer to each command takes, for each size."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[7, 324])
    command = str(Path(sys.executable).with_name("rapc"))
    print("| recording | run | first input | processor time in s | peak in MB |")
    print("|---|---|---|---:|---:|")
    for size in parser.parse_args().sizes:
        with TemporaryDirectory() as folder:
            path = Path(folder) / "run.jsonl"
            record(path, size)
            for how, file in (("again", path), ("look at", of_another_world(path))):
                for text in COMMANDS:
                    asked = (command, "repl", str(file), "-c", text)
                    taken = child.take(asked, os.environ)
                    used = f"{taken['cpu']:.2f} | {taken['peak']:.0f}"
                    print(f"| {size} MB | {how} | `{text}` | {used} |")


if __name__ == "__main__":
    main()
