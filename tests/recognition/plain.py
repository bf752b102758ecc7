"""Recognition, written a second time from docs/explanation/memory.md and [T 2.3].

It knows nothing of the memory under test. Facts are one dict, sets are lists of
views, and everything is tried: all pairs of views, all groups, all collections. What
is alike is in `plain_matching`, what leaves a set in `plain_leaving`, what becomes of
facts in `plain_facts`; here is what handlers do, and in which order.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rapc.base.values import Atom

from . import plain_leaving, plain_matching
from .plain_facts import Facts
from .plain_parts import Declared, Expected, Gun, Layer, Thing

Told = tuple[str, str, str | None, str, Atom, str | None, float | None, float | None]
"""An event: what, item, sensor, class, place, the other name, score, rival."""


class Plain:
    """A memory by section 7. What is done outside a batch is a batch of its own."""

    def __init__(self, declared: Declared) -> None:
        self.declared = declared
        self.facts = Facts(declared)
        self.things: dict[str, Thing] = {}
        self.guns: dict[str, Gun] = {}
        self.sets: dict[tuple[str, Atom], Expected] = {}
        self.events: list[Told] = []
        self._counted: list[Atom] = []
        self._depth = 0
        self._numbers = 0
        self._names = 0
        self._layers = 0

    # --- what handlers do ----------------------------------------------------

    @contextmanager
    def batch(self) -> Iterator[None]:
        """Matching waits for the end of it, and counting for that of the matching."""
        self._depth += 1
        yield
        self._depth -= 1
        if self._depth:
            return
        self._settle()
        while self._counted:
            self._count(self._counted.pop(0))
            self._settle()

    def introduce(self, sensor: str, kind: str, place: Atom) -> str:
        """An item is seen; one that is in reach is the same as before."""
        place = self.facts.name(place)
        with self.batch():
            if kind not in self.declared.indistinct:
                return self._introduce_gun(sensor, kind, place)
            for thing in self.things.values():
                if thing.sensor == sensor:
                    return self._introduce_again(str(thing.name), kind, place)
            return self._introduce_new(sensor, kind, place)

    def _introduce_again(self, name: str, kind: str, place: Atom) -> str:
        self.move(name, place)
        name = str(self.facts.name(name))
        self.facts.put("class", name, kind, "true")
        return name

    def _introduce_new(self, sensor: str, kind: str, place: Atom) -> str:
        self._names += 1
        name = f"thing-{self._names}"
        thing = Thing(self._number(), kind, name, sensor)
        self.things[name] = thing
        self.facts.put("class", name, kind, "true")
        self.facts.put("location", name, place)
        expected = self._expected(kind, place)
        expected.local.append(thing)
        self._fill(expected)
        self._tell("introduced", thing, place)
        return name

    def _introduce_gun(self, sensor: str, kind: str, place: Atom) -> str:
        gun = self.guns.setdefault(sensor, Gun(sensor, kind))
        before = self.facts.value("location", sensor)
        news, gun.accessible = not gun.accessible, True
        self.facts.put("class", sensor, gun.kind, "true")
        self.facts.put("location", sensor, place)
        if news:
            self._tell("introduced", gun, place)
        elif before != place:
            self._tell("moved", gun, place)
        return sensor

    def move(self, name: str, place: Atom) -> None:
        """An item in reach is now at a place."""
        name, place = str(self.facts.name(name)), self.facts.name(place)
        with self.batch():
            if name in self.guns:
                before = self.facts.value("location", name)
                self.facts.put("location", name, place)
                if before != place:
                    self._tell("moved", self.guns[name], place)
                return
            thing = self.things[name]
            if self.place(thing) == place:
                self.facts.put("location", name, place)
                return
            left = self._leave(thing)
            for view in self._expected(thing.kind, place).views():
                view.append(left.who[0])
            self.facts.put("location", str(left.who[0].name), place)
            self._tell("moved", left.who[0], place, *left.told)

    def lose(self, name: str) -> None:
        """An item is not where it was, and out of reach."""
        name = str(self.facts.name(name))
        with self.batch():
            if name in self.guns:
                self._lose_gun(self.guns[name])
                return
            left = self._leave(self.things[name])
            left.who[0].sensor = None
            self.facts.put("location", str(left.who[0].name), "unknown")
            self._tell("lost", left.who[0], "unknown", *left.told)

    def _lose_gun(self, gun: Gun) -> None:
        gun.accessible = False
        self.facts.put("location", gun.name, "unknown")
        self._tell("lost", gun, "unknown")

    def fix_cardinality(self, place: Atom) -> None:
        """No others are at a place; it takes effect after the matching."""
        with self.batch():
            if self.facts.name(place) not in self._counted:
                self._counted.append(self.facts.name(place))

    def expire(self) -> None:
        """All sensor names go; what was in reach becomes a layer of its set."""
        with self.batch():
            for expected in self.sets.values():
                if expected.local:
                    self._push(expected)
            for thing in self.things.values():
                thing.sensor = None
            for gun in self.guns.values():
                gun.accessible = False
            for thing in list(self.things.values()):
                if self.place(thing) == "unknown":
                    self._forget(thing)

    def assert_fact(self, *fact: Atom) -> None:
        """A fact holds from now on."""
        with self.batch():
            self.facts.put(*fact)

    def erase(self, *prefix: Atom) -> None:
        """Every fact that starts so goes."""
        with self.batch():
            self.facts.erase(prefix)

    # --- names and places ----------------------------------------------------

    def place(self, thing: Thing) -> Atom | None:
        """Where a thing with a name is believed to be."""
        return self.facts.value("location", str(thing.name))

    def _number(self) -> int:
        self._numbers += 1
        return self._numbers

    def _empty(self, kind: str) -> Thing:
        return Thing(self._number(), kind, None, None)

    def _expected(self, kind: str, place: Atom) -> Expected:
        return self.sets.setdefault((kind, place), Expected(kind, place))

    def _push(self, expected: Expected) -> None:
        self._layers += 1
        expected.layers.append(Layer(self._layers, expected.local))
        expected.local = []
        self._fill(expected)

    def _fill(self, expected: Expected) -> None:
        """No layer holds fewer than another, or than are in reach."""
        for layer in expected.layers:
            while len(layer.members) < expected.size:
                layer.members.append(self._empty(expected.kind))

    def _tell(
        self,
        what: str,
        item: Thing | Gun,
        place: Atom,
        other: str | None = None,
        score: float | None = None,
        rival: float | None = None,
    ) -> None:
        sensor = item.sensor if isinstance(item, Thing) else item.reach
        told = (what, str(item.name), sensor, item.kind, place, other, score, rival)
        self.events.append(told)

    # --- the end of a batch --------------------------------------------------

    def _settle(self) -> None:
        busy = True
        while busy:
            while any(self._identify(each) for each in list(self.sets.values())):
                pass
            trimmed = [self._tidy(each) for each in list(self.sets.values())]
            busy = any(trimmed)
        for key, expected in list(self.sets.items()):
            if not expected.size:
                del self.sets[key]

    def _identify(self, expected: Expected) -> bool:
        """Carry out the first match of a set; whether there was one."""
        match = plain_matching.first_match(expected, self.facts)
        if match is None:
            return False
        keep, gone = self._merge(match.one, match.other, None)
        if keep.name and gone.name:
            told = match.score, match.rival
            self._tell("merged", keep, expected.place, gone.name, *told)
        return True

    def _tidy(self, expected: Expected) -> bool:
        """Redundant layers go, then the oldest; whether any of the latter did."""
        kept: list[Layer] = []
        for layer in expected.layers:
            others = [expected.local, *(each.members for each in kept)]
            if not any(set(layer.members) == set(other) for other in others):
                kept.append(layer)
        surplus = max(0, len(kept) - self.declared.max_layers)
        expected.layers = kept[surplus:]
        for layer in kept[:surplus]:
            for thing in layer.members:
                if thing.name and not expected.standing(thing):
                    self._forget(thing)
        return surplus > 0

    def _count(self, place: Atom) -> None:
        place = self.facts.name(place)
        for fact in list(self.facts.stamps):
            gun = self.guns.get(str(fact[1]))
            if gun and not gun.accessible and fact == ("location", gun.name, place):
                self._lose_gun(gun)
        for expected in [each for each in self.sets.values() if each.place == place]:
            for _ in range(expected.size - len(expected.local)):
                self._lose_one(expected)

    def _lose_one(self, expected: Expected) -> None:
        """One too many: an empty item is moved nowhere."""
        nobody = self._empty(expected.kind)
        expected.local.append(nobody)
        left = plain_leaving.leave(nobody, expected, self.facts, self._merge)
        for thing in left.dropped:
            self._forget(thing)
        self._fill(expected)
        for thing in left.who:
            if thing.name:
                self.facts.put("location", thing.name, "unknown")
                self._tell("lost", thing, "unknown", *left.told)

    # --- merging and forgetting ----------------------------------------------

    def _leave(self, thing: Thing) -> plain_leaving.Left:
        expected = self.sets.get((thing.kind, self.place(thing) or "unknown"))
        if expected is None:
            return plain_leaving.Left([thing])
        left = plain_leaving.leave(thing, expected, self.facts, self._merge)
        for other in left.dropped:
            self._forget(other)
        self._fill(expected)
        return left

    def _merge(
        self, one: Thing, other: Thing, mover: Thing | None
    ) -> tuple[Thing, Thing]:
        """Two things are one: who is kept and who is gone. A mover keeps its values."""
        one, other = sorted((one, other), key=lambda each: each.number)
        keep, gone = (other, one) if one.name is None and other.name else (one, other)
        if keep.name and gone.name:
            self._merge_facts(keep, gone, mover)
            del self.things[gone.name]
        keep.sensor = keep.sensor or gone.sensor
        for expected in self.sets.values():
            for view in expected.views():
                view[:] = [keep if each is gone else each for each in view]
        return keep, gone

    def _merge_facts(self, keep: Thing, gone: Thing, mover: Thing | None) -> None:
        stronger = keep if keep.sensor and not gone.sensor else gone
        if mover is not None:
            stronger = mover
        self.facts.merge(
            str(keep.name), str(gone.name), stronger is gone, mover is not None
        )
        for (kind, place), expected in list(self.sets.items()):
            if place == gone.name:
                del self.sets[kind, place]
                self._join(expected, self._expected(kind, str(keep.name)))

    def _join(self, one: Expected, other: Expected) -> None:
        """What was expected in two containers is expected in the one they are."""
        other.local.extend(one.local)
        other.layers.extend(one.layers)
        other.layers.sort(key=lambda layer: layer.serial)
        self._fill(other)

    def _forget(self, thing: Thing) -> None:
        """Nothing is known of a thing any more, nor of what was expected in it."""
        forgotten = [thing]
        for each in forgotten:
            name = str(each.name)
            if self.things.pop(name, None) is None:
                continue
            self.facts.forget(name)
            for key in [key for key in self.sets if key[1] == name]:
                expected = self.sets.pop(key)
                for view in expected.views():
                    forgotten.extend(other for other in view if other.name)
