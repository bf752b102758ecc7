"""`rapc run`: run tasks of a library against a world."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, TextIO

import click
import msgspec

from rapc.analysis.facts.effects import endless, reached
from rapc.base.interrupts import interrupts_held
from rapc.base.outputs import SAVED_STATE, TRACE
from rapc.base.values import format_list, readable, readable_numbers
from rapc.base.visible import visible, visible_lines
from rapc.cli.common import (
    PIPED_WIDTH,
    load_checked,
    refuse_output,
    width_of,
    write_output,
)
from rapc.cli.options import WholeNumber, command, fail, settings
from rapc.cli.run_options import (
    end_time,
    prepared,
    read_spec,
    run_options,
    until_option,
)
from rapc.errors import StateError, reason
from rapc.events import Deadlock, Event, TaskResult
from rapc.library.library import Library
from rapc.runtime.events.report import (
    OF_DECISIONS,
    OF_GOALS,
    MendedFailures,
    RunReport,
)
from rapc.runtime.events.trace import JsonTrace, TextTrace
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.spec import RunSpec
from rapc.world import Drawable, Picture, Time, World

EXAMPLES = """\b
Examples:
  rapc run rocks.rap --world truck --task '(fill-order red 4 factory-1)'
  rapc run rocks.rap --world truck --agenda deliveries
  rapc run rocks.rap --world truck --task '(wakeup)' --seed 7 -q --trace run.jsonl
  rapc run rocks.rap --world truck --task '(wakeup)' \\
      --fault '(arm-grasp ?arm ?thing) arm-dropped p=0.3 from=100 until=200'
  rapc run my.rap --world truck --set truck.fuel=20 --set rapc.futile-limit=3 \\
      --task '(patrol) :priority 4' --until 500
