"""Worlds by name, their option values from text, and the making of worlds.

rapc has its own worlds. A package offers a world by an entry point of the group
`rapc.worlds`; a world can also be named `module:Class`. A world is imported only when
it is requested, and packages are not searched for one of rapc's own worlds: the search
takes longer than reading a library. Errors of the user are `WorldError`s, which the
front ends show.
"""

from __future__ import annotations

import importlib
import random
import re
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rapc.base.code_places import place_of_error, said_by
from rapc.base.files import path_named, read_text
from rapc.base.former import kit_help, module_help
from rapc.base.names import did_you_mean
from rapc.base.values import Atom, Text, number
from rapc.errors import ArgumentError, LoadError, RefusedError, WorldError
from rapc.spec import Plain, RunSpec
from rapc.world import Kit, Option, World

if TYPE_CHECKING:
    from importlib import metadata

OWN: Mapping[str, str] = {
    "courier": "rapc.worlds.courier:CourierWorld",
    "hallway": "rapc.worlds.hallway:HallwayWorld",
    "truck": "rapc.worlds.truck:TruckWorld",
}
"""The worlds that come with rapc, each as `module:Class`."""

GROUP = "rapc.worlds"
"""The entry-point group under which packages offer their worlds."""

PEERS = ("exec", "unix", "tcp")
"""The kinds of addresses of worlds in other processes: `exec:COMMAND`."""

_REMOTE = "rapc.worlds.remote.world:world_at"
_MODULE_CLASS = re.compile(r"\w+(\.\w+)*:\w+(\.\w+)*")
_NUMBER = re.compile(r"[-+]?[0-9]+(\.[0-9]+)?")
_SYMBOL = re.compile(r"[^\s()\";?]+")


def available() -> tuple[str, ...]:
    """Return the names of all installed worlds, sorted."""
    return tuple(sorted({*OWN, *_entry_points().names}))


def meant(refused: RefusedError) -> list[str]:
    """Return a line for each installed world that offers all missing names, sorted.

    Worlds that cannot be loaded are left out.
    """
    found = []
    for name in available() if refused.lacking else ():
        try:
            offer = find_world(name).kit.offer
        except WorldError:
            continue
        offered = {*offer.primitives, *offer.data, *offer.skills, *offer.events}
        if offered >= {*refused.lacking}:
            found.append(f"the world `{name}` has them all")
    return found


def find_permitted(name: str, modules: Collection[str]) -> type[World]:
    """Return the world named by a file from any source.

    A file may name any installed world, because the user installed it. A file may name
    `module:Class` only of `modules`, because importing a module runs its code; and a
    peer only if its kind is among `modules`: `exec`.

    Raises:
        WorldError: as `find_world`, and for a module that is not permitted.
    """
    module = name.partition(":")[0]
    if ":" in name and module not in modules:
        what = f"the module `{module}` may not be imported"
        if module in PEERS:
            what = f"a world of the form `{module}:` may not be used"
        raise WorldError(
            f"{what} for a test",
            f"permit it by `--world-module {module}` or by `world-modules` in "
            "`rapc.toml`, under pytest by `rap_world_modules`",
        )
    return find_world(name)


def find_world(name: str) -> type[World]:
    """Return the world of an installed name, of `module:Class`, or of a peer.

    A peer is named `exec:COMMAND`, `unix:/path` or `tcp:127.0.0.1:PORT`. Modules are
    also searched in the working directory.

    Raises:
        WorldError: if the name is unknown or not a world.
    """
    if not isinstance(name, str):
        raise ArgumentError("the name of a world is a text")
    if ":" in name and name.partition(":")[0] in PEERS:
        world_at: Any = _load(name, _REMOTE)
        world: type[World] = world_at(name, find_world)
        return world
    if ":" in name:
        if not _MODULE_CLASS.fullmatch(name):
            raise WorldError(f"`{name}` cannot be loaded: it is not `module:Class`")
        place = name
    else:
        place = OWN.get(name) or _installed(name)
    found = _load(name, place)
    if not (isinstance(found, type) and issubclass(found, World)):
        raise WorldError(f"`{place}` is not a subclass of `rapc.World`")
    refuse_incomplete(found, place)
    return found


