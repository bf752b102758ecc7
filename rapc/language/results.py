"""Results of methods and tasks that the interpreter sets; programs test them by name.

Not here: the results that primitives declare.
"""

from __future__ import annotations

from typing import Final

from rapc.base.messages import OKAY

INTERFERENCE: Final = "interference"
"""Failure of a task or method: a condition, an input or a request cannot hold."""

NO_METHOD: Final = "no-method"
"""Failure of a task: no method can be tried."""

FUTILE_LOOP: Final = "futile-loop"
"""Failure of a task: a repeated choice, or the goal of an ancestor [T 3.2.5]."""

SIGNAL: Final = "signal"
"""Failure of a step: ended by a signal that it waited for [S 3.1]."""

RESULTS: Final = (OKAY, NO_METHOD, INTERFERENCE, FUTILE_LOOP, SIGNAL)
"""All these results."""
