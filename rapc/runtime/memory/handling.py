"""The handlers' way into memory (T A.3 to A.5) and the hosts' view of it."""

from __future__ import annotations

from rapc.runtime.events import ItemEvent, ItemIntroduced, ItemLost, ItemMoved
from rapc.runtime.memory.items import Item
from rapc.runtime.memory.memory import EXTERNAL, FactError, Memory
from rapc.runtime.recorder import Recorder
from rapc.runtime.world import Time
from rapc.terms import Atom, Fact, format_atom, format_list

UNKNOWN = "unknown"


class MemoryView:
    """Memory to be read: what functions, default functions and solvers are given."""

    def __init__(self, memory: Memory, recorder: Recorder) -> None:
        self._memory = memory
        self._recorder = recorder

    @property
    def now(self) -> Time:
        """The time of the clock."""
        return self._recorder.time

    @property
    def place(self) -> Atom | None:
        """The robot's own place: the one last given to `arrive`."""
        return self._memory.place

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """The facts that match, oldest first; None matches anything.

        Defaults are not consulted, and `external` is what is stored as such.
        """
        return list(self._memory.facts.matching(pattern))

    def value(self, *index: Atom) -> Atom | None:
        """The asserted value of a property for an index, or None."""
        fact = self._memory.facts.values.get(index)
        return None if fact is None else fact[-1]

    def age(self, *fact: Atom) -> Time | None:
        """Time units since a fact was last asserted, or None."""
        stamp = self._memory.facts.stamps.get(fact)
        return None if stamp is None else self.now - stamp


class HandlerAccess(MemoryView):
    """What handlers do to memory: the `HandlerMemory` of `rapc.runtime.world`."""

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact now. Raises FactError for what may not be asserted."""
        checked = self._memory.checked(fact)
        self._refuse_by_hand(checked)
        self._memory.assert_fact(checked, "handler")

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts so. Raises FactError as `assert_fact`."""
        self._refuse_by_hand(prefix)
        self._memory.erase(prefix, "handler")

    def _refuse_by_hand(self, fact: Fact) -> None:
        """Only introduce, move and lose set an item's place and introducing class."""
        item = self._memory.items.known.get(str(fact[1])) if len(fact) > 1 else None
        if item is None:
            return
        classed = fact[0] == "class" and len(fact) > 2 and fact[2] == item.kind
        if fact[0] == "location" or classed:
            raise FactError(
                f"{format_list(fact)}: an introduced item's location and class "
                "are set by `introduce`, `move` and `lose`"
            )

    def introduce(self, sensor_name: str, kind: str, place: Atom) -> str:
        """An item is seen: see `HandlerMemory.introduce`."""
        memory = self._memory
        place = self._stored(place)
        item, news = memory.items.introduce(sensor_name, kind)
        before = self.value("location", item.name)
        self._set("class", item.name, item.kind, "true")
        self._set("location", item.name, place)
        if news:
            memory.moved("know-sensor-name")
            self._tell(ItemIntroduced, item, place)
        elif before != place:
            self._tell(ItemMoved, item, place)
        return item.name

    def move(self, item: str, place: Atom) -> None:
        """An accessible item now is at `place`; it stays accessible.

        Raises:
            FactError: for a name that no handler introduced.
        """
        known = self._introduced(item)
        place = self._stored(place)
        self._set("location", item, place)
        self._tell(ItemMoved, known, place)

    def lose(self, item: str) -> None:
        """An item is not where it was. Raises FactError as `move`."""
        known = self._introduced(item)
        known.accessible = False
        self._memory.moved("know-sensor-name")
        self._set("location", item, UNKNOWN)
        self._tell(ItemLost, known, UNKNOWN)

    def fix_cardinality(self, place: Atom) -> None:
        """Items believed at `place` and not accessible get the place `unknown`."""
        place = self._stored(place)
        for fact in list(self._memory.facts.matching(("location", None, place))):
            item = self._memory.items.known.get(str(fact[1]))
            if item is not None and not item.accessible:
                self.lose(item.name)

    def expire(self) -> None:
        """All sensor names go: the robot has moved."""
        if self._memory.items.expire():
            self._memory.moved("know-sensor-name")

    def arrive(self, place: Atom) -> None:
        """The robot now is at `place`, of which `external` speaks from now on."""
        self._memory.arrive(place)

    def _introduced(self, item: str) -> Item:
        known = self._memory.items.known.get(item)
        if known is None:
            raise FactError(f"no handler has introduced an item `{item}`")
        return known

    def _stored(self, place: Atom) -> Atom:
        if place == EXTERNAL and self._memory.place is not None:
            return self._memory.place
        return place

    def _set(self, *fact: Atom) -> None:
        self._memory.assert_fact(self._memory.checked(fact), "handler")

    def _tell(self, kind: type[ItemEvent], item: Item, place: Atom) -> None:
        if self._recorder.on:
            self._recorder.emit(
                kind,
                item=item.name,
                sensor=item.sensor if item.accessible else None,
                location=format_atom(place),
                kind=item.kind,
            )
