"""Breakpoints stop where they say, as often as they say."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc import events
from rapc.debug.breakpoints import Breakpoint, Breakpoints
from rapc.debug.find import find_event
from rapc.debug.history import History
from rapc.debug.questions.differences import diff
from rapc.errors import ArgumentError, TextError
from rapc.repl.commands.table import commands
from rapc.repl.complete import candidates
from rapc.repl.shell import Shell
from tests.debug import moments
from tests.debug.sessions import row, scripted, truck
from tests.repl.shells import said, truck_shell


def _with(*points: Breakpoint) -> tuple[History, Breakpoints]:
    session = truck()
    found = Breakpoints(session)
    for point in points:
        found.add(point)
    return session, found


def _cycles(session: History) -> list[int]:
    """Run to the end and return the cycles at whose end the run has stopped."""
    found = []
    while session.go().kind == "break":
        found.append(session.cycle)
    return found


@pytest.mark.parametrize(
    ("point", "kind", "wanted"),
    [
        (
            Breakpoint("rap", "travel-road"),
            events.TaskSelected,
            lambda keys: keys["goal"].name == "travel-road",
        ),
        (
            Breakpoint("rap", "(travel-road ?from ?way zone-2)"),
            events.TaskSelected,
            lambda keys: keys["goal"].inputs[2:] == ("zone-2",),
        ),
        (
            Breakpoint("method", "outside"),
            events.MethodChosen,
            lambda keys: keys["method"] == "outside",
        ),
        (
            Breakpoint("primitive", "(arm-grasp ? ?)"),
            events.PrimitiveRequested,
            lambda keys: keys["request"][0] == "arm-grasp",
        ),
        (
            Breakpoint("fact", "(location ?thing bay2)"),
            events.FactAsserted,
            lambda keys: keys["fact"][0] == "location" and keys["fact"][2] == "bay2",
        ),
    ],
)
def test_a_run_stops_wherever_it_happens(
    point: Breakpoint, kind: type, wanted: object
) -> None:
    session, _ = _with(point)
    stopped = _cycles(session)
    kinds = (kind, events.FactErased) if kind is events.FactAsserted else (kind,)
    told = session.scan(*kinds, want=lambda one: wanted(one.keys))  # type: ignore[operator]
    assert stopped == sorted({one.cycle for one in told})
    assert stopped


TWICE = """
(declare-primitive walk (?place) (okay))
(define-rap (fetch) (method carry (task-net (t1 (bring)))))
(define-rap (bring) (method carry (primitive (walk dock))))
"""


@pytest.mark.parametrize(
    ("what", "cycles"),
    [("carry", [1, 2]), ("carry of fetch", [1]), ("Carry of BRING", [2])],
)
def test_method_breakpoint_stops_in_the_rap_it_names(
    what: str, cycles: list[int]
) -> None:
    session = scripted(TWICE, "(fetch)", rows=(row("(walk dock)"),))
    points = Breakpoints(session)
    points.add(Breakpoint("method", what))
    assert _cycles(session) == cycles


def test_method_breakpoint_tells_the_raps_it_stands_for() -> None:
    shell = Shell(scripted(TWICE, "(fetch)", rows=(row("(walk dock)"),)), commands())
    text = said(shell, ":break method carry", width=200)
    assert "`carry` is a method of `fetch`, `bring`; `:break method carry of f" in text
    text = said(shell, ":break method carry of bring after 0", width=200)
    assert text == "breakpoint 2: method carry of bring\n"
    assert "stopped: breakpoint 1 (method carry): method-chosen carry of fetch [1]" in (
        said(shell, ":run", width=200)
    )
    assert [one.text for one in candidates(shell, ":break method carry of ")] == [
        "bring",
        "fetch",
    ]
    assert "of" in [one.text for one in candidates(shell, ":break method carry ")]


def test_conditions_counts_and_logs() -> None:
    session, points = _with(
        Breakpoint("primitive", "(truck-move)", condition="(truck-location zone-2)"),
        Breakpoint("primitive", "(truck-move)", passes=6),
        Breakpoint("primitive", "(truck-move)", logs=True),
    )
    moves = session_moves()
    assert _cycles(session) == [moves[2], moves[4], moves[6]]
    assert len(points.logged) == len(moves)


def session_moves() -> list[int]:
    """Return the cycles in which the truck moves."""
    session = truck()
    session.go()
    told = session.scan(events.PrimitiveRequested)
    return [o.cycle for o in told if o.keys["request"][0] == "truck-move"]


def test_changed_query_and_time_stop_the_run() -> None:
    session, _ = _with(
        Breakpoint("true", "(truck-location zone-4)", before=True),
        Breakpoint("false", "(truck-location zone-4)"),
        Breakpoint("time", "150"),
    )
    session.go()
    assert not session.run.question("(truck-location zone-4)").holds()
    session.step()
    assert session.run.question("(truck-location zone-4)").holds()
    session.go()
    assert not session.run.question("(truck-location zone-4)").holds()
    session.go()
    assert session.now >= 150
    session.goto(session.cycle - 1)
    assert session.now < 150


def test_nothing_stops_a_replay() -> None:
    session, _ = _with(Breakpoint("rap", "travel-road"))
    session.goto(100)
    session.go()
    session.goto(90)
    assert session.cycle == 90


def test_invalid_breakpoint_is_reported() -> None:
    session, points = _with()
    for point, said_of in (
        (Breakpoint("frob"), "unknown kind of breakpoint `frob`"),
        (Breakpoint("rap", "fill-oder"), "did you mean `fill-order`"),
        (Breakpoint("method", "outsid"), "did you mean `outside`"),
        (Breakpoint("method", "outside of travel-road"), "has no method `outside`"),
        (Breakpoint("method", "outside of travel-raod"), "mean `travel-road`"),
        (Breakpoint("true", "(frob)"), "unknown predicate `frob`"),
        (Breakpoint("time", "noon"), "expected a number"),
    ):
        with pytest.raises((ArgumentError, TextError, ValueError), match=said_of):
            points.add(point)
    with pytest.raises(ArgumentError, match="unknown breakpoint 4"):
        points.remove(4)
    assert not points.all
    assert not session.checks


def test_breakpoints_are_kept_in_a_file(tmp_path: Path) -> None:
    kept = tmp_path / "points.json"
    shell = truck_shell()
    shell.answer(":break rap travel-road after 2 if (place depot depot)")
    shell.answer(":break deadline log")
    assert "2 breakpoints" in said(shell, f":break save {kept}")
    other = truck_shell()
    text = said(other, f":break load {kept}")
    assert "rap travel-road if (place depot depot) after 2" in text
    for damaged in (b"[{}]", b'[{"kind":"\xff"}]', b'[{"x":' + b"[" * 100_000):
        kept.write_bytes(damaged)
        assert "is not a list of breakpoints" in said(
            other, f":break load {kept}", width=300
        )
    assert "cannot read" in said(other, f":break load {tmp_path / 'none'}")
    assert "no breakpoints" in said(other, ":unbreak all")


def test_watches_are_marked_where_they_change() -> None:
    shell = truck_shell()
    shell.answer(":show none")
    assert said(shell, ":watch (truck-location ?where)") == (
        "  watch 1 (truck-location ?where): ?where unknown\n"
    )
    assert "* watch 1 (truck-location ?where): ?where depot" in said(shell, ":step 2")
    assert "  watch 1 (truck-location ?where): ?where depot" in said(shell, ":step 2")
    assert said(shell, ":unwatch 1") == "no watches\n"
    assert "unknown watch 3" in said(shell, ":unwatch 3")
    assert "unknown predicate `frob`" in said(shell, ":watch (frob)")


def test_events_are_found_back_and_forth() -> None:
    session = truck()
    grasp = find_event(session, "primitive-ended", ["arm-grasp"])
    assert grasp is not None
    assert session.cycle == grasp.cycle
    back = find_event(session, "method-chosen", ["rap=travel-road"], back=True)
    assert back is not None
    assert session.cycle == back.cycle < grasp.cycle
    here = session.cycle
    assert find_event(session, "task-failed") is None
    assert session.cycle == here
    with pytest.raises(TextError, match="did you mean `task-failed`"):
        find_event(session, "task-faild")


FAILS = """
(declare-primitive walk (?place) (okay blocked))
(define-rap (go) (method there (primitive (walk dock))))
"""


def test_search_in_vain_tells_the_events_before() -> None:
    shell = Shell(
        scripted(FAILS, "(go)", rows=(row("(walk dock)", "blocked"),)), commands()
    )
    shell.answer(":run")
    assert said(shell, ":find task-failed").splitlines()[:2] == [
        "no event task-failed after this cycle",
        "1 event before this cycle: use `:find back task-failed`",
    ]
    text = said(shell, ":find method-ended result=blocked")
    assert (
        "events before this cycle: use `:find back method-ended result=blocked`" in text
    )
    last = shell.history.cycle
    assert f"in cycle {last}\n" in said(shell, ":find back task-failed")
    assert "no event task-failed before this cycle" in said(
        shell, ":find back task-failed"
    )
    assert "events before" not in said(shell, ":find signal")


def test_two_moments_are_compared() -> None:
    session = truck()
    session.goto(60)
    found = diff(session, "20 60")
    assert found.table is not None
    assert ("+", "fact", "(truck-location quarry-1)") in found.table.rows
    assert ("-", "fact", "(truck-location zone-6)") in found.table.rows
    assert any(row[0] == "-" and "[10]" in str(row[2]) for row in found.table.rows)
    assert session.cycle == 60


def test_breakpoint_before_an_arrival_stops_at_the_end_of_the_cycle() -> None:
    session = moments.courier(1000)
    session.checks.clear()
    points = Breakpoints(session)
    points.add(Breakpoint("fact", "(call ?)", before=True))
    while (stop := session.wait()).kind == "asked":
        here = session.moment
    assert stop.kind == "break"
    assert session.moment == (here.cycle, 0, 0)
    while not session.question("(call ?)").holds():
        assert session.wait().kind == "asked"
    assert session.cycle == here.cycle
    assert session.between
