"""`rapc experiment`: a batch of seeded runs, its tables and plots."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import click

from rapc.base.interrupts import INTERRUPTED
from rapc.base.names import plural
from rapc.base.outputs import (
    COVERAGE,
    PAGE,
    PNG,
    RESULTS_PAGE,
    RUN_COMMANDS,
    SVG,
    TABLES,
    check_output,
)
from rapc.base.visible import visible
from rapc.cli.common import (
    load_checked,
    print_line,
    refuse_output,
    width_of,
    write_output,
)
from rapc.cli.options import TypedPath, WholeNumber, command, fail, say, settings
from rapc.cli.run_options import processes_option
from rapc.cli.test import print_coverage
from rapc.console.experiments import output
from rapc.console.experiments.tables import show
from rapc.debug import costs
from rapc.errors import reason
from rapc.experiments import definition
from rapc.experiments.batch import BatchResult, Workers, WorkersLost, jobs, run_batch
from rapc.experiments.local import LocalWorkers, cores
from rapc.experiments.points import Point
from rapc.experiments.run import Job, Result, run_job
from rapc.experiments.session import Batch
from rapc.experiments.store import Store, StoreError, sole_user
from rapc.experiments.summary import PartSummary
from rapc.testing.covered import CoverageSum, run_covered

EXAMPLES = """\b
Examples:
  rapc experiment chapter6 --part one --seeds 10
  rapc experiment my-experiment.toml --jobs 4 --out results
  rapc experiment my-experiment.toml --against ../yesterday/my-library
  rapc experiment my-experiment.toml --view --pages 20
  rapc experiment my-experiment.toml --coverage
  rapc experiment my-experiment.toml --cluster tcp://10.0.0.5:8786
