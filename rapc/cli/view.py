"""`rapc view`: write a page that shows a run."""

from __future__ import annotations

import os
import signal
import webbrowser
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any

import click
import msgspec

from rapc.base.files import path_of
from rapc.base.interrupts import interrupts_held, terminations_as_interrupts
from rapc.base.outputs import CHROME, MCAP, PAGE
from rapc.base.values import readable
from rapc.base.visible import visible
from rapc.cli.common import (
    load_checked,
    refuse_output,
    serve,
    wait_for_readers,
    write_output,
    write_picture,
)
from rapc.cli.options import TypedPath, command, fail
from rapc.cli.repl import (
    RECORDED,
    begun_again,
    history_of,
    opened_journal,
    shell_of,
)
from rapc.cli.run_options import end_time, prepared, run_options, until_option
from rapc.debug.bug import SUFFIX
from rapc.debug.history import History, Moment, Stop
from rapc.debug.log import EventLog
from rapc.debug.questions.differences import MOST_DURATIONS, library_of
from rapc.debug.recorded import Replay
from rapc.debug.recording import Playback, Recording
from rapc.debug.saved_state import SavedState, is_saved_state
from rapc.durable.folder import is_journal, is_running
from rapc.experiments.draws import drawn
from rapc.experiments.points import Point
from rapc.experiments.run import resolved
from rapc.experiments.session import Batch
from rapc.runtime.events.trace import record
from rapc.view.page import live_page, page, unknown_start
from rapc.view.pictures import Pictures
from rapc.view.svg import svg
from rapc.view.viewed import Viewed, stream_trace
from rapc.world import Savable, Time
from rapc.worlds.registry import build_world, find_world

EXAMPLES = """\b
Examples:
  rapc view run.jsonl
  rapc view rocks.rap --world truck --agenda deliveries -o rocks.html --open
  rapc view yesterday.jsonl --compare today.jsonl
  rapc view run.jsonl --picture moment.svg --at 120
  rapc view --attach day-1 --open
  rapc view run.jsonl --export perfetto.json --export run.mcap
"""


_MOST_EVENTS = 2_000_000
"""The number of events that are kept for the symptoms, so that no run is repeated."""


@command(EXAMPLES)
@click.argument("path", required=False, type=TypedPath())
@click.option("--world", "world_name", help="World to run against.")
@run_options
@until_option
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="Write the page to FILE [default: PATH.html].",
)
@click.option(
    "--compare", "other", metavar="OTHER", help="Show this run beside the run at PATH."
)
@click.option(
    "--picture",
    metavar="FILE.svg",
    help="Write a picture of the world at a moment to FILE.",
)
@click.option(
    "--at",
    type=click.IntRange(0),
    metavar="CYCLE",
    help="Moment of the picture: the end of CYCLE [default: the end].",
)
@click.option(
    "--export",
    "exports",
    multiple=True,
    metavar="FILE",
    help="Write the run to FILE.json (Perfetto) or FILE.mcap (repeatable).",
)
@click.option(
    "--attach",
    type=TypedPath(file_okay=False),
    metavar="FOLDER",
    help="Serve the page of the run of a journal that goes on.",
)
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
def view(
    path: str | None,
    world_name: str | None,
    output: str | None,
    other: str | None,
    picture: str | None,
    at: int | None,
    exports: Sequence[str],
    attach: str | None,
    opens: bool,
    **more: Any,
) -> None:
    """Write a page that shows a run: one HTML file that needs no network.

    With --picture, write a drawing of the world beside what the robot believes. A run
    of a world without a picture shows what the robot believes. With --export, write the
    run for other tools: as a Chrome trace for Perfetto (FILE.json), or as an MCAP file
    for Foxglove and Lichtblick (FILE.mcap). With one of these options, a page is only
    written with -o, --compare or --open.

    PATH is a recorded run (FILE.jsonl), the report of a run (FILE.bug), the folder of a
    journal, a saved state, which is continued, or a library that is run; Ctrl-C ends
    the run. A recorded run of a
    simulated world is run again if its library and world are available: the page then
    shows the source and the truth, too.

    OTHER is like PATH. A library as OTHER begins its run as the run at PATH did, and is
    stopped after 10 times the duration of that run.

    With --attach, a server on this computer shows a run with a journal, which goes on
    in another process, until Ctrl-C. Standard error has the address.

    Exit status: 0 if the page was written, 2 if not.
    """
    if attach is not None:
        if any((path, output, other, picture, exports, *more.values())):
            raise click.UsageError("--attach can only be used with --world and --open")
        _attach(attach, world_name, opens=opens)
        return
    if path is None:
        raise click.UsageError("Missing argument 'PATH'.")
    if at is not None and picture is None:
        raise click.UsageError("--at requires --picture")
    for name in exports:
        _check_export(name, path)
    views = [_viewed(path, world_name, more)]
    if picture is not None:
        _draw(views[0], picture, at)
    for name in exports:
        _export(views[0], name)
    written = picture is not None or exports
    if written and output is None and other is None and not opens:
        return
    if other is not None:
        views.append(_other(other, world_name, views[0]))
        views[0].name, views[1].name = "before", "after"
    file = output or f"{Path(os.path.abspath(path_of(path))).stem}.html"
    files = [one for v in views if v.program for one in v.program.library.files]
    told = "is an input of the command"
    refuse_output("-o", file, PAGE, ([path, other, *files], told))
    write_output(file, page(views).encode())
    click.echo(f"wrote {visible(file)}")
    if opens:
        webbrowser.open(Path(file).resolve().as_uri())


