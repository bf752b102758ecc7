"""Reading a configuration file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from rapc.analysis.config import SHARED, Config, Configured, files
from rapc.base import toml
from rapc.base.files import read_text
from rapc.base.names import nearest
from rapc.errors import Error


class ConfigError(Error):
    """A configuration that cannot be used; the message names the file."""


def nearest_config(path: str) -> Configured:
    """Return the nearest configuration of a path; an empty one if there is none.

    Raises:
        ConfigError: for an invalid configuration.
        LoadError: for a configuration that cannot be read.
    """
    found = (read_config(file) for file in files(Path(path)))
    return next((one for one in found if one is not None), Configured())


def read_config(file: Path) -> Configured | None:
    """Return the configuration in a file; None for a pyproject.toml without one.

    Raises:
        ConfigError: if the configuration cannot be used.
        LoadError: if the file cannot be read.
    """
    text = read_text(file)
    try:
        table: Any = toml.parsed(text)
        if file.name == SHARED:
            if "rapc" not in table.get("tool", {}):
                return None
            table = table["tool"]["rapc"]
        if not isinstance(table, dict):
            raise ConfigError(f"`{file}`: expected a table as `tool.rapc`")
        known = [field.encode_name for field in msgspec.structs.fields(Config)]
        for key in table:
            if key not in known:
                near = nearest(key, known)
                help = (
                    f"did you mean `{near}`?" if near else f"known: {', '.join(known)}"
                )
                raise ConfigError(f"`{file}`: unknown key `{key}`", help)
        return Configured(toml.converted(table, Config), file)
    except toml.TomlError as error:
        raise ConfigError(f"`{file}`: {error.message}") from error
