"""Tables of measurements that benches and experiments have stored in docs/figures."""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import msgspec

from generator.markdown import block, sentence, table

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent


def targets() -> str:
    """Return the place of the last measurement and the table of its targets."""
    beside = _bench("beside")
    return f"{beside.told(beside.read(beside.FIGURES / 'beside.json')).rstrip()}\n"


def profiles() -> str:
    """Return the profiles of the last measurement."""
    beside = _bench("beside")
    return block("text", beside.read(beside.FIGURES / "beside.json").profiles)


def _bench(name: str) -> ModuleType:
    """Return a module of the benches, which are not installed."""
    if str(ROOT) not in sys.path:
        sys.path.append(str(ROOT))
    return import_module(f"bench.{name}")


def slips() -> str:
    """Return the sums of slips and, for each group, the slips that are found."""
    counts = msgspec.json.decode((DOCS / "figures" / "slips.json").read_bytes())
    numbers = ("made", "found", "named", "single")
    groups: dict[str, list[tuple[str, ...]]] = {}
    for row in counts["kinds"]:
        remark = f" ({row['remark']})" if row["remark"] else ""
        links = [f"[{n}](../reference/rules/{n}.md)" for n in row["rules"]]
        cells = (*(str(row[number]) for number in numbers), ", ".join(links))
        groups.setdefault(row["group"], []).append((row["slip"] + remark, *cells))
    head = ("slip", "made", "found", "named", "single", "rules")
    tables = [
        f"### {sentence(group)[:-1]}\n\n{table(head, rows)}"
        for group, rows in groups.items()
    ]
    sure = [row for row in counts["kinds"] if not row["remark"]]
    made, found, named, single = (sum(r[n] for r in sure) for n in numbers)
    return (
        f"Measured on {counts['date']}, with at most {counts['each']} slips of each "
        f"kind in each library. The {len(sure)} kinds without a remark: {made} slips, "
        f"{found} found; the cause is named for {named}, and "
        f"{single} have a single finding. {counts['idle']} further slips of all kinds "
        "changed no trace and are left out.\n\n" + "\n".join(tables)
    )


def stored(name: str) -> str:
    """Return the output of a bench as it is stored; a block if it is no table."""
    text = _read(name)
    return text if text.startswith("| ") else block("text", text)


def runs(name: str, parts: str, columns: str) -> str:
    """Return the points of some parts of an experiment.

    Args:
        name: the stored `tables.md` of `rapc experiment`.
        parts: names of parts that vary the same option, with commas. A part with one
            point has its name in the first column.
        columns: names of columns, with commas, `-` for a space.
    """
    found, wanted = _parts(name), columns.replace("-", " ").split(",")
    rows = []
    for part in parts.split(","):
        _, varied, points = found[part]
        for value, cells in points:
            first = part if varied == "point" else value
            rows.append((first, *[cells[column] for column in wanted]))
    return table((varied, *wanted), rows)


def means(name: str, parts: str, columns: str) -> str:
    """Return the means of some parts of an experiment, with a column for each point.

    The arguments are those of `runs`; `all` are all parts.
    """
    found, wanted = _parts(name), columns.replace("-", " ").split(",")
    rows = []
    for part in found if parts == "all" else parts.split(","):
        title, varied, points = found[part]
        means = [[cells[column].split()[0] for column in wanted] for _, cells in points]
        rows.append((title, *map(", ".join, means)))
    named = [f"{varied} {value}" for value, _ in points]
    head = ["all runs"] if varied == "point" else named
    return table((", ".join(wanted), *head), rows)


_Part = tuple[str, str, list[tuple[str, dict[str, str]]]]
"""A title, the varied option, and the cells of each value by their columns."""


def _parts(name: str) -> dict[str, _Part]:
    """Return the parts of a stored experiment by their names."""
    found: dict[str, _Part] = {}
    for text in _read(name).split("\n### ")[1:]:
        [(title, part)] = re.findall(r"\A(.*) \(part `(.+)`\)\n", text)
        tables = re.findall(r"(?:^\|.*\n)+", text, re.M)
        main, rest = (
            [line[2:-2].split(" | ") for line in lines.splitlines()] for lines in tables
        )
        head, _, *rows = (
            [*one, *other[3:]] for one, other in zip(main, rest, strict=True)
        )
        points = [(row[0], dict(zip(head[1:], row[1:], strict=True))) for row in rows]
        found[part] = (title, head[0], points)
    return found


def _read(name: str) -> str:
    return (DOCS / "figures" / f"{name}.txt").read_text(encoding="utf-8")
