"""What all tests share: the same examples of hypothesis in every run, and Ctrl-C."""

from __future__ import annotations

import signal

from hypothesis import settings

from tests.effort import THOROUGH

settings.register_profile("same-every-run", derandomize=True, deadline=None)
settings.register_profile(THOROUGH, derandomize=True, deadline=None)
settings.load_profile("same-every-run")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell has what it starts in the background ignore Ctrl-C, and commands started
    # by tests would inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
