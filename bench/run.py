"""Run all benchmarks, or those named, and print their figures as a table.

python -m bench.run [--quick] [NAME]..., where `--help` lists the names
"""

from __future__ import annotations

import argparse
import os
import platform
from collections.abc import Callable, Iterator

from bench import (
    agenda,
    chapter6,
    compiled,
    memory,
    monitors,
    order,
    parse,
    queries,
    saving,
)
from bench.common import Figure, table

BENCHES: dict[str, Callable[[bool], Iterator[Figure]]] = {
    "parse": parse.figures,
    "compiled": compiled.figures,
    "queries": queries.figures,
    "monitors": monitors.figures,
    "agenda": agenda.figures,
    "order": order.figures,
    "chapter6": chapter6.figures,
    "memory": memory.figures,
    "saving": saving.figures,
}


def machine() -> str:
    """What the figures were taken on."""
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return f"{python}, {platform.system()} {platform.machine()}, {os.cpu_count()} cores"


def main() -> None:
    """Read the command line and print."""
    parser = argparse.ArgumentParser(description="The benchmarks of rapc.")
    parser.add_argument("bench", nargs="*", help=f"some of: {', '.join(BENCHES)}")
    parser.add_argument("--quick", action="store_true", help="small sizes, to try it")
    args = parser.parse_args()
    unknown = set(args.bench) - set(BENCHES)
    if unknown:
        parser.error(f"no such bench: {', '.join(sorted(unknown))}")
    print(machine() + "\n")
    found = (
        figure
        for name, figures in BENCHES.items()
        if not args.bench or name in args.bench
        for figure in figures(args.quick)
    )
    for line in table(found):
        print(line, flush=True)


if __name__ == "__main__":
    main()
