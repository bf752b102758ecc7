"""What just happened, written as a test."""

from __future__ import annotations

from pathlib import Path

import pytest

import rapc
from rapc import events
from rapc.debug.history import History
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell
from rapc.runtime.task_request import TaskRequest
from rapc.testing.discover import find
from rapc.testing.run import Status, run_case
from rapc.world import Kit
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld
from rapc.worlds.truck import TruckWorld
from tests.debug.sessions import TRUCK, row, truck
from tests.repl.shells import said

ARMS = """
(declare-primitive grasp (?thing) (okay dropped))
(declare-primitive look (?thing) (okay) :atomic false)
(declare-memory-proposition held (?thing))
(declare-memory-proposition seen (?thing))
(declare-memory-proposition idle (?thing))
(define-rap (pick-up ?thing)
  (succeed (held ?thing))
  (method (context (seen ?thing)) (primitive (grasp ?thing)))
  (method (context (not (seen ?thing))) (primitive (look ?thing))))
"""

DROPS = (
    row("(look box)", "okay", 0, after=3, asserts=(("seen", "box"), ("idle", "cup"))),
    row("(grasp box)", "dropped", 2, times=1),
)

CATCHES = (row("(grasp box)", "okay", 1, asserts=(("held", "box"),)),)


def arms(
    folder: Path, *rows: object, task: str | TaskRequest = "(pick-up box)"
) -> Shell:
    """Return a shell with a library in a folder and a world that answers by rows."""
    path = folder / "arms.rap"
    path.write_text(ARMS, encoding="utf-8")
    library = rapc.load(path)
    world = ScriptedWorld(list(rows), declared=library.program.library)  # type: ignore[arg-type]
    session = History.open(library, world, tasks=[task] if task else [])
    return Shell(session, commands(), [str(path)])


def statuses(path: Path) -> list[Status]:
    """Return what becomes of the tests in a file."""
    return [run_case(case).status for case in find([path]).cases]


def test_exported_test_contains_only_relevant_parts(tmp_path: Path) -> None:
    shell = arms(tmp_path, *DROPS, *CATCHES)
    path = tmp_path / "dropped.test.rap"
    told = said(shell, ":run", f":export-test {path}", width=400)
    assert told.strip() == f"test dropped written to {path}; the test passes now"
    text = path.read_text(encoding="utf-8")
    assert '(require "arms")' in text
    assert "(seen box)" in text
    assert "idle" not in text
    assert ":after 3" in text
    assert statuses(path) == [Status.PASSED]


def test_it_fails_once_the_library_does_something_else(tmp_path: Path) -> None:
    path = tmp_path / "caught.test.rap"
    said(arms(tmp_path, *DROPS[:1], *CATCHES), ":run", f":export-test {path}")
    assert statuses(path) == [Status.PASSED]
    other = ARMS.replace("(primitive (look", "(primitive (grasp")
    (tmp_path / "arms.rap").write_text(other, encoding="utf-8")
    assert statuses(path) == [Status.FAILED]


def test_failure_is_exported_as_an_expectation(tmp_path: Path) -> None:
    shell = arms(tmp_path, DROPS[0], row("(grasp box)", "dropped", 2))
    path = tmp_path / "gave-up.test.rap"
    assert "passes now" in said(shell, ":run", f":export-test {path}", width=400)
    assert "(fails (pick-up box) dropped)" in path.read_text(encoding="utf-8")
    assert statuses(path) == [Status.PASSED]


def test_unmet_condition_fails_now(tmp_path: Path) -> None:
    shell = arms(tmp_path, DROPS[0], row("(grasp box)", "dropped", 2))
    path = tmp_path / "wanted.test.rap"
    told = said(shell, ":run", f":export-test {path} succeeds", width=400)
    assert "the test fails now" in told
    assert "(succeeds (pick-up box))" in path.read_text(encoding="utf-8")
    assert statuses(path) == [Status.FAILED]


def test_hallway_run_becomes_a_test(tmp_path: Path) -> None:
    """The test is shortened by trials, in some of which no fact tells the space."""
    path = tmp_path / "errand.test.rap"
    session = History.open(
        rapc.load("stdlib/hallway"), "hallway", agenda="errand", seed=1
    )
    shell = Shell(session, commands(), ["stdlib/hallway"])
    told = said(shell, ":to 8", f":export-test {path}", width=400)
    assert "the test passes now" in told
    assert statuses(path) == [Status.PASSED]


