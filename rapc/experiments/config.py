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

from rapc.base.names import did_you_mean
from rapc.base.values import Atom, Text
from rapc.errors import WorldError
from rapc.experiments.draws import Draws, with_draws
from rapc.runtime.settings import read_settings
from rapc.world import World
from rapc.worlds import registry

OWN = "rapc"
"""The owner of the interpreter's settings, beside that of a world's options."""

Plain = bool | int | float | str
"""The value of an option; that of one of kind `text` is the text itself."""


_CODE = (".py", ".lark")
"""The endings of files that decide what a package does."""


class PointConfig(msgspec.Struct, frozen=True):
    """What is run, and what is counted of it."""

    rapc: str
    #: A digest of rapc and of the package of the world.
    code: str
    library: str
    #: The files of the library, name and text, in the order in which they were linked.
    sources: tuple[tuple[str, str], ...]
    world: str
    #: All options of the world, and all settings of the interpreter.
    options: Mapping[str, Plain]
    settings: Mapping[str, int | float]
    tasks: tuple[str, ...]
    until: int | float
    counted: tuple[str, ...]
    count: Mapping[str, str]
    #: Which figures of the world about the truth are told.
    figures: tuple[str, ...] = ()
    #: What each seed draws; it stands in tasks and in `texts` by its name in braces.
    draws: Draws = {}
    #: Options and settings with something drawn, by `owner.name`.
    texts: Mapping[str, str] = {}

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
    return plain_values(values)


def plain_values(values: Mapping[str, Atom | bool]) -> dict[str, Plain]:
    """Return values of options as a configuration has them."""
    return {n: v.value if isinstance(v, Text) else v for n, v in values.items()}


def by_owner(
    world: type[World], texts: Mapping[str, str]
) -> tuple[dict[str, str], dict[str, str]]:
    """Part settings by `owner.name` into the interpreter's and the world's, by name.

    Raises:
        WorldError: for an owner that is neither.
    """
    own: dict[str, str] = {}
    theirs: dict[str, str] = {}
    for key, text in texts.items():
        owner, _, name = key.partition(".")
        if owner not in (OWN, world.name):
            raise WorldError(
                f"`{key}`: `{owner}` is neither `{OWN}` nor `{world.name}`",
                did_you_mean(owner, [OWN, world.name]),
            )
        (own if owner == OWN else theirs)[name] = text
    return own, theirs


def resolved(config: PointConfig, values: Mapping[str, str]) -> PointConfig:
    """Return `config` with the values drawn in their places, so that nothing is drawn.

    Raises:
        WorldError, SettingError: for an option or setting that cannot be so.
    """
    if not config.draws:
        return config
    world = registry.find_world(config.world)
    own, theirs = by_owner(world, config.texts)
    theirs = {name: with_draws(text, values) for name, text in theirs.items()}
    own = {name: with_draws(text, values) for name, text in own.items()}
    options = registry.read_options(world, theirs)
    settings = msgspec.structs.asdict(read_settings(own))
    drawn = {name.replace("-", "_") for name in own}
    return msgspec.structs.replace(
        config,
        tasks=tuple([with_draws(task, values) for task in config.tasks]),
        options={**config.options, **plain_values(options)},
        settings={**config.settings, **{name: settings[name] for name in drawn}},
        draws={},
        texts={},
    )


def digest_of_code(world: type[World]) -> str:
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
