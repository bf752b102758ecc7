"""`rapc check PATH...`: read, link and check RAP libraries."""

from __future__ import annotations

from collections.abc import Sequence

import click

from rapc.analysis import driver
from rapc.analysis.driver import CheckReport
from rapc.base.diagnostics import Severity
from rapc.base.names import plural
from rapc.cli.common import (
    common_options,
    fail,
    print_findings,
    read_paths,
    say,
    settings,
)

EXAMPLES = """\b
Examples:
  rapc check my-library/
  rapc check --output-format concise deliver.rap carry.rap
  rapc check --ignore misspelt-variable,RAP017 my-library/
  rapc check --fail-level error - < deliver.rap
"""


@click.command(
    epilog=EXAMPLES, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.argument("paths", metavar="PATH...", nargs=-1, required=True)
@click.option("--select", multiple=True, metavar="RULES", help="Only these rules.")
@click.option(
    "--extend-select", multiple=True, metavar="RULES", help="These rules besides."
)
@click.option("--ignore", multiple=True, metavar="RULES", help="Not these rules.")
@click.option(
    "--output-format",
    type=click.Choice(["full", "concise", "json"]),
    default="full",
    show_default=True,
    help="How findings are printed.",
)
@click.option(
    "--fail-level",
    type=click.Choice(["error", "warning", "info"]),
    default="warning",
    show_default=True,
    help="The least grave finding that makes the exit status 1.",
)
@click.option("--exit-zero", is_flag=True, help="Exit with 0 whatever is found.")
@common_options
def check(
    paths: Sequence[str],
    select: Sequence[str],
    extend_select: Sequence[str],
    ignore: Sequence[str],
    output_format: str,
    fail_level: str,
    exit_zero: bool,
) -> None:
    """Check RAP libraries: files, folders with RAP files, or - for standard input.

    All paths together are one library, with the files that they require. RULES are
    names or codes of rules, separated by commas (see `rapc rule`).

    Exit status: 0 if nothing was found, 1 for a finding at or above the fail level, 2
    for bad usage and for what cannot be read.
    """
    try:
        enabled = driver.enabled_rules(
            _words(select) if select else None, _words(extend_select), _words(ignore)
        )
    except driver.UnknownRuleError as error:
        fail(f"{error}{f'; {error.help}' if error.help else ''}")
    report = driver.check_library(read_paths(paths), enabled)
    say(f"ran {len(driver.passes())} passes")
    print_findings(report, output_format)
    if output_format != "json" and not settings().quiet:
        click.echo(_summary(report))
    worst = report.worst()
    if worst is not None and worst >= Severity[fail_level.upper()] and not exit_zero:
        raise SystemExit(1)


def _words(given: Sequence[str]) -> list[str]:
    words = [word.strip() for one in given for word in one.split(",")]
    return [word for word in words if word]


def _summary(report: CheckReport) -> str:
    checked = f"checked {plural(len(report.files), 'file')}, "
    checked += plural(report.raps, "RAP")
    if not report.findings:
        return f"{checked}: no findings"
    counts: dict[str, int] = {}
    for finding in sorted(report.findings, key=lambda f: -f.severity):
        word = finding.severity.word
        counts[word] = counts.get(word, 0) + 1
    found = [f"{n} info" if w == "info" else plural(n, w) for w, n in counts.items()]
    return f"{checked}: {', '.join(found)}"