def test_exported_test_has_user_acts(tmp_path: Path) -> None:
    shell = arms(tmp_path, *CATCHES, task="")
    path = tmp_path / "by-hand.test.rap"
    said(shell, ":assert (seen box)", "(pick-up box) :priority 2", ":run")
    assert "passes now" in said(shell, f":export-test {path}", width=400)
    text = path.read_text(encoding="utf-8")
    assert "(seen box)" in text
    assert "(task (pick-up box) :priority 2)" in text
    assert statuses(path) == [Status.PASSED]


@pytest.mark.slow
def test_a_run_of_the_truck_with_items_becomes_a_test(tmp_path: Path) -> None:
    shell = Shell(truck(), commands(), [TRUCK])
    path = tmp_path / "on-the-way.test.rap"
    assert "passes now" in said(shell, ":to 60", f":export-test {path}", width=400)
    text = path.read_text(encoding="utf-8")
    assert ":data ((object-seen" in text
    assert "opposite" not in text
    assert statuses(path) == [Status.PASSED]


STOWED = """
(define-rap (stowed)
  (monitor-state (location ?rock bay2))
  (succeed (location ?rock bay2))
  (method (task-net)))
"""
"""A task that is done at once when a rock is in the bay."""


@pytest.mark.slow
def test_truck_run_with_a_moved_item_becomes_a_test(tmp_path: Path) -> None:
    path = tmp_path / "orders.rap"
    text = Path(TRUCK).read_text(encoding="utf-8")
    path.write_text(text + STOWED, encoding="utf-8")
    orders = History.open(
        rapc.load(path), "truck", tasks=["(rock-order red 1)"], seed=7
    )
    shell, test = Shell(orders, commands(), [str(path)]), tmp_path / "stowed.test.rap"
    said(shell, "(stowed) :priority 9", ":to 106")
    assert "passes now" in said(shell, f":export-test {test} 2", width=400)
    written = test.read_text(encoding="utf-8")
    assert ":moves ((item-1 bay2))" in written
    assert statuses(test) == [Status.PASSED]
    test.write_text(written.replace(":moves ((item-1 bay2))", ""), encoding="utf-8")
    assert statuses(test) == [Status.FAILED]


HANDS = """
(declare-primitive scan () (okay))
(declare-primitive grasp (?arm ?thing) (okay))
(declare-sensor-datum object-seen (?place ?thing ?kind))
(declare-memory-property class (?thing ?kind ?value) unknown)
(declare-memory-property location (?thing ?place) unknown)
(declare-indistinct-class rock)
(define-rap (take ?kind ?arm)
  (succeed (and (class ?thing ?kind true) (location ?thing ?arm)
                (class ?other jug true) (location ?other unknown)))
  (method (context (not (class ? ?kind true))) (primitive (scan)))
  (method (context (class ?thing ?kind true)) (primitive (grasp ?arm ?thing))))
"""


class _Hands(ScriptedWorld):
    """A world whose handlers move and lose items; data are handled as the truck's."""

    name = "truck"


def test_exported_test_has_moved_and_lost_items(tmp_path: Path) -> None:
    path, test = tmp_path / "hands.rap", tmp_path / "taken.test.rap"
    path.write_text(HANDS, encoding="utf-8")
    library = rapc.load(path)
    seen = (
        ("object-seen", "shelf", "r7", "rock"),
        ("object-seen", "shelf", "jug", "jug"),
    )
    rows = [
        Row(("scan",), data=seen),
        Row(("grasp", "?arm", "?x"), moves=(("?x", "?arm"),), loses=("jug",)),
    ]
    declared = library.program.library
    world = _Hands(rows, declared=declared, kit=TruckWorld.kit)
    shell = Shell(
        History.open(library, world, tasks=["(take rock left)"]),
        commands(),
        [str(path)],
    )
    assert "passes now" in said(shell, ":run", f":export-test {test}", width=400)
    written = test.read_text(encoding="utf-8")
    assert (
        "((grasp left r7) okay :times 1 :moves ((item-1 left)) :loses (jug))" in written
    )
    assert "(succeeds (take rock left))" in written
    assert statuses(test) == [Status.PASSED]
    path.write_text(HANDS.replace("(grasp ?arm", "(grasp right"), encoding="utf-8")
    assert statuses(test) == [Status.FAILED]


