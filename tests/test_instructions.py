"""The pieces of work whose instructions are counted can be done."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bench.instructions import WORKS
from tests.effort import first

CHECKOUT = Path(__file__).parents[1]

SMALL = [name for name in WORKS if not name.startswith(("agenda", "order", "chapter6"))]


@pytest.mark.parametrize("work", first(1, ["queries 4", *SMALL]))
def test_work_that_is_counted_can_be_done(work: str) -> None:
    script = str(CHECKOUT / "bench" / "counted.py")
    subprocess.run([sys.executable, "-P", script, work, "1"], cwd=CHECKOUT, check=True)
