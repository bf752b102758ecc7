"""The figures of graphs, drawn by Graphviz."""

from __future__ import annotations

import hashlib
import re
import shlex
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

from click.testing import CliRunner

from rapc.cli.main import cli

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent

FIGURES: Mapping[str, str] = {
    "fill-order.svg": "stdlib/truck --rap fill-order",
    "stay-charged.svg": "examples/courier --effects stay-charged",
    "s-figure2.svg": "s-figure2.dot",
    "s-figure4.svg": "rapc:hallway --skills 0.1 --world hallway --task '(pass 0)'",
    "s-figure5.svg": "rapc:hallway --skills 0.1 --world hallway "
    "--task '(follow-hall-to-end)'",
}
"""The figures that Graphviz draws: a file, or arguments of `rapc graph`."""


def graph(source: str) -> str:
    """Return the graph that a figure shows, in the language of Graphviz."""
    if source.endswith(".dot"):
        return (DOCS / "figures" / source).read_text(encoding="utf-8")
    path, *options = shlex.split(source)
    library = path if path.startswith("rapc:") else str(ROOT / path)
    done = CliRunner().invoke(cli, ["graph", library, *options])
    if done.exit_code:
        raise ValueError(done.output)
    return done.stdout


def drawn(text: str) -> str:
    """Return a graph as SVG, with the digest of its text."""
    done = subprocess.run(
        ["dot", "-Tsvg"], input=text, text=True, capture_output=True, check=True
    )
    svg = re.sub(
        r"<!--.*?-->\n*", "", done.stdout[done.stdout.index("<svg") :], flags=re.S
    )
    return f"<!-- {digest(text)} -->\n{svg}"


def digest(text: str) -> str:
    """Return a digest of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


def stale_figures() -> Iterator[tuple[Path, str]]:
    """Yield the figures that show an old graph, with their new graphs."""
    for name, source in FIGURES.items():
        path = DOCS / "figures" / name
        text = graph(source)
        old = path.read_text(encoding="utf-8") if path.exists() else ""
        if not old.startswith(f"<!-- {digest(text)} -->"):
            yield path, text
