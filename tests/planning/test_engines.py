"""Engines: real child processes that answer, fail, hang, and leave processes behind."""

from __future__ import annotations

import os
import random
import shlex
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from socket import socket
from typing import Any, NoReturn

import pytest

import rapc
from bench.plans import searches
from rapc import events
from rapc.cli.repl import begun_again
from rapc.debug.history import History
from rapc.debug.recorded import Replay
from rapc.debug.recording import Recording
from rapc.library.library import usable_in_plans
from rapc.library.operators import Model
from rapc.planning import engines, solver
from tests.cli.command import COMMAND
from tests.cli.command import rapc as command

COURIER = "examples/courier"
GOAL = "(and (delivered medicine ward-3) (docked))"
FAKE = Path(__file__).with_name("fake_engine.py")
STEPS = (
    "(fetch medicine ward-3)",
    "(bring medicine ward-3)",
    "(travel-to base)",
    "(go-into-dock)",
)
LIMIT = 60.0


def fake(deed: str, timeout: float = LIMIT) -> rapc.Engine:
    words = [sys.executable, str(FAKE), deed]
    found = rapc.engine(f"{shlex.join(words)} {{domain}} {{problem}} {{plan}}", timeout)
    assert found is not None
    return found


def plan(engine: rapc.Engine | None) -> rapc.Plan:
    facts = ["(robot-at base)", "(gives-out pharmacy medicine)"]
    return rapc.plan(rapc.load(COURIER), GOAL, facts=facts, engine=engine)


@pytest.fixture
def pids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield the file for the numbers of the processes; end those that are left."""
    file = tmp_path / "pids"
    monkeypatch.setenv("FAKE_ENGINE_PIDS", str(file))
    yield file
    left = [one for one in numbers(file) if is_running(one)]
    for one in left:
        os.kill(one, signal.SIGKILL)
    assert not left


@pytest.fixture
def begun_limit(pids: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the time limit of an engine begin when its processes have started."""
    watched = engines._watched

    def wait(mine: socket, process: Any, ends: float) -> tuple[bytes | None, bytes]:
        limit = ends - time.monotonic()
        wait_for_begin(pids)
        return watched(mine, process, time.monotonic() + limit)

    monkeypatch.setattr(engines, "_watched", wait)


def wait_for_begin(file: Path) -> None:
    """Wait until the processes of an engine have written their numbers to a file."""
    ends = time.monotonic() + LIMIT
    while not file.exists() and time.monotonic() < ends:
        time.sleep(0.005)
    assert file.exists()


def numbers(file: Path) -> list[int]:
    return [int(one) for one in file.read_text().split()] if file.exists() else []


def is_running(number: int) -> bool:
    try:
        status = Path(f"/proc/{number}/stat").read_text()
    except FileNotFoundError:
        return False
    return status.rpartition(")")[2].split()[0] not in "ZX"


def wait_for_end(file: Path) -> None:
    """Wait until the processes in a file have ended."""
    ends = time.monotonic() + LIMIT
    while any(map(is_running, numbers(file))) and time.monotonic() < ends:
        time.sleep(0.01)
    assert numbers(file)


@pytest.mark.parametrize("deed", ["solve", "print-much", "plan-and-fail"])
def test_valid_plan_of_an_engine_is_used(deed: str) -> None:
    found = plan(fake(deed))
    assert tuple(one.goal for one in found.steps) == STEPS
    assert (found.engine, found.refused) == (fake(deed).name, "")
    assert found.expanded == 0
    assert found.steps[0].purpose == "for t2: (on-tray medicine ward-3)"


@pytest.mark.parametrize(
    ("deed", "said"),
    [
        ("half", "wrong-plan: unknown step in line 2"),
        ("too-short", "wrong-plan: 2 steps that do not solve the problem"),
        ("wrong-order", "wrong-plan: 6 steps that do not solve the problem"),
        ("unknown", "wrong-plan: unknown step in line 2"),
        ("no-steps", "wrong-plan: 0 steps that do not solve the problem"),
        ("rubbish", "wrong-plan: unknown step in line 1"),
        ("write-much", "wrong-plan: more than 10000 steps"),
        ("one-long-line", "wrong-plan: unknown step in line 1"),
        ("fail", "engine-failed: no plan, status 3"),
        ("die", "engine-failed: no plan, SIGSEGV"),
        ("die-of-another-signal", "engine-failed: no plan, signal 40"),
        ("kill-parent", "engine-failed: no plan, its process was killed"),
    ],
)
def test_planner_of_rapc_is_asked_if_an_engine_fails(deed: str, said: str) -> None:
    found = plan(fake(deed))
    assert found.refused == said
    assert found.engine == "builtin"
    assert tuple(one.goal for one in found.steps) == STEPS


def test_reason_has_the_last_line_without_temporary_names() -> None:
    said = "engine-failed: no plan, status 1: out of memory in plan.pddl"
    assert plan(fake("print-much-and-fail")).refused == said


