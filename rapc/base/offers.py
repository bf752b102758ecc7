"""The offer of a world, a part of the port (`rapc.world`)."""

from __future__ import annotations

import re
from collections.abc import Mapping

import msgspec

AFTER_CRASH = ("repeat", "fail", "ask")
"""The ways to treat a request that was under way when the interpreter died."""


class Offer(msgspec.Struct, frozen=True):
    """The requests that a world accepts and the messages that it sends, by name."""

    #: The number of arguments of each primitive, and its results.
    primitives: Mapping[str, tuple[int, tuple[str, ...]]] = {}
    #: The number of arguments of each sensor datum.
    data: Mapping[str, int] = {}
    #: The number of arguments of each skill, its name with the colon.
    skills: Mapping[str, int] = {}
    #: The number of arguments of each signal, its name with the colon (`:alarm`).
    events: Mapping[str, int] = {}
    #: The primitives that only sense and change nothing [T 6.3].
    sensors: tuple[str, ...] = ()
    #: The primitives that are not atomic: their end comes later [T 7.3.3].
    not_atomic: tuple[str, ...] = ()
    #: The names of the arguments of a primitive, datum, skill or signal, for its
    #: declaration (`rapc worlds NAME --declare`): `{"drive": ("room",)}`.
    arguments: Mapping[str, tuple[str, ...]] = {}
    #: The treatment of a primitive's request that was under way when the interpreter
    #: died, if a resumed run cannot find out its outcome: `repeat`, `fail` or `ask`. By
    #: default, sensors repeat and other primitives fail.
    after_crash: Mapping[str, str] = {}

    def counts(self, name: str) -> set[int]:
        """Return the possible numbers of arguments of a name; empty if unknown."""
        tables = (self.data, self.skills, self.events)
        found = {table[name] for table in tables if name in table}
        return found | {n for one, (n, _) in self.primitives.items() if one == name}

    def __post_init__(self) -> None:
        """Validate the fields; raise TypeError."""
        _look_at(self.primitives)
        for counts in (self.data, self.skills, self.events):
            for name, count in counts.items():
                if type(count) is not int:
                    wanted = "a number of arguments"
                    raise TypeError(
                        f"expected {wanted} for `{name}` in an Offer, not {count!a}"
                    )
        for name in (*self.skills, *self.events):
            if not name.startswith(":"):
                raise TypeError(
                    f"expected a colon at the start of the name `{name}` in an Offer"
                )
        for names in (self.sensors, self.not_atomic):
            if isinstance(names, str):
                raise TypeError(f"expected a tuple of names in an Offer, not {names!a}")
        self._check_after_crash()
        for name, called in self.arguments.items():
            if isinstance(called, str) or not all(map(_is_name, called)):
                wanted = "a tuple of names for the arguments"
                raise TypeError(
                    f"expected {wanted} of `{name}` in an Offer, not {called!a}"
                )
            if len(called) not in self.counts(name) or len({*called}) < len(called):
                given = ", ".join(called) or "()"
                raise TypeError(
                    f"unknown name `{name}` with arguments {given} in an Offer"
                )

    def _check_after_crash(self) -> None:
        for name, treatment in self.after_crash.items():
            if name not in self.primitives:
                raise TypeError(f"unknown primitive `{name}` in an Offer")
            if treatment not in AFTER_CRASH:
                wanted = ", ".join(AFTER_CRASH)
                raise TypeError(
                    f"expected one of {wanted} for `{name}` in an Offer, not "
                    f"{treatment!a}"
                )


def _look_at(primitives: object) -> None:
    """Validate the primitives of an Offer; raise TypeError."""
    if not isinstance(primitives, Mapping):
        raise TypeError(
            f"expected a dict of primitives in an Offer, not {primitives!a}"
        )
    for name, offered in primitives.items():
        match offered:
            case [int(), [*results]] if all(type(r) is str for r in results):
                continue
        wanted = "a number of arguments and a tuple of results"
        raise TypeError(f"expected {wanted} for `{name}` in an Offer, not {offered!a}")


def _is_name(value: object) -> bool:
    """Return whether a value is a valid variable name without question mark."""
    return type(value) is str and bool(_NAME.fullmatch(value))


_NAME = re.compile(r"[a-z][a-z0-9-]*")
