"""The memory under test and the plain one, each as a side that `pictures` reads."""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.values import Atom, Fact
from rapc.events import ItemEvent
from rapc.library.loader import load_text
from rapc.runtime.memory.recognition.scoring import DescribedItem
from tests.memory.bench import DescriptionView, MemoryBench

from .pictures import Pictured, Read, Side, Told, step_named
from .plain import Plain
from .plain_facts import NEVER
from .plain_parts import Comparator, Declared, Thing


def rap(declared: Declared) -> str:
    """The declarations as RAP text; every property but two has one value each."""
    lines = [
        "(declare-memory-property class (?item ?class ?value) unknown)",
        "(declare-memory-property location (?item ?place) unknown)",
        "(declare-memory-proposition near (?item ?other))",
    ]
    for name in declared.properties:
        if name in ("class", "location"):
            continue
        args = "?item ?other ?value" if name == "contains" else "?item ?value"
        excludes = " ".join(
            f":excludes {value} ({against} ?item ? {forbidden})"
            for owner, value, against, forbidden in declared.excludes
            if owner == name
        )
        lines.append(f"(declare-memory-property {name} ({args}) unknown {excludes})")
    lines += [f"(declare-indistinct-class {kind})" for kind in declared.indistinct]
    for (kind, place), comparator in declared.comparators.items():
        where = "" if place is None else place
        if comparator.function is not None:
            lines.append(f"(declare-class-comparator {kind} {where} in-python-{kind})")
            continue
        rows = [f"(veto {name})" for name in comparator.veto]
        rows += [f"(score {name} {n})" for name, n in comparator.weights.items()]
        rows += [f"(ignore {name})" for name in comparator.ignored]
        lines.append(f"(declare-class-comparator {kind} {where} {' '.join(rows)})")
    return "\n".join(lines)


def _in_python(
    comparator: Comparator,
) -> Callable[[DescribedItem, DescribedItem], float]:
    """The comparator as a library takes it."""

    def compare(one: DescribedItem, other: DescribedItem) -> float:
        assert comparator.function is not None
        return comparator.function(one.properties, other.properties)

    return compare


class UnderTest(Side):
    """The memory of `rapc.runtime.memory`, without an interpreter."""

    def __init__(self, declared: Declared) -> None:
        super().__init__(declared)
        loaded = load_text(rap(declared))
        assert loaded.diagnostics == (), loaded.diagnostics
        functions = {
            f"in-python-{kind}": _in_python(comparator)
            for (kind, _), comparator in declared.comparators.items()
            if comparator.function is not None
        }
        most = declared.max_layers
        self._memory = MemoryBench(loaded.library, functions, max_layers=most)
        self._told = 0

    def memory(self) -> MemoryBench:
        """The memory itself."""
        return self._memory

    def at(self, time: float) -> None:
        """Set the clock."""
        self._memory.time = time

    def now_called(self, name: str) -> Atom:
        """The name that now stands for a name."""
        return self._memory.name(name)

    def sets(self) -> dict[tuple[str, Atom], Pictured]:
        """The expectation sets."""
        return {
            (each.kind, self.label(each.place)): self.pictured(
                [[_read(d) for d in view] for view in (each.local, *each.layers)],
                each.size,
            )
            for each in self._memory.sets()
        }

    def facts(self) -> dict[Fact, float | None]:
        """All facts with their stamps."""
        memory = self._memory.memory
        found: dict[Fact, float | None] = {}
        for name in (*self.declared.properties, "near"):
            args = 3 if name in ("class", "contains") else 2
            for fact in memory.query(name, *[None] * args):
                age = memory.age(*fact)
                stamp = None if age is None else memory.now - age
                found[self.labelled(fact)] = stamp
        return found

    def told(self) -> list[Told]:
        """What was told of items since this was last asked."""
        new = self._memory.events[self._told :]
        self._told += len(new)
        return [self._tell(event) for event in new if isinstance(event, ItemEvent)]

    def _tell(self, event: ItemEvent) -> Told:
        what = type(event).__name__.removeprefix("Item").lower()
        return Told(
            what=what,
            item=str(self.label(event.item)),
            sensor=step_named(event.sensor),
            kind=event.kind,
            place=str(self.label(event.location)),
            other=None if event.with_ is None else str(self.label(event.with_)),
            score=event.score,
            rival=event.rival,
        )


def _read(of: DescriptionView) -> Read:
    return of.number, of.name, of.sensor, tuple(of.properties.items())


class ByHand(Side):
    """The plain memory of this folder."""

    def __init__(self, declared: Declared) -> None:
        super().__init__(declared)
        self._plain = Plain(declared)
        self._seen = 0

    def memory(self) -> Plain:
        """The memory itself."""
        return self._plain

    def at(self, time: float) -> None:
        """Set the clock."""
        self._plain.facts.now = time

    def now_called(self, name: str) -> Atom:
        """The name that now stands for a name."""
        return self._plain.facts.name(name)

    def sets(self) -> dict[tuple[str, Atom], Pictured]:
        """The expectation sets."""
        return {
            (kind, self.label(place)): self.pictured(
                [
                    [self._read(d) for d in view]
                    for view in (each.local, *(layer.members for layer in each.layers))
                ],
                each.size,
            )
            for (kind, place), each in self._plain.sets.items()
        }

    def _read(self, thing: Thing) -> Read:
        found = self._plain.facts.of(thing).items()
        values = tuple((i, (v, _stamp(at))) for i, (v, at) in found)
        return thing.number, thing.name, thing.sensor, values

    def facts(self) -> dict[Fact, float | None]:
        """All facts with their stamps."""
        stamps = self._plain.facts.stamps
        return {self.labelled(fact): _stamp(at) for fact, at in stamps.items()}

    def told(self) -> list[Told]:
        """What was told of items since this was last asked."""
        new = self._plain.events[self._seen :]
        self._seen += len(new)
        return [
            Told(
                what=what,
                item=str(self.label(item)),
                sensor=step_named(sensor),
                kind=kind,
                place=str(self.label(place)),
                other=None if other is None else str(self.label(other)),
                score=score,
                rival=rival,
            )
            for what, item, sensor, kind, place, other, score, rival in new
        ]


def _stamp(at: float) -> float | None:
    return None if at == NEVER else at
