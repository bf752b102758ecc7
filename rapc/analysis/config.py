"""The configuration of a project: `rapc.toml`, or `[tool.rapc]` in pyproject.toml.

The nearest one counts: that of the folder named, else of the one above it, and so on.
In one folder `rapc.toml` comes first. Nothing is merged. Files are read by
`rapc.analysis.config_file`, which those who have none do without.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal

import msgspec

from rapc.analysis.selection import PerFile, chosen_rules, rule_names
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
    """What a project says about checks and tests; rules are given by name or code."""

    #: The rules that report; all that are not opt-in if None.
    select: tuple[str, ...] | None = None
    #: Rules that report besides.
    extend_select: tuple[str, ...] = ()
    #: Rules that do not report.
    ignore: tuple[str, ...] = ()
    #: Rules that do not report in some files, by patterns of names of files.
    per_file_ignores: Mapping[str, tuple[str, ...]] = {}
    #: Severities that differ from those of the rules.
    severity: Mapping[str, Level] = {}
    #: The least grave finding that makes the exit status 1.
    fail_level: Level | None = None
    #: How findings are printed.
    output_format: str | None = None
    #: The file of findings that are known, as seen from the configuration.
    baseline: str | None = None
    #: A key without effect, accepted in configurations of earlier versions.
    cache_dir: str | None = None
    #: The modules of which tests may name worlds; `rapc check` imports none.
    world_modules: tuple[str, ...] = ()


class Configured(msgspec.Struct, frozen=True):
    """A configuration and the file that it stands in."""

    config: Config = Config()
    #: None if there is none.
    file: Path | None = None

    def beside(self, name: str | None) -> Path | None:
        """Return the path of what it names, as seen from it."""
        if name is None or self.file is None:
            return None
        return self.file.parent / name

    def per_file(self) -> tuple[PerFile, ...]:
        """Return what its `per-file-ignores` say.

        Raises:
            UnknownRuleError: for a word that is no rule.
        """
        root = "" if self.file is None else str(self.file.parent)
        said = self.config.per_file_ignores
        return tuple(PerFile(p, chosen_rules(rules), root) for p, rules in said.items())

    def severities(self) -> Mapping[str, Severity]:
        """Return what its `severity` says, by the names of rules.

        Raises:
            UnknownRuleError: for a word that is no rule.
        """
        found = {}
        for word, level in self.config.severity.items():
            (name,) = rule_names([word])
            found[name] = Severity[level.upper()]
        return found


def files(place: Path) -> Iterator[Path]:
    """Yield the files that may configure commands for a path, nearest first.

    A pyproject.toml need not have a configuration in it.
    """
    here = place.absolute()
    for folder in (here, *here.parents):
        for name in (OWN, SHARED):
            file = folder / name
            if os.path.isfile(file):
                yield file
