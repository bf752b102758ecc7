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

from rapc.experiments.draws import Draws, with_draws
from rapc.runtime.settings import read_settings
from rapc.spec import RunSpec
from rapc.world import World
from rapc.worlds import registry

_CODE = (".py", ".lark")
"""The endings of files that decide what a package does."""


class PointConfig(msgspec.Struct, frozen=True):
    """What is run, and what is counted of it."""

    rapc: str
    #: A digest of rapc and of the package of the world.
    code: str
    #: What a run is begun with, but for its seed; all options and settings are there.
    spec: RunSpec
    #: The files of the library, name and text, in the order in which they were linked.
    sources: tuple[tuple[str, str], ...]
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
        digest = hashlib.sha256(texts.encode(errors="replace")).hexdigest()
        spec = msgspec.structs.replace(self.spec, library="", digest=digest)
        plain = {**msgspec.structs.asdict(self), "spec": spec}
        del plain["sources"]
        return msgspec.json.encode(plain, order="deterministic")

    def digest(self) -> str:
        """The hash under which results are stored."""
        return hashlib.sha256(self.as_json()).hexdigest()[:16]


def resolved(config: PointConfig, values: Mapping[str, str]) -> PointConfig:
    """Return `config` with the values drawn in their places, so that nothing is drawn.

    Raises:
        WorldError, SettingError: for an option or setting that cannot be so.
    """
    if not config.draws:
        return config
    spec = config.spec
    texts = {name: with_draws(text, values) for name, text in config.texts.items()}
    options, own = registry.read_values(registry.find_world(spec.world), texts)
    settings = read_settings(own).named()
    spec = msgspec.structs.replace(
        spec,
        tasks=tuple([with_draws(task, values) for task in spec.tasks]),
        options={**spec.options, **options},
        settings={**spec.settings, **{name: settings[name] for name in own}},
    )
    return msgspec.structs.replace(config, spec=spec, draws={}, texts={})


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
