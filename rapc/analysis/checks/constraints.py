"""RAP129: steps that undo what a constraint asks for, themselves or by what they do.

A constraint is asked at each selection of each task below [L 3.21]. So it is broken as
soon as a step surely undoes the fact, at whatever depth, and any other one is to come.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.task_nets import TASK_NETS, Net
from rapc.analysis.checks.threats import WORLD
from rapc.analysis.facts.effects import done
from rapc.analysis.facts.logic import Literal, contradict, fact_name, literals
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_goal

BROKEN = Rule(
    code="RAP129",
    name="broken-constraint",
    severity=Severity.WARNING,
    summary="a step undoes what a constraint asks for while other steps are left",
    why="""`constraints` have to hold for all that is done below (T 4.4.3). A step that
surely makes one false is the end of those that come after it: they fail with
`interference`. Ask for it in the context, if it has to hold at first only, or let the
step come last.""",
    ignore="where the steps that are left are to be dropped then",
    source="T 4.4.3, 5.3.4",
    example=WORLD
    + """\
(define-rap (deliver)
  (method
    (constraints (bay-open))
    (task-net
      (t1 (close) (for t2))
      (t2 (empty)))))
""",
    better=WORLD
    + """\
(define-rap (deliver)
  (method
    (constraints (bay-open))
    (task-net
      (t1 (empty) (for t2))
      (t2 (close)))))
""",
)


_FAR = 5
"""So many RAPs deep steps are followed."""

_MOST = 200
"""So many goals below the steps of one method are looked at."""


@check(BROKEN, needs_whole="method")
def constraints(run: Pass) -> Iterator[Diagnostic]:
    """Find steps that undo what a constraint above them asks for."""
    nets = run.result(TASK_NETS)
    for rap in run.library.raps.values():
        for method in rap.methods:
            net = nets.get(id(method.body))
            asked = [*literals(rap.constraints), *literals(method.constraints)]
            asked = [one for one in asked if fact_name(one)]
            if isinstance(method.body, nodes.TaskNet) and net is not None and asked:
                yield from _broken(run, method.body.steps, net, asked)


def _broken(
    run: Pass, steps: Sequence[nodes.Step], net: Net, asked: Sequence[Literal]
) -> Iterator[Diagnostic]:
    """Yield the first step that surely undoes what is asked while others are left."""
    if net.broken or net.order is None:
        return
    left = _left(net)
    search = _Search(run, asked)
    for far in (0, _FAR):
        for at, step in enumerate(steps):
            found = search.undoing(step.goal, left[at], far)
            if found is not None:
                yield _finding(step, *found)
                return


def _left(net: Net) -> list[bool]:
    """Return of each step whether any other one may come up when it has ended."""
    before, _ = net.reach()
    everything = (1 << len(before)) - 1
    return [there | 1 << at != everything for at, there in enumerate(before)]


_Undone = tuple[Literal, nodes.Goal]
"""A fact that is asked for, and the goal that surely undoes it."""


class _Search:
    """A search for what undoes facts, in the steps of a method and below these.

    Args:
        run: the run of the pass.
        asked: the facts, in the terms of the method.
    """

    def __init__(self, run: Pass, asked: Sequence[Literal]) -> None:
        self._run = run
        self._asked: dict[str, list[Literal]] = {}
        for one in asked:
            self._asked.setdefault(fact_name(one), []).append(one)
        self._below = 0

    def undoing(self, goal: nodes.Goal, left: bool, far: int) -> _Undone | None:
        """Return what surely undoes a fact: a goal, or one below; None if nothing.

        Args:
            goal: the goal, in the terms of the method.
            left: whether anything is to come when the goal is reached.
            far: how many RAPs deep its steps are followed.
        """
        library = self._run.library
        for effect in done(library, goal) if left else ():
            for wanted in self._asked.get(fact_name(effect), ()):
                if contradict(self._run.signatures, wanted, effect):
                    return wanted, goal
        rap = library.raps.get(goal.name)
        if rap is None or not far or not rap.methods:
            return None
        pairs = zip(rap.inputs, goal.args, strict=False)
        given = {variable.name: term for variable, term in pairs}
        found = [self._in_method(method, given, left, far) for method in rap.methods]
        return found[0] if all(one is not None for one in found) else None

    def _in_method(
        self,
        method: nodes.Method,
        given: Mapping[str, nodes.Term],
        left: bool,
        far: int,
    ) -> _Undone | None:
        net = self._run.result(TASK_NETS).get(id(method.body))
        if not isinstance(method.body, nodes.TaskNet) or net is None:
            return None
        if net.broken or net.order is None:
            return None
        more = _left(net)
        for at, step in enumerate(method.body.steps):
            self._below += 1
            if at in net.early or self._below > _MOST:
                continue
            goal = _handed(step.goal, given, far)
            found = self.undoing(goal, left or more[at], far - 1)
            if found is not None:
                return found
        return None


def _handed(goal: nodes.Goal, given: Mapping[str, nodes.Term], far: int) -> nodes.Goal:
    """Return a goal in the terms of the caller; what has no term there is like none."""
    args: list[nodes.Term] = []
    for at, term in enumerate(goal.args):
        if isinstance(term, nodes.Const):
            args.append(term)
        elif isinstance(term, nodes.Var) and term.name in given:
            args.append(given[term.name])
        else:
            args.append(nodes.Var(f"?{goal.name} {far} {at}"))
    return msgspec.structs.replace(goal, args=tuple(args))


def _finding(step: nodes.Step, wanted: Literal, by: nodes.Goal) -> Diagnostic:
    labels = [Label(wanted.span, "asked here")]
    way = ""
    if by.span != step.goal.span:
        labels.append(Label(by.span, f"`{format_goal(by)}` does"))
        way = " on its way"
    return BROKEN.at(
        step.goal.span,
        f"step `{step.tag}` undoes `{format_formula(wanted.formula)}`{way}, a "
        "constraint of the steps that are left",
        labels=tuple(labels),
        help="let it come last, or ask for this in the context",
    )
