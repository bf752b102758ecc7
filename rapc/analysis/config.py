"""The configuration of a project: `rapc.toml`, or `[tool.rapc]` in pyproject.toml.

The nearest configuration counts: first the named folder, then its parent folders. In
one folder `rapc.toml` comes before pyproject.toml. Configurations are not merged.
`rapc.analysis.config_file` reads the files; a project without a configuration does not
import that module.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal

import msgspec

from rapc.analysis.selection import (
    PerFile,
    Selection,
    by_default,
    chosen_rules,
    rule_names,
)
from rapc.base.diagnostics import Severity

OWN = "rapc.toml"
SHARED = "pyproject.toml"

Level = Literal["error", "warning", "info"]


class Config(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    rename="kebab",
    kw_only=True,
):
    """The configuration of checks and tests; a rule is given by name or code."""

    #: The rules that report; None for all rules that are not opt-in.
    select: tuple[str, ...] | None = None
    #: Rules that report in addition.
    extend_select: tuple[str, ...] = ()
    #: Rules that do not report.
    ignore: tuple[str, ...] = ()
    #: By pattern of file names, the rules that do not report in matching files.
    per_file_ignores: Mapping[str, tuple[str, ...]] = {}
    #: Severities that differ from the default of the rule.
    severity: Mapping[str, Level] = {}
    #: The lowest severity that sets exit status 1.
    fail_level: Level | None = None
    #: The output format of findings.
    output_format: str | None = None
    #: The baseline file, relative to the configuration.
    baseline: str | None = None
    #: A key without effect, accepted in configurations of earlier versions.
    cache_dir: str | None = None
    #: The files and folders that are one library each, relative to the configuration;
    #: None to find the libraries by `require`.
    libraries: tuple[str, ...] | None = None
    #: Modules with worlds that tests may name; `rapc check` imports no module.
    world_modules: tuple[str, ...] = ()


class Configured(msgspec.Struct, frozen=True):
    """A configuration and its file."""

    config: Config = Config()
    #: None without a configuration.
    file: Path | None = None

    def beside(self, name: str | None) -> Path | None:
        """Return the path of a named file, relative to the configuration."""
        if name is None or self.file is None:
            return None
        return self.file.parent / name

    def selection(self) -> Selection:
        """Return the rules that report.

        Raises:
            UnknownRuleError: if a word is not a rule.
        """
        said = self.config
        enabled = by_default() if said.select is None else chosen_rules(said.select)
        enabled |= chosen_rules(said.extend_select)
        enabled -= chosen_rules(said.ignore)
        return Selection(enabled, self.per_file(), self.severities())

    def per_file(self) -> tuple[PerFile, ...]:
        """Return the value of `per-file-ignores`.

        Raises:
            UnknownRuleError: if a word is not a rule.
        """
        root = "" if self.file is None else str(self.file.parent)
        said = self.config.per_file_ignores
        return tuple(PerFile(p, chosen_rules(rules), root) for p, rules in said.items())

    def severities(self) -> Mapping[str, Severity]:
        """Return the value of `severity`, by the names of rules.

        Raises:
            UnknownRuleError: if a word is not a rule.
        """
        found = {}
        for word, level in self.config.severity.items():
            (name,) = rule_names([word])
            found[name] = Severity[level.upper()]
        return found


def files(place: Path) -> Iterator[Path]:
    """Yield the files that may configure commands for a path, nearest first.

    A pyproject.toml in the result may have no configuration.
    """
    here = place.absolute()
    for folder in (here, *here.parents):
        for name in (OWN, SHARED):
            file = folder / name
            if os.path.isfile(file):
                yield file
