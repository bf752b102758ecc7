"""`rapc view`: write a page that shows a run."""

from __future__ import annotations

import signal
import webbrowser
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import msgspec

from rapc.base.outputs import PAGE, SVG
from rapc.base.visible import visible
from rapc.cli.common import load_checked, refuse_output, write_output
from rapc.cli.options import command, fail
from rapc.cli.repl import RECORDED, begun_again, history_of, shell_of
from rapc.cli.run_options import prepared, run_options, until_option
from rapc.debug.bug import SUFFIX
from rapc.debug.history import History, Stop
from rapc.debug.questions.differences import MOST_DURATIONS, library_of
from rapc.debug.recorded import Replay
from rapc.debug.recording import Playback, Recording
from rapc.view.page import page
from rapc.view.pictures import Pictures
from rapc.view.svg import svg
from rapc.view.viewed import Trace, Viewed
from rapc.world import Savable

EXAMPLES = """\b
Examples:
  rapc view run.jsonl
  rapc view rocks.rap --world truck --task '(rock-order red 1)' -o rocks.html --open
  rapc view yesterday.jsonl --compare today.jsonl
  rapc view run.jsonl --picture moment.svg --at 120
"""


@command(EXAMPLES)
@click.argument("path", type=click.Path())
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
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
def view(
    path: str,
    world_name: str | None,
    output: str | None,
    other: str | None,
    picture: str | None,
    at: int | None,
    opens: bool,
    **more: Any,
) -> None:
    """Write a page that shows a run: one HTML file that needs no network.

    With --picture, write a drawing of the world beside what the robot believes, and no
    page without -o. A run of a world without a picture shows what the robot believes.

    PATH is a recorded run (FILE.jsonl), the report of a run (FILE.bug), or a library
    that is run; Ctrl-C ends the run. A recorded run of a simulated world is run again
    if its library and world are available: the page then shows the source and the
    truth, too.

    OTHER is like PATH. A library as OTHER begins its run as the run at PATH did, and is
    stopped after 10 times the duration of that run.

    Exit status: 0 if the page was written, 2 if not.
    """
    if at is not None and picture is None:
        raise click.UsageError("--at requires --picture")
    views = [_viewed(path, world_name, more)]
    if picture is not None:
        _draw(views[0], picture, at)
        if output is None and other is None and not opens:
            return
    if other is not None:
        views.append(_other(other, world_name, views[0]))
        views[0].name, views[1].name = "before", "after"
    file = output or f"{Path(path).stem}.html"
    files = [one for v in views if v.program for one in v.program.library.files]
    told = "is an input of the command"
    refuse_output("-o", file, PAGE, ([path, other, *files], told))
    write_output(file, page(views).encode())
    click.echo(f"wrote {visible(file)}")
    if opens:
        webbrowser.open(Path(file).resolve().as_uri())


def _draw(viewed: Viewed, file: str, at: int | None) -> None:
    """Write the picture of a moment; default: the end."""
    history = viewed.history
    scene = viewed.pictures.scene_at(history.cycle if at is None else at)
    if scene is None:
        fail("cannot draw the run: its world has no picture, and memory has no place")
    refuse_output("--picture", file, SVG)
    when = "the end" if at is None else f"cycle {at}"
    write_output(file, svg(scene, f"{viewed.name}, {when}").encode())
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
    is_report = path.endswith(SUFFIX)
    if not (is_report or more["tasks"] or more["agenda"]):
        fail("missing --task or --agenda")
    history = shell_of(path, world_name, **more).history
    return _run(path, history, goes_on=not is_report)


def _other(path: str, world_name: str | None, first: Viewed) -> Viewed:
    """Return a run to compare; a library begins its run as the first run did."""
    if path.endswith((RECORDED, SUFFIX)):
        return _viewed(path, world_name, {})
    spec = first.history.spec
    if spec.world_class and world_name is None:
        fail(
            f"missing `--world {spec.world_class}`, whose module is imported only then"
        )
    if spec.until is None:
        until = first.history.now * MOST_DURATIONS
        spec = msgspec.structs.replace(spec, until=until)
    ready = prepared(load_checked(path), spec, world_name or spec.world)
    return _run(path, history_of(ready, spec.until), goes_on=True)


def _run(name: str, history: History, *, goes_on: bool) -> Viewed:
    """Return a run at its end; Ctrl-C ends it early."""
    trace, pictures = Trace(history), Pictures(history)
    before = signal.signal(signal.SIGINT, lambda *_: history.pause())
    try:
        stop = history.go() if goes_on else Stop("asked")
    finally:
        signal.signal(signal.SIGINT, before)
    note = stop.said if stop.kind == "broken" else ""
    text = trace.text()
    return Viewed(name, note, text, history, history.run.library, pictures)


def _recorded(path: Path, world_name: str | None) -> Viewed:
    """Return a recorded run, run again if that gives the same events."""
    recording = Recording(path)
    history, note = begun_again(recording, world_name), ""
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
    return Viewed(path.name, note, path.read_bytes(), history, library, pictures)
