"""The states of a task.

The life of a task; each arrow has the name of its verb:

    made --create--> waiting --release--> (untested) --test--> eligible
                        ^ for order, time or a signal             |
                                                                select
    blocked <--block-- (monitors do not hold) <-------------------|
       |                                                          |
      wake, once they do                                    start_method
       |                                                          |
       +--> eligible                                           running
                                                                  |
    eligible <--------------------end_method----------------------+

    any of them --succeed, fail, remove--> ended

`untested` is for monitored tasks alone: they are tested before they first become
eligible. A task that was selected leaves the agenda; it comes back with the end of
its method, or when its monitors hold again.

Where the verbs are: `create`, `release` in `tasks.start`; `block`, `wake` and the test
in `monitors.monitors`; `select` in `state.agenda` (`choose`) and `tasks.cycle`;
`start_method` in `tasks.try_method`; `end_method`, `succeed`, `fail` in `tasks.finish`;
`remove` in `tasks.remove`.
"""

from __future__ import annotations

from typing import Final, Literal

WAITING: Final = "waiting"
UNTESTED: Final = "untested"
ELIGIBLE: Final = "eligible"
BLOCKED: Final = "blocked"
RUNNING: Final = "running"
ENDED: Final = "ended"
"""State of a task between its cycles."""

State = Literal["waiting", "untested", "eligible", "blocked", "running", "ended"]
"""The type of the states."""