def _attach(folder: str, world_name: str | None, *, opens: bool) -> None:
    """Serve the page of the run of a journal, which may go on."""
    shell = opened_journal(Path(folder), world_name, follow=True)
    history, note = shell.history, "the run goes on in another process"
    text = live_page(history.run, folder, note="; ".join([note, *_unknown(history)]))
    with interrupts_held():
        live = serve(text)
    try:
        with terminations_as_interrupts():
            stream_trace(history, live.feed)
            if opens:
                webbrowser.open(live.address)
            if is_running(Path(folder)):
                history.go()
            live.feed.end()
    except KeyboardInterrupt:
        live.close()
        return
    if history.over:
        wait_for_readers(live)
    else:
        wait_for_readers(live, "the run stands still: `rapc run --resume` continues it")


def _draw(viewed: Viewed, file: str, at: int | None) -> None:
    """Write the picture of a moment; default: the end."""
    first, last = viewed.history.beginning.cycle, viewed.history.cycle
    if at is not None and not first <= at <= last:
        fail(f"--at: expected a cycle from {first} to {last}, not {at}")
    scene = viewed.scene_at(at)
    if scene is None:
        fail("cannot draw the run: its world has no picture, and memory has no place")
    when = "the end" if at is None else f"cycle {at}"
    write_picture(file, svg(scene, f"{viewed.name}, {when}"))


def page_of_run(session: Batch, point: Point, seed: int) -> str:
    """Return the page of a run of an experiment, which is run again."""
    config = resolved(point.config, drawn(point.config.draws, seed))
    spec = msgspec.structs.replace(config.spec, seed=seed)
    ready = prepared(load_checked(point.library), spec, session.made.world)
    history = history_of(ready, spec.until)
    return page([_run(f"{point.part}, seed {seed}", history, goes_on=True)])


def _check_export(file: str, path: str) -> None:
    """End the command if the run cannot be written to a file."""
    kind = {".json": CHROME, ".mcap": MCAP}.get(Path(file).suffix.lower())
    if kind is None:
        fail(f"--export: expected FILE.json or FILE.mcap, not `{file}`")
    refuse_output("--export", file, kind, ([path], "is an input of the command"))
    if kind is MCAP and find_spec("mcap") is None:
        fail("--export: MCAP files require: pip install 'rapc[mcap]'")


def _export(viewed: Viewed, file: str) -> None:
    """Write a run for another tool."""
    records = (record(told.event()) for told in viewed.events())
    if file.lower().endswith(".mcap"):
        from rapc.view.mcap import write_mcap

        stream = BytesIO()
        write_mcap(stream, records, viewed.pictures.changes)
        data = stream.getvalue()
    else:
        from rapc.view.chrome import chrome_trace

        data = msgspec.json.encode(chrome_trace(records))
    write_output(file, data)
    click.echo(f"wrote {visible(file)}")


