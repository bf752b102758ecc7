"""Output of `rapc worlds`, as plain text for a width in columns."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence

from rapc.base.names import plural
from rapc.base.values import typed
from rapc.console.lines import wrapped
from rapc.testing.contract.trials import SEEDS, Trial
from rapc.world import Option, World

_NARROW = 24
"""The width below which a text goes below its name instead of beside it."""


def list_worlds(worlds: Mapping[str, str], width: int) -> str:
    """Return a line or more for each world: its name and a summary."""
    return "\n".join(columns(worlds.items(), width))


def describe_world(world: World, width: int) -> str:
    """Return the offer of a world: primitives with results, data, skills, options."""
    offer = world.kit.offer
    primitives = [
        (f"{name}/{arity}", ", ".join(results))
        for name, (arity, results) in offer.primitives.items()
    ]
    lines = wrapped(f"{world.name}: {summary_of(type(world))}", width)
    lines += _section("primitives / arguments: results", primitives, width)
    named = (("data", offer.data), ("skills", offer.skills), ("events", offer.events))
    listed: list[tuple[str, Sequence[str]]] = [
        (f"{title} / arguments", [f"{name}/{arity}" for name, arity in names.items()])
        for title, names in named
    ]
    listed.insert(0, ("sensor primitives", offer.sensors))
    for title, words in listed:
        if words:
            lines += ["", *wrapped(title, width)]
            folded = wrapped("  ".join(words), width - 2)
            lines += ["  " + line for line in folded]
    rows = [(option.name, _option(option)) for option in world.kit.options]
    lines += _section(f"options for `--set {world.name}.option=VALUE`", rows, width)
    return "\n".join(lines)


def summary_of(world: type[World]) -> str:
    """Return the first line of a world's documentation, without its full stop."""
    return (inspect.getdoc(world) or "").partition("\n")[0].rstrip(".")


def columns(rows: Iterable[tuple[str, str]], width: int) -> list[str]:
    """Return names with a text beside or, on a narrow terminal, below each name."""
    rows = list(rows)
    left = max((len(name) for name, _ in rows), default=0) + 2
    beside = width - left >= _NARROW
    lines = []
    for name, text in rows:
        room = width - left if beside else width - 4
        folded = wrapped(text, room)
        if beside:
            first, *rest = folded or [""]
            lines.append(f"{name:<{left}}{first}".rstrip())
            lines += [" " * left + line for line in rest]
        else:
            lines += [name, *("    " + line for line in folded)]
    return lines


def _section(title: str, rows: Sequence[tuple[str, str]], width: int) -> list[str]:
    if not rows:
        return []
    body = ("  " + line for line in columns(rows, width - 2))
    return ["", *wrapped(title, width), *body]


def _option(option: Option) -> str:
    words = [typed(option.default) or "none", option.unit]
    if option.kind != "number":
        words.append(f"({option.kind})")
    return f"{' '.join(filter(None, words))}: {option.doc}"


# --- contract tests ------------------------------------------------------------------


def report(name: str, trials: Sequence[Trial], requests: int, width: int) -> str:
    """Return a line for each tested part, with its errors below.

    Results that no request had are listed, too: the code for these results was not
    tested.
    """
    failed = sum(bool(trial.faults) for trial in trials)
    left_out = sum(bool(trial.left_out) for trial in trials)
    passed = len(trials) - failed - left_out
    counts = [f"{plural(passed, 'check')} passed"]
    counts += [f"{failed} failed"] if failed else []
    counts += [f"{left_out} not applicable"] if left_out else []
    tried = f"{plural(requests, 'request')} with each of {len(SEEDS)} seeds"
    lines = [line for trial in trials for line in _told(trial, width)]
    last = f"{name}: {', '.join(counts)} ({tried})"
    return "\n".join([*lines, *wrapped(last, width)])


def _told(trial: Trial, width: int) -> Iterator[str]:
    """Yield the lines about one part."""
    word = "failed" if trial.faults else "n/a" if trial.left_out else "passed"
    more = f": {trial.left_out}" if trial.left_out else ""
    first, *rest = wrapped(f"{trial.part}{more}", max(width - _LEFT, 1))
    yield f"  {word:<6}  {first}"
    yield from (" " * _LEFT + line for line in rest)
    below = list(trial.faults)
    if trial.unseen:
        below.append("results that no request had:")
    below += [f"{name}: {', '.join(told)}" for name, told in trial.unseen.items()]
    for text in below:
        yield from (" " * _LEFT + line for line in wrapped(text, width - _LEFT))


_LEFT = 10
"""The indent of the parts, in columns."""
