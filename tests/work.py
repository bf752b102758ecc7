"""Work counted in lines of Python, which are as many on every machine."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

from rapc.base.gc_paused import gc_paused


def lines(run: Callable[[], object]) -> int:
    """How many lines of Python something executes."""
    count = 0

    def step(frame: FrameType, event: str, arg: Any) -> Any:
        nonlocal count
        count += event == "line"
        return step

    before = sys.gettrace()
    with gc_paused():  # its callbacks may be Python
        sys.settrace(step)
        try:
            run()
        finally:
            sys.settrace(before)
    return count