def test_engine_without_output_is_waited_for() -> None:
    assert plan(fake("close-output")).engine == fake("close-output").name


def test_process_that_an_engine_leaves_is_ended(pids: Path) -> None:
    assert plan(fake("leave-a-process"))
    wait_for_end(pids)


def test_program_that_has_gone_is_a_failure(tmp_path: Path) -> None:
    program = tmp_path / "engine"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o700)
    engine = rapc.engine(f"{program} {{domain}} {{problem}} {{plan}}")
    program.unlink()
    found = plan(engine)
    assert found.refused.startswith("engine-failed: no plan, status 127: ")
    assert found.refused.endswith("engine: No such file or directory")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nowhere {domain} {problem} {plan}", "cannot find the program `nowhere`"),
        ("./README.md {domain} {problem} {plan}", "cannot run the program `./README"),
        ("cat {domain} {problem}", "has no {plan}"),
        ("cat", "has no {domain}, {problem}, {plan}"),
        ("", "has no {domain}"),
        ("sh '{domain} {problem} {plan}", "cannot read the engine"),
        ("up:x y", "invalid name of an engine: `x y`"),
        ("up:", "the name of an engine is missing after `up:`"),
    ],
)
def test_engine_that_cannot_be_run_is_refused(name: str, said: str) -> None:
    with pytest.raises(rapc.PlanError, match=f"^(?s:.*){said}"):
        rapc.engine(name)


