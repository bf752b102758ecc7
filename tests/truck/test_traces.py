"""The traces of T 6.2, told in full: each task considered, chosen, done and failed.

The same runs stand as tests beside the library, where only what T tells of them is
asked for; here nothing may change unseen. To write them anew:

    python -m tests.truck.test_traces
"""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from rapc.runtime.events.trace import TextTrace
from rapc.testing.discover import find
from rapc.testing.run import Status, run_case

from .runs import STDLIB

GOLDEN = Path(__file__).parent / "golden"
TRACES = {"trace-1": "weapon", "trace-2": "enemies"}


def told(name: str) -> str:
    """The text trace of a run; the first line, which names a path, left out."""
    file = STDLIB / "truck" / f"{TRACES[name]}.test.rap"
    [case] = [c for c in find([file]).cases if c.test.name.startswith(f"thesis-{name}")]
    stream = io.StringIO()
    outcome = run_case(case, listener=TextTrace(stream))
    assert outcome.status is Status.PASSED
    return stream.getvalue().partition("\n")[2]


@pytest.mark.parametrize("name", TRACES)
def test_the_trace_is_golden(name: str) -> None:
    golden = (GOLDEN / f"{name}.txt").read_text(encoding="utf-8")
    assert told(name) == golden


if __name__ == "__main__":
    for trace in TRACES:
        (GOLDEN / f"{trace}.txt").write_text(told(trace), encoding="utf-8")
