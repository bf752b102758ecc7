"""`rapc repl`: debug a run interactively."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click
import msgspec

from rapc.base.visible import visible
from rapc.cli.common import load_checked, width_of
from rapc.cli.options import TypedPath, command, fail, settings
from rapc.cli.run_options import (
    end_time,
    prepared,
    read_spec,
    run_options,
    until_option,
)
from rapc.compiler.program import Program
from rapc.debug.bug import SUFFIX, present_moment, read_bug, versions
from rapc.debug.history import Done, History
from rapc.debug.log import EventLog
from rapc.debug.recorded import Replay
from rapc.debug.recording import Playback, Recording
from rapc.debug.reload import TYPED
from rapc.durable.folder import is_journal
from rapc.errors import Error
from rapc.host import load, loads
from rapc.library.library import Library, digest
from rapc.repl.commands.table import commands
from rapc.repl.script import inputs, run_script
from rapc.repl.shell import Shell
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.world import Time
from rapc.worlds.registry import find_world
from rapc.worlds.scripted import ScriptedWorld

RECORDED = ".jsonl"
"""The suffix of the files of recorded runs."""

_NO_SCRIPT = "the script of its world is not part of the file"

EXAMPLES = """\b
Examples:
  rapc repl rocks.rap --world truck --task '(rock-order red 1)'
  rapc repl rocks.rap --world truck --agenda deliveries -c ':step 5' -c ':tree'
  rapc repl rocks.rap --world truck --agenda deliveries --json < commands
  rapc repl run.jsonl
  rapc repl rocks.bug
  rapc repl day-1
  rapc repl --attach day-1
  rapc repl
