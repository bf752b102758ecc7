"""Tables of measurements that the benches have stored."""

from __future__ import annotations

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
        f"{counts['each']} slips at most of each kind. The {len(sure)} kinds without a "
        f"remark: {made} slips, {found} found; the cause is named for {named}, and "
        f"{single} have a single finding. {counts['idle']} further slips of all kinds "
        "were not found and changed no trace.\n\n" + "\n".join(tables)
    )
