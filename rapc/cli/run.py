"""`rapc run`: run tasks of a library against a world."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any, TextIO, get_type_hints

import click
import msgspec

from rapc.analysis.facts.effects import endless, reached
from rapc.base.interrupts import interrupts_held, terminations_as_interrupts
from rapc.base.outputs import SAVED_STATE
from rapc.base.values import format_list, readable, readable_numbers
from rapc.base.visible import visible, visible_lines
from rapc.base.writing import Output
from rapc.cli.common import (
    PIPED_WIDTH,
    load_checked,
    refuse_output,
    serve,
    wait_for_readers,
    width_of,
    write_output,
)
from rapc.cli.durable import (
    Begun,
    Course,
    JournalOptions,
    Resumed,
    refuse_trace,
)
from rapc.cli.options import TypedPath, WholeNumber, command, fail, options_of, settings
from rapc.cli.run_options import (
    end_time,
    prepared,
    read_spec,
    run_options,
    until_option,
)
from rapc.errors import StateError
from rapc.events import Deadlock, Event, TaskResult
from rapc.library.library import Library
from rapc.runtime.events.report import (
    OF_DECISIONS,
    OF_GOALS,
    MendedFailures,
    RunReport,
)
from rapc.runtime.events.trace import JsonTrace, TextTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.spec import RunSpec
from rapc.world import Drawable, Picture, Time

if TYPE_CHECKING:
    from rapc.view.live import Live

EXAMPLES = """\b
Examples:
  rapc run rocks.rap --world truck --task '(fill-order red 4 factory-1)'
  rapc run rocks.rap --world truck --agenda deliveries --seed 7 -q
  rapc run rocks.rap --world truck --task '(wakeup)' --trace run.jsonl
  rapc run rocks.rap --world truck --task '(wakeup)' \\
      --fault '(arm-grasp ?arm ?thing) arm-dropped p=0.3 from=100 until=200'
  rapc run my.rap --world truck --set truck.fuel=20 --set rapc.futile-limit=3 \\
      --task '(patrol) :priority 4' --until 500
  rapc run rocks.rap --world truck --agenda deliveries --journal day-1
  rapc run --resume day-1
