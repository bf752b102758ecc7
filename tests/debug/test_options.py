"""Options are changed while a run goes on, and go back with it."""

from __future__ import annotations

from rapc import events
from tests.debug.sessions import truck
from tests.repl.shells import rows, said, truck_shell


def test_a_setting_counts_from_where_it_was_changed() -> None:
    shell = truck_shell()
    shell.answer(":show none")
    shell.answer(":step 20")
    shell.answer(":option rapc.cycle-cost 1")
    states = {}
    while shell.history.step().kind == "asked":
        states[shell.history.cycle] = shell.history.run.save()
    for cycle in (19, 90, 21):
        shell.history.goto(cycle)
        assert (shell.history.run.settings.cycle_cost == 1) == (cycle > 19)
        assert cycle == 19 or shell.history.run.save() == states[cycle]
    usual = truck()
    usual.go()
    shell.history.go()
    assert shell.history.now > usual.now + 50


def test_an_option_of_the_world_counts_from_where_it_was_changed() -> None:
    shell = truck_shell()
    shell.answer(":to 20")
    assert said(shell, ":option truck.arm2-drops=100") == (
        "set truck.arm2-drops to 100\n"
    )
    assert said(shell, ":option truck.arm1-drops = 100").startswith("set ")
    there = shell.history.run.save()
    shell.answer(":to 90")
    told = shell.history.scan(events.PrimitiveEnded)
    grasps = [
        one.keys["result"] for one in told if one.keys["request"][0] == "arm-grasp"
    ]
    assert set(grasps) == {"arm-dropped"}
    shell.history.goto(10)
    assert ("truck.arm2-drops", "50") in rows(shell, ":option")
    shell.history.goto(20)
    assert shell.history.run.save() == there
    assert ("truck.arm2-drops", "100") in rows(shell, ":option")
    assert ("rapc.futile-limit", "2") in rows(shell, ":option")


def test_options_are_changed_where_results_are_forced() -> None:
    shell = truck_shell()
    shell.answer(":force (arm-grasp ? ?) arm-dropped")
    assert said(shell, ":option truck.arm2-drops 100").startswith("set ")
    assert said(shell, ":option rapc.futile-limit 3").startswith("set ")
    shell.answer(":to 90")
    there = shell.history.run.save()
    shell.history.goto(30)
    shell.history.goto(90)
    assert shell.history.run.save() == there


def test_commitments_refer_to_the_time_of_the_choice() -> None:
    shell = truck_shell()
    shell.answer(":to 60")
    before = said(shell, ":when chosen")
    shell.answer(":option rapc.futile-limit 4")
    assert said(shell, ":when chosen") == before
    assert shell.history.run.settings.futile_limit == 4


def test_unchangeable_option_is_reported() -> None:
    shell = truck_shell()
    for text, answer in (
        ("truck.fuel 3", "`truck.fuel` cannot change during a run"),
        ("truck.fule 3", "the world `truck` has no option `fule`"),
        ("truck.arm1-drops 300", "`arm1-drops` must be between 0 and 100"),
        ("truck.arm1-drops", "missing value of `truck.arm1-drops`"),
        ("rapc.futil-limit 3", "did you mean `futile-limit`?"),
        ("rapc.strict maybe", "takes true or false, not `maybe`"),
        ("foo 3", "expected `truck.NAME` or `rapc.NAME`"),
        ("foo.x 3", "unknown owner `foo`; expected `rapc` or `truck`"),
    ):
        assert answer in said(shell, f":option {text}", width=200)
    assert shell.history.branch.acts == []