"""


_MOST_FRAMES = 1_000_000

_MOST_TOLD = 60_000
"""The number of events that are kept to explain the end of the run."""


@command(EXAMPLES)
@click.argument("path", type=click.Path())
@click.option("--world", "world_name", required=True, help="World to run against.")
@run_options
@until_option
@click.option(
    "--trace", type=click.Path(dir_okay=False), help="Write the trace to FILE."
)
@click.option(
    "--trace-format",
    type=click.Choice(["jsonl", "text"]),
    default="jsonl",
    show_default=True,
    help="Format of the trace file.",
)
@click.option(
    "--trace-pictures",
    is_flag=True,
    help="Add the changes of the world's picture to the trace.",
)
@click.option(
    "--save",
    type=click.Path(dir_okay=False),
    metavar="FILE",
    help="Write the state at the time of --until to FILE.",
)
@click.option(
    "--keep",
    "kept",
    type=click.Path(dir_okay=False),
    metavar="FILE",
    help="Write the methods that solvers found to a new RAP file.",
)
@click.option(
    "--show",
    is_flag=True,
    help="Show the world and the robot's beliefs instead of the trace.",
)
@click.option(
    "--show-every",
    type=WholeNumber(_MOST_FRAMES),
    metavar="N",
    help="Print every Nth frame if --show writes to a file or pipe.",
)
def run(
    path: str,
    world_name: str,
    until: float | None,
    trace: str | None,
    trace_format: str,
    trace_pictures: bool,
    save: str | None,
    kept: str | None,
    show: bool,
    show_every: int | None,
    **more: Any,
) -> None:
    """Run tasks of the library at PATH against a world.

    Without -q and --show, the trace goes to standard output. A short report follows.

    The report explains the end: the decisions behind the last request if the world has
    ended the run, and, without -q, what kept the goals that have not ended and which
    background tasks failed.

    A foreground task that never ends keeps the run going until the time of --until.
    Without --until, a note on standard error names the task.

    With --trace-pictures, the trace has an event `pictured` for each change of the
    world's picture. `rapc view` needs these events only for a world that it cannot
    make again.

    With --save, the run stops before the first cycle at or after the time of --until.
    A test can begin in the saved state.

    With --keep, FILE requires the library and has a `define-method` form for each
    method that a problem solver has found, also after Ctrl-C. A run of FILE has these
    methods from the start.

    Exit status: 0 if every foreground task succeeded and no background task failed, 1
    if not, 2 if the run could not start.
    """
    if show_every is not None and not show:
        raise click.UsageError("--show-every requires --show")
    if save is not None and until is None:
        raise click.UsageError("--save requires --until")
    if more["agenda"] is None and not more["tasks"]:
        fail("missing --task or --agenda")
    keep = _keeping(kept)
    library = load_checked(path)
    end = end_time(until)
    spec = read_spec(world_name, until=end, **more)
    if trace_pictures:
        spec = _with_pictures(spec, trace is not None and trace_format == "jsonl")
    interpreter = prepared(library, spec, world_name)
    world = interpreter.world
    _tell_what_ends_it(interpreter.first_tasks, library.library, end)
    wanted = show or trace_pictures
    drawn = _drawable(interpreter.port, world_name) if wanted else None
    if save is not None:
        told = "is a source file of the library"
        refuse_output("--save", save, SAVED_STATE, (library.library.files, told))
    report, mended = RunReport(world.kit.offer.sensors), MendedFailures()
    known: deque[Event] = deque(maxlen=_MOST_TOLD)
    with ExitStack() as stack, _ended_by_interrupts(interpreter):
        stack.callback(keep, interpreter, path)
        with interrupts_held():
            if trace is not None:
                files = (path, *library.library.files)
                stream = stack.enter_context(_opened(trace, files, world))
                form = JsonTrace if trace_format == "jsonl" else TextTrace
                interpreter.listen(form(stream))
            interpreter.listen(report, *RunReport.kinds)
            interpreter.listen(mended, *MendedFailures.kinds)
            interpreter.listen(
                known.append, *(OF_DECISIONS if settings().quiet else OF_GOALS)
            )
            if show and drawn is not None:
                _show(stack, interpreter, drawn, show_every or 0)
            else:
                interpreter.listen(_tell_deadlock, Deadlock)
                if not settings().quiet:
                    interpreter.listen(TextTrace(_Shown(sys.stdout)))
            interpreter.start()
        if save is not None and end is not None:
            _save_at(interpreter, end, save)
        interpreter.run(until=end)
    for line in chain(report.lines(), _mended(mended), _figures(interpreter)):
        click.echo(visible(line))
    if not all(map(_went_well, interpreter.results())):
        _explain(known, interpreter)
        raise SystemExit(1)


def _explain(known: Iterable[Event], interpreter: Interpreter) -> None:
    """Print the decisions behind the end of a run, and what kept its goals.

    With -q, the events that show what kept the goals are not made.
    """
    from rapc.debug.log import ToldEvent
    from rapc.debug.questions.ends import end_of, goals_of
    from rapc.repl.draw import draw

    told, library = [ToldEvent.of(event) for event in known], interpreter.library
    answers = {"Before the end:": end_of(told, library)}
    if not settings().quiet:
        goals = goals_of(told, interpreter.now, library, all_=False)
        answers["What kept the goals:"] = goals
    for title, answer in answers.items():
        if answer.table is not None:
            shown = msgspec.structs.replace(answer, lines=(title,), notes=())
            width, color = width_of(sys.stdout), settings().colored()
            click.echo(draw(shown, width, color=color), nl=False)


def _with_pictures(spec: RunSpec, traced: bool) -> RunSpec:
    """Return the spec of a run whose trace has pictures."""
    if not traced:
        raise click.UsageError("--trace-pictures requires --trace, in jsonl")
    return msgspec.structs.replace(spec, settings={**spec.settings, "pictures": True})


def _keeping(file: str | None) -> Callable[[Interpreter, str], None]:
    """Return the function that writes found methods to a file, if there is one.

    A file that cannot be written ends the command.
    """
    if file is None:
        return lambda interpreter, library: None
    from rapc.cli.keep import keep, refuse_kept

    refuse_kept(file)
    return partial(keep, file)


def _save_at(interpreter: Interpreter, time: Time, file: str) -> None:
    """Run to a time and write the state; a run that ends before ends the command."""
    from rapc.debug.saved_state import state_file

    while interpreter.come_to_choice() and interpreter.now < time:
        interpreter.step()
    if interpreter.reason is not None:
        fail(f"cannot save: the run ended before time {readable(time)}")
    try:
        write_output(file, state_file(interpreter))
    except StateError as error:
        fail(f"cannot save: {error.message}")
    interpreter.end("until")


def _mended(mended: MendedFailures) -> Iterator[str]:
    """Yield the lines of the report on failures that a retry has mended."""
    if total := mended.counts().total():
        yield f"Failures mended by a retry: {total}."
        yield from (f"  {line}" for line in mended.lines())


def _figures(interpreter: Interpreter) -> Iterator[str]:
    """Yield the lines of the report on the figures of the world."""
    if figures := interpreter.figures():
        yield "Figures of the world:"
        yield from (f"  {n:<20} {readable(v):>6}" for n, v in figures.items())


def _tell_what_ends_it(
    asked: Sequence[TaskRequest], library: Library, end: Time | None
) -> None:
    """Note on standard error that a run ends at once, or never."""
    if end is not None:
        return
    if all(request.background for request in asked):
        said = "note: the run ends at once: all tasks are in the background"
        click.echo(f"{said}; use --until", err=True)
    else:
        _tell_endless(asked, library)


def _tell_endless(asked: Sequence[TaskRequest], library: Library) -> None:
    """Note on standard error the tasks that keep a run going without end."""
    never = endless(reached(library, (str(one.goal[0]) for one in asked)))
    for request in asked:
        if request.goal[0] in never and not request.background:
            goal = visible(format_list(request.goal))
            said = f"note: {goal} never ends, so the run never ends"
            click.echo(
                f"{said}: use --until, or add another task and `:background true` "
                f"to this one",
                err=True,
            )


def _tell_deadlock(event: Event) -> None:
    """Report on standard error a deadlock that has closed; the run goes on."""
    assert isinstance(event, Deadlock)
    said = f"deadlock at time {readable(event.time)}: {'; '.join(event.waiting)}"
    click.echo(f"note: {visible(said)}", err=True)


def _went_well(result: TaskResult) -> bool:
    """Return whether a task succeeded or, in the background, did not fail."""
    if result.background:
        return result.outcome != "failed"
    return result.outcome == "succeeded"


@contextmanager
def _ended_by_interrupts(interpreter: Interpreter) -> Iterator[None]:
    """Let Ctrl-C end the run in the block early, so that it can be reported."""
    try:
        yield
    except KeyboardInterrupt:
        interpreter.end("cancelled")


class _Shown:
    """A stream for people: with readable numbers, without control characters."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write `text` with readable numbers and visible control characters."""
        return self._stream.write(visible_lines(readable_numbers(text)))

    def flush(self) -> None:
        """Flush the stream."""
        self._stream.flush()


