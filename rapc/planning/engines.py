"""Engines: planners of others, each asked in a process of its own.

An engine gets a problem as PDDL and writes a plan to a file. Its plan is used only if
the plan solves the problem of rapc; else the search of rapc is asked. Whatever the
engine does, its processes end with the answer, with Ctrl-C, and with rapc.
"""

from __future__ import annotations

import os
import re
import selectors
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from rapc.base.names import plural
from rapc.base.visible import visible
from rapc.errors import PlanError, reason
from rapc.planning.ground import Action, Problem
from rapc.planning.pddl import written
from rapc.planning.sketch import goal_atoms

_FOLDER = Path(__file__).parent
_PLACES = ("{domain}", "{problem}", "{plan}")
_MOST_BYTES = 1_000_000
_MOST_STEPS = 10_000
_CHUNK = 65_536
_KEPT = 4096
_MOST_SHOWN = 200
_LONGEST = 3600.0
"""The longest wait of a selector in seconds."""
_STEP = re.compile(r"\(\s*([^\s()]+)\s*\)")


class Engine(NamedTuple):
    """A planner that is not part of rapc."""

    name: str
    #: The words of the command, with `{domain}`, `{problem}` and `{plan}`.
    command: Sequence[str]
    #: The limit in seconds for an answer.
    timeout: float
    #: Whether actions have costs, if these are different whole numbers.
    costs: bool

    def ask(self, problem: Problem) -> tuple[Action, ...] | str:
        """Return actions that solve a problem, or the reason why there are none."""
        try:
            return _answer(self, problem)
        except EngineError as error:
            return str(error)


class EngineError(Exception):
    """An engine without a usable plan; the text begins with a word for the failure."""


def find_engine(name: str, timeout: float, *, costs: bool) -> Engine:
    """Return an engine by name; see `rapc.engine`."""
    kind, _, engine = name.partition(":")
    if kind == "up":
        if not engine:
            raise PlanError("the name of an engine is missing after `up:`")
        if not re.fullmatch(r"[\w-]+", engine):
            raise PlanError(f"invalid name of an engine: `{engine}`")
        if find_spec("unified_planning") is None:
            said = f"the engine `{name}` requires unified-planning"
            raise PlanError(said, "pip install 'rapc[engines]'")
        script = (sys.executable, "-P", str(_FOLDER / "up_engine.py"))
        return Engine(name, (*script, engine, *_PLACES), timeout, costs)
    try:
        words = shlex.split(name)
    except ValueError as error:
        raise PlanError(f"cannot read the engine `{name}`: {error}") from None
    places = ", ".join(_PLACES)
    missing = [one for one in _PLACES if not any(one in word for word in words)]
    if missing:
        said = f"the engine `{name}` has no {', '.join(missing)}"
        raise PlanError(said, f"write `builtin`, `up:NAME` or a command with {places}")
    program = shutil.which(words[0])
    if program is None:
        if Path(words[0]).is_file():
            said = f"cannot run the program `{words[0]}` of the engine"
            raise PlanError(said, f"make it executable: chmod +x {words[0]}")
        raise PlanError(f"cannot find the program `{words[0]}` of the engine")
    command = (os.path.abspath(program), *words[1:])
    return Engine(name, command, timeout, costs)


def _answer(engine: Engine, problem: Problem) -> tuple[Action, ...]:
    """Return the plan of an engine; raise EngineError without a valid plan."""
    text = written(problem, costs=engine.costs)
    try:
        with tempfile.TemporaryDirectory(
            prefix="rapc-engine-", ignore_cleanup_errors=True
        ) as folder:
            files = [Path(folder, f"{place[1:-1]}.pddl") for place in _PLACES]
            for file, content in zip(files, text[:2], strict=False):
                file.write_text(content, encoding="utf-8")
            command = list(engine.command)
            for place, file in zip(_PLACES, files, strict=True):
                command = [word.replace(place, str(file)) for word in command]
            ended = _run(command, folder, engine.timeout)
            answer = _beginning(files[2])
    except OSError as error:
        raise EngineError(f"engine-failed: {reason(error)}") from None
    if answer is None:
        raise EngineError(f"engine-failed: no plan, {ended}")
    actions = _plan(answer, text.actions)
    if goal_atoms(problem, actions) is None:
        said = f"{plural(len(actions), 'step')} that do not solve the problem"
        raise EngineError(f"wrong-plan: {said}")
    return actions


