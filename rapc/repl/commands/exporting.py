"""The command that exports the run as a test."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from rapc.base.values import format_list
from rapc.debug.acts import CancelTasks, SubmitTask
from rapc.debug.answer import Answer, command, say
from rapc.debug.arguments import Arguments
from rapc.errors import LoadError, StateError, TextError
from rapc.events import RunStarted
from rapc.ir.nodes import DefineTest
from rapc.repl.shell import Shell
from rapc.runtime.task_request import as_text
from rapc.testing.discover import find
from rapc.testing.exported import exported
from rapc.testing.run import Case, Outcome, Status, run_case
from rapc.world import Time

_SUFFIX = ".test.rap"


@command(
    "FILE [TASK] [succeeds]",
    ":export-test dropped.test.rap",
    ":export-test wanted.test.rap 1 succeeds",
)
def _export_test(shell: Shell, args: Arguments) -> Answer:
    """Write the run so far as a test that passes now.

    The world becomes a script with each request, its result, its time and its changes
    of memory. The test expects the result of TASK (default: the first task) and all
    requests. With `succeeds`, the test expects success: for a failed task, the test
    fails now. If a script cannot repeat the run, export from an earlier moment.
    """
    path = Path(args.word("file"))
    task = 1 if args.peek() in ("", "succeeds") else args.task(shell.history)
    wanted = args.takes("succeeds")
    args.end()
    if not path.name.endswith(_SUFFIX):
        raise TextError(f"the file name must end with `{_SUFFIX}`")
    if not shell.paths:
        raise TextError("cannot export: the library was not loaded from files")
    told = [one.event() for one in shell.history.scan()]
    program = shell.history.library.program
    declared = program.library.primitives
    test = exported(
        re.sub(r"[^a-z0-9]+", "-", path.name.removesuffix(_SUFFIX).lower()),
        told,
        task,
        acts=_acts(shell),
        not_atomic=[name for name, one in declared.items() if not one.atomic],
    )

    begun = told[0]
    world = begun.spec.world_class if isinstance(begun, RunStarted) else ""
    modules = [world.partition(":")[0]] if world else []  # imported by the run

    def run(node: DefineTest) -> Outcome:
        return run_case(Case(node, program), modules=modules)

    _agree(run(test.node()))
    test.shorten(lambda node: run(node).status is Status.PASSED)
    if wanted:
        test.want()
    text = f"{_requires(shell.paths, path)}\n\n{test.text()}"
    passes = _write(path, text, modules, wanted=wanted)
    written = (
        f"test {test.name} written to {path}; the test "
        f"{'passes' if passes else 'fails'} now"
    )
    return say(
        written, *[f"`rapc test` requires `--world-module {m}`" for m in modules]
    )


def _acts(shell: Shell) -> Iterator[tuple[Time, str]]:
    """Yield the tasks that the user submitted or cancelled, as `at` actions."""
    history = shell.history
    for done in history.branch.acts[: history.moment.acts]:
        if isinstance(done.act, SubmitTask):
            yield done.time, f"(task {as_text(done.act.request)})"
        elif isinstance(done.act, CancelTasks):
            yield done.time, f"(cancel {format_list(done.act.goal)})"


def _requires(paths: Sequence[str], test: Path) -> str:
    """Return the `require` forms of the test file."""
    names = [Path(os.path.relpath(path, test.parent)).as_posix() for path in paths]
    return "\n".join(f'(require "{name.removesuffix(".rap")}")' for name in names)


def _agree(outcome: Outcome) -> None:
    """Validate that the script has reproduced the results of the world.

    Raises:
        StateError: if the results differ, or if a test cannot name the world.
    """
    if outcome.status is not Status.PASSED:
        why = outcome.failures[0].happened[0]
        raise StateError(
            f"a script cannot repeat this run: {why}; try to export from an earlier "
            "moment (`:goto`)"
        )


def _write(path: Path, text: str, modules: Collection[str], *, wanted: bool) -> bool:
    """Write a file and run the test in it; return whether the test passes.

    Raises:
        LoadError: if the file cannot be written or already exists.
        StateError: if the files of the library do not reproduce the run; no file is
            then left.
    """
    try:
        with path.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except OSError as error:
        raise LoadError(f"cannot write `{path}`: {error.strerror}") from error
    outcomes = [run_case(case, modules=modules) for case in find([path]).cases]
    passes = [one.status is Status.PASSED for one in outcomes]
    if not outcomes or outcomes[0].status is Status.ERROR or not (wanted or passes[0]):
        path.unlink()
        raise StateError(
            "the files of the library have changed since the run started; use `:reload`"
        )
    return passes[0]
