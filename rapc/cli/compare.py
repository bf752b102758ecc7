"""`rapc compare`: compare two runs, or two libraries over seeds."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import msgspec

from rapc.cli.common import load_checked, width_of
from rapc.cli.options import Amount, TypedPath, WholeNumber, command, fail, settings
from rapc.cli.repl import RECORDED, shell_of
from rapc.cli.run_options import (
    end_time,
    prepared,
    processes_option,
    read_spec,
    run_options,
    until_option,
)
from rapc.compiler.program import Program
from rapc.debug.bug import SUFFIX
from rapc.debug.questions.differences import (
    MOST_DURATIONS,
    Comparison,
    Side,
    compared,
    finished,
    recorded_run,
    this_run,
)
from rapc.experiments.definition import MOST_SEEDS
from rapc.spec import RunSpec

EXAMPLES = """\b
Examples:
  rapc compare yesterday.jsonl today.jsonl
  rapc compare yesterday.jsonl my-library/
  rapc compare customer.bug my-library/
  rapc compare old/ new/ --world courier --agenda shift --until 3000 --seeds 30
"""


_TIME_LIMIT = 120
"""The time limit of a run of many, in seconds."""

_THRESHOLD = 5
"""The default of `--threshold`, in per cent."""


@command(EXAMPLES)
@click.argument("before", type=TypedPath())
@click.argument("after", type=TypedPath())
@click.option("--world", "world_name", help="World to run libraries against.")
@run_options
@until_option
@click.option(
    "--seeds",
    type=WholeNumber(MOST_SEEDS),
    metavar="N",
    help="Compare N runs of each library, from --seed on.",
)
@processes_option
@click.option(
    "--threshold",
    type=Amount(min=0),
    default=_THRESHOLD,
    show_default=True,
    metavar="PERCENT",
    help="Increase of the time that sets exit status 1.",
)
@click.option("--json", "as_json", is_flag=True, help="Write one line of JSON.")
def compare(
    before: str,
    after: str,
    world_name: str | None,
    until: float | None,
    seeds: int | None,
    processes: int | None,
    threshold: float,
    as_json: bool,
    **more: Any,
) -> None:
    """Compare the runs BEFORE and AFTER.

    A run is a recorded run (FILE.jsonl), the report of a run (FILE.bug), or a library
    that is run. The output has the first different decision with its reasons on both
    sides, a table with the cost of all differences in time, and the definitions that
    differ.

    With a file and a library, the run of the library begins as the run of the file did;
    it is stopped after 10 times the duration of that run. Two libraries require --world
    and tasks; with --seeds, the table has averages with 95 % confidence intervals.

    Exit status: 0; 1 if AFTER has fewer successful tasks, or as many and takes longer
    by PERCENT or more; 2 if a run could not start.
    """
    recorded = [one for one in (before, after) if one.endswith((RECORDED, SUFFIX))]
    if recorded and any((*{**more, "seed": 0}.values(), until, seeds, more["seed"])):
        fail(
            "cannot change the start of a recorded run",
            "use only --world, --threshold and --json",
        )
    if processes is not None and seeds is None:
        fail("--jobs requires --seeds")
    if len(recorded) == 2:
        one = _recorded(before, world_name, "before")
        other = _recorded(after, world_name, "after")
        found = compared(one, other, threshold=threshold)
    elif recorded:
        found = _beside_a_recording(before, after, world_name, threshold)
    else:
        libraries = (load_checked(before), load_checked(after))
        if world_name is None:
            fail("missing --world", "list the installed worlds with `rapc worlds`")
        if more["agenda"] is None and not more["tasks"]:
            fail("missing --task or --agenda")
        spec = read_spec(world_name, until=end_time(until), **more)
        if seeds is None:
            one, other = _run_both(libraries, spec, world_name)
            found = compared(one, other, threshold=threshold)
        else:
            found = _of_seeds(libraries, spec, world_name, seeds, processes, threshold)
    _print(found, as_json)
    raise SystemExit(1 if found.worse else 0)


def _print(found: Comparison, as_json: bool) -> None:
    if as_json:
        record = {"worse": found.worse, **found.answer.record()}
        click.echo(msgspec.json.encode(record))
        return
    from rapc.repl.draw import draw

    color = settings().colored()
    click.echo(draw(found.answer, width_of(sys.stdout), color=color), nl=False)


def _beside_a_recording(
    before: str, after: str, world_name: str | None, threshold: float
) -> Comparison:
    """Compare a recorded run with a run of a library that begins in the same way."""
    is_before = before.endswith((RECORDED, SUFFIX))
    path, library = (before, after) if is_before else (after, before)
    names = ("before", "after") if is_before else ("after", "before")
    recorded = _recorded(path, world_name, names[0])
    begun = recorded.spec
    if begun.world_class and world_name is None:
        fail(
            f"the code of the world `{begun.world_class}` is run only with "
            f"`--world {begun.world_class}`"
        )
    if begun.until is None:
        begun = msgspec.structs.replace(begun, until=recorded.now * MOST_DURATIONS)
    named = world_name or begun.world
    run = _run(load_checked(library), begun, named, names[1])
    one, other = (recorded, run) if is_before else (run, recorded)
    return compared(one, other, threshold=threshold)


def _recorded(path: str, world_name: str | None, name: str) -> Side:
    """Return a recorded run from its trace, or repeat the run of a report."""
    if path.endswith(SUFFIX):
        return this_run(shell_of(path, world_name, until=None).history, name)
    return recorded_run(Path(path), name)


def _run(library: Program, spec: RunSpec, world_name: str, name: str) -> Side:
    return finished(prepared(library, spec, world_name), spec.until, name)


def _run_both(
    libraries: Sequence[Program], spec: RunSpec, world_name: str
) -> tuple[Side, Side]:
    before, after = libraries
    return (
        _run(before, spec, world_name, "before"),
        _run(after, spec, world_name, "after"),
    )


def _of_seeds(  # the options of the command
    libraries: Sequence[Program],
    spec: RunSpec,
    world_name: str,
    seeds: int,
    processes: int | None,
    threshold: float,
) -> Comparison:
    """Compare two libraries over seeds, and the decisions of the first that differs."""
    from rapc.console.experiments.output import bar
    from rapc.experiments.paired import run_pairs

    if spec.faults:
        fail("cannot combine --seeds and --fault")
    for library in libraries:
        prepared(library, spec, world_name)
    wanted = range(spec.seed, spec.seed + seeds)
    given = settings()
    shown = sys.stderr.isatty() and not given.quiet
    with bar(
        "runs", 2 * seeds, sys.stderr, shown=shown, color=given.colored()
    ) as advance:
        found, faults = run_pairs(
            libraries, spec, wanted, processes, _TIME_LIMIT, advance
        )
    if faults:
        fail("run without a result", *faults)
    differ = (seed for seed, (one, other) in found.items() if one != other)
    seed = next(differ, spec.seed)
    one_spec = msgspec.structs.replace(spec, seed=seed)
    one, other = _run_both(libraries, one_spec, world_name)
    pairs = [*found.values()]
    return compared(one, other, pairs=pairs, of=f"seed {seed}", threshold=threshold)
