"""What came of holding a world to the port, for a person to read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.base.names import plural
from rapc.console.lines import wrapped
from rapc.testing.contract.trials import SEEDS, Trial


def report(name: str, trials: Sequence[Trial], requests: int, width: int) -> str:
    """Return a line for each part that was tried, and what is wrong below it.

    So are the results that no request had: the code behind them was not tried.
    """
    broken = sum(bool(trial.faults) for trial in trials)
    kept = f"keeps to the port in {len(trials) - broken} of {len(trials)} parts"
    last = kept if broken else "keeps to the port"
    tried = f"{plural(requests, 'request')} under each of {len(SEEDS)} seeds"
    lines = [line for trial in trials for line in _told(trial, width)]
    return "\n".join([*lines, *wrapped(f"{name} {last}; {tried}", width)])


def _told(trial: Trial, width: int) -> Iterator[str]:
    """Yield the lines about one part."""
    word = "broken" if trial.faults else "-" if trial.left_out else "ok"
    more = f": {trial.left_out}" if trial.left_out else ""
    first, *rest = wrapped(f"{trial.part}{more}", max(width - _LEFT, 1))
    yield f"  {word:<6}  {first}"
    yield from (" " * _LEFT + line for line in rest)
    below = list(trial.faults)
    if trial.unseen:
        below.append("results never seen:")
    below += [f"{name}: {', '.join(told)}" for name, told in trial.unseen.items()]
    for text in below:
        yield from (" " * _LEFT + line for line in wrapped(text, width - _LEFT))


_LEFT = 10
"""How far from the left the parts stand."""
