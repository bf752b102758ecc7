"""Which formulas hold together in a run of the reference, by where they stand."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rapc.base.source import Span
from rapc.ir import nodes
from tests.reference.queries import Asker
from tests.reference.run import Run
from tests.reference.searching import Before
from tests.reference.tasks import Task
from tests.reference.terms import Bindings

Spans = frozenset[Span]
"""Where formulas stand that hold, or have no solution as a `not` says, at one time."""


class Holding:
    """What has held together, as long as a run is watched.

    `together` are all formulas that had a solution, each with its parts; `chosen` those
    of contexts, with the `repeat-while` before them; `choosing` the RAPs of the tasks
    that came to choose a method, and could.

    Args:
        monkeypatch: puts this between the reference and its questions.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.together: set[Spans] = set()
        self.chosen: set[Spans] = set()
        self.choosing: set[str] = set()
        #: By its id, each `or` that has a solution, and the branch that has it.
        self._taken: dict[int, tuple[nodes.Or, nodes.Formula]] = {}
        solutions, first, holds = Asker.solutions, Asker.first, Run.holds

        def watched(
            asker: Asker, formula: nodes.Formula, env: Bindings, before: Before
        ) -> Iterator[Bindings]:
            if isinstance(formula, nodes.Or):
                for part in formula.parts:
                    for found in asker.solutions(part, env, before):
                        self._taken[id(formula)] = formula, part
                        yield found
            elif isinstance(formula, nodes.Not):
                if next(asker.solutions(formula.part, env, before), None) is None:
                    yield env
                else:
                    self.together.add(self._parts(formula.part))
            else:
                yield from solutions(asker, formula, env, before)

        def asked(
            asker: Asker, formula: nodes.Formula, env: Bindings
        ) -> Bindings | None:
            found = first(asker, formula, env)
            if found is not None:
                self.together.add(self._parts(formula))
            return found

        def stated(
            run: Run,
            task: Task | None,
            formula: nodes.Formula | None,
            env: Bindings,
            clause: str,
            where: nodes.Node | None = None,
        ) -> Bindings | None:
            found = holds(run, task, formula, env, clause, where)
            if clause.startswith("context of method") and found is not None:
                assert task is not None
                assert formula is not None
                self.choosing.add(task.rap.name)
                self.chosen.add(self._parts(formula))
            return found

        monkeypatch.setattr(Asker, "solutions", watched)
        monkeypatch.setattr(Asker, "first", asked)
        monkeypatch.setattr(Run, "holds", stated)

    def _parts(self, formula: nodes.Formula) -> Spans:
        """Return where the parts stand of a formula that has just had a solution."""
        found, waiting = set[Span](), [formula]
        while waiting:
            here = waiting.pop()
            found.add(here.span)
            if isinstance(here, nodes.And):
                waiting += here.parts
            elif isinstance(here, nodes.Not):
                found.add(here.part.span)
            elif isinstance(here, nodes.Or):
                _, part = self._taken[id(here)]
                waiting.append(part)
        return frozenset(found)
