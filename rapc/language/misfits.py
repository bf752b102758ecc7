"""What is said of data that do not fit a rule, where its shape does not say enough."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec


class Misfit(msgspec.Struct, frozen=True):
    """A row: what is reported of whatever stands where a rule is wanted."""

    #: The rule of the checker that is broken.
    finding: str
    #: The message; `{kind}` stands for what was found, with its article.
    message: str
    help: str = ""


def _clause(message: str, help: str = "") -> Misfit:
    return Misfit("malformed-clause", message, help)


_SKILL = "write `({} (:skill argument...))`"

MISFITS: Mapping[str, Misfit] = {
    # tests
    "answer": _clause(
        "an answer is a question to a function, and a value",
        "write `((function argument...) value)`",
    ),
    "world_option": _clause(
        "an option of the world is its name and a value", "write `(name value)`"
    ),
    "script_row": _clause(
        "a row of the script is wanted here, not {kind}", "write `((request) result)`"
    ),
    "enabled": _clause("one skill is wanted here", _SKILL.format("enable")),
    "disabled": _clause("one skill is wanted here", _SKILL.format("disable")),
    **dict.fromkeys(
        ("moved", "placed"),
        _clause(
            "an item and its place are wanted here, not {kind}", "write `(item place)`"
        ),
    ),
    "event_pattern": _clause(
        "an event pattern is wanted here, not {kind}",
        "write `(task-failed :reason no-method)`",
    ),
}
"""What is said by the rule that was wanted."""
