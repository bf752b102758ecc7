"""Slips that show only where the whole library is looked at: files, agendas, sensing.

As in `bench.mutation_words`, a kind yields every place where the slip can be made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os.path import basename

from bench.mutation_base import Base, Edit, Kind, negated
from rapc.analysis.facts.logic import is_never
from rapc.base.source import Span
from rapc.ir import nodes


def _require_dropped(base: Base) -> Iterator[Edit]:
    for form in base.library.forms:
        if isinstance(form, nodes.Require):
            yield Edit(form.span, "", f"{basename(form.name)}.rap")


def _goal_of_loop_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if rap.repeat_while is not None and rap.succeed is not None:
            yield Edit(base.around(rap.succeed.span), "", rap.name)


def _round_remembers_nothing(base: Base) -> Iterator[Edit]:
    """A loop over things does not remember which it has dealt with."""
    for rap in base.raps:
        loop = rap.repeat_while
        if isinstance(loop, nodes.And):
            for part in loop.parts:
                if isinstance(part, nodes.Not) and isinstance(part.part, nodes.SetTest):
                    yield Edit(part.span, "")


def _look_seldom(base: Base) -> Iterator[Edit]:
    """A task that looks again and again does so a hundred times more seldom."""
    for one in base.index.of(nodes.MonitorTime):
        for term in (one.node.start, one.node.stop):
            if not isinstance(term, nodes.Const):
                break
        else:
            said = [base.text(term.span) for term in (one.node.start, one.node.stop)]
            if all(word.isdigit() for word in said):
                whole = one.node.start.span.to(one.node.stop.span)
                yield Edit(whole, f"{said[0]}00 {said[1]}00")


def _condition_for_monitor(base: Base) -> Iterator[Edit]:
    """A fact of the monitor of a standing task is made a condition of it."""
    for rap in base.raps:
        monitor = rap.monitor_state
        if isinstance(monitor, nodes.And) and _stands(rap):
            for part in monitor.parts:
                if isinstance(part, nodes.Proposition):
                    text = base.text(monitor.span).replace(base.text(part.span), "", 1)
                    end = base.around(monitor.span).end
                    more = f")\n  (preconditions {base.text(part.span)})"
                    yield Edit(
                        Span(rap.span.file, monitor.span.start, end), text + more
                    )


def _standing_with_a_goal(base: Base) -> Iterator[Edit]:
    """What a standing task brings about is made its goal."""
    for rap in base.raps:
        if _stands(rap) and rap.succeed is not None and rap.monitor_state is not None:
            goal = negated(base, rap.monitor_state)
            yield Edit(rap.succeed.span, goal.content)


def _stands(rap: nodes.DefineRap) -> bool:
    """Whether a RAP is never done."""
    return is_never(rap.succeed)


def _promise_turned_round(base: Base) -> Iterator[Edit]:
    """An effect that a RAP declares is the contrary of what it brings about."""
    for rap in base.raps:
        for effect in rap.effects:
            text = base.text(effect.pattern.span)
            yield Edit(effect.span, text if effect.negated else f"(not {text})")


def _context_as_constraint(base: Base) -> Iterator[Edit]:
    """What has to hold at first is asked for all the while."""
    for _, method, _ in base.nets():
        if method.context is not None and method.constraints is None:
            whole = base.around(method.context.span)
            if base.text(whole).startswith("(context"):
                word = Span(whole.file, whole.start + 1, whole.start + len("(context"))
                yield Edit(word, "constraints")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "`require` dropped": ("names", _require_dropped),
    "`succeed` of a loop dropped": ("loops", _goal_of_loop_dropped),
    "loop remembers nothing": ("loops", _round_remembers_nothing),
    "looks a hundred times more seldom": ("sensing", _look_seldom),
    "fact of a monitor made a condition": ("monitors", _condition_for_monitor),
    "standing task with a goal": ("monitors", _standing_with_a_goal),
    "constraint for a context": ("methods", _context_as_constraint),
    "promise turned round": ("effects", _promise_turned_round),
}
"""Every kind of slip here, with the group that it is of."""