def _viewed(path: str, world_name: str | None, more: Mapping[str, Any]) -> Viewed:
    """Return the run at a path, at its end."""
    if path.endswith(RECORDED):
        if any(more.values()):
            fail(
                "cannot change the start of a recorded run",
                "remove all options of the run but --world",
            )
        return _recorded(Path(path), world_name)
    if is_saved_state(Path(path)):
        return _continued(Path(path), world_name, more)
    is_past = path.endswith(SUFFIX) or is_journal(Path(path))
    if not (is_past or more["tasks"] or more["agenda"]):
        fail("missing --task or --agenda")
    history = shell_of(path, world_name, **more).history
    return _run(path, history, goes_on=not is_past)


def _other(path: str, world_name: str | None, first: Viewed) -> Viewed:
    """Return a run to compare; a library begins its run as the first run did."""
    is_past = path.endswith((RECORDED, SUFFIX)) or is_journal(Path(path))
    if is_past or is_saved_state(Path(path)):
        return _viewed(path, world_name, {"until": None})
    spec = first.history.spec
    if spec.world_class and world_name is None:
        fail(f"missing `--world {spec.world_class}`, whose code is run only then")
    if spec.until is None:
        until = first.history.now * MOST_DURATIONS
        spec = msgspec.structs.replace(spec, until=until)
    ready = prepared(load_checked(path), spec, world_name or spec.world)
    return _run(path, history_of(ready, spec.until), goes_on=True)


def _continued(path: Path, world_name: str | None, more: Mapping[str, Any]) -> Viewed:
    """Return the run that continues a saved state, at its end."""
    until = end_time(more["until"])
    if any({**more, "until": None}.values()):
        fail(
            "cannot change the start of a saved state",
            "remove all options of the run but --world and --until",
        )
    state = SavedState(path.read_bytes())
    found = find_world(world_name or state.world)
    world = build_world(found, state.seed, state.options_of(found))
    run, log = state.continued(state.library(), world, {}), EventLog()
    if until is not None and until < run.now:
        fail(f"--until: the saved state is at time {readable(run.now)}")
    run.listen(log)
    return _run(path.name, History(run, log), goes_on=True, until=until)


def _run(
    name: str, history: History, *, goes_on: bool, until: Time | None = None
) -> Viewed:
    """Return a run at its end; Ctrl-C ends it early.

    Args:
        name: the name of the run.
        history: the run.
        goes_on: whether the run goes on from its present moment.
        until: the time at which it stops, if the history has no limit of its own.
    """
    notes = _unknown(history)
    history.branch.events.keep(_MOST_EVENTS)
    data = BytesIO()
    trace = TextIOWrapper(data, encoding="utf-8", newline="\n")
    stream_trace(history, trace)
    pictures = Pictures(history)  # it may leave the end of the run
    before = signal.signal(signal.SIGINT, lambda *_: history.pause())
    try:
        stop = Stop("asked")
        if goes_on and until is not None:
            stop = history.go(lambda: "" if history.now >= until else None)
        elif goes_on:
            stop = history.go()
    finally:
        signal.signal(signal.SIGINT, before)
    if stop.kind == "broken":
        notes.append(stop.said)
    trace.flush()
    note, program = "; ".join(notes), history.run.library
    return Viewed(name, note, data.getvalue(), history, program, pictures)


def _unknown(history: History) -> list[str]:
    """Return a note if the start of a run is unknown."""
    first = history.beginning
    if first == Moment(0):
        return []
    return [unknown_start(first.cycle)]


def _recorded(path: Path, world_name: str | None) -> Viewed:
    """Return a recorded run, run again if that gives the same events."""
    recording = Recording(path)
    history, note = begun_again(recording, world_name), ""
    history.branch.events.keep(_MOST_EVENTS)
    pictures = Pictures(history)
    if history.is_run and not isinstance(history.run.port, Savable):
        note = "the world of the run cannot be run again: the page shows no truth"
    elif history.is_run:
        replay = Replay(history, recording)
        history.go()
        if replay.parted is not None:
            note = f"{replay.note()}: the page shows no truth"
    if note or not history.is_run:
        history = History(Playback(recording))
        history.goto(recording.last_cycle + 1)
        pictures = Pictures(history)
    library = library_of(recording.begun)
    data = path.read_bytes()
    return Viewed(path.name, note, data, history, library, pictures, recording)
