"""The clauses that hold a formula: what each binds, and when the interpreter asks it.

This is the one list of these clauses. Walks, passes, plans and explanations read it; a
clause that is added here is walked, checked for bindings, names and contradictions,
compiled and explained. Its syntax is in the grammar, its field in `rapc.ir.nodes`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

import msgspec

from rapc.ir import nodes

When = Literal["select", "wake", "choose", "run"]
"""When a clause is evaluated.

`select`: in each cycle of the task [L 3.1]; `wake`: while the task waits for its
monitor [L 5]; `choose`: when a method is chosen; `run`: while a method runs.
"""


class Clause(msgspec.Struct, frozen=True):
    """A clause with a formula."""

    #: Its name in the language, and the field of its node.
    word: str
    field: str
    when: When
    #: Whether a method starts, or continues, only where it holds.
    required: bool = True
    #: Whether the variables that it binds are bound in the method.
    hands_on: bool = False
    #: Whether it must hold for all tasks below, too.
    inherited: bool = False

    @property
    def is_condition(self) -> bool:
        """Whether a selected task, or its method, continues only where it holds."""
        return self.required and self.when != "wake"


RAP = (
    Clause("succeed", "succeed", "select", required=False),
    Clause("monitor-state", "monitor_state", "wake"),
    Clause("preconditions", "preconditions", "select"),
    Clause("constraints", "constraints", "select", inherited=True),
    Clause("repeat-while", "repeat_while", "choose", hands_on=True),
)
"""The clauses of a RAP, in the order in which a cycle evaluates them."""

METHOD = (
    Clause("context", "context", "choose", hands_on=True),
    Clause("constraints", "constraints", "run", inherited=True),
)
"""The clauses of a method."""

FOR = Clause("for", "formula", "run", hands_on=True)
"""The annotation of a step that holds a formula."""

CLAUSES = (*RAP, *METHOD, FOR)


def held(
    clauses: Iterable[Clause], node: nodes.DefineRap | nodes.Method
) -> Iterator[tuple[Clause, nodes.Formula]]:
    """Yield those of some clauses that a RAP or a method has, with their formulas."""
    for clause in clauses:
        formula = getattr(node, clause.field)
        if formula is not None:
            yield clause, formula
