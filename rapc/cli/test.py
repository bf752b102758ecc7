"""`rapc test`: run the tests of RAP libraries."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from rapc.base.files import same_file
from rapc.base.names import did_you_mean
from rapc.base.outputs import COVERAGE, JUNIT
from rapc.base.visible import visible
from rapc.cli.check_options import nearest_config
from rapc.cli.common import (
    print_line,
    refuse_faulty,
    refuse_output,
    write_output,
)
from rapc.cli.options import Amount, TypedPath, WholeNumber, command, fail, settings
from rapc.cli.run_options import fault_option, read_option
from rapc.console.lines import wrapped
from rapc.console.testing import explain
from rapc.testing import coverage as covering
from rapc.testing import discover
from rapc.testing.coverage import Coverage, FileCoverage
from rapc.testing.faults import read_fault
from rapc.testing.run import Case, Outcome
from rapc.testing.session import TestSession, effects_summary, exit_status, summary
from rapc.worlds.registry import importing_from

EXAMPLES = """\b
Examples:
  rapc test my-library/
  rapc test arms.test.rap --seeds 20
  rapc test tests/ --fault '(arm-grasp ?arm ?x) arm-dropped p=0.3 until=200'
"""

_LEAST_WIDTH = 20

_MOST_SEEDS = 100_000

_MOST_JOBS = 1000


@command(EXAMPLES)
@click.argument("paths", nargs=-1, metavar="PATH...", type=TypedPath())
@click.option(
    "--only",
    multiple=True,
    metavar="NAME",
    help="Run only the tests of this name (repeatable).",
)
@click.option("--seed", type=int, default=0, show_default=True, help="First seed.")
@click.option(
    "--seeds",
    type=WholeNumber(_MOST_SEEDS),
    default=1,
    metavar="N",
    help="Number of seeds; a test must pass with each.",
)
@click.option(
    "--jobs",
    type=WholeNumber(_MOST_JOBS),
    default=1,
    show_default=True,
    metavar="N",
    help="Number of processes.",
)
@fault_option
@click.option(
    "--world-module",
    "modules",
    multiple=True,
    metavar="MODULE",
    help="Allow tests to import worlds from MODULE (repeatable).",
)
@click.option(
    "--junit",
    type=TypedPath(dir_okay=False),
    metavar="FILE",
    help="Write the results to FILE as JUnit XML.",
)
@click.option(
    "--coverage",
    is_flag=False,
    flag_value="",
    metavar="[FILE.json]",
    help="Report test coverage; with FILE.json, also as JSON.",
)
@click.option(
    "--coverage-min",
    "least",
    type=Amount(0, 100),
    metavar="N",
    help="Fail if the coverage is below N per cent.",
)
@click.option(
    "--effects",
    is_flag=True,
    help="Check the declared effects of RAPs in simulators.",
)
def test(
    paths: Sequence[str],
    only: Sequence[str],
    seed: int,
    seeds: int,
    jobs: int,
    faults: Sequence[str],
    modules: Sequence[str],
    junit: str | None,
    coverage: str | None,
    least: float | None,
    effects: bool,
) -> None:
    """Run the tests in files, and in all *.test.rap files below folders.

    Tests may import worlds from the modules of --world-module and from the
    `world-modules` of the nearest rapc.toml, or of `[tool.rapc]` in a pyproject.toml.

    With --effects, a test in a simulator also fails if a RAP succeeds and one of its
    declared effects has not come true.

    Exit status: 0 if all tests passed, 1 if a test failed, 2 if a test could not run.
    """
    if coverage and not coverage.endswith(".json"):
        paths, coverage = (coverage, *paths), ""
    if not paths:
        raise click.UsageError("missing a file or folder with tests")
    gathered = None if coverage is None and least is None else Coverage()
    if jobs > 1:
        _refuse_with_jobs(paths, gathered, only)
    injected = tuple([read_option("--fault", read_fault, text) for text in faults])
    configured = nearest_config(paths[0])
    permitted = (*modules, *configured.config.world_modules)
    running = TestSession(
        range(seed, seed + seeds), injected, gathered, permitted, effects
    )
    cases = _find(paths, only)
    inputs = {*paths, *(file for case in cases for file in _files(case))}
    told = "is a source file of the tests or of their library"
    for option, file, output in (
        ("--junit", junit, JUNIT),
        ("--coverage", coverage, COVERAGE),
    ):
        if file:
            refuse_output(option, file, output, (inputs, told))
    if junit and coverage and same_file(junit, coverage):
        fail(f"cannot write --junit and --coverage to the same file `{junit}`")
    useless = list(running.useless(cases))
    if useless:
        fail("--fault: " + useless[0], *useless[1:])
    home = Path.cwd() if configured.file is None else configured.file.parent
    with importing_from(home):
        outcomes = _tell(
            running.run(cases)
            if jobs == 1
            else _in_processes(running, paths, cases, jobs)
        )
    _explain(outcomes)
    status = exit_status(outcomes)
    if gathered is not None:
        print_coverage(gathered.files(), coverage)
        if least is not None and _falls_short(gathered, least):
            status = max(status, 1)
    if effects:
        _say("text", effects_summary(outcomes))
    if junit is not None:
        write_output(junit, explain.as_junit(outcomes))
    click.echo(summary(outcomes, seeds))
    raise SystemExit(status)


def _files(case: Case) -> Iterable[str]:
    """Return the files that a test was read from."""
    return (case.test.span.file, *case.library.library.files)


def print_coverage(files: Sequence[FileCoverage], file: str | None) -> None:
    """Print the coverage of tests or runs; also write it to a file."""
    for line in covering.table(files):
        _say("text", line)
    click.echo()
    if file:
        write_output(file, covering.as_json(files))


def _falls_short(gathered: Coverage, least: float) -> bool:
    """Print the coverage; return whether it is below the required minimum."""
    short, told = covering.verdict(gathered.files(), least)
    _say("failed" if short else "text", told)
    return short


def _find(paths: Sequence[str], only: Sequence[str]) -> tuple[Case, ...]:
    """Return the tests in files and folders; with `only`, those of these names."""
    found = discover.find(paths)
    refuse_faulty(*found.reports)
    where = ", ".join(f"`{path}`" for path in paths)
    if not found.cases:
        fail(f"no tests found in {where}")
    names = {case.test.name for case in found.cases}
    for name in only:
        if name not in names:
            fail(f"no test `{name}` in {where}", did_you_mean(name, names))
    return tuple([one for one in found.cases if not only or one.test.name in only])


def _refuse_with_jobs(
    paths: Sequence[str], gathered: Coverage | None, only: Sequence[str]
) -> None:
    """Refuse the options that require one process."""
    if only:
        raise click.UsageError("cannot combine --jobs and --only")
    if gathered is not None:
        raise click.UsageError("cannot combine --jobs and --coverage")
    if "-" in paths:
        raise click.UsageError("cannot combine --jobs and standard input")


def _in_processes(
    running: TestSession, paths: Sequence[str], cases: Sequence[Case], jobs: int
) -> list[Outcome]:
    """Run the tests in several processes; show their progress on a terminal."""
    from rapc.console.experiments import output
    from rapc.experiments.batch import WorkersLost
    from rapc.testing.parallel import run_parallel

    given = settings()
    shown = sys.stderr.isatty() and not given.quiet
    color, outcomes = given.colored(), []
    try:
        with output.bar(
            "tests", len(cases), sys.stderr, shown=shown, color=color
        ) as advance:
            for outcome in run_parallel(running, paths, cases, jobs):
                outcomes.append(outcome)
                advance(1)
    except WorkersLost as error:
        fail(f"{error.message}: {len(outcomes)} of {len(cases)} ran")
    return outcomes


def _tell(ended: Iterable[Outcome]) -> list[Outcome]:
    """Print a line for each outcome, below the name of its file."""
    outcomes = []
    file = None
    for outcome in ended:
        outcomes.append(outcome)
        status = outcome.status.value
        if settings().quiet and status == "passed":
            continue
        if file != outcome.case.test.span.file:
            file = outcome.case.test.span.file
            _say("title", file)
        _say(status, f"  {status:<6}  {explain.test_title(outcome)}")
        if outcome.mended:
            _say("text", "          failures mended by a retry:")
        for line in outcome.mended:
            _say("text", f"            {line}")
    return outcomes


def _explain(outcomes: Sequence[Outcome]) -> None:
    for outcome in outcomes:
        if outcome.failures:
            click.echo()
            shown = " ".join(outcome.case.test.doc.split())
            doc = f": {shown}" if shown else ""
            _say(outcome.status.value, f"{explain.test_title(outcome)}{doc}")
            for line in explain.failure_lines(outcome):
                _say(line.kind, line.text)
    if not settings().quiet or any(outcome.failures for outcome in outcomes):
        click.echo()


def _say(kind: str, text: str) -> None:
    """Print a line in the style of its kind, wrapped or cut for a terminal."""
    lines = [visible(text)]
    if sys.stdout.isatty():
        width = max(shutil.get_terminal_size().columns, _LEAST_WIDTH)
        if kind == "text":
            lines = wrapped(lines[0], width, indent="    ")
        elif len(lines[0]) > width:
            lines = [lines[0][: width - 1] + "…"]
    for line in lines:
        print_line(kind, line)
