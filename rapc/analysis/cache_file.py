"""Where the cache of a check is, and whether it is worth having one.

Apart from `rapc.analysis.cache`, which small libraries have no use for.
"""

from __future__ import annotations

import os
from binascii import crc32
from collections.abc import Sequence
from pathlib import Path

from rapc.analysis.selection import Selection
from rapc.base.files import files_at, path_named
from rapc.errors import LoadError

SUFFIX = ".checked"
"""How the names of caches end."""

SMALLEST = 50_000
"""Files of fewer bytes in all are checked sooner than looked up."""


def file_for(
    folder: Path | None, paths: Sequence[str], selection: Selection
) -> Path | None:
    """Return the file for checks of some paths, if there is one or one is worth it.

    Args:
        folder: the folder of caches; the one of the user if None.
        paths: the paths that are checked.
        selection: the rules that report.
    """
    rules = (sorted(selection.enabled), selection.per_file, selection.severities)
    told = repr((os.getcwd(), paths, rules)).encode("utf-8", "backslashreplace")
    file = (folder or _of_user()) / f"{crc32(told):08x}{SUFFIX}"
    return file if os.path.isfile(file) or _is_large(paths) else None


def _of_user() -> Path:
    """Return the folder in which a user has caches of rapc."""
    own = os.environ.get("RAPC_CACHE_DIR")
    if own:
        return Path(own)
    said = os.environ.get("XDG_CACHE_HOME", "")
    home = Path(said) if os.path.isabs(said) else Path("~/.cache").expanduser()
    return home / "rapc"


def _is_large(paths: Sequence[str]) -> bool:
    size = 0
    try:
        for path in paths:
            for file in files_at(path_named(path), tests=False):
                size += os.stat(file).st_size
                if size >= SMALLEST:
                    return True
    except (LoadError, OSError, ValueError):  # who reads the files will say so
        pass
    return False