@pytest.mark.slow
def test_a_whole_order_becomes_a_test(tmp_path: Path) -> None:
    """Names lapse on roads and things are counted: what the data bring is told, too."""
    shell = Shell(truck(), commands(), [TRUCK])
    path = tmp_path / "all.test.rap"
    told = said(shell, ":run", f":export-test {path}", width=400)
    assert "passes now" in told
    assert "(new-location " in path.read_text(encoding="utf-8")
    assert statuses(path) == [Status.PASSED]


LUCKY = """
(declare-primitive draw () (okay))
(declare-memory-function lucky ())
(declare-memory-proposition drawn (?lot))
(define-rap (try-luck) (succeed (lucky)) (method (primitive (draw))))
"""


def test_run_beyond_scripts_cannot_be_exported(tmp_path: Path) -> None:
    """What a function of the host answers stands in no event."""
    path, test = tmp_path / "lucky.rap", tmp_path / "drawn.test.rap"
    path.write_text(LUCKY, encoding="utf-8")
    library = rapc.load(path)
    kit = Kit(functions={"lucky": lambda memory: memory.now() >= 3})
    rows = [Row(("draw",), takes=1)]
    world = ScriptedWorld(rows, declared=library.program.library, kit=kit)
    session = History.open(library, world, tasks=["(try-luck)"])
    shell = Shell(session, commands(), [str(path)])
    told = said(shell, ":run", f":export-test {test}", width=400)
    assert "a script cannot repeat this run" in told
    assert not test.exists()


def test_exported_test_has_tasks_of_a_program(tmp_path: Path) -> None:
    shell = arms(tmp_path, *DROPS, *CATCHES, task=TaskRequest(("pick-up", "box"), 3))
    path = tmp_path / "given.test.rap"
    said(shell, ":run", f":export-test {path}")
    assert "(task (pick-up box) :priority 3)" in path.read_text(encoding="utf-8")
    assert statuses(path) == [Status.PASSED]


@pytest.mark.parametrize(
    "task",
    ["(pick-up box) :priority 2 :at 7", "(Pick-up  box)  :at  7.0 :priority 2"],
)
def test_later_task_is_submitted_at_its_time(tmp_path: Path, task: str) -> None:
    shell = arms(tmp_path, *DROPS, *CATCHES, task=task)
    path = tmp_path / "later.test.rap"
    assert "passes now" in said(shell, ":run", f":export-test {path}", width=400)
    written = path.read_text(encoding="utf-8")
    assert "(at 7 (task (pick-up box) :priority 2))" in written
    assert statuses(path) == [Status.PASSED]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("run.rap", "must end with `.test.rap`"),
        ("new.test.rap 99", "unknown task [99]"),
        ("new.test.rap 1 often", "unexpected argument `often`"),
        ("there.test.rap", "cannot write"),
        ("", "missing file"),
    ],
)
def test_unwritable_export_is_refused(tmp_path: Path, given: str, message: str) -> None:
    shell = arms(tmp_path, *DROPS, *CATCHES)
    (tmp_path / "there.test.rap").write_text("; kept\n", encoding="utf-8")
    name = f"{tmp_path}/{given}" if given else ""
    assert message in said(shell, ":run", f":export-test {name}", width=400)
    assert not (tmp_path / "new.test.rap").exists()
    kept = (tmp_path / "there.test.rap").read_text(encoding="utf-8")
    assert kept == "; kept\n"


# --- in the simulator -----------------------------------------------------------------

COURIER = Path(__file__).parents[2] / "examples" / "courier"
ORDERS = "orders.rap"


def courier(
    folder: Path, *, broken: bool = False, **more: object
) -> tuple[Shell, Path]:
    """A shell with a shift of the courier, and the file of a test."""
    for file in COURIER.glob("*.rap"):
        if not file.name.endswith(".test.rap"):
            (folder / file.name).write_bytes(file.read_bytes())
    if broken:
        text = (folder / ORDERS).read_text(encoding="utf-8")
        (folder / ORDERS).write_text(broken_orders(text), encoding="utf-8")
    paths = [str(folder / "shift.rap")]
    session = History.open(
        rapc.load(paths[0]), "courier", agenda="shift", seed=4, **more
    )
    return Shell(session, commands(), paths), folder / "it.test.rap"


def broken_orders(text: str) -> str:
    """The orders of the courier with a RAP that always fails."""
    head = "(define-rap (hand-to-the-nurse (?goods goods) (?ward ward))"
    assert text.count(head) == 1
    return text.replace(head, f"{head} (preconditions nil)")


