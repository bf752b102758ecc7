"""Digest of the Python code that determines the result of a run."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path

_CODE = (".py", ".lark")
"""The suffixes of files with code."""


def digest_of_code(world: type) -> str:
    """Return a digest of the code of rapc, and of the package of a world.

    A world in another process adds a digest of its own.

    Args:
        world: the class of the world.
    """
    package = world.__module__.partition(".")[0]
    return _digest_of(tuple(sorted({"rapc", package}))) + getattr(world, "digest", "")


@cache
def _digest_of(packages: tuple[str, ...]) -> str:
    digest = hashlib.sha256()
    for file in (file for name in packages for file in _files(name)):
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def _files(package: str) -> Iterable[Path]:
    home = sys.modules[package].__file__
    if home is None:
        return ()
    file = Path(home)
    if file.name != "__init__.py":
        return (file,)
    found = (f for f in file.parent.rglob("*") if f.suffix in _CODE)
    # Examples are not code of the package; in a checkout they are behind a link.
    return sorted(
        f for f in found if "examples" not in f.relative_to(file.parent).parts
    )
