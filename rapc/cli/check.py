"""`rapc check PATH...`: read, link and check RAP libraries.

This module combines the options. `rapc.analysis` selects the findings (selection,
config, baseline); `rapc.console` formats them (findings, formats).
"""

from __future__ import annotations

import os
from collections.abc import Container, Mapping
from pathlib import Path
from typing import Any

import click
import msgspec

from rapc.analysis import registry
from rapc.analysis.check_files import check_files
from rapc.analysis.driver import CheckReport
from rapc.analysis.selection import UnknownRuleError
from rapc.base.diagnostics import Applicability, Fix
from rapc.base.files import lies_in, path_of, read_standard_input
from rapc.base.names import plural
from rapc.base.outputs import BASELINE, FINDINGS
from rapc.base.visible import visible
from rapc.base.writing import remove_parts
from rapc.cli.check_options import Chosen, Options, settle
from rapc.cli.common import (
    FOR_PEOPLE,
    STATISTICS,
    diff,
    findings_text,
    print_findings,
    refuse_output,
    rewrite,
    write_output,
)
from rapc.cli.options import USAGE, TypedPath, command, fail, options_of, say, settings
from rapc.errors import in_a_line
from rapc.library.loader import STANDARD_INPUT, Units

EXAMPLES = """\b
Examples:
  rapc check my-library/
  rapc check --output-format concise deliver.rap carry.rap
  rapc check --ignore misspelt-variable,RAP017 my-library/
  rapc check --fix my-library/
  rapc check --output-format sarif --output-file rapc.sarif my-library/
  rapc check --fail-level error - < deliver.rap
"""


_OF_LIBRARY = "is a source file of the library"
_SETTLED = "configures the report"


@command(EXAMPLES)
@click.argument("paths", metavar="[PATH...]", type=TypedPath(), nargs=-1)
@options_of(Options)
def check(**given: Any) -> None:
    """Check RAP libraries: files, folders with RAP files, or - for standard input.

    All paths together are one library, with the files that they require. Without a
    path, the libraries of the working directory are checked. Each test file is
    checked by itself, with the files that the test file requires. RULES are
    names or codes of rules, separated by commas (see `rapc rule`). Options override
    the configuration, which is a `rapc.toml` or `[tool.rapc]` in a pyproject.toml.

    Exit status: 0 without findings, 1 for a finding at or above the fail level, 2 for
    invalid usage or a file that cannot be read or (with --fix) written.
    """
    options = msgspec.convert(given, Options)
    _contradict(options)
    if options.watch:
        from rapc.cli.watch import watch

        units = Units()
        watch(options.paths or (os.curdir,), lambda: _run(options, units).report.files)
        return
    try:
        done = _run(_with_input(options), Units())
    except UnknownRuleError as error:
        fail(in_a_line(error))
    if done.left:
        raise SystemExit(USAGE)
    if done.grave and not options.exit_zero:
        raise SystemExit(1)


def _contradict(options: Options) -> None:
    """End the command if options do not go together."""
    if options.unsafe_fixes and not (options.fix or options.diff):
        fail("--unsafe-fixes requires --fix or --diff")
    if options.isolated and options.config is not None:
        fail("cannot combine --config and --isolated")
    if options.stdin_filename is not None and "-" not in options.paths:
        fail("--stdin-filename requires the path `-`")
    if options.statistics and options.output_format not in {None, *STATISTICS}:
        fail(f"--statistics requires the output format {' or '.join(STATISTICS)}")
    if options.write_baseline is not None and (options.fix or options.diff):
        fail("cannot combine --write-baseline with --fix or --diff")
    if options.write_baseline is not None and options.output_file is not None:
        fail("cannot combine --write-baseline and --output-file")
    if options.watch and ("-" in options.paths or options.write_baseline is not None):
        fail("cannot combine --watch with the path `-` or --write-baseline")


def _with_input(options: Options) -> Options:
    """Read standard input if `-` is a path, and set its file name."""
    if "-" not in options.paths:
        return options
    name = options.stdin_filename or STANDARD_INPUT
    paths = tuple(name if path == "-" else path for path in options.paths)
    texts = {name: read_standard_input()}
    return msgspec.structs.replace(options, paths=paths, texts=texts)


class Done(msgspec.Struct, frozen=True):
    """The result of one check."""

    #: All findings, and the files that were read.
    report: CheckReport
    #: Whether to exit with status 1.
    grave: bool
    #: Whether a file could not be written, which sets exit status 2.
    left: bool = False


def _run(options: Options, units: Units) -> Done:
    """Check the paths, fix the files if requested, and report."""
    chosen = settle(options)
    if options.fix or options.diff:
        return _mend(options, chosen, units)
    report = _checked(options, chosen, units)
    if options.write_baseline is not None:
        return _note(report, options.write_baseline, chosen)
    return _tell(report, options, chosen)


def _checked(options: Options, chosen: Chosen, units: Units) -> CheckReport:
    report = _report(options, chosen, options.texts, units)
    for name in report.files:
        say(f"read {name}")
    say(f"ran {len(registry.checks())} checks")
    return report