"""


_MOST_FRAMES = 1_000_000

_MOST_TOLD = 60_000
"""The number of events that are kept to explain the end of the run."""


@command(EXAMPLES)
@click.argument("path", required=False, type=TypedPath())
@click.option("--world", "world_name", help="World to run against.")
@run_options
@until_option
@click.option(
    "--trace", type=TypedPath(dir_okay=False), help="Write the trace to FILE."
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
    type=TypedPath(dir_okay=False),
    metavar="FILE",
    help="Write the state at the time of --until to FILE.",
)
@click.option(
    "--keep",
    "kept",
    type=TypedPath(dir_okay=False),
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
@click.option(
    "--view",
    "port",
    type=click.IntRange(0, 65535),
    is_flag=False,
    flag_value=0,
    metavar="[PORT]",
    help="Serve the page of the run on this computer until Ctrl-C.",
)
@click.option(
    "--paused", is_flag=True, help="With --view: pause before the first cycle."
)
@options_of(JournalOptions)
def run(
    path: str | None,
    world_name: str | None,
    until: float | None,
    trace: str | None,
    trace_format: str,
    trace_pictures: bool,
    save: str | None,
    kept: str | None,
    show: bool,
    show_every: int | None,
    port: int | None,
    paused: bool,
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

    With --view, a server on this computer shows the run in a browser while the run goes
    on. Standard error has the address. Readers need its token; they see the run from
    its start. Without PORT, the server takes a free port. After the end of the run the
    server waits for Ctrl-C. Readers may pause the run, step, submit tasks, assert facts
    and force results; with --save, they only watch. A journal has the acts of readers,
    who cannot force results then.

    With --journal, the run can be resumed after the end of its process: `rapc run
    --resume FOLDER` continues the run and its trace. FOLDER names the world, whose code
    is run: resume only journals that you trust.

    The outcome of a request that was under way at the end of the process may be
    unknown. --after-crash states the treatment of a primitive: `repeat` sends the
    request again, `fail` ends its method, `ask` asks the user on a terminal. By default
    sensors repeat and other primitives fail.

    Exit status: 0 if every foreground task succeeded and no background task failed, 1
    if not, 2 if the run could not start or its files cannot be written, 3 if a request
    under way requires --after-crash.
    """
    if show_every is not None and not show:
        raise click.UsageError("--show-every requires --show")
    if save is not None and until is None:
        raise click.UsageError("--save requires --until")
    if paused and (port is None or save is not None):
        raise click.UsageError("--paused requires --view, without --save")
    keep = _keeping(kept)
    traced = trace, trace_format, trace_pictures
    course = _course(path, world_name, until, save, traced, more)
    if port is not None and save is None:
        from rapc.view.control import Control

        course.control = Control(paused=paused)
    interpreter = course.run
    files = interpreter.library.library.files
    wanted = show or trace_pictures
    drawn = _drawable(interpreter) if wanted else None
    if save is not None:
        told = "is a source file of the library"
        refuse_output("--save", save, SAVED_STATE, (files, told))
    report = RunReport(interpreter.world.kit.offer.sensors)
    mended = MendedFailures()
    course.reports = report, mended
    known: deque[Event] = deque(maxlen=_MOST_TOLD)
    with ExitStack() as stack, _ended_by_interrupts(course):
        stack.callback(lambda: keep(course.run, str(path)))
        with interrupts_held():
            live = _followed(stack, course, path, traced, port)
            interpreter.listen(report, *RunReport.kinds)
            interpreter.listen(mended, *MendedFailures.kinds)
            interpreter.listen(
                known.append, *(OF_DECISIONS if settings().quiet else OF_GOALS)
            )
            _show_run(stack, interpreter, drawn if show else None, show_every)
            stack.callback(course.close)
            course.begin()
        if save is not None:
            _save_at(course, save)
        course.go()
    try:
        _tell_end(course.run, report, mended, known)
    finally:
        if live is not None:
            wait_for_readers(live)


def _followed(
    stack: ExitStack,
    course: Course,
    path: str | None,
    traced: tuple[str | None, str, bool],
    port: int | None,
) -> Live | None:
    """Write the trace of a run, and serve its page if there is a port.

    A file or a port that cannot be used ends the command.
    """
    trace, trace_format, _ = traced
    run, stream, live = course.run, None, None
    if trace is not None:
        refuse_trace(trace, [str(path), *run.library.library.files], run.world)
        if not isinstance(course, Begun):
            stream = stack.enter_context(Output(trace).text())
    # One encoding serves the file and the readers.
    shared = stream if trace_format == "jsonl" else None
    if port is not None:
        live = _served(course, path or run.spec.library, port, shared)
        stack.callback(live.feed.end)
    if stream is not None and (live is None or shared is None):
        run.listen((TextTrace if shared is None else JsonTrace)(stream))
    return live


def _served(course: Course, name: str, port: int, trace: TextIO | None) -> Live:
    """Serve the page of a run, and write its events to the file of a trace, if any.

    A port that cannot be used ends the command.
    """
    from rapc.view.page import live_page, unknown_start

    commands, note = () if course.control is None else course.control.commands(), ""
    if isinstance(course, Resumed) and course.unknown:
        note = unknown_start(course.unknown)
    text = live_page(course.run, name, commands, note)
    live = serve(text, port, course.control, trace)
    heard = JsonTrace(live.feed)
    course.run.listen(heard)
    if isinstance(course, Resumed):
        course.hear_past = heard
    return live


