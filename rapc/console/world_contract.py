"""What came of holding a world to the port, for a person to read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.console.lines import wrapped
from rapc.testing.contract.trials import REQUESTS, SEEDS, Trial


def report(name: str, trials: Sequence[Trial], width: int) -> str:
    """Return a line for each part that was tried, and what is wrong below it."""
    broken = sum(bool(trial.faults) for trial in trials)
    kept = f"keeps to the port in {len(trials) - broken} of {len(trials)} parts"
    last = kept if broken else "keeps to the port"
    tried = f"{REQUESTS} requests under each of {len(SEEDS)} seeds"
    lines = [line for trial in trials for line in _told(trial, width)]
    return "\n".join([*lines, *wrapped(f"{name} {last}; {tried}", width)])


def _told(trial: Trial, width: int) -> Iterator[str]:
    """Yield the lines about one part."""
    word = "broken" if trial.faults else "-" if trial.left_out else "ok"
    more = f": {trial.left_out}" if trial.left_out else ""
    first, *rest = wrapped(f"{trial.part}{more}", max(width - _LEFT, 1))
    yield f"  {word:<6}  {first}"
    yield from (" " * _LEFT + line for line in rest)
    for fault in trial.faults:
        yield from (" " * _LEFT + line for line in wrapped(fault, width - _LEFT))


_LEFT = 10
"""How far from the left the parts stand."""