def refuse_incomplete(world: type[World], place: str) -> None:
    """Refuse a class of worlds without the required names.

    Raises:
        WorldError: with the missing names; `place` is the name of the class.
    """
    missing = sorted(getattr(world, "__abstractmethods__", ()))
    if not isinstance(getattr(world, "name", None), str):
        missing.append("name")
    help_ = ""
    if not isinstance(getattr(world, "kit", None), Kit):
        missing.append("kit")
        help_ = kit_help(world)
    if missing:
        said = f"the world `{place}` does not define {', '.join(missing)}"
        raise WorldError(said, help_)


def _entry_points() -> metadata.EntryPoints:
    from importlib import metadata  # noqa: PLC0415  # few runs use the module

    return metadata.entry_points(group=GROUP)


def _installed(name: str) -> str:
    """Return the `module:Class` that a package offers by a name."""
    places = {point.value for point in _entry_points().select(name=name)}
    if len(places) == 1:
        return places.pop()
    listed = ", ".join(f"`{place}`" for place in sorted(places or available()))
    if places:
        said = f"several packages offer a world `{name}`"
        raise WorldError(said, f"name one of {listed}")
    known = f"known are {listed}; one of a module is named `module:Class`"
    raise WorldError(f"unknown world `{name}`", did_you_mean(name, available(), known))


def _load(name: str, place: str) -> object:
    """Return the object at `module:Class`; `name` is its name in messages."""
    module, _, path = place.partition("[")[0].partition(":")
    try:
        with importing_from(Path.cwd()):
            found = importlib.import_module(module.strip())
            for part in path.strip().split("."):
                found = getattr(found, part)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # imported code may raise any exception
        said = f"{place_of_error(error)}: {said_by(error)}"
        meant = _in_capitals(module.strip(), path.strip())
        if isinstance(error, ImportError):
            meant = meant or module_help(error.name)
        raise WorldError(f"the world `{name}` cannot be loaded{said}", meant) from error
    return found


def _in_capitals(module: str, wanted: str) -> str:
    """Return a hint if the module has the name with other capital letters."""
    for name in vars(sys.modules.get(module, object)):
        if name != wanted and name.lower() == wanted.lower():
            return (
                f"`{module}` has `{name}`; RAP reads symbols in small letters, so in a "
                f'test it is written "{module}:{name}"'
            )
    return ""


@contextmanager
def importing_from(folder: Path) -> Iterator[None]:
    """Let Python also search a folder for modules of worlds, after all others."""
    here = str(folder.absolute())
    if here in sys.path:
        yield
        return
    sys.path.append(here)
    try:
        yield
    finally:
        sys.path.remove(here)


OWN_SETTINGS = "rapc"
"""The owner of the interpreter's settings; the other owner is the world."""


def split_setting(text: str) -> tuple[str, str]:
    """Return the key and the value of `owner.name=value`.

    Raises:
        WorldError: if the text has a different form.
    """
    key, equals, value = text.partition("=")
    owner, dot, name = key.strip().partition(".")
    if not (equals and dot and owner and name):
        raise WorldError(f"`{text}` is not of the form `world.option=value`")
    return key.strip(), value.strip()


def read_values(
    world: type[World], texts: Mapping[str, str]
) -> tuple[dict[str, Plain], dict[str, str]]:
    """Return options of a world, and settings of the interpreter as texts.

    Args:
        world: the world.
        texts: the values by `owner.name`; the owner is the world or `rapc`.

    Raises:
        WorldError: for an unknown owner or option, or a value of the wrong kind.
    """
    own: dict[str, str] = {}
    theirs: dict[str, str] = {}
    for key, text in texts.items():
        owner, _, name = key.partition(".")
        if owner not in (OWN_SETTINGS, world.name):
            raise WorldError(
                f"`{key}`: unknown owner `{owner}`; expected `{OWN_SETTINGS}` or "
                f"`{world.name}`",
                did_you_mean(owner, [OWN_SETTINGS, world.name]),
            )
        (own if owner == OWN_SETTINGS else theirs)[name] = text
    return plain_values(read_options(world, theirs) if theirs else {}), own


def plain_values(options: Mapping[str, Atom | bool]) -> dict[str, Plain]:
    """Return values of options as plain data: a `Text` becomes a `str`."""
    return {n: v.value if isinstance(v, Text) else v for n, v in options.items()}


