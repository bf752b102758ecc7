"""What all tests share: the same examples of hypothesis in every run, and Ctrl-C.

Hypothesis would take constants out of the modules that happen to be imported, which
depends on the tests that ran before, and find a strategy too slow when the machine is.
"""

from __future__ import annotations

import signal

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

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell has what it starts in the background ignore Ctrl-C, and commands started
    # by tests would inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
