"""What all tests share: the same examples of hypothesis in every run, and Ctrl-C.

Hypothesis would take constants out of the modules that happen to be imported, which
depends on the tests that ran before, and find a strategy too slow when the machine is.
"""

from __future__ import annotations

import signal

import pytest
from _pytest.nodeid import NodeId
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

from tests.effort import THOROUGH

for profile in ("same-every-run", THOROUGH):
    settings.register_profile(
        profile,
        derandomize=True,
        deadline=None,
        suppress_health_check=[HealthCheck.too_slow],
    )
settings.load_profile("same-every-run")
providers._get_local_constants = lambda: providers._local_constants


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give tests the group of their mark `xdist_group`, and put long ones first.

    pytest-xdist 3.8 writes the group into `_nodeid`, which pytest 9.2 does not read:
    without this, each worker sets up the fixtures of the group. It begins with the
    groups, the largest first; a long test at the end would leave the other workers
    without work.
    """
    items.sort(key=lambda item: item.get_closest_marker("long") is None)
    for item in items:
        grouped = getattr(item, "_nodeid", "")
        if "@" in grouped:
            item._id = NodeId.parse(grouped)


if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell has what it starts in the background ignore Ctrl-C, and commands started
    # by tests would inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