def test_run_beyond_scripts_becomes_a_test_in_the_simulator(tmp_path: Path) -> None:
    shell, path = courier(tmp_path, options={"battery": 60}, facts=["(call ward-2)"])
    said(shell, ":to 100")
    assert "passes now" in said(shell, f":export-test {path} 3", width=400)
    text = path.read_text(encoding="utf-8")
    assert "(world courier)" in text
    assert "(options (battery 60))" in text
    assert "(facts (call ward-2))" in text
    assert "(seed 4)" in text
    assert "(cycles 100)" in text
    assert "script" not in text
    assert "(active (deliver medicine ward-3))" in text
    assert statuses(path) == [Status.PASSED]


def test_wanted_success_judges_a_repaired_robot(tmp_path: Path) -> None:
    """The repaired robot sends other requests than the recorded run."""
    shell, path = courier(tmp_path, broken=True)
    said(shell, ":run")
    told = said(shell, f":export-test {path} 3 succeeds", width=400)
    assert "the test fails now" in told
    assert statuses(path) == [Status.FAILED]
    (tmp_path / ORDERS).write_bytes((COURIER / ORDERS).read_bytes())
    assert statuses(path) == [Status.PASSED]


def test_acts_of_the_user_are_acts_of_a_test_in_the_simulator(tmp_path: Path) -> None:
    shell, path = courier(tmp_path)
    said(shell, ":to 30", ":assert (call ward-2)", "(deliver linen ward-2)", ":to 60")
    told = said(shell, f":export-test {path} 3 succeeds", width=400)
    assert "written" in told
    text = path.read_text(encoding="utf-8")
    assert "(asserts (call ward-2))" in text
    assert "(task (deliver linen ward-2))" in text
    assert "saved-state" not in text


@pytest.mark.parametrize("more", ["", " succeeds"])
def test_test_begins_in_a_state_after_acts_beyond_tests(
    tmp_path: Path, more: str
) -> None:
    shell, path = courier(tmp_path)
    said(shell, ":to 30", ":retry 3", ":to 60")
    told = said(shell, f":export-test {path} 3{more}", width=400)
    state = tmp_path / "it.state"
    assert f"written to {path} and {state}" in told
    assert '(saved-state "it.state")' in path.read_text(encoding="utf-8")
    assert Status.ERROR not in statuses(path)
    again = said(shell, f":export-test {path} 3{more}", width=400)
    assert f"cannot write `{path}`" in again
    assert state.exists()


def test_test_begins_in_a_state_with_other_settings(tmp_path: Path) -> None:
    settings = rapc.Settings(futile_limit=3)
    shell, path = courier(tmp_path, settings=settings)
    said(shell, ":to 60")
    assert "it.state" in said(shell, f":export-test {path} 3", width=400)
    assert "(cycles 60)" in path.read_text(encoding="utf-8")
    assert statuses(path) == [Status.PASSED]


def test_forced_results_are_in_the_state(tmp_path: Path) -> None:
    shell, path = courier(tmp_path)
    said(shell, ":to 30", ":force (drive ward-3) blocked 2", ":to 60")
    told = said(shell, f":export-test {path} 3 succeeds", width=400)
    assert "it.state" in told
    assert statuses(path) == [Status.FAILED]


def test_state_file_in_the_way_leaves_no_test(tmp_path: Path) -> None:
    shell, path = courier(tmp_path)
    (tmp_path / "it.state").write_text("kept", encoding="utf-8")
    said(shell, ":to 30", ":retry 3", ":to 60")
    told = said(shell, f":export-test {path} 3 succeeds", width=400)
    assert "it.state`: the file exists" in told
    assert not path.exists()


def test_removed_task_can_only_be_wanted(tmp_path: Path) -> None:
    shell, path = courier(tmp_path)
    said(shell, ":to 100")
    removed = next(
        told.event().task  # type: ignore[attr-defined]
        for told in shell.history.scan(events.TaskRemoved)
    )
    told = said(shell, f":export-test {path} {removed}", width=400)
    assert f"task [{removed}] was removed, which no test can expect" in told
    assert "written" in said(shell, f":export-test {path} {removed} succeeds")


@pytest.mark.parametrize("cycle", range(0, 200, 50))
def test_each_moment_of_a_shift_becomes_a_test(tmp_path: Path, cycle: int) -> None:
    shell, path = courier(tmp_path)
    said(shell, f":to {cycle}" if cycle else ":goto 0")
    told = said(shell, f":export-test {path} 1 succeeds", width=400)
    assert "the test fails now" in told
