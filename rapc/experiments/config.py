"""The configuration of a run, every input except the seed, and its digest.

A configuration has the text of the library in it and needs no file besides: it can be
sent to another process or machine that has the same rapc.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import msgspec

from rapc.base.values import Atom, Text
from rapc.world import World

Plain = bool | int | float | str
"""The value of an option; that of one of kind `text` is the text itself."""


_CODE = (".py", ".lark")
"""The endings of files that decide what a package does."""


class Config(msgspec.Struct, frozen=True):
    """What is run, and what is counted of it.

    `sources` are the files of the library, name and text, in the order in which they
    were linked; `options` are all that the world has, `settings` all that the
    interpreter has; `code` is a digest of rapc and of the package of the world.
    """

    rapc: str
    code: str
    library: str
    sources: tuple[tuple[str, str], ...]
    world: str
    options: Mapping[str, Plain]
    settings: Mapping[str, int | float]
    tasks: tuple[str, ...]
    until: int | float
    counted: tuple[str, ...]
    count: Mapping[str, str]

    def as_json(self) -> bytes:
        """The configuration for a person, with a digest for the library's text.

        It does not say where files lie: the same library elsewhere is the same.
        """
        texts = "\0".join(text for _, text in self.sources)
        plain = {
            **msgspec.structs.asdict(self),
            "library": hashlib.sha256(texts.encode(errors="replace")).hexdigest(),
        }
        del plain["sources"]
        return msgspec.json.encode(plain, order="deterministic")

    def digest(self) -> str:
        """The hash under which results are stored."""
        return hashlib.sha256(self.as_json()).hexdigest()[:16]


def world_options(
    world: type[World], plain: Mapping[str, Plain]
) -> dict[str, Atom | bool]:
    """Values of options as a world takes them."""
    kinds = {option.name: option.kind for option in world.kit.options}
    return {
        name: Text(str(value)) if kinds[name] == "text" else value
        for name, value in plain.items()
    }


def plain_options(
    world: type[World], given: Mapping[str, Atom | bool]
) -> dict[str, Plain]:
    """The values of all options of a world: those given, and the defaults."""
    values = {option.name: option.default for option in world.kit.options} | dict(given)
    return {n: v.value if isinstance(v, Text) else v for n, v in values.items()}


def code_of(world: type[World]) -> str:
    """A digest of the code that decides what a run comes to.

    That is all of rapc, and the package of the world if that is another one.
    """
    package = world.__module__.partition(".")[0]
    return _digest_of(tuple(sorted({"rapc", package})))


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
    return sorted(f for f in file.parent.rglob("*") if f.suffix in _CODE)
