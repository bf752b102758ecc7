"""Settings of the interpreter, and how they are read from text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated

import msgspec

from rapc.base.names import hint
from rapc.base.values import number
from rapc.errors import SettingError
from rapc.spec import Plain

_Count = Annotated[int, msgspec.Meta(ge=1)]
_Cost = Annotated[int, msgspec.Meta(ge=0)] | Annotated[float, msgspec.Meta(ge=0)]


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of the interpreter (`--set rapc.NAME=value`)."""

    #: How often one choice is allowed [T 3.2.5].
    futile_limit: _Count = 2
    #: The last different choices of a task of which that counts.
    max_choices: _Count = 1000
    #: The cycles without the clock moving after which a run is called off.
    idle_cycles: _Count = 100_000
    #: The waits in a row without a cycle after which a run is over [L 4.48].
    idle_waits: _Count = 100_000
    #: The time units that a cycle takes [T 7.2.1].
    cycle_cost: _Cost = 0
    #: How often a question may go back in vain before it is given up [L 2.70].
    query_steps: _Count = 1_000_000
    #: How many layers an expectation set keeps (docs/memory.md).
    max_layers: _Count = 8
    #: How long a run waits for a world that cannot say when it will send something.
    patience: _Cost = 3600
    #: Whether handlers are held to what the library declares of them.
    strict: bool = False

    def named(self, names: Iterable[str] | None = None) -> dict[str, Plain]:
        """Return the values by the names of the command line (`futile-limit`).

        Args:
            names: of those that are wanted; all if None.
        """
        fields = {name.replace("_", "-"): name for name in self.__struct_fields__}
        wanted = fields if names is None else names
        return {name: getattr(self, fields[name]) for name in wanted}


_TAKES = {
    "cycle-cost": "0 or more",
    "patience": "0 or more",
    "strict": "true or false",
}
"""What settings take that are no whole numbers from 1."""


def read_settings(values: Mapping[str, Plain]) -> Settings:
    """Return settings by the names of the command line (`futile-limit`).

    Args:
        values: the values, or texts of them.

    Raises:
        SettingError: for an unknown name, or a value that the setting does not take.
    """
    names = {n.replace("_", "-"): n for n in Settings.__struct_fields__}
    read: dict[str, object] = {}
    for name, value in values.items():
        if name not in names:
            said = f"there is no setting `rapc.{name}`{hint(name, names)}"
            raise SettingError(said)
        try:
            read[names[name]] = _read(value) if isinstance(value, str) else value
            msgspec.convert({names[name]: read[names[name]]}, Settings)
        except ValueError:
            takes = _TAKES.get(name, "a whole number, 1 or more")
            raise SettingError(f"`rapc.{name}` takes {takes}, not `{value}`") from None
    return msgspec.convert(read, Settings)


def _read(text: str) -> bool | int | float:
    flag = {"true": True, "false": False}.get(text)
    return number(float(text)) if flag is None else flag
