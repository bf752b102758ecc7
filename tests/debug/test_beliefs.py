"""The debugger tells when belief and truth parted, and through what."""

from __future__ import annotations

import random

import pytest

import rapc
from rapc.base.values import Fact
from rapc.debug.acts import AssertFact
from rapc.debug.breakpoints import Breakpoint, Breakpoints
from rapc.debug.discrepancies import Discrepancies
from rapc.debug.history import History
from rapc.debug.questions.beliefs import belief
from rapc.debug.questions.times import timeline
from rapc.errors import ArgumentError
from rapc.events import Event, RunEnded, TaskSelected
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell
from tests.debug import moments
from tests.debug.sessions import scripted
from tests.repl.shells import said

COLUMNS = ["believed", "since", "by", "truth", "wrong from", "cycle", "to"]


def courier() -> History:
    """Return a session in which the courier drives and loads."""
    library = rapc.load("examples/courier")
    return History.open(library, "courier", agenda="shift", seed=1)


def rows(history: History, *fact: str) -> list[list[object]]:
    """Return the rows of `:belief`."""
    found = belief(history, *fact).rows
    return [[one[name] for name in COLUMNS] for one in found]


def put_wrong(history: History) -> None:
    """Let the robot believe that it has docked."""
    history.act(AssertFact(("docked",)))


def test_belief_is_wrong_from_the_next_cycle_on() -> None:
    history = courier()
    history.goto(5)
    put_wrong(history)
    time = history.now
    history.step()
    assert rows(history) == [["(docked)", time, "user", "not so", history.now, 6, None]]


def test_parting_ends_when_the_belief_goes() -> None:
    history = courier()
    history.goto(5)
    put_wrong(history)
    history.step()
    begun = history.now
    history.goto(60)
    first = rows(history, "(docked)")[0]
    assert first[4] == begun
    assert isinstance(first[6], int | float)
    assert first[6] > begun


def test_past_wrong_beliefs_are_listed_without_a_present_one() -> None:
    history = courier()
    assert belief(history).lines == ("no wrong beliefs",)
    history.goto(5)
    put_wrong(history)
    history.step()
    assert belief(history).lines == ()
    history.goto(60)
    told = belief(history)
    assert told.lines == ("no present wrong beliefs; wrong beliefs of the past:",)
    assert rows(history) == rows(history, "(docked)")
    history.goto(7)
    assert belief(history).lines == ()


def test_going_back_gives_the_answer_of_then() -> None:
    history = courier()
    history.goto(5)
    put_wrong(history)
    history.step()
    then = rows(history)
    history.goto(60)
    history.goto(6)
    assert rows(history) == then
    history.goto(4)
    assert rows(history) == []
    history.goto(60)
    assert len(rows(history, "(docked)")) == 1


def test_branches_have_their_own_partings() -> None:
    history = courier()
    history.goto(30)
    history.goto(5)
    put_wrong(history)
    history.step()
    assert len(rows(history)) == 1
    history.switch("main")
    history.goto(6)
    assert rows(history) == []


def test_sound_run_has_no_partings_of_the_place() -> None:
    history = courier()
    history.go()
    assert history.over
    assert rows(history, "(robot-at ?)") == []


def test_world_without_truth_is_refused() -> None:
    history = scripted(
        "(define-rap (nothing) (method (primitive (look))))"
        "(declare-primitive look () (okay))",
        "(nothing)",
    )
    with pytest.raises(ArgumentError, match="has no method `truth`"):
        belief(history)
    with pytest.raises(ArgumentError, match="has no method `truth`"):
        Breakpoints(history).add(Breakpoint("untrue", "(docked)"))


def test_unknown_fact_is_refused() -> None:
    with pytest.raises(ArgumentError, match="did you mean `docked`"):
        belief(courier(), "(dockd)")


def test_breakpoint_stops_at_the_first_wrong_belief() -> None:
    shell = Shell(courier(), commands())
    shell.history.goto(5)
    put_wrong(shell.history)
    told = said(shell, ":break untrue (docked)", ":run")
    assert "(docked) is untrue" in told
    assert shell.history.cycle == 6


def test_comparing_does_not_change_the_trace() -> None:
    history, serials = courier(), list[int]()
    history.go()
    library = rapc.load("examples/courier")
    listeners = [lambda event: serials.append(event.n)]
    run = library.start("courier", agenda="shift", seed=1, listeners=listeners)
    run.run()
    assert (history.serial, history.now) == (serials[-1] + 1, run.now)


def test_timeline_lists_wrong_beliefs() -> None:
    history = courier()
    history.goto(5)
    put_wrong(history)
    history.goto(60)
    first = rows(history, "(docked)")[0]
    marks = [one for one in timeline(history).rows if "wrong" in str(one["what"])]
    assert [(one["from"], one["to"], one["what"]) for one in marks] == [
        (first[4], first[6], "wrong belief: (docked)")
    ]


def test_breakpoint_stops_at_the_same_cycle_after_going_back() -> None:
    shell = Shell(courier(), commands())
    shell.history.goto(5)
    put_wrong(shell.history)
    shell.history.goto(60)
    said(shell, ":goto 2", ":break untrue (docked)", ":run")
    assert shell.history.cycle == 6


WRONG: dict[str, Fact] = {
    "courier": ("docked",),
    "truck": ("truck-heading", "west"),
    "hallway": ("current-space", "robot", "kitchen"),
}
"""A fact that is seldom true, by run."""


@pytest.mark.parametrize("name", WRONG)
def test_discrepancies_equal_a_comparison_in_each_cycle(name: str) -> None:
    session = moments.RUNS[name](400)
    each = Discrepancies()
    run, dice = session.run, random.Random(8)

    def compare(event: Event) -> None:
        if event.n >= each.compared:
            each.compare(event, run.wrong_beliefs())

    run.listen(compare, TaskSelected, RunEnded)
    for _ in range(12):
        session.step(dice.randrange(40))
        session.act(AssertFact(WRONG[name]))
        back = session.moment
        session.goto(dice.randrange(session.cycle + 1))
        session.goto(back)
    assert len(each.all) > 3
    assert session.branch.discrepancies.all == each.all


def test_fact_may_be_given_by_its_name() -> None:
    history = courier()
    history.goto(5)
    put_wrong(history)
    history.step()
    assert rows(history, "docked") == rows(history, "(docked)") != []
