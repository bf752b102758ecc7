"""`rapc journal`: describe, verify, cut and convert journals of runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import click

from rapc.base.names import plural
from rapc.base.outputs import TRACE
from rapc.base.values import format_list, readable
from rapc.base.visible import visible
from rapc.cli.common import refuse_output
from rapc.cli.options import TypedPath, command, fail, say_error
from rapc.cli.repl import opened_journal
from rapc.debug.recorded import write_trace
from rapc.durable import folder as files
from rapc.durable.folder import Lock, Stored
from rapc.durable.past import Past, past_of
from rapc.durable.records import Answered, Requested
from rapc.errors import LoadError
from rapc.world import Finished, Lost

EXAMPLES = """\b
Examples:
  rapc run rocks.rap --world truck --agenda deliveries --journal day-1
  rapc journal info day-1
  rapc journal verify day-1
  rapc journal cut day-1 --cycle 5000
  rapc journal convert day-1 --trace day-1.jsonl
"""


@command(EXAMPLES)
@click.argument("action", type=click.Choice(["info", "verify", "cut", "convert"]))
@click.argument("folder", type=TypedPath())
@click.option(
    "--cycle", type=click.IntRange(min=0), metavar="N", help="With cut: the last cycle."
)
@click.option(
    "--trace",
    type=TypedPath(dir_okay=False),
    metavar="FILE",
    help="With convert: the file of the trace.",
)
@click.option("--world", "world_name", help="World of the run, for convert.")
def journal(
    action: str,
    folder: str,
    cycle: int | None,
    trace: str | None,
    world_name: str | None,
) -> None:
    """Describe, verify, cut or convert the journal in FOLDER.

    `info` lists what the journal is of, its size, its damage, and the requests under
    way. `verify` reads all files. `cut` removes what follows the last snapshot at or
    before a cycle: the run then resumes from there. `convert` writes the trace of the
    run.

    Exit status: 0; 1 if `verify` finds damaged files; 2 if the journal cannot be read.
    """
    path = Path(folder)
    if (action == "cut") != (cycle is not None):
        raise click.UsageError("`cut` requires --cycle, and no other action takes it")
    if (action == "convert") != (trace is not None):
        raise click.UsageError(
            "`convert` requires --trace, and no other action takes it"
        )
    if action == "info":
        for line in _described(path):
            click.echo(visible(line))
    elif action == "verify":
        _verify(path)
    elif cycle is not None:
        _cut(path, cycle)
    elif trace is not None:
        refuse_output("--trace", trace, TRACE)
        history = opened_journal(path, world_name).history
        count = write_trace(history, Path(trace))
        click.echo(f"{plural(count, 'event')} written")


def _described(folder: Path) -> Iterator[str]:
    stored = files.read(folder, whole=True)
    meta, spec = stored.meta, stored.meta.spec
    past = past_of(stored.records, stored.first_cycle)
    yield f"library   {spec.library}"
    yield f"world     {spec.world_class or spec.world}"
    if meta.engine is not None:
        yield f"engine    {meta.engine.name}"
    yield f"seed      {spec.seed}"
    for task in spec.tasks:
        yield f"task      {task}"
    yield f"rapc      {meta.rapc}"
    if meta.trace:
        yield f"trace     {meta.trace}"
    parts, snapshots = files.numbers(folder)
    size = sum(one.stat().st_size for one in folder.iterdir())
    yield (
        f"files     {plural(len(parts), 'part')}, "
        f"{plural(len(snapshots), 'snapshot')}, {readable(size / 1e6)} MB"
    )
    yield f"cycles    {stored.first_cycle} to {past.cycle}"
    yield (
        f"records   {plural(len(past.answers), 'answer')} of the world, "
        f"{plural(len(past.acts), 'act')} of the host"
    )
    yield f"state     {_state(folder, past)}"
    damage = [one.message for one in files.damaged_snapshots(folder)]
    if stored.damage is not None:
        damage = [stored.damage.message, *damage]
    for message in dict.fromkeys(damage):
        yield f"damage    {message}"
    for ticket, request in sorted(_under_way(stored).items()):
        yield f"under way [{ticket}] {request}"


def _state(folder: Path, past: Past) -> str:
    if past.reason:
        return f"ended ({past.reason})"
    return "goes on" if files.is_running(folder) else "to be resumed"


def _under_way(stored: Stored) -> dict[int, str]:
    """Return the requests and activations under way, by ticket."""
    found: dict[int, str] = {}
    for record in stored.records:
        if isinstance(record, Requested):
            found[record.asked[0]] = _in_words(record.asked)
        elif isinstance(record, Answered) and record.call in ("perform", "activate"):
            if record.told is not None:
                found.pop(record.asked[0], None)
        elif isinstance(record, Answered) and record.call in ("cancel", "deactivate"):
            found.pop(record.asked[0], None)
        elif isinstance(record, Answered) and record.call == "messages":
            for one in record.told:
                if isinstance(one, Finished | Lost):
                    found.pop(one.ticket, None)
    return found


def _in_words(asked: tuple[object, ...]) -> str:
    request = asked[1]
    assert isinstance(request, tuple)
    if len(asked) > 2:
        return " ".join(map(format_list, request))
    return format_list(request)


def _verify(folder: Path) -> None:
    files.read_meta(folder)
    parts, snapshots = files.numbers(folder)
    last = max((*parts, *snapshots), default=1)
    damage, records = list(files.damaged_snapshots(folder)), 0
    for number in range(min((*parts, *snapshots), default=1), last + 1):
        try:
            part = files.read_part(folder, number, is_last=number == last)
        except LoadError as error:
            damage.append(error)
            continue
        records += len(part.records)
        if part.end < part.size:
            cut, name = part.size - part.end, files.part_file(folder, number)
            click.echo(f"note: `{name}` ends with {cut} incomplete bytes")
    for one in damage:
        say_error(one.message)
    click.echo(
        f"{plural(len(parts), 'part')} with {plural(records, 'record')}, "
        f"{plural(len(snapshots), 'snapshot')}, {len(damage)} damaged"
    )
    if damage:
        raise SystemExit(1)


def _cut(folder: Path, cycle: int) -> None:
    files.read_meta(folder)
    lock = Lock(folder)
    parts, snapshots = files.numbers(folder)
    found = []
    for number in snapshots:
        with suppress(LoadError):  # one of the other snapshots may do
            snapshot = files.read_snapshot(folder, number)
            if snapshot.cycle <= cycle:
                found.append((number, snapshot.cycle))
    if not found and 1 not in parts:
        fail(f"cannot cut: the journal has no snapshot up to cycle {cycle}")
    number, at = max(found, default=(1, 0))
    for one in {*parts, *snapshots}:
        if one > number:
            files.snapshot_file(folder, one).unlink(missing_ok=True)
            files.part_file(folder, one).unlink(missing_ok=True)
    files.part_file(folder, number).unlink(missing_ok=True)
    lock.release()
    click.echo(f"the run resumes from cycle {at}")