def _report(
    options: Options, chosen: Chosen, texts: Mapping[str, str], units: Units
) -> CheckReport:
    """Check the paths, or without a path the libraries of the working directory."""
    if options.paths:
        return check_files(options.paths, chosen.selection, texts, parser=units)
    from rapc.analysis.libraries import check_workspace

    here, selection = os.curdir, chosen.selection
    report = check_workspace(here, chosen.configured, selection, texts, parser=units)
    if not report.files:
        fail("missing PATH: the working directory has no RAP files")
    return report


def _tell(
    report: CheckReport,
    options: Options,
    chosen: Chosen,
    *,
    fixed: str = "",
    refused: Container[Fix] = (),
    apart: bool = False,
) -> Done:
    """Print findings and the summary, on standard error if `apart`.

    Findings at or above the fail level set the exit status. The summary does not offer
    the fixes that were `refused`.
    """
    known = ""
    if chosen.baseline is not None:
        report, known = _without_known(report, chosen.baseline)
    if options.output_file is not None:
        settled = (chosen.configured.file, chosen.baseline)
        inputs = (report.files, _OF_LIBRARY), (settled, _SETTLED)
        refuse_output("--output-file", options.output_file, FINDINGS, *inputs)
        text = findings_text(report, chosen.format, options.statistics)
        write_output(options.output_file, text.encode())
    else:
        print_findings(report, chosen.format, options.statistics, err=apart)
    if chosen.format in FOR_PEOPLE and not settings().quiet:
        said = _summary(report) + fixed + known + _fixable(report, refused)
        click.echo(said, err=apart)
    worst = report.worst()
    return Done(report, worst is not None and worst >= chosen.fail_level)


def _without_known(report: CheckReport, file: Path) -> tuple[CheckReport, str]:
    """Return a report without the findings of a baseline, and a text about it."""
    from rapc.analysis import baseline

    compared = baseline.compare(report, file)
    name = visible(str(file))
    words = f"; {compared.known} hidden by {name}" if compared.known else ""
    if compared.gone:
        words += (
            f"; {compared.gone} findings of {name} are fixed: write the baseline again"
        )
    return compared.report, words


def _note(report: CheckReport, file: str, chosen: Chosen) -> Done:
    """Write a baseline; an existing baseline may be replaced."""
    from rapc.analysis import baseline

    inputs = (report.files, _OF_LIBRARY), ([chosen.configured.file], _SETTLED)
    refuse_output("--write-baseline", file, BASELINE, *inputs)
    write_output(file, baseline.baseline_text(report, file).encode())
    if not settings().quiet:
        count = plural(len(report.findings), "finding")
        click.echo(f"wrote {count} to {visible(file)}")
    return Done(report, grave=False)


# --- fixes ----------------------------------------------------------------------------


def _mend(options: Options, chosen: Chosen, units: Units) -> Done:
    """Apply fixes, or show the fixes; fixed standard input goes to the output."""
    from rapc.analysis import fixes

    before: dict[str, str] = {}

    def check(texts: Mapping[str, str]) -> CheckReport:
        texts = {**options.texts, **texts}
        report = _report(options, chosen, texts, units)
        for name, source in report.files.items():
            before.setdefault(name, source.text)
        return report

    def allowed(name: str) -> bool:
        return any(lies_in(name, path) for path in options.paths or (os.curdir,))

    mended = fixes.mend(check, allowed, unsafe=options.unsafe_fixes)
    changed = {n: t for n, t in mended.texts.items() if t != before[n]}
    count = _fixes(mended.fixed)
    if options.diff:
        for name, text in changed.items():
            click.echo(diff(name, before[name], text), nl=False)
        if not settings().quiet:
            click.echo(f"{count} would be applied", err=True)
        return Done(mended.report, bool(changed))
    given = {name: mended.texts.get(name, text) for name, text in options.texts.items()}
    files = [name for name in before if name not in given and allowed(name)]
    remove_parts(map(path_of, files))
    left = [
        name
        for name in files
        if name in changed and not rewrite(name, before[name], changed[name])
    ]
    for text in given.values():
        click.echo(text, nl=False)
    fixed = f", {count} applied" if mended.fixed and not left else ""
    if mended.refused:
        fixed += f", {_fixes(len(mended.refused))} rejected"
    report = check(given) if left else mended.report
    refused, apart = mended.refused, bool(given)
    done = _tell(report, options, chosen, fixed=fixed, refused=refused, apart=apart)
    return msgspec.structs.replace(done, left=bool(left))


def _fixes(number: int) -> str:
    return "1 fix" if number == 1 else f"{number} fixes"


# --- the summary ------------------------------------------------------------------


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


def _fixable(report: CheckReport, refused: Container[Fix]) -> str:
    """Return a text about the findings that --fix can fix, or no text."""
    fixes = [finding.diagnostic.fix for finding in report.findings]
    offered = [fix for fix in fixes if fix is not None and fix.edits]
    kinds = [fix.applicability for fix in offered if fix not in refused]
    safe, unsafe = (kinds.count(k) for k in (Applicability.SAFE, Applicability.UNSAFE))
    if safe:
        more = f", {unsafe} more with --unsafe-fixes" if unsafe else ""
        return f"; {safe} fixable with --fix{more}"
    return f"; {unsafe} fixable with --fix --unsafe-fixes" if unsafe else ""