"""


INDEX = "index.html"
"""The file of the page of the results."""

_PAGES, _MOST_PAGES = 10, 10_000
"""The default and highest number of pages of runs."""

_MOST_FAULTS = 10
"""The highest number of printed runs without a result."""


@command(EXAMPLES)
@click.argument("name", metavar="NAME|FILE.toml", type=TypedPath())
@click.option(
    "--part",
    "parts",
    multiple=True,
    metavar="NAME",
    help="Run only this part (repeatable).",
)
@click.option(
    "--seeds",
    type=WholeNumber(definition.MOST_SEEDS),
    metavar="N",
    help="Runs for each point, from seed 0 [default: from the file].",
)
@processes_option
@click.option(
    "--out",
    type=TypedPath(file_okay=False),
    metavar="DIR",
    help="Folder for the results [default: NAME-results].",
)
@click.option(
    "--against",
    type=TypedPath(),
    metavar="LIBRARY",
    help="Also run LIBRARY, and print what has changed since.",
)
@click.option(
    "--coverage",
    is_flag=False,
    flag_value="",
    metavar="[FILE.json]",
    help="Report the coverage of all runs; with FILE.json, also as JSON.",
)
@click.option(
    "--cluster",
    metavar="ADDRESS",
    help="Run on the workers of the Dask scheduler at ADDRESS.",
)
@click.option(
    "--view", "viewed", is_flag=True, help="Write a page of the results: index.html."
)
@click.option(
    "--pages",
    type=click.IntRange(0, _MOST_PAGES),
    metavar="N",
    help=f"Pages of runs to write (with --view) [default: {_PAGES}].",
)
def experiment(
    name: str,
    parts: Sequence[str],
    seeds: int | None,
    processes: int | None,
    out: str | None,
    against: str | None,
    coverage: str | None,
    cluster: str | None,
    viewed: bool,
    pages: int | None,
) -> None:
    """Run the experiment NAME of rapc, or the experiment in FILE.toml.

    Each result is saved when its run ends. If the experiment was interrupted, the same
    command runs only the missing runs.

    With --against, each seed is also run with LIBRARY. The table of changes has the
    figures whose average differs, with the 95 % confidence interval of the difference.

    With --view, DIR/index.html shows all runs in plots. The least usual run of each
    point in turn has a page in DIR/runs; for other runs, index.html has the command
    that writes the page.

    Exit status: 0 if every run has a result, 1 if a run has none, 2 if no run could
    start.
    """
    if cluster is not None and processes is not None:
        raise click.UsageError("cannot combine --jobs and --cluster")
    if coverage is not None:
        _refuse_with_coverage(coverage, against, cluster)
    gathered = None if coverage is None else CoverageSum()
    if pages is not None and not viewed:
        raise click.UsageError("--pages requires --view")
    session = _session(name, parts, seeds, against)
    folder = _folder(out or f"{session.made.name}-results")
    _check_outputs(session, folder)
    with sole_user(folder), Store(folder / output.RESULTS) as store:
        faults = _run_missing(session, store, cluster, processes, gathered)
        summaries = list(session.summaries(store))
        compared = list(session.pairs(store))
        if viewed:
            made = _PAGES if pages is None else pages
            _view(session, store, summaries, folder, made)
    for summary in summaries:
        if summary.part.name in session.chosen:
            _print(summary)
    for before, after, pairs in compared:
        _print_changes(before, after, [*pairs.values()])
    if gathered is not None:
        print_coverage(gathered.files(), coverage)
    _write(session, summaries, folder)
    if not settings().quiet:
        click.echo(f"results, tables and plots: `{visible(str(folder))}`")
    _tell_faults(faults)
    raise SystemExit(1 if faults else 0)


def _refuse_with_coverage(
    coverage: str, against: str | None, cluster: str | None
) -> None:
    """Refuse what cannot be combined with `--coverage`, and files of other kinds."""
    for option, given in (("--against", against), ("--cluster", cluster)):
        if given is not None:
            raise click.UsageError(f"cannot combine --coverage and {option}")
    if coverage:
        if not coverage.endswith(".json"):
            raise click.UsageError("--coverage: the file name must end with .json")
        refuse_output("--coverage", coverage, COVERAGE)


def _session(
    name: str, parts: Sequence[str], seeds: int | None, against: str | None
) -> Batch:
    file = definition.experiment_file(name)
    made = definition.read_experiment(file)
    return Batch(made, file.parent, load_checked, parts, seeds, against)


def _folder(name: str) -> Path:
    try:
        Path(name).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        fail(f"cannot create `{name}`: {reason(error)}")
    return Path(name)


def _check_outputs(session: Batch, folder: Path) -> None:
    """Check that tables, plots and commands overwrite no other file.

    Raises:
        WriteError: as `rapc.base.outputs.check_output`.
    """
    for name in (output.TABLES, output.TASKS):
        check_output(folder / name, TABLES)
    check_output(folder / output.COMMANDS, RUN_COMMANDS)
    for part in session.made.part:
        if part.vary is not None:
            check_output((folder / part.name).with_suffix(".svg"), SVG)
            check_output((folder / part.name).with_suffix(".png"), PNG)


def _run_missing(
    session: Batch,
    store: Store,
    cluster: str | None,
    processes: int | None,
    gathered: CoverageSum | None,
) -> list[str]:
    """Run the missing runs; return the errors of runs without a result.

    For the coverage, all runs are done.

    Results stay in the store after an interrupt or after the loss of the workers.
    """
    missing = session.missing(store if gathered is None else None)
    total = sum(len(seeds) for _, seeds in missing)
    if not total:
        say("0 runs are missing")
        return []
    faults: list[str] = []
    came = 0
    work = run_job if gathered is None else run_covered
    try:
        say(f"{total} runs are missing")
        with (
            _workers(session, total, cluster, processes, work) as workers,
            _bar(session, total) as advance,
        ):
            for done in run_batch(workers, jobs(missing, workers.chunk)):
                store.add(done.config, done.results)
                if gathered is not None:
                    gathered.add(done.results)
                came += sum(result.measures is not None for result in done.results)
                advance(len(done.results))
                faults += _tell(session, done)
    except (KeyboardInterrupt, WorkersLost, StoreError) as error:
        why = str(error) or "interrupted"
        told = f"{came} of {total} runs finished; run the command again for the rest"
        click.echo(f"error: {why}: {told}", err=True)
        interrupted = isinstance(error, KeyboardInterrupt)
        raise SystemExit(INTERRUPTED if interrupted else 1) from None
    return faults


def _bar(session: Batch, total: int) -> AbstractContextManager[Callable[[int], object]]:
    """Return a bar that shows the number of finished runs, if it is visible."""
    given = settings()
    shown = sys.stderr.isatty() and not given.quiet and not given.verbose
    color = given.colored()
    return output.bar(session.made.name, total, sys.stderr, shown=shown, color=color)


@contextmanager
def _workers(
    session: Batch,
    total: int,
    cluster: str | None,
    processes: int | None,
    work: Callable[[Job], tuple[Result, ...]],
) -> Iterator[Workers]:
    """Yield the processes of this machine, or the workers of a cluster."""
    found: AbstractContextManager[Workers]
    if cluster is None:
        count = min(processes or cores(), total)
        found = LocalWorkers(count, work, session.made.time_limit)
    else:
        try:
            from rapc.experiments.cluster import ClusterWorkers
        except ModuleNotFoundError as error:
            _raise_unless_missing(error, "distributed")
            fail("--cluster requires Dask: install `rapc[cluster]`")
        try:
            found = ClusterWorkers(cluster, total)
            if not found.threads:
                click.echo(f"`{cluster}` has no workers; waiting", err=True)
        except WorkersLost as error:
            fail(str(error))
    with found as workers:
        yield workers


def _raise_unless_missing(error: ModuleNotFoundError, package: str) -> None:
    """Raise `error` again unless `package` is the missing package."""
    if (error.name or "").partition(".")[0] != package:
        raise error


def _tell(session: Batch, done: BatchResult) -> list[str]:
    """Print the finished runs if `-v` is set; return the errors as text."""
    point = session.point_of(done.config)
    where = f"part `{point.part}`"
    if point.value is not None:
        where += f", {session.made.part_named(point.part).vary} {show(point.value)}"
    faults = []
    for result in done.results:
        if result.measures is not None:
            say(f"{where}, seed {result.seed}: done in {result.seconds:.2f} s")
            continue
        for line in result.trace.splitlines():
            say(line)
        repeat = session.command(point, result.seed)
        fault = visible(f"{where}, seed {result.seed}: {result.fault}")
        faults.append(f"{fault}\n  to repeat the run: {repeat}")
    return faults


def _tell_faults(faults: Sequence[str]) -> None:
    for fault in faults[:_MOST_FAULTS]:
        click.echo(f"error: run without a result: {fault}", err=True)
    more = len(faults) - _MOST_FAULTS
    if more > 0:
        click.echo(f"error: {more} more runs without a result", err=True)


def _write(session: Batch, summaries: Sequence[PartSummary], folder: Path) -> None:
    """Write tables, plots and commands beside the results."""
    try:
        drawn = _draw(summaries, folder)
        heading = session.made.title or session.made.name
        output.write_tables(heading, summaries, drawn, folder / output.TABLES)
        output.write_tasks(heading, summaries, folder / output.TASKS)
        output.write_commands(session, folder / output.COMMANDS)
    except OSError as error:
        fail(f"cannot write in `{folder}`: {reason(error)}")


def _view(
    session: Batch,
    store: Store,
    summaries: Sequence[PartSummary],
    folder: Path,
    most: int,
) -> None:
    """Write the page of the results, and pages of the least usual runs."""
    from rapc.cli.view import page_of_run
    from rapc.view.experiment import FOLDER, chosen_runs, results_page

    check_output(folder / INDEX, RESULTS_PAGE)
    chosen = chosen_runs(session, store, most)
    pages = {}
    for one in chosen:
        file = _folder(str(folder / FOLDER)) / one.file
        check_output(file, PAGE)
        say(f"writing {file}")
        write_output(str(file), page_of_run(session, one.point, one.seed).encode())
        pages[one.point.digest, one.seed] = f"{FOLDER}/{one.file}"
    text = results_page(session, store, summaries, pages)
    write_output(str(folder / INDEX), text.encode())
    click.echo(f"wrote {visible(str(folder / INDEX))} and {plural(len(pages), 'page')}")


def _draw(summaries: Sequence[PartSummary], folder: Path) -> list[str]:
    """Draw the parts with a varied setting; return their names."""
    try:
        from rapc.console.experiments.plots import draw_plot
    except ModuleNotFoundError as error:
        _raise_unless_missing(error, "matplotlib")
        click.echo("plots not drawn: install `rapc[viz]`", err=True)
        return []
    named = {summary.part.name: summary for summary in summaries}
    drawn = []
    for name, summary in named.items():
        if summary.part.vary is not None:
            others = [named[other] for other in summary.part.beside if other in named]
            draw_plot([summary, *others], folder / name)
            drawn.append(name)
    return drawn


def _print_changes(before: Point, after: Point, pairs: Sequence[costs.Pair]) -> None:
    """Print what has changed between the libraries of two points."""
    from rapc.repl.draw import draw

    said = f"part `{after.part}`"
    if after.value is not None:
        said += f", {show(after.value)}"
    print_line("title", f"{said}: {before.library} and {after.library}")
    if pairs:
        answer = costs.table_of(pairs, ("before", "after"))
        width, color = width_of(sys.stdout), settings().colored()
        click.echo(draw(answer, width, color=color))


def _print(summary: PartSummary) -> None:
    for line in output.part_as_text(summary, width_of(sys.stdout)):
        print_line(line.kind, line.text)
    click.echo()
