"""Options of `rapc check`, combined with the configuration of a project."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import click
import msgspec

from rapc.analysis import config
from rapc.analysis.config import Configured
from rapc.analysis.selection import PerFile, Selection, chosen_rules
from rapc.base.diagnostics import Severity
from rapc.cli.common import FORMATS
from rapc.cli.options import Opt, TypedPath, fail, say

_RULES: Mapping[str, Any] = {"metavar": "RULES"}
_FILE: Mapping[str, Any] = {"metavar": "FILE", "type": TypedPath(dir_okay=False)}
_LEVELS = click.Choice(["error", "warning", "info"])
_Words = tuple[str, ...]


class Options(msgspec.Struct, frozen=True, kw_only=True):
    """The options of `rapc check`, as the user wrote them; click uses this table.

    A field with a description is the option `--NAME`.
    """

    paths: tuple[str, ...]
    select: Annotated[
        _Words, Opt(help="Report only these rules; `ALL` selects every rule.", **_RULES)
    ]
    extend_select: Annotated[_Words, Opt(help="Also report these rules.", **_RULES)]
    ignore: Annotated[_Words, Opt(help="Do not report these rules.", **_RULES)]
    per_file_ignores: Annotated[
        _Words,
        Opt(help="Ignore rules in files that match PATTERN.", metavar="PATTERN:RULES"),
    ]
    fix: Annotated[bool, Opt(help="Apply safe fixes.")]
    unsafe_fixes: Annotated[
        bool, Opt(help="Also apply unsafe fixes (with --fix or --diff).")
    ]
    diff: Annotated[bool, Opt(help="Show the changes of --fix without applying them.")]
    statistics: Annotated[bool, Opt(help="Count the findings of each rule.")]
    output_format: Annotated[
        str | None,
        Opt(help="Format of the findings [default: full].", type=click.Choice(FORMATS)),
    ]
    output_file: Annotated[str | None, Opt(help="Write the findings to FILE.", **_FILE)]
    write_baseline: Annotated[
        str | None, Opt(help="Write all findings to a baseline FILE.", **_FILE)
    ]
    baseline: Annotated[
        str | None, Opt(help="Hide the findings listed in this baseline.", **_FILE)
    ]
    fail_level: Annotated[
        str | None,
        Opt(
            help="Lowest severity that sets exit status 1 [default: warning].",
            type=_LEVELS,
        ),
    ]
    exit_zero: Annotated[
        bool, Opt(help="Exit with status 0 even if there are findings.")
    ]
    stdin_filename: Annotated[
        str | None, Opt(help="File name to report for standard input.", metavar="NAME")
    ]
    no_cache: Annotated[bool, Opt(help="Ignored; accepted for older scripts.")]
    watch: Annotated[bool, Opt(help="Check again after each change of a file.")]
    config: Annotated[
        str | None, Opt(help="Read the configuration from FILE.", **_FILE)
    ]
    isolated: Annotated[bool, Opt(help="Ignore all configuration files.")]
    #: Texts that replace files: standard input, by its name.
    texts: Mapping[str, str] = {}


class Chosen(msgspec.Struct, frozen=True):
    """The selected rules and the format of the report."""

    #: The selected rules.
    selection: Selection
    #: The format of findings, one of `FORMATS`.
    format: str
    #: The lowest severity that sets exit status 1.
    fail_level: Severity
    #: The baseline file, if any.
    baseline: Path | None
    #: The configuration; its file is None if there is none.
    configured: Configured


def settle(options: Options) -> Chosen:
    """Combine options and configuration; an option overrides the configuration.

    `--select` replaces the rules of the configuration; other options about rules add
    rules to the configuration.

    Raises:
        ConfigError: for an invalid configuration.
        LoadError: for a configuration that cannot be read.
        UnknownRuleError: for a word that is not the name or code of a rule.
    """
    found = _configured(options)
    if found.file is not None:
        say(f"configured by {found.file}")
    said = found.config
    configured = found.selection()
    enabled = configured.enabled
    if options.select:
        enabled = chosen_rules(split_at_commas(options.select))
    enabled |= chosen_rules(split_at_commas(options.extend_select))
    enabled -= chosen_rules(split_at_commas(options.ignore))
    per_file = [_per_file(text) for text in options.per_file_ignores]
    baseline = None if options.baseline is None else Path(options.baseline)
    if baseline is None:
        baseline = found.beside(said.baseline)
    shape = options.output_format or said.output_format or "full"
    if shape not in FORMATS:
        fail(f"`{found.file}`: unknown output format `{shape}`")
    level = options.fail_level or said.fail_level or "warning"
    return Chosen(
        Selection(enabled, (*configured.per_file, *per_file), configured.severities),
        shape,
        Severity[level.upper()],
        baseline,
        found,
    )


def _configured(options: Options) -> Configured:
    """Return the configuration for the options; an empty one if there is none."""
    if options.isolated:
        return Configured()
    if options.config is None:
        return nearest_config(options.paths[0] if options.paths else os.curdir)
    from rapc.analysis.config_file import read_config

    found = read_config(Path(options.config))
    return found or fail(f"`{options.config}` has no table `tool.rapc`")


def nearest_config(path: str) -> Configured:
    """Return the nearest configuration of a path; an empty one if there is none.

    Raises:
        ConfigError: for an invalid configuration.
        LoadError: for a configuration that cannot be read.
    """
    if next(config.files(Path(path)), None) is None:
        return Configured()
    from rapc.analysis import config_file

    return config_file.nearest_config(path)


def split_at_commas(given: Iterable[str]) -> Iterator[str]:
    """Yield the words of texts with comma-separated words."""
    for one in given:
        yield from filter(None, (word.strip() for word in one.split(",")))


def _per_file(text: str) -> PerFile:
    pattern, colon, rules = text.rpartition(":")
    if not colon or not pattern or not rules.strip():
        fail(f"--per-file-ignores: `{text}` is not PATTERN:RULES")
    return PerFile(pattern, chosen_rules(split_at_commas([rules])))
