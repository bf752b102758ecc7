"""Small programs that both interpreters must run alike, for tests with names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rapc.worlds.script import Row
from tests.reference.case import Case, print_form
from tests.reference.compare import compare, report
from tests.reference.vocabulary import DECLARATIONS

DECLARED = "".join(print_form(form) + "\n" for form in DECLARATIONS)

ANSWERS = (Row(("act", "?")), Row(("rest",)), Row(("slow", "?"), after=1))
"""The last rows of every script: whatever is asked is okay."""

SUB = "(define-rap (sub) (method (task-net)))"
USE = "(define-rap (use ?i) (method (primitive (act ?i))))"
FIND = "(define-rap (find => ?o) (succeed (p a ?o)))"


def play(
    text: str, *tasks: str, only: str, rows: Sequence[Row] = (), **more: Any
) -> list[str]:
    """The time and the values of all events of some kinds, once both agree."""
    case = Case(
        seed=0, source=DECLARED + text, tasks=tasks, rows=(*rows, *ANSWERS), **more
    )
    outcome = compare(case)
    assert outcome.verdict == "agree", report(case, outcome)
    return [_line(row) for row in outcome.rapc if row["event"] in only.split()]


def _line(row: dict[str, Any]) -> str:
    kind, time = row["event"].split("-")[-1], row["time"]
    values = [v for k, v in row.items() if k not in ("event", "cycle", "time")]
    return " ".join(str(value) for value in (time, kind, *values))
