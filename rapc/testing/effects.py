"""Declared effects of RAPs, checked when a task succeeds in a simulator.

The planner relies on the `effects` of a RAP: after a success, each fact must hold, and
each `(not fact)` must not hold. Facts are checked at the end of the method after which
the task succeeds, before other tasks can change them; facts with outputs at the
success, when the outputs are known.

Not checked: `(may fact)`, a property with the value `?`, a negated fact with a variable
that is neither input nor output, and a task that succeeds without a method.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rapc import events
from rapc.base.source import Span
from rapc.base.values import Text, readable
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.ir.walk import substitute, variables
from rapc.runtime.interpreter import Interpreter
from rapc.world import OKAY


class EffectsCheck:
    """A listener that checks the declared effects of each RAP that succeeds.

    Args:
        run: the run.
        fail: called with the position of a false effect and an explanation, once for
            each effect.
    """

    def __init__(self, run: Interpreter, fail: Callable[[Span, str], None]) -> None:
        self._run, self._fail = run, fail
        #: The goals of tasks of RAPs with `effects`.
        self._goals: dict[int, events.Goal] = {}
        #: The false effects at the end of the last method of a task.
        self._ended: dict[int, dict[Span, str]] = {}
        self._told: set[Span] = set()
        #: The names of the RAPs with `effects` that were checked.
        self.checked: dict[str, None] = {}
        run.listen(self._selects, events.TaskSelected)
        run.listen(self._starts, events.MethodChosen, events.MethodSuspended)
        run.listen(self._ends, events.MethodEnded)
        run.listen(self._succeeds, events.TaskSucceeded)

    def _selects(self, event: Any) -> None:
        if self._run.library.library.raps[event.goal.name].effects:
            self._goals[event.task] = event.goal

    def _starts(self, event: Any) -> None:
        self._ended.pop(event.task, None)

    def _ends(self, event: Any) -> None:
        goal = self._goals.get(event.task)
        if goal is not None and event.result == OKAY:
            self._ended[event.task] = dict(self._false(goal))

    def _succeeds(self, event: Any) -> None:
        false = self._ended.pop(event.task, None)
        if false is None:
            return
        self.checked[event.goal.name] = None
        false.update(self._false(event.goal, event.outputs))
        for span, text in false.items():
            if span not in self._told:
                self._told.add(span)
                at = f"[{event.task}] succeeded at time {readable(event.time)}"
                self._fail(span, f"{event.goal} {at}, but {text}")

    def _false(
        self, goal: events.Goal, values: Mapping[str, Any] | None = None
    ) -> Iterator[tuple[Span, str]]:
        """Yield the false effects, with their positions, as text.

        Args:
            goal: the goal of the task.
            values: the values of outputs, to check the effects with outputs; without
                them all other effects are checked.
        """
        rap = self._run.library.library.raps[goal.name]
        inputs = zip([one.name for one in rap.inputs], goal.inputs, strict=True)
        terms = {
            name: nodes.Const(value)
            for name, value in (*inputs, *(values or {}).items())
            if isinstance(value, str | int | float | Text)
        }
        outputs = {one.name for one in rap.outputs}
        for effect in rap.effects:
            names = {one.name for one in variables(*effect.pattern.args)}
            if effect.possible or names.isdisjoint(outputs) == (values is not None):
                continue
            pattern = substitute(effect.pattern, terms)
            free = list(variables(*pattern.args))
            if effect.negated and any(not one.anonymous for one in free):
                continue
            is_property = pattern.name in self._run.library.library.properties
            if is_property and not effect.negated and pattern.args[-1] in free:
                continue
            if self._run.question(pattern).holds() == effect.negated:
                how = "still holds" if effect.negated else "does not hold"
                yield effect.pattern.span, f"{format_node(pattern)} {how}"