def _opened(trace: str, files: Iterable[str], world: World) -> TextIO:
    """Open the file of a trace; a file that the run has read ends the command.

    Args:
        trace: the file to write.
        files: the files of the library.
        world: the world of the run, which may be a module of the user.
    """
    module = getattr(sys.modules.get(type(world).__module__), "__file__", None)
    inputs = (
        (files, "is a source file of the library"),
        ([module], "is the source file of the world"),
    )
    refuse_output("--trace", trace, TRACE, *inputs)
    try:
        return Path(trace).open("w", encoding="utf-8")
    except OSError as error:
        fail(f"cannot write `{trace}`: {reason(error)}")


def _drawable(world: HeldWorld, world_name: str) -> Callable[[], Picture]:
    """Return the `picture` of a world; a world without it ends the command."""
    if not isinstance(world, Drawable):
        fail(f"cannot show world `{world_name}`: it has no `picture` method")
    world.picture()
    return world.picture


def _show(
    stack: ExitStack,
    interpreter: Interpreter,
    picture: Callable[[], Picture],
    every: int,
) -> None:
    """Draw the run while it runs."""
    import shutil

    from rapc.console.show.live import LiveView

    known = (80, 24) if sys.stdout.isatty() else (PIPED_WIDTH, 0)
    view = LiveView(
        interpreter,
        picture,
        sys.stdout,
        lambda: shutil.get_terminal_size(known),
        color=settings().colored(),
        every=every,
    )
    interpreter.listen(stack.enter_context(view))
