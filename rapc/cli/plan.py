"""`rapc plan GOAL PATH`: find a plan for a goal that no RAP has."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from rapc.base.source import SourceFile
from rapc.base.visible import visible
from rapc.cli.common import load_checked, write_output
from rapc.cli.options import Amount, TypedPath, WholeNumber, command, fail, settings
from rapc.cli.run_options import (
    end_time,
    prepared,
    read_spec,
    run_options,
    until_option,
)
from rapc.errors import FactError, PlanError, TextError, reason
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import read_settings
from rapc.world import Time

if TYPE_CHECKING:
    from rapc.planning.plan import Plan

EXAMPLES = """\b
Examples:
  rapc plan '(docked)' examples/courier --world courier
  rapc plan '(and (delivered medicine ward-3) (docked))' examples/courier \\
      --world courier --format steps
  rapc plan '(docked)' examples/courier --fact '(robot-at kitchen)' --explain
  rapc plan '(docked)' examples/courier --world courier --engine up:pyperplan
"""

_MOST_STATES = 10_000_000


@command(EXAMPLES)
@click.argument("goal")
@click.argument("path", type=TypedPath())
@click.option("--world", "world_name", help="World whose facts hold.")
@run_options
@click.option(
    "--after",
    type=Amount(min=0),
    metavar="TIME",
    help="Plan for the facts in a run at TIME.",
)
@click.option(
    "--use",
    multiple=True,
    metavar="RAP",
    help="Use only these RAPs with `effects` (repeatable).",
)
@click.option(
    "--limit",
    type=WholeNumber(_MOST_STATES),
    metavar="N",
    help="Look at N states at most [default: rapc.plan-limit].",
)
@click.option(
    "--explain", is_flag=True, help="Also list the parts that the planner leaves out."
)
@click.option(
    "--format",
    "output_format",
    type=click.Choice(["rap", "steps", "json"]),
    default="rap",
    show_default=True,
    help="Format of the plan.",
)
@click.option(
    "--keep",
    "kept",
    type=TypedPath(dir_okay=False),
    metavar="FILE",
    help="Write the RAP with its plan to a new RAP file.",
)
@click.option(
    "--export",
    "exported",
    type=TypedPath(file_okay=False),
    metavar="DIR",
    help="Write DIR/domain.pddl and DIR/problem.pddl.",
)
@click.option(
    "--engine",
    metavar="ENGINE",
    default="builtin",
    show_default=True,
    help="Planner: `builtin`, `up:NAME` or a command.",
)
@click.option(
    "--engine-timeout",
    type=Amount(min=0, min_open=True),
    default=10,
    show_default=True,
    metavar="SECONDS",
    help="Time limit for an answer of the engine.",
)
@click.option(
    "--strips", is_flag=True, help="With --export, --engine: leave out costs."
)
@click.option("--run", "execute", is_flag=True, help="Also run the plan.")
@click.option("--priority", type=int, help="With --run: priority of the task.")
@until_option
def plan(
    goal: str,
    path: str,
    world_name: str | None,
    after: float | None,
    use: tuple[str, ...],
    limit: int | None,
    explain: bool,
    output_format: str,
    kept: str | None,
    exported: str | None,
    engine: str,
    engine_timeout: float,
    strips: bool,
    execute: bool,
    priority: int | None,
    until: float | None,
    **more: Any,
) -> None:
    """Find a plan for GOAL with the RAPs of the library at PATH that have `effects`.

    The plan begins with the facts of the world and of --fact; with --after, with the
    facts in memory at that time of a run.

    --export writes the situation, the goal and the instances of operators as PDDL
    without variables. If actions have different costs, it uses `:action-costs`.

    With --engine, the planner is a program in a process of its own: `up:NAME` is an
    engine of unified-planning, and a command has the words {domain}, {problem} and
    {plan} for the names of the files. rapc checks each plan of an engine. If there is
    no valid plan within --engine-timeout, the built-in planner is asked.

    With --run, the run continues with a task for the goal; the planner is asked again
    if the plan fails.

    Exit status: 0 for a plan, 1 without one, or if the run did not achieve the goal, 2
    if the search could not start.
    """
    from rapc.cli.keep import keep_plan, refuse_kept
    from rapc.host import CheckedLibrary, planner_of
    from rapc.host import engine as find_engine
    from rapc.host import plan as find
    from rapc.parser.formatter import formatted

    has_world = world_name is not None
    has_pddl = exported is not None or engine != "builtin"
    _require(
        (execute or after is not None, has_world, "--run and --after require --world"),
        (priority is not None, execute, "--priority requires --run"),
        (until is not None, execute, "--until requires --run"),
        (strips, has_pddl, "--strips requires --export or --engine"),
    )
    end = end_time(until)
    if kept is not None:
        refuse_kept(kept)
    library = load_checked(path)
    spec = read_spec(world_name, **more)
    try:
        asked = find_engine(engine, engine_timeout, costs=not strips)
    except PlanError as error:
        fail(error.message, error.help)
    run = None
    if world_name is not None:
        run = prepared(library, spec, world_name, planner=planner_of(asked))
        _advance(run, after)
    limits = read_settings(spec.settings)
    try:
        found = find(
            CheckedLibrary(library),
            goal,
            facts=spec.facts,
            run=run,
            use=use,
            limit=limits.plan_limit if limit is None else limit,
            tries=limits.plan_tries,
            engine=asked,
        )
    except (TextError, FactError, PlanError) as error:
        fail(error.message, error.help)
    if found.refused:
        said = f"note: {found.refused}; the built-in planner was asked"
        click.echo(visible(said), err=True)
    for part in found.unseen:
        said = f"note: the planner takes this part of the goal to hold: {part}"
        click.echo(visible(said), err=True)
    text = formatted(SourceFile("plan", found.text)).text
    _print(found, text, output_format)
    if explain:
        for part in found.left_out:
            click.echo(visible(f"left out: {part}"))
    if exported is not None:
        _export(exported, found.pddl(costs=not strips))
    if not found:
        _end_without_plan(found, empty=run is None and not spec.facts)
    if kept is not None:
        keep_plan(kept, text, path)
    if execute and run is not None and not _achieved(run, goal, priority, use, end):
        raise SystemExit(1)


def _require(*rules: tuple[bool, bool, str]) -> None:
    """End the command if an option is used without the option that it requires."""
    for used, met, said in rules:
        if used and not met:
            fail(said)


def _end_without_plan(found: Plan, *, empty: bool) -> NoReturn:
    """End the command; if memory is empty, print a note about its facts."""
    if empty and found.unreachable and found.operators:
        click.echo("note: memory has no facts; use --world or --fact", err=True)
    raise SystemExit(1)


def _export(folder: str, texts: tuple[str, str] | None) -> None:
    """Write a domain and a problem to a folder; an error ends the command."""
    if texts is None:
        fail("--export: the problem has too many instances of operators")
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        fail(f"--export: cannot create `{folder}`: {reason(error)}")
    for name, text in zip(("domain", "problem"), texts, strict=True):
        write_output(str(Path(folder, f"{name}.pddl")), text.encode())


def _advance(run: Interpreter, after: float | None) -> None:
    """Start a run, and continue to a time; a run without tasks is not over then."""
    run.start()
    if after is not None:
        run.call_at(after, lambda: None)
        while run.now < after and run.reason is None:
            if not run.come_to_arrival():
                run.step()


def _achieved(
    run: Interpreter,
    goal: str,
    priority: int | None,
    use: Sequence[str],
    end: Time | None,
) -> bool:
    """Run a task for the goal, print the trace, and return whether it succeeded."""
    from rapc.runtime.events.trace import TextTrace

    if not settings().quiet:
        run.listen(TextTrace(sys.stdout))
    name = run.achieve(goal, priority or 0, use=use)
    run.run(until=end)
    outcome = next(one.outcome for one in run.results() if one.goal.name == name)
    click.echo(visible(f"{goal}: {outcome}"))
    return outcome == "succeeded"


def _print(found: Plan, text: str, output_format: str) -> None:
    """Print a plan in a format, or the reason why there is none."""
    if output_format == "json":
        click.echo(_json(found))
    elif not found:
        click.echo(visible(found.summary))
    elif output_format == "rap":
        click.echo(text, nl=False)
    else:
        for line in _steps(found):
            click.echo(visible(line))


def _steps(found: Plan) -> list[str]:
    """Return a line for each step with its purpose, and a line of figures."""
    width = max(len(step.goal) for step in found.steps) if found.steps else 0
    lines = [
        f"{step.tag} {step.goal:<{width}}  {step.purpose}".rstrip()
        for step in found.steps
    ]
    return [*lines, found.summary]


def _json(found: Plan) -> str:
    """Return a plan as JSON."""
    import msgspec

    said = {
        "reason": found.reason,
        "steps": found.steps,
        "cost": found.cost,
        "expanded": found.expanded,
        "unreachable": found.unreachable,
        "left-out": found.left_out,
        "text": found.text if found else "",
        "engine": found.engine,
        "refused": found.refused,
    }
    return msgspec.json.encode(said).decode()
