"""The configuration of `rapc check`: `rapc.toml`, or `[tool.rapc]` in pyproject.toml.

The nearest one counts: that of the folder checked, else of the one above it, and so on.
In one folder `rapc.toml` comes first. Nothing is merged.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import msgspec

from rapc.analysis.selection import PerFile, rule_names
from rapc.base import toml
from rapc.base.diagnostics import Severity
from rapc.base.files import read_text
from rapc.base.names import nearest
from rapc.errors import Error

OWN = "rapc.toml"
SHARED = "pyproject.toml"

Level = Literal["error", "warning", "info"]


class ConfigError(Error):
    """A configuration that cannot be used; the message names its file."""


class Config(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    rename="kebab",
    kw_only=True,
):
    """What a project says about checking it; rules are given by name or code."""

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


class Configured(msgspec.Struct, frozen=True):
    """A configuration and the file that it stands in."""

    config: Config = Config()
    #: None if there is none.
    file: Path | None = None

    def per_file(self) -> tuple[PerFile, ...]:
        """Return what its `per-file-ignores` say.

        Raises:
            UnknownRuleError: for a word that is no rule.
        """
        root = "" if self.file is None else str(self.file.parent)
        said = self.config.per_file_ignores
        return tuple(PerFile(p, rule_names(rules), root) for p, rules in said.items())

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


def find(place: Path) -> Configured:
    """Return the nearest configuration of a file or folder, or an empty one.

    Raises:
        ConfigError: for one that cannot be used.
        LoadError: for one that cannot be read.
    """
    here = place.absolute()
    for folder in (here, *here.parents):
        for name in (OWN, SHARED):
            file = folder / name
            if os.path.isfile(file):
                found = read(file)
                if found is not None:
                    return found
    return Configured()


def read(file: Path) -> Configured | None:
    """Return the configuration in a file; None for a pyproject.toml without one.

    Raises:
        ConfigError: for one that cannot be used.
        LoadError: for a file that cannot be read.
    """
    text = read_text(file)
    try:
        table: Any = toml.parsed(text)
        if file.name == SHARED:
            if "rapc" not in table.get("tool", {}):
                return None
            table = table["tool"]["rapc"]
        if not isinstance(table, dict):
            raise ConfigError(f"`{file}`: `tool.rapc` is no table")
        known = [field.encode_name for field in msgspec.structs.fields(Config)]
        for key in table:
            if key not in known:
                near = nearest(key, known)
                help = (
                    f"did you mean `{near}`?" if near else f"known: {', '.join(known)}"
                )
                raise ConfigError(f"`{file}`: there is no key `{key}`", help)
        return Configured(toml.converted(table, Config), file)
    except toml.TomlError as error:
        raise ConfigError(f"`{file}`: {error.message}") from error