def read_options(
    world: type[World], texts: Mapping[str, str]
) -> dict[str, Atom | bool]:
    """Return option values from text, each of its option's kind.

    The value of an option of kind `text` may be `@FILE`, for the content of that file.

    Raises:
        WorldError: for an unknown option or a value of the wrong kind.
    """
    options = {option.name: option for option in world.kit.options}
    return {
        name: _value(world, _known(world, options, name), text)
        for name, text in texts.items()
    }


def _known(world: type[World], options: Mapping[str, Option], name: str) -> Option:
    if name not in options:
        message = f"the world `{world.name}` has no option `{name}`"
        listed = f"`rapc worlds {world.name}` lists them"
        raise WorldError(message, did_you_mean(name, options, listed))
    return options[name]


def _value(world: type[World], option: Option, text: str) -> Atom | bool:
    if option.kind == "text":
        return Text(_file(text[1:]) if text.startswith("@") else text)
    if option.kind == "flag" and text.lower() in ("true", "false"):
        return text.lower() == "true"
    if option.kind == "symbol" and _SYMBOL.fullmatch(text):
        return text.lower()
    if _NUMBER.fullmatch(text) and len(text) <= 300:
        value = number(float(text)) if "." in text else int(text)
        if option.kind == "number" or (option.kind == "integer" and value % 1 == 0):
            return value
    raise _wrong_kind(world, option, text)


def _wrong_kind(world: type[World], option: Option, value: str) -> WorldError:
    kind = "`true` or `false`" if option.kind == "flag" else f"one {option.kind}"
    said = f"`{world.name}.{option.name}` takes {kind}, not `{value}`"
    return WorldError(said, option.doc)


def _file(path: str) -> str:
    try:
        return read_text(path_named(path))
    except LoadError as error:
        raise WorldError(str(error)) from error


def build_world(
    world: type[World], seed: int, options: Mapping[str, Atom | bool]
) -> World:
    """Return a world for a run, with the random stream `world` of a seed.

    The world gets the value of an option of kind `text` as a `str`.

    Raises:
        WorldError: if the world refuses option values, or raises another exception.
    """
    make: Callable[..., World] = world
    defaults = {option.name: option.default for option in world.kit.options}
    given = plain_values({**defaults, **options})
    try:
        made = make(random.Random(f"{seed}:world"), given)
        made.made_with = dict(given)
        return made
    except ValueError as error:
        said = said_by(error).removeprefix("ValueError: ")
        raise WorldError(f"the world `{world.name}` refuses: {said}") from error
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # foreign code may raise any exception
        place = place_of_error(error)
        said = f"the world `{world.name}` cannot be built{place}: {said_by(error)}"
        raise WorldError(said) from error


def world_of(spec: RunSpec) -> World:
    """Return the world of a run, made with its seed and options, without faults.

    Raises:
        WorldError: as `find_world`, `check_options` and `build_world`.
    """
    world = find_world(spec.world_class or spec.world)
    return build_world(world, spec.seed, check_options(world, spec.options))


def open_world(name: str, seed: int = 0, **options: Atom | bool) -> World:
    """Return a world by its name; `fuel_capacity=20` sets `fuel-capacity`.

    Raises:
        ArgumentError: if the seed is not a whole number.
        WorldError: for an unknown world or option, or if the world refuses a value.
    """
    if type(seed) is not int:
        raise ArgumentError("`seed` is not a whole number")
    world = find_world(name)
    return build_world(world, seed, check_options(world, options))


TYPES: Mapping[str, tuple[type, ...]] = {
    "flag": (bool,),
    "integer": (int,),
    "number": (int, float),
    "symbol": (str,),
    "text": (Text, str),
}
"""Types of option values, by kind."""


def check_options(
    world: type[World], options: Mapping[str, Atom | bool]
) -> dict[str, Atom | bool]:
    """Return option values for a world, by their names with hyphens.

    Raises:
        WorldError: for an unknown option or a value of the wrong kind.
    """
    known = {option.name: option for option in world.kit.options}
    found: dict[str, Atom | bool] = {}
    for given, value in options.items():
        name = given.replace("_", "-")
        option = _known(world, known, name)
        if type(value) not in TYPES[option.kind]:
            raise _wrong_kind(world, option, repr(value))
        is_text = option.kind == "text" and isinstance(value, str)
        found[name] = Text(str(value)) if is_text else value
    return found
