"""Where the time of a firing and of a task goes: the profile of W3 and W4.

    python -m bench.profiles

The adapter of the side-by-side benchmarks is run as it is there, under cProfile. That
makes calls look dearer than they are, so shares are told, not times.
"""

from __future__ import annotations

import cProfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType
from typing import Any

ADAPTER = Path(__file__).with_name("rapc_adapter.py")
LINES = 12


class Peer:
    """What an adapter's class is made from; only its own methods are used here."""


def adapter() -> Any:
    """An instance of the adapter's class `Rapc`."""
    scope: dict[str, Any] = {
        "__name__": "rapc_adapter",
        "Peer": Peer,
        "peer": lambda made: made,
    }
    code = compile(ADAPTER.read_text(encoding="utf-8"), str(ADAPTER), "exec")
    exec(code, scope)  # noqa: S102  # a file of this folder
    return scope["Rapc"]()


def firings(monitors: int, count: int) -> Callable[[], None]:
    """So many firings among so many monitors, ready to be run."""
    made = adapter()
    made.fired = 0
    made.w3_setup(monitors)

    def fire() -> None:
        for number in range(count):
            made.w3_fire(number % monitors)

    return fire


def tree(depth: int) -> Callable[[], None]:
    """A tree of tasks with three branches and so many levels, ready to be run."""
    made = adapter()
    made.w4_setup(3, depth)
    made.w4_run()
    work: Callable[[], None] = made.w4_run
    return work


def profile(work: Callable[[], None], lines: int = LINES) -> Iterator[str]:
    """The functions in which most of the time is spent, with their shares of it."""
    profiler = cProfile.Profile()
    profiler.runcall(work)
    parts = sorted(profiler.getstats(), key=lambda part: part.inlinetime, reverse=True)
    whole = sum(part.inlinetime for part in parts)
    for part in parts[:lines]:
        share = part.inlinetime / whole
        yield f"{share:5.1%} {part.callcount:>9,} calls  {_name(part.code)}"


def _name(code: CodeType | str) -> str:
    """A function with the folder and file it is from."""
    if isinstance(code, str):
        return code
    file = Path(code.co_filename)
    return f"{code.co_qualname} ({file.parent.name}/{file.name})"


def text(quick: bool = False) -> str:
    """Both profiles, each under a heading."""
    monitors, depth = (100, 4) if quick else (10_000, 8)
    parts = [
        f"W3: firings among {monitors:,} monitors",
        *profile(firings(monitors, 2 * monitors)),
        "",
        f"W4: a tree of tasks, {depth} levels",
        *profile(tree(depth)),
    ]
    return "\n".join(parts)


if __name__ == "__main__":
    print(text())
