"""What a host hands to a run, looked at before anything is done with it."""

from __future__ import annotations

from math import isnan

import msgspec

from rapc.errors import ArgumentError, SettingError
from rapc.runtime.settings import Settings


def need_call(value: object, what: str) -> None:
    """Raise ArgumentError unless `value`, told of as `what`, can be called."""
    if not callable(value):
        raise ArgumentError(f"{what} is {kind(value)}, nothing that can be called")


def need_time(value: object, what: str) -> None:
    """Raise ArgumentError unless `value`, told of as `what`, is a number."""
    if type(value) not in (int, float) or isnan(value):  # type: ignore[arg-type]
        raise ArgumentError(f"{what} is {kind(value)}, no time")


def need_settings(settings: object) -> None:
    """Look at settings that were made by a program and not read.

    Raises:
        ArgumentError: if `settings` are of another type.
        SettingError: if one of them has a value that it does not take.
    """
    if not isinstance(settings, Settings):
        raise ArgumentError(f"`settings` is {kind(settings)}, not `rapc.Settings`")
    try:
        msgspec.convert(msgspec.structs.asdict(settings), Settings)
    except msgspec.ValidationError as error:
        raise SettingError(
            f"a setting has a value that it does not take: {error}"
        ) from None


def kind(value: object) -> str:
    """Return in words what `value` is: `a text`, `None`, `of type int`."""
    if isinstance(value, float) and isnan(value):
        return "nan"
    words: dict[type, str] = {type(None): "None", str: "a text", list: "a list"}
    found = type(value)
    name = f"of type {found.__module__}.{found.__qualname__}"
    return words.get(found, name.replace("builtins.", ""))