def test_engine_of_a_missing_package_names_the_extra(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(engines, "find_spec", lambda name: None)
    with pytest.raises(rapc.PlanError) as caught:
        rapc.engine("up:aries")
    assert caught.value.help == "pip install 'rapc[engines]'"


def test_engine_is_not_asked_for_a_goal_that_holds() -> None:
    found = rapc.plan(
        rapc.load(COURIER),
        "(robot-at base)",
        facts=["(robot-at base)"],
        engine=fake("fail"),
    )
    assert (found.engine, found.refused, found.steps) == ("builtin", "", ())


def told(deed: str) -> tuple[list[events.Event], rapc.Interpreter]:
    """Return the events of a run with a goal for a planner."""
    text = f"(define-rap (evening) (succeed {GOAL}) (plan))"
    found: list[events.Event] = []
    run = (
        rapc.load(COURIER)
        .extend(text)
        .start(
            "courier", tasks=["(evening)"], engine=fake(deed), listeners=[found.append]
        )
    )
    run.run(until=1000)
    return found, run


@pytest.mark.parametrize("deed", ["solve", "fail"])
def test_run_emits_the_engine_of_a_plan(deed: str) -> None:
    found, run = told(deed)
    made = next(one for one in found if isinstance(one, events.PlanMade))
    assert run.results()[0].outcome == "succeeded"
    if deed == "fail":
        assert (made.engine, made.refused) == (
            "builtin",
            "engine-failed: no plan, status 3",
        )
        assert made.line().endswith("4 steps (engine-failed: no plan, status 3)")
    else:
        assert (made.engine, made.refused) == (fake(deed).name, "")
        assert made.line().endswith(f"4 steps by {made.engine}")
    assert found == told(deed)[0]


def test_command_asks_an_engine_and_reports_a_failure() -> None:
    for deed, note in (("solve", ""), ("fail", "note: engine-failed: no plan, ")):
        options = ("--world", "courier", "--fact", "(robot-at base)", "--run")
        engine = ("--engine", fake(deed).name)
        done = command("plan", GOAL, COURIER, *options, *engine)
        assert done.returncode == 0
        assert done.stdout.endswith(f"{GOAL}: succeeded\n")
        assert done.stderr.startswith(note)
        assert done.stderr.count("\n") == bool(note)


def test_command_refuses_an_engine_that_cannot_be_run() -> None:
    done = command("plan", GOAL, COURIER, "--engine", "nowhere")
    assert done.returncode == 2
    assert done.stderr.startswith("error: the engine `nowhere` has no {domain}")


# --- processes that do not end by themselves ------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("begun_limit")
def test_engine_that_hangs_is_ended_with_its_group(pids: Path) -> None:
    found = plan(fake("hang", timeout=0.5))
    wait_for_end(pids)
    assert found.refused == "engine-timeout: no answer in 0.5 s"
    assert found.engine == "builtin"
    assert found


def begun(pids: Path) -> subprocess.Popen[str]:
    """Start a command whose engine hangs, and wait for the engine."""
    options = ["--world", "courier", "--fact", "(robot-at base)"]
    options += ["--engine", fake("hang").name, "--engine-timeout", "600"]
    process = subprocess.Popen(
        [str(COMMAND), "plan", GOAL, COURIER, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for_begin(pids)
    return process


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "status"),
    [(signal.SIGINT, 130), (signal.SIGTERM, -15), (signal.SIGKILL, -9)],
)
def test_engine_ends_with_the_command(
    pids: Path, number: signal.Signals, status: int
) -> None:
    process = begun(pids)
    process.send_signal(number)
    output, errors = process.communicate(timeout=LIMIT)
    assert process.returncode == status
    assert (output, errors.strip()) == ("", "")
    wait_for_end(pids)


def kill_at(moments: int, seed: int, pids: Path) -> None:
    """Kill the processes of an engine at random moments; each plan is valid."""
    rng = random.Random(seed)
    for _ in range(moments):
        pids.unlink(missing_ok=True)
        late = rng.random() * 0.2
        chosen = rng.randrange(2)

        def kill(late: float = late, chosen: int = chosen) -> None:
            wait_for_begin(pids)
            time.sleep(late)
            os.kill(numbers(pids)[chosen], signal.SIGKILL)

        thread = threading.Thread(target=kill)
        thread.start()
        found = plan(fake("hang", timeout=1))
        thread.join()
        wait_for_end(pids)
        assert tuple(one.goal for one in found.steps) == STEPS
        assert found.refused in (
            "engine-failed: no plan, SIGKILL",
            "engine-timeout: no answer in 1 s",
        )


@pytest.mark.slow
@pytest.mark.usefixtures("begun_limit")
def test_killed_engine_does_not_end_the_plan(pids: Path) -> None:
    kill_at(2, 1, pids)


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.usefixtures("begun_limit")
def test_killed_engines_do_not_end_the_plan(pids: Path) -> None:
    kill_at(20, 2, pids)


# --- real engines ---------------------------------------------------------------------


PYPERPLAN = (
    f'{shlex.quote(sys.executable)} -m pyperplan -s gbf -H hff "$0" "$1" '
    '&& mv "$1.soln" "$2"'
)
COMMAND_OF_PYPERPLAN = f"sh -c {shlex.quote(PYPERPLAN)} {{domain}} {{problem}} {{plan}}"


def solved_by(name: str) -> list[int]:
    """Solve three problems with an engine; return the sizes of the plans."""
    engine, sizes = rapc.engine(name, 5 * LIMIT), []
    for one in islice(searches(), 3):
        program = one.library.program
        rap = program.library.raps[one.goal]
        use = usable_in_plans(program.library.raps, rap)
        model = Model(program.library, program.signatures, use)
        goal = model.goal(rap, {})
        found = solver.solve(model, one.facts, goal, limit=1, engine=engine)
        assert (found.engine, found.refused) == (name, "")
        assert found.sketch is not None
        sizes.append(len(found.sketch.actions))
    return sizes


@pytest.mark.slow
@pytest.mark.skipif(find_spec("pyperplan") is None, reason="requires pyperplan")
def test_pyperplan_solves_three_problems() -> None:
    assert solved_by(COMMAND_OF_PYPERPLAN)[:2] == [8, 7]


@pytest.mark.nightly
@pytest.mark.skipif(find_spec("up_pyperplan") is None, reason="requires up-pyperplan")
def test_engine_of_unified_planning_solves_three_problems() -> None:
    assert solved_by("up:pyperplan")[:2] == [8, 7]
    missing = plan(rapc.engine("up:nowhere", LIMIT))
    assert missing.refused == (
        "engine-failed: no plan, status 1: unified-planning has no engine `nowhere`, "
        "or the package of the engine is missing"
    )
    assert missing


@pytest.mark.parametrize("deed", ["solve", "fail"])
def test_trace_is_replayed_without_its_engine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, deed: str
) -> None:
    library = tmp_path / "evening.rap"
    folder = os.path.relpath(COURIER, tmp_path)
    library.write_text(
        f'(require "{folder}") (define-rap (evening) (succeed {GOAL}) (plan))'
    )
    trace = tmp_path / "run.jsonl"
    with trace.open("w") as stream:
        run = rapc.load(library).start(
            "courier",
            tasks=["(evening)"],
            engine=fake(deed),
            listeners=[rapc.JsonTrace(stream)],
        )
        run.run(until=1000)

    def broken(*args: object, **more: object) -> NoReturn:
        raise AssertionError("planned during a replay")

    monkeypatch.setattr(solver, "solve", broken)
    recording = Recording(trace)
    history = begun_again(recording, None)
    replay = Replay(history, recording)
    history.go()
    assert history.is_run
    assert replay.parted is None
    assert history.cycle == recording.last_cycle


def test_trace_with_a_damaged_plan_is_refused(tmp_path: Path) -> None:
    found, run = told("solve")
    trace = tmp_path / "run.jsonl"
    with trace.open("w") as stream:
        write = rapc.JsonTrace(stream)
        for one in found:
            write(one)
    trace.write_text(trace.read_text().replace("(method plan-1 ", "(plan-1 "))
    recording = Recording(trace)
    history = History(run)
    with pytest.raises(rapc.LoadError, match=r"is not a trace: line [0-9]+ is not"):
        Replay(history, recording)