"""


@command(EXAMPLES)
@click.argument("path", required=False, type=TypedPath())
@click.option("--world", "world_name", help="World to run against.")
@run_options
@until_option
@click.option(
    "-c",
    "--command",
    "given",
    multiple=True,
    metavar="INPUT",
    help="Debugger command (repeatable); standard input is not read.",
)
@click.option(
    "--attach",
    type=TypedPath(file_okay=False),
    metavar="FOLDER",
    help="Follow the run of a journal that goes on.",
)
@click.option(
    "--json", "as_json", is_flag=True, help="Write each answer as one line of JSON."
)
def repl(
    path: str | None,
    world_name: str | None,
    given: Sequence[str],
    as_json: bool,
    attach: str | None,
    until: float | None,
    **more: Any,
) -> None:
    """Debug a run of the library at PATH in a world, or a recorded or reported run.

    PATH may also be the folder of a journal. With --attach, `:run` and `:step` wait for
    a run that goes on in another process; Ctrl-C stops the wait. A world that cannot be
    saved is not asked anything: what the journal does not have is unknown.

    Without PATH, the library is empty: type RAP forms to try them. A library without
    primitives and skills requires no world. On a terminal, `:help` at the prompt lists
    all commands. Otherwise the commands are read from standard input, and the answers
    are printed as plain text.

    Exit status: 0; 1 if a command of a script failed; 2 if the run could not start.
    """
    if attach is not None:
        if any((path, until, *more.values())):
            fail("cannot change the start of a run with --attach")
        shell = opened_journal(Path(attach), world_name, follow=True)
    else:
        shell = shell_of(path, world_name, until=until, **more)
    color = settings().colored()
    if sys.stdin.isatty() and sys.stdout.isatty() and not (given or as_json):
        from rapc.repl.prompt import Prompt, history_file

        history = history_file(path)
        Prompt(shell, color=color, history=history).run()
        return
    texts = given or inputs(sys.stdin)
    width = width_of(sys.stdout)
    if not run_script(shell, texts, sys.stdout, width, color=color, as_json=as_json):
        raise SystemExit(1)


def shell_of(
    path: str | None, world_name: str | None, *, until: float | None, **more: Any
) -> Shell:
    """Return a shell for the run that the command line describes.

    Args:
        path: the library, recording or report; None for an empty library.
        world_name: the world.
        until: the time limit of the run.
        more: the other options of `run_options`.
    """
    end = end_time(until)
    if path is None:
        if world_name or any({**more, "seed": 0, "until": until}.values()):
            fail("missing PATH of a library", "options of a run require a library")
        library = loads("", TYPED)
        world = ScriptedWorld([], declared=library.program.library)
        shell = Shell(History.open(library, world, seed=more["seed"]), commands())
    elif path.endswith((RECORDED, SUFFIX)) or is_journal(Path(path)):
        if any((*more.values(), until)):
            fail(
                "cannot change the start of a recorded run",
                "remove all options of the run but --world",
            )
        opened = _recorded if path.endswith(RECORDED) else _reported
        if not path.endswith((RECORDED, SUFFIX)):
            opened = opened_journal
        shell = opened(Path(path), world_name)
    else:
        program = load_checked(path)
        if world_name is None and _asks_a_world(program.library):
            fail(
                "missing --world",
                "list the installed worlds with `rapc worlds`",
            )
        spec = read_spec(world_name, until=end, **more)
        ready = prepared(program, spec, world_name)
        shell = Shell(history_of(ready, end), commands(), [path])
    return shell


def opened_journal(
    path: Path, world_name: str | None, *, follow: bool = False
) -> Shell:
    """Return a shell for the run of a journal, at its end.

    Args:
        path: the folder of the journal.
        world_name: the world, if the user has named it.
        follow: whether to wait for further records while the run goes on.
    """
    from rapc.durable.opening import Opened

    opened = Opened(path, follow=follow)
    spec, stored = opened.spec, opened.stored
    if stored.damage is not None:
        begins = f"the history begins at cycle {stored.first_cycle}"
        click.echo(visible(f"note: {stored.damage.message}; {begins}"), err=True)
    missing = _missing_world(spec, world_name, path)
    if missing:
        fail(f"cannot open `{path}`: {missing}")
    ready = prepared(
        opened.program(), spec, world_name or spec.world, build=opened.build
    )
    history = opened.history(ready)
    opened.go_to_end(history)
    return Shell(history, commands(), [spec.library], str(opened))


def _asks_a_world(library: Library) -> bool:
    """Return whether a library declares primitives or skills of a world."""
    return bool(library.primitives or library.skills)


def _recorded(path: Path, world_name: str | None) -> Shell:
    """Replay a recorded run, or open it for viewing only."""
    recording = Recording(path)
    history = begun_again(recording, world_name)
    if history.is_run:
        Replay(history, recording)
        return Shell(history, commands(), [recording.begun.library], str(recording))
    return Shell(history, commands(), recording=str(recording))


def begun_again(recording: Recording, world_name: str | None) -> History:
    """Begin the run of a recording again; if that is impossible, play the recording.

    The reason, or a change of the library, is printed on standard error.
    """
    begun = recording.begun
    found = _at_hand(begun, world_name, recording.path)
    if isinstance(found, str):
        _tell(f"opened read-only: {found}")
        return History(Playback(recording))
    if begun.digest != digest(found.library):
        _tell("warning: the library has changed since the recording")
    named = world_name or (None if begun.world == ScriptedWorld.name else begun.world)
    ready = prepared(found, begun, named)
    # The limit keeps background tasks going; another run may go on after the recording.
    alone = all(task.background for task in ready.first_tasks)
    return history_of(ready, begun.until if alone else None)


def _tell(text: str) -> None:
    click.echo(text, err=True)


def _reported(path: Path, world_name: str | None) -> Shell:
    """Repeat the run of a bug report up to the moment at which it was written."""
    bug = read_bug(path)
    missing = _missing_world(bug.spec, world_name, path)
    if missing or (_is_scripted(bug.spec) and _asks_a_world(bug.library.library)):
        fail(f"cannot repeat `{path}`: {missing or _NO_SCRIPT}")
    named = world_name or (None if _is_scripted(bug.spec) else bug.spec.world)
    ready = prepared(bug.library, bug.spec, named)
    session = history_of(ready, bug.spec.until, bug.acts)
    here = versions(session)
    if here != bug.versions:
        same = "other code of rapc or of the world"
        other = here if str(here) != str(bug.versions) else same
        _tell(f"warning: the report was written by {bug.versions}; this is {other}")
    stop = session.reach(bug.written_at.moment)
    if stop.kind == "asked" and bug.written_at.reason:
        session.step()
    found = present_moment(session)
    if found != bug.written_at:
        _tell(
            f"warning: the run differs from the report: {found}, not {bug.written_at}"
        )
    return Shell(session, commands(), (), str(bug.written_at))


def _is_scripted(begun: RunSpec) -> bool:
    """Return whether the world of a run is a script, which no file has."""
    return begun.world == ScriptedWorld.name


def _missing_world(begun: RunSpec, world_name: str | None, path: Path) -> str:
    """Return why the world of a recorded or reported run is missing, or no text.

    The file may come from an untrusted source, so the module of a world named
    `module:Class` is imported only if the user names it. A world different from that of
    the file ends the command.
    """
    if world_name is not None and find_world(world_name).name != begun.world:
        named = begun.world_class or begun.world
        fail(f"`{path}` was recorded in the world `{named}`, not in `{world_name}`")
    if world_name is None and begun.world_class:
        return (
            f"the code of the world `{begun.world_class}` is run only with "
            f"`--world {begun.world_class}`"
        )
    try:
        if not _is_scripted(begun):
            find_world(world_name or begun.world)
    except Error as error:
        return error.message
    return ""


def _at_hand(begun: RunSpec, world_name: str | None, path: Path) -> Program | str:
    """Return the library of a recorded run, or why library or world is missing."""
    missing = _missing_world(begun, world_name, path)
    if missing:
        return missing
    try:
        program = load(begun.library).program
    except Error as error:
        return error.message
    if _is_scripted(begun) and _asks_a_world(program.library):
        return _NO_SCRIPT
    return program


def history_of(
    ready: Interpreter, end: Time | None, acts: Iterable[Done] = ()
) -> History:
    """Start the run, which ends at the time `end`, under a debugger."""
    log = EventLog()
    ready.listen(log)
    ready.start(end)
    history = History(ready, log, acts)
    history.spec = msgspec.structs.replace(history.spec, until=end)
    return history