def _show_run(
    stack: ExitStack,
    interpreter: Interpreter,
    drawn: Callable[[], Picture] | None,
    show_every: int | None,
) -> None:
    """Print or draw the run while it runs, unless -q is set."""
    if drawn is not None:
        _show(stack, interpreter, drawn, show_every or 0)
        return
    interpreter.listen(_tell_deadlock, Deadlock)
    if not settings().quiet:
        interpreter.listen(TextTrace(_Shown(sys.stdout)))


def _tell_end(
    interpreter: Interpreter,
    report: RunReport,
    mended: MendedFailures,
    known: Iterable[Event],
) -> None:
    """Print the report; exit with status 1 if a task has failed."""
    for line in chain(report.lines(), _mended(mended), _figures(interpreter)):
        click.echo(visible(line))
    if not all(map(_went_well, interpreter.results())):
        _explain(known, interpreter)
        raise SystemExit(1)


def _course(  # the options of `run`
    path: str | None,
    world_name: str | None,
    until: float | None,
    save: str | None,
    traced: tuple[str | None, str, bool],
    more: dict[str, Any],
) -> Course:
    """Return the course of a run that can start; an invalid option ends the command.

    Args:
        path: the library.
        world_name: the world.
        until: the time limit.
        save: the value of `--save`.
        traced: the values of `--trace`, `--trace-format` and `--trace-pictures`.
        more: the other options of a run, and those of `JournalOptions`.
    """
    given = {name: more.pop(name) for name in get_type_hints(JournalOptions)}
    trace, trace_format, pictures = traced
    if given["journal"] is not None and (save or trace_format != "jsonl"):
        other = "--save" if save else f"--trace-format {trace_format}"
        raise click.UsageError(f"--journal cannot be used with {other}")
    if given["resume"] is not None:
        if given["journal"] is not None:
            raise click.UsageError("--journal cannot be used with --resume")
        if any((path, world_name, *more.values(), until, trace, save, pictures)):
            fail("cannot change the start of a resumed run")
        return Resumed(given)
    if given["journal"] is None and any(given.values()):
        name = next(name for name, value in given.items() if value)
        option = name.replace("_", "-")
        needed = "--resume" if name == "take_up" else "--journal or --resume"
        raise click.UsageError(f"--{option} requires {needed}")
    if path is None:
        raise click.UsageError("Missing argument 'PATH'.")
    if world_name is None:
        raise click.UsageError("Missing option '--world'.")
    if more["agenda"] is None and not more["tasks"]:
        fail("missing --task or --agenda")
    library = load_checked(path)
    end = end_time(until)
    spec = read_spec(world_name, until=end, **more)
    if pictures:
        spec = _with_pictures(spec, trace is not None and trace_format == "jsonl")
    interpreter = prepared(library, spec, world_name)
    _tell_what_ends_it(interpreter.first_tasks, library.library, end)
    if given["journal"] is not None:
        return Begun(interpreter, given, end, trace)
    return Course(interpreter, end)


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


def _save_at(course: Course, file: str) -> None:
    """Run to the end time, write the state and end the run.

    A run that ends before ends the command.
    """
    from rapc.debug.saved_state import state_file

    interpreter, time = course.run, course.until
    assert time is not None
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
def _ended_by_interrupts(course: Course) -> Iterator[None]:
    """Let Ctrl-C or SIGTERM end the run in the block early; the report follows.

    The run ends after its present cycle; a second signal in this cycle ends the command
    at once. The journal of the run, if any, does not have this end.
    """
    delayed = forced = False

    def delay() -> bool:
        nonlocal delayed, forced
        if not course.run.interrupt():
            return False
        delayed, forced = True, delayed
        return not forced

    with terminations_as_interrupts(delay):
        try:
            yield
        except KeyboardInterrupt:
            if forced:
                raise
            course.cancel()


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


def _drawable(run: Interpreter) -> Callable[[], Picture]:
    """Return the `picture` of the world; a world without it ends the command."""
    world = run.port
    if not isinstance(world, Drawable):
        name = run.spec.world_class or run.spec.world
        fail(f"cannot show world `{name}`: it has no `picture` method")
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
