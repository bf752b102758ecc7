"""Settings of the interpreter, and their parser."""

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
    #: The number of last different choices of a task that count for `futile-limit`.
    max_choices: _Count = 1000
    #: The cycles without a move of the clock after which a run is aborted.
    idle_cycles: _Count = 100_000
    #: The waits in a row without a cycle after which a run is over [L 4.48].
    idle_waits: _Count = 100_000
    #: The time units that a cycle takes [T 7.2.1].
    cycle_cost: _Cost = 0
    #: The steps back in vain after which a query is aborted [L 2.70].
    query_steps: _Count = 1_000_000
    #: The highest number of sets and counters of live tasks [L 6.28].
    max_resources: _Count = 1_000_000
    #: How many layers an expectation set keeps (docs/explanation/memory.md).
    max_layers: _Count = 8
    #: The time to wait for a world that cannot state its next time.
    patience: _Cost = 3600
    #: The states that one search for a plan looks at [L 10.11].
    plan_limit: _Count = 20_000
    #: The states that a search looks at for a cheaper plan.
    plan_tries: Annotated[int, msgspec.Meta(ge=0)] = 0
    #: Whether handlers are checked against their declarations.
    strict: bool = False
    #: Whether the trace has each change of the world's picture (`pictured`).
    pictures: bool = False

    def named(self, names: Iterable[str] | None = None) -> dict[str, Plain]:
        """Return the values by the names of the command line (`futile-limit`).

        Args:
            names: the names to return; all if None.
        """
        fields = {name.replace("_", "-"): name for name in self.__struct_fields__}
        wanted = fields if names is None else names
        return {name: getattr(self, fields[name]) for name in wanted}


_TAKES = {
    "cycle-cost": "0 or more",
    "patience": "0 or more",
    "plan-tries": "a whole number, 0 or more",
    "strict": "true or false",
    "pictures": "true or false",
}
"""The parsers of settings that are no whole numbers from 1."""


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
            said = f"unknown setting `rapc.{name}`{hint(name, names)}"
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
