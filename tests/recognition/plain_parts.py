"""What the plain memory is made of: things, guns, sets and the declarations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from rapc.base.values import Atom, Fact

Known = Mapping[Fact, Atom]
"""The values of a thing's further properties, without those that are unknown."""


@dataclass(frozen=True)
class Comparator:
    """A comparator as RAP declares it: vetoing, weighted and ignored properties.

    A `function` of what is known of two things takes the place of these.
    """

    veto: Sequence[str] = ()
    weights: Mapping[str, float] = field(default_factory=dict)
    ignored: Sequence[str] = ()
    function: Callable[[Known, Known], float] | None = None


@dataclass(frozen=True)
class Declared:
    """What a library declares.

    `properties` are names; an exclusion `(p, v, q, w)` says that `(p x v)` excludes
    `(q x ? w)`; comparators are by class, or by class and place.
    """

    properties: Sequence[str]
    indistinct: Sequence[str]
    excludes: Sequence[tuple[str, Atom, str, Atom]] = ()
    comparators: Mapping[tuple[str, Atom | None], Comparator] = field(
        default_factory=dict
    )
    max_layers: int = 8

    def comparator(self, kind: str, place: Atom) -> Comparator:
        """The one for the place, else the one for the class, else that of all."""
        for key in ((kind, place), (kind, None)):
            if key in self.comparators:
                return self.comparators[key]
        return Comparator()


@dataclass(eq=False)
class Thing:
    """A description of an item of an indistinct class; an empty one has no name."""

    number: int
    kind: str
    name: str | None
    sensor: str | None


@dataclass(eq=False)
class Gun:
    """An item of a distinct class, known at sight."""

    name: str
    kind: str
    accessible: bool = False

    @property
    def reach(self) -> str | None:
        """Its sensor name, while it has one."""
        return self.name if self.accessible else None


@dataclass(eq=False)
class Layer:
    """A view that was pushed when its set went out of reach."""

    serial: int
    members: list[Thing]


@dataclass(eq=False)
class Expected:
    """An expectation set: the local model's part, then layers, the oldest first."""

    kind: str
    place: Atom
    local: list[Thing] = field(default_factory=list)
    layers: list[Layer] = field(default_factory=list)

    @property
    def size(self) -> int:
        """How many items are believed to be there."""
        return max(len(view) for view in self.views())

    def views(self) -> list[list[Thing]]:
        """The local model's part, then the layers from latest to earliest."""
        return [self.local, *(layer.members for layer in reversed(self.layers))]

    def things(self) -> list[Thing]:
        """All that stand in a view, each once."""
        return list(dict.fromkeys(d for view in self.views() for d in view))

    def standing(self, thing: Thing) -> int:
        """In how many views a thing stands."""
        return sum(thing in view for view in self.views())

    def apart(self, one: Thing, other: Thing) -> bool:
        """Whether two things stand in one view, so that they are not one item."""
        return any(one in view and other in view for view in self.views())
