"""The clauses with a formula: their bindings and the time of their evaluation.

This is the only list of these clauses. Walks, passes, plans and explanations read the
list: a clause added to it is walked, checked for bindings, names and contradictions,
compiled and explained. Not here: the syntax of a clause (the grammar), and its field
(`rapc.ir.nodes`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

import msgspec

from rapc.ir import nodes

When = Literal["select", "wake", "choose", "run"]
"""The time of evaluation of a clause.

`select`: in each cycle of the task [L 3.1]; `wake`: while the task waits for its
monitor [L 5]; `choose`: when a method is chosen; `run`: while a method runs.
"""


class Clause(msgspec.Struct, frozen=True):
    """A clause with a formula."""

    #: The name of the clause in the language, and its field in the node.
    word: str
    field: str
    when: When
    #: Whether the clause must hold for a method to start or continue.
    required: bool = True
    #: Whether the bindings of the clause hold in the method.
    hands_on: bool = False
    #: Whether the clause must hold for all descendant tasks, too.
    inherited: bool = False

    @property
    def is_condition(self) -> bool:
        """Whether a selected task or its method needs the clause to continue."""
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
"""The annotation of a step with a formula."""


def held(
    clauses: Iterable[Clause], node: nodes.DefineRap | nodes.Method
) -> Iterator[tuple[Clause, nodes.Formula]]:
    """Yield the clauses that a RAP or a method has, with their formulas."""
    for clause in clauses:
        formula = getattr(node, clause.field)
        if formula is not None:
            yield clause, formula
