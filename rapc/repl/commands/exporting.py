"""The command that exports the run as a test."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from rapc.base.values import format_list
from rapc.console.experiments.output import bar
from rapc.debug.acts import (
    Act,
    AssertFact,
    CancelTasks,
    EraseFacts,
    SendSignal,
    SubmitTask,
)
from rapc.debug.answer import Answer, command, say
from rapc.debug.arguments import Arguments
from rapc.debug.history import Done
from rapc.debug.saved_state import SavedState, state_file
from rapc.errors import LoadError, StateError, TextError, reason
from rapc.events import RunStarted
from rapc.ir.nodes import DefineTest
from rapc.repl.shell import Shell
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import as_text
from rapc.runtime.truth import WRONG_BELIEFS
from rapc.spec import RunSpec
from rapc.testing.discover import find
from rapc.testing.exported import (
    MOST_RUNS,
    Exported,
    exported,
    in_simulator,
    last_cycle,
    outcome_of,
)
from rapc.testing.run import Case, Outcome, Status, run_case
from rapc.world import Time
from rapc.worlds.scripted import ScriptedWorld

_SUFFIX = ".test.rap"


@command(
    "FILE [TASK] [succeeds]",
    ":export-test dropped.test.rap",
    ":export-test wanted.test.rap 1 succeeds",
)
def _export_test(shell: Shell, args: Arguments) -> Answer:
    """Write the run so far as a test.

    The test expects the result of TASK (default: the first task), and passes now. The
    world becomes a script with each request, its result, its time and its changes of
    memory; the test then expects all requests. If a script cannot repeat the run, the
    test runs in the simulator. With `succeeds`, the test expects success and runs in
    the simulator, if the world is one: for a failed task, the test fails now. If the
    robot has wrong beliefs now, the test also expects none at its end.

    A test in the simulator repeats the run with its seed, options and tasks. If the run
    has other settings, faults, or acts that no test can state, the test begins in a
    saved state, in a file with the suffix `.state`.
    """
    path = Path(args.word("file"))
    task = 1 if args.peek() in ("", "succeeds") else args.task(shell.history)
    wanted = args.takes("succeeds")
    args.end()
    if not path.name.endswith(_SUFFIX):
        raise TextError(f"the file name must end with `{_SUFFIX}`")
    if not shell.paths:
        raise TextError("cannot export: the library was not loaded from files")
    shown = sys.stderr.isatty()
    with bar("test runs", MOST_RUNS, sys.stderr, shown=shown, color=shown) as advance:
        return _exported(_Export(shell, path, task, advance), wanted=wanted)


def _exported(export: _Export, *, wanted: bool) -> Answer:
    """Write the first test that reproduces the run.

    Raises:
        StateError: if no test reproduces the run.
    """
    if not (wanted or outcome_of(export.told, export.task)[1]):
        raise StateError(
            f"task [{export.task}] was removed, which no test can expect; use "
            "`succeeds`"
        )
    reasons = []
    for attempt in export.attempts(wanted=wanted):
        try:
            written = attempt()
        except StateError as error:
            reasons.append(error.message)
            continue
        if wanted:
            written.want(*export.right_beliefs(written))
        return export.write(written, wanted=wanted)
    raise StateError(f"cannot export this run: {'; '.join(dict.fromkeys(reasons))}")


class _Export:
    """The export of the present run as a test of a task.

    Args:
        shell: the shell with the run.
        path: the file of the test.
        task: the number of the task.
        advance: called before each run of a test.
    """

    def __init__(
        self, shell: Shell, path: Path, task: int, advance: Callable[[int], object]
    ) -> None:
        self._shell, self._path, self.task = shell, path, task
        self._advance = advance
        self._name = re.sub(r"[^a-z0-9]+", "-", path.name.removesuffix(_SUFFIX).lower())
        self._program = shell.history.library.program
        self.told = [one.event() for one in shell.history.scan()]
        begun = self.told[0]
        self._spec = begun.spec if isinstance(begun, RunStarted) else RunSpec()
        module = self._spec.world_class.partition(":")[0]
        #: The module of the world, which the run has imported.
        self._modules = [module] if module else []
        #: The saved state in which the test begins, and its file; empty without one.
        self._state = b""
        self._state_file = path.with_name(path.name.removesuffix(_SUFFIX) + ".state")

    def attempts(self, *, wanted: bool) -> Iterator[Callable[[], Exported]]:
        """Yield functions that return a test, which reproduces the run, or raise.

        The functions raise StateError if the test does not reproduce the run.
        """
        simulated = self._spec.world != ScriptedWorld.name
        if not (wanted and simulated):
            yield self._in_script
        if simulated:
            yield self._in_simulator
        if wanted and simulated:
            yield self._in_script

    def right_beliefs(self, test: Exported) -> Iterator[str]:
        """Yield the expectation of right beliefs, if the robot has wrong ones now."""
        simulated = not any(part.kind == "row" for part in test.parts)
        if simulated and self._shell.history.run.wrong_beliefs():
            yield f"(figure {WRONG_BELIEFS} = 0)"

    def _in_script(self) -> Exported:
        declared = self._program.library.primitives
        test = exported(
            self._name,
            self.told,
            self.task,
            acts=_actions(self._done(), _TASKS),
            not_atomic=[name for name, one in declared.items() if not one.atomic],
        )
        self._agree(test, "a script cannot repeat this run")
        test.shorten(lambda node: self._run(node).status is Status.PASSED)
        return test

    def _in_simulator(self) -> Exported:
        """Return a test in the simulator, from the beginning or from a state."""
        end = last_cycle(self.told, self.task)
        acts = [done for done in self._done() if done.cycle < end]
        unsaid = [done.cycle for done in acts if type(done.act) not in _SAID]
        if self._spec.faults or self._spec.settings != Settings().named():
            unsaid.insert(0, 0)
        if not unsaid:
            said = _actions(acts, _SAID)
            test = in_simulator(self._name, self.told, self.task, acts=said, end=end)
            with suppress(StateError):
                self._agree(test, "")
                return test
            unsaid = [done.cycle for done in acts] or [0]
        first = unsaid[-1]
        history = self._shell.history
        past = first < history.cycle
        with history.at_choice(first + 1) if past else history.at() as run:
            self._state = state_file(run)
        test = in_simulator(
            self._name,
            self.told,
            self.task,
            acts=_actions([done for done in acts if done.cycle > first], _SAID),
            end=end,
            state=(self._state_file.name, first),
        )
        self._agree(test, "the simulator does not repeat this run")
        return test

    def _done(self) -> Sequence[Done]:
        """Return the acts of the user so far."""
        history = self._shell.history
        return history.branch.acts[: history.moment.acts]

    def _run(self, node: DefineTest) -> Outcome:
        self._advance(1)
        state = SavedState(self._state) if node.saved_state is not None else None
        return run_case(Case(node, self._program), modules=self._modules, state=state)

    def _agree(self, test: Exported, message: str) -> None:
        """Validate that a test reproduces the result of the run.

        Raises:
            StateError: if the results differ, or if a test cannot name the world.
        """
        outcome = self._run(test.node())
        if outcome.status is not Status.PASSED:
            raise StateError(f"{message}: {outcome.failures[0].happened[0]}")

    def write(self, test: Exported, *, wanted: bool) -> Answer:
        """Write the files and run the test in them.

        Raises:
            LoadError: if a file cannot be written or already exists.
            StateError: if the files of the library do not reproduce the run; no file is
                then left.
        """
        path, state = self._path, self._state_file
        text = f"{_requires(self._shell.paths, path)}\n\n{test.text()}"
        files = {path: text.encode()}
        if test.node().saved_state is not None:
            files[state] = self._state
        _write_new(files)
        found = find([path]).cases
        outcomes = [run_case(case, modules=self._modules) for case in found]
        passes = [one.status is Status.PASSED for one in outcomes]
        faulty = not outcomes or outcomes[0].status is Status.ERROR
        if faulty or not (wanted or passes[0]):
            for file in files:
                file.unlink()
            raise StateError(
                "the files of the library have changed since the run started; use "
                "`:reload`"
            )
        written = f"test {test.name} written to {' and '.join(map(str, files))}"
        verb = "passes" if passes[0] else "fails"
        return say(
            f"{written}; the test {verb} now",
            *[f"`rapc test` requires `--world-module {m}`" for m in self._modules],
        )


_Said = Mapping[type[Act], Callable[[Any], str]]
"""For some types of acts, the action of an `at` for an act."""

_TASKS: _Said = {
    SubmitTask: lambda act: f"(task {as_text(act.request)})",
    CancelTasks: lambda act: f"(cancel {format_list(act.goal)})",
}
"""The acts that a script does not contain as changes of memory or signals."""

_SAID: _Said = {
    **_TASKS,
    AssertFact: lambda act: f"(asserts {format_list(act.fact)})",
    EraseFacts: lambda act: f"(erases {format_list(act.prefix)})",
    SendSignal: lambda act: f"(signals {format_list(act.content)})",
}
"""The acts that a test can state."""


def _requires(paths: Sequence[str], test: Path) -> str:
    """Return the `require` forms of the test file."""
    names = [Path(os.path.relpath(path, test.parent)).as_posix() for path in paths]
    return "\n".join(f'(require "{name.removesuffix(".rap")}")' for name in names)


def _actions(acts: Iterable[Done], said: _Said) -> Iterator[tuple[Time, str]]:
    """Yield acts as actions of an `at`, each with its time."""
    for done in acts:
        if type(done.act) in said:
            yield done.time, said[type(done.act)](done.act)


def _write_new(files: Mapping[Path, bytes]) -> None:
    """Write files that do not exist, all or none.

    Raises:
        LoadError: if a file cannot be written or already exists.
    """
    written = []
    for path, data in files.items():
        try:
            with path.open("xb") as stream:
                written.append(path)
                stream.write(data)
        except OSError as error:
            for file in written:
                file.unlink()
            raise LoadError(f"cannot write `{path}`: {reason(error)}") from error