def _beginning(file: Path) -> str | None:
    """Return the text of a file, up to a limit; None without a regular file."""
    if not file.is_file():
        return None
    with file.open("rb") as plan:
        return plan.read(_MOST_BYTES).decode(errors="replace")


def _plan(answer: str, known: Mapping[str, Action | None]) -> tuple[Action, ...]:
    """Return the actions of a plan: a name in parentheses for each step.

    Raises:
        EngineError: for a text that is not a plan.
    """
    found: list[Action] = []
    for number, row in enumerate(answer.splitlines()[: _MOST_STEPS + 1], 1):
        line = row.partition(";")[0].strip()
        step = _STEP.fullmatch(line)
        if line and (step is None or step[1].lower() not in known):
            raise EngineError(f"wrong-plan: unknown step in line {number}")
        action = None if step is None else known[step[1].lower()]
        if action is not None:
            found.append(action)
    if len(found) > _MOST_STEPS:
        raise EngineError(f"wrong-plan: more than {_MOST_STEPS} steps")
    return tuple(found)


def _run(command: Sequence[str], folder: str, timeout: float) -> str:
    """Run a command to its end; return its status and its last line.

    Raises:
        EngineError: after the timeout.
    """
    mine, theirs = socket.socketpair()
    with mine:
        with theirs:
            child = [sys.executable, "-IS", str(_FOLDER / "engine_child.py")]
            process = subprocess.Popen(  # noqa: S603  # the user's own command
                [*child, *command],
                stdin=theirs.fileno(),
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                cwd=folder,
                start_new_session=True,
            )
        try:
            status, printed = _watched(mine, process, time.monotonic() + timeout)
        finally:
            with suppress(ProcessLookupError, PermissionError):  # all have ended
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            assert process.stdout is not None
            process.stdout.close()
    if status is None:
        raise EngineError(f"engine-timeout: no answer in {timeout:g} s")
    lines = [one for one in printed.decode(errors="replace").splitlines() if one]
    # no names of temporary files, which differ from run to run
    last = lines[-1].replace(f"{folder}/", "").strip() if lines else ""
    last = visible(last)[:_MOST_SHOWN]
    return f"{_ending(status)}{f': {last}' if last else ''}"


def _watched(
    mine: socket.socket, process: subprocess.Popen[bytes], ends: float
) -> tuple[bytes | None, bytes]:
    """Return the status that the child sends, None at the end of time, and its output.

    Only the end of the output is kept.
    """
    assert process.stdout is not None
    output = process.stdout.fileno()
    os.set_blocking(output, False)
    status, printed = None, b""
    with selectors.DefaultSelector() as selector:
        selector.register(mine, selectors.EVENT_READ)
        selector.register(output, selectors.EVENT_READ)
        while status is None:
            left = ends - time.monotonic()
            if left <= 0:
                break
            ready = {key.fd for key, _ in selector.select(min(left, _LONGEST))}
            if mine.fileno() in ready:
                status = mine.recv(_CHUNK)
            with suppress(BlockingIOError):
                data = os.read(output, _CHUNK)
                printed = (printed + data)[-_KEPT:]
                if not data and output in ready:
                    selector.unregister(output)
    return status, printed


def _ending(status: bytes) -> str:
    """Return how a command has ended; without a status its group was killed."""
    if not status:
        return "its process was killed"
    number = int(status)
    if number >= 0:
        return f"status {number}"
    names = {one.value: one.name for one in signal.Signals}
    return names.get(-number, f"signal {-number}")
