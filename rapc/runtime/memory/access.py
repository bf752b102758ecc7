"""The interface of memory for handlers, hosts, functions and solvers [T A.3-A.5]."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

from rapc.base import source
from rapc.base.values import Atom, Fact, format_list
from rapc.errors import FactError
from rapc.events import ItemEvent, ItemIntroduced, ItemLost, ItemMoved
from rapc.ir.nodes import Formula
from rapc.language.atoms import need_atoms, need_fact
from rapc.library.library import Library
from rapc.library.signatures import Signatures, kind_tests
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.fields import LEFT_OUT, Fields
from rapc.runtime.memory.facts import NEVER
from rapc.runtime.memory.items import Item
from rapc.runtime.memory.memory import (
    EXTERNAL,
    Memory,
    Observer,
    check_prefix,
    in_one_form,
)
from rapc.runtime.memory.recognition.recognizer import MAX_LAYERS, Recognizer
from rapc.runtime.memory.recognition.scoring import Comparator, Scores
from rapc.runtime.memory.recognition.sets import UNKNOWN, Description, ExpectationSet
from rapc.world import DatumHandler, Time

_BY_HANDLERS = ("class", "location")
"""An introduced item in `introduce`, `move` and `lose`."""


Answers = Callable[[str | Formula, Mapping[str, Atom] | None], list[dict[str, Any]]]
"""A function that returns all solutions of a formula with some variables bound."""

Evidence = dict[Fact, Time | None]
"""Facts in memory, each with the time of its last assertion; None if unknown."""

Pattern = tuple[Any, ...]
"""A fact with None for each unknown value."""


class MemoryView:
    """Read access to memory, for functions, default functions and solvers."""

    def __init__(self, memory: Memory, recorder: Recorder) -> None:
        self._memory = memory
        self._recorder = recorder

    @property
    def now(self) -> Time:
        """Return the time of the clock."""
        return self._recorder.time

    @property
    def place(self) -> Atom | None:
        """Return the robot's own place: the last argument of `arrive`."""
        return self._memory.place

    def __iter__(self) -> Iterator[Fact]:
        """Yield all facts, name by name, the oldest of each name first."""
        return iter(self._memory.facts)

    def __contains__(self, fact: object) -> bool:
        """Return whether memory contains a fact."""
        return fact in self._memory.facts

    def names(self) -> list[str]:
        """Return the names of the facts in memory, sorted."""
        tables = self._memory.facts.tables.items()
        return sorted(str(name) for name, table in tables if table.stamps)

    def facts(self, name: str) -> dict[Fact, Time | None]:
        """Return the facts of a name, oldest first, each with its time as `since`."""
        need_atoms((name,), "the name of a fact")
        return {f: self.since(f) for f in self._memory.facts.table(name).stamps}

    def since(self, fact: Fact) -> Time | None:
        """Return the time of a fact's last assertion; None if nobody asserted it."""
        need_fact(fact, "the fact")
        stamp = self._memory.facts.stamp(fact)
        return None if stamp is None or stamp == NEVER else stamp

    def items(self) -> tuple[Item, ...]:
        """Return the items in memory, in the order of their introduction."""
        return tuple(self._memory.items.known.values())

    def names_of(self, item: str) -> set[str]:
        """Return all names of an item; several if items were recognised as one."""
        items = self._memory.items
        kept = items.canonical(item)
        return {str(kept), *(n for n in items.aliases if items.canonical(n) == kept)}

    def canonical(self, pattern: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return a fact or a pattern with the kept names of items."""
        return self._memory.canonical(pattern)

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """Return the facts that match, oldest first; None matches anything.

        The method ignores defaults, and matches `external` only as the stored symbol.
        """
        try:
            return self._memory.facts.matching(self._memory.canonical(pattern))
        except (IndexError, TypeError):
            need_atoms(pattern, "the pattern")
            raise

    def value(self, *index: Atom) -> Atom | None:
        """Return the asserted value of a property for an index, or None."""
        try:
            fact = self._memory.facts.asserted(self._memory.canonical(index))
        except (IndexError, TypeError):
            need_atoms(index, "the property")
            raise
        return None if fact is None else fact[-1]

    def count(self, kind: str, place: Atom) -> int:
        """Return how many items of a class memory expects at a place [T 2.3.3].

        For an indistinct class the number is the size of its expectation set.
        """
        memory = self._memory
        try:
            here = memory.place if place == EXTERNAL else None
            size = memory.expected_at(
                kind, memory.items.canonical(place if here is None else here)
            )
            if size is not None:
                return size
            known = memory.items.known
            found = [known.get(str(fact[1])) for fact in memory.facts_at(place)]
        except TypeError:
            need_atoms((kind, place), "the count")
            raise
        return sum(1 for item in found if item is not None and item.kind == kind)

    def kind(self, item: Atom) -> str | None:
        """Return the introducing class of an item; None for a plain symbol."""
        found = self._memory.items.known.get(str(self._memory.items.canonical(item)))
        return None if found is None else found.kind

    def spread(self, name: str, *places: int) -> float:
        """Return the mean number of facts that agree in the arguments at `places`.

        Only facts of the predicate `name` count. Argument positions start at 1.
        Without positions, return the number of these facts.
        """
        need_atoms((name, *places), "the facts")
        facts = self._memory.facts.table(name).stamps
        kinds = {tuple([fact[at : at + 1] for at in places]) for fact in facts}
        return len(facts) / len(kinds) if kinds else 0

    def age(self, *fact: Atom) -> Time | None:
        """Return the time units since a fact was last asserted, or None."""
        try:
            since = self.since(self._memory.canonical(fact))
        except (IndexError, TypeError):
            need_atoms(fact, "the fact")
            raise
        return None if since is None else self.now - since


class MemoryBatch:
    """A group of changes of memory; made by `MemoryAccess.batch`."""

    __slots__ = ("_access", "_depth")

    def __init__(self, access: MemoryAccess) -> None:
        self._access = access
        self._depth = 0

    def __enter__(self) -> None:
        self._depth += 1

    def __exit__(self, kind: object, *_: object) -> None:
        self._depth -= 1
        if self._depth == 0 and kind is None:
            self._access.end_batch()


class MemoryAccess(MemoryView):
    """Write access to memory, for handlers: the `HandlerMemory` of `rapc.world`.

    Handlers receive this object, a host and the interpreter use it; `memory` is the
    memory behind it. A new object has no observers of memory.

    Args:
        library: the linked library.
        signatures: the declarations of the library.
        recorder: receives the events about facts and items.
        comparators: every comparator in Python that the library names.
        max_layers: how many layers an expectation set keeps.
    """

    FIELDS: ClassVar[Fields] = {
        "memory": Memory,
        "recognizer": Recognizer,
        "closing": LEFT_OUT,
        "answers": LEFT_OUT,
        "_memory": LEFT_OUT,
        "_recorder": LEFT_OUT,
        "_files": LEFT_OUT,
        "_counted": LEFT_OUT,
        "_of_kinds": LEFT_OUT,
        "_batch": LEFT_OUT,
    }

    def __init__(
        self,
        library: Library,
        signatures: Signatures,
        recorder: Recorder,
        comparators: Mapping[str, Comparator],
        max_layers: int = MAX_LAYERS,
    ) -> None:
        classes = library.indistinct
        sets: dict[tuple[str, Atom], ExpectationSet] = {}
        declared = library.properties.values()
        memory = Memory(signatures, recorder, declared, classes, sets)
        super().__init__(memory, recorder)
        view = MemoryView(memory, recorder)
        scores = Scores(classes.values(), library.comparators, comparators, view)
        self._files = library.files
        self.memory = memory
        self.recognizer = Recognizer(
            memory, recorder, tuple(classes), scores, max_layers, sets
        )
        self._counted: dict[Atom, None] = {}
        #: The tests of the arguments of facts with declared kinds, by the facts' name.
        self._of_kinds = kind_tests(signatures.kinds, signatures.relations)
        self._batch = MemoryBatch(self)
        #: A check before the end of a batch; `rapc.strict` sets it.
        self.closing: list[Callable[[], None]] = []
        #: The evaluation of handlers' queries; the interpreter sets it.
        self.answers: Answers | None = None

    def observe(self, *others: Observer) -> None:
        """Register all observers of memory: the recogniser, then `others`.

        Only this method registers observers of memory. Without indistinct classes the
        method registers no recogniser.
        """
        first = () if self.memory.mentions is None else (self.recognizer,)
        self.memory.observe(*first, *others)

    def ask(
        self, formula: str | Formula, given: Mapping[str, Atom] | None = None
    ) -> list[dict[str, Any]]:
        """Return all solutions of a formula: see `HandlerMemory.ask`.

        Raises:
            ValueError: for an invalid formula, or a query of undeclared names.
        """
        if self.answers is None:
            raise ValueError("a formula can be evaluated only in a run")
        return self.answers(formula, given)

    def batch(self) -> MemoryBatch:
        """Return a batch of changes (as the data of one result) for a `with` statement.

        The end of the batch recognises items, then removes surplus items from the
        places where all accessible items are known. An inner batch is a part of the
        outer one.
        """
        return self._batch

    def end_batch(self) -> None:
        """End the outermost batch: recognise items, and lose the unseen items."""
        while self.closing:
            self.closing.pop(0)()
        self.recognise()
        while self._counted:
            place = next(iter(self._counted))
            del self._counted[place]
            place = self._memory.items.canonical(place)
            self._lose_others(place)
            self.recognizer.fix(place)
            self.recognise()

    def drop_batch(self) -> None:
        """Discard the outstanding work of a batch that was aborted."""
        self._counted.clear()
        self.closing.clear()

    def receive(self, content: Fact, handlers: Mapping[str, DatumHandler]) -> Fact:
        """Pass a datum to its handler; return the datum in memory names."""
        items = self._memory.items
        if items.by_sensor:
            content = items.named(content)
        handlers[str(content[0])](self, content)
        return content

    def take_up(self, other: MemoryAccess) -> None:
        """Replace the memory by the memory behind `other`, of the same library."""
        self.drop_batch()
        self.memory.take_up(other.memory)
        self.recognizer.take_up(other.recognizer)

    def recognise(self) -> None:
        """Recognise items, if a description has changed."""
        if self.recognizer.unsettled:
            self.recognizer.settle()

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact now, with all of its arguments.

        Raises:
            FactError: as `assert_for`, and for a property without its value.
        """
        self.assert_for("handler", fact, whole=True)

    def erase(self, *prefix: Atom) -> None:
        """Erase all facts that start with `prefix`. Raises FactError as `erase_for`."""
        self.erase_for("handler", prefix)

    def assert_for(self, by: str, fact: Fact, *, whole: bool = False) -> None:
        """Assert a fact now, on behalf of `by`: a handler or the host.

        With `whole` the value `true` of a property may not be omitted.

        Raises:
            FactError: if the declarations do not allow the fact, or if the fact is
                an item's place or introducing class.
        """
        memory, given = self._memory, fact
        fact = memory.checked(given)
        if whole and len(fact) != len(given):
            relation = memory.signatures.relations[str(fact[0])]
            at = source.place(relation.span, self._files)
            said = f"{format_list(given)} has no value for `{relation.written}`"
            raise FactError(
                f"{said}, declared at {at}; a handler must state all arguments"
            )
        if fact[0] in self._of_kinds:
            self.check_kinds(fact)
        if fact[0] in _BY_HANDLERS:
            self.check_owner(fact)
        memory.store(fact, by)

    def checked(self, fact: Fact) -> Fact:
        """Return a fact from outside in the form in which memory stores it.

        Raises:
            FactError: if the declarations do not allow the name, the number of
                arguments, or their kinds.
        """
        fact = self._memory.checked(fact)
        self.check_kinds(fact)
        return fact

    def check_kinds(self, fact: Fact) -> None:
        """Raise a FactError if a fact has arguments of a wrong kind."""
        for at, holds in self._of_kinds.get(fact[0], ()):
            if not holds(fact[at]):
                signatures = self._memory.signatures
                wrong = signatures.wrong_kind("asserted", str(fact[0]), fact[1:])
                raise FactError(f"{format_list(fact)}: {wrong}")

    def erase_for(self, by: str, prefix: Fact) -> None:
        """Erase every fact that starts with `prefix`, on behalf of `by`.

        Raises:
            FactError: if the prefix has an undeclared name, or as `assert_for`.
        """
        memory = self._memory
        if prefix and prefix[0] in _BY_HANDLERS:
            self.check_owner(memory.canonical(prefix))
        check_prefix(prefix, memory.signatures.relations)
        if memory.items.aliases:
            prefix = memory.canonical(prefix)
        for fact in memory.facts.starting(prefix):
            memory.remove(fact, by)

    def check_owner(self, fact: Fact) -> None:
        """Refuse a fact, or a prefix of a fact, that only this class itself may set.

        Raises:
            FactError: for the place or the introducing class of an introduced item,
                which `introduce`, `move` and `lose` set.
        """
        known = self._memory.items.known
        if not known:
            return
        if len(fact) == 1:
            facts = self._memory.facts.starting(fact)
            items = [known.get(str(found[1])) for found in facts]
        else:
            items = [known.get(str(fact[1]))]
        for item in items:
            other = fact[0] == "class" and len(fact) > 2 and item is not None
            if item is not None and not (other and fact[2] != item.kind):
                raise FactError(
                    f"{format_list(fact)}: an introduced item's location and class "
                    "are set by `introduce`, `move` and `lose`"
                )

    def introduce(self, sensor_name: str, kind: str, place: Atom) -> str:
        """Register an item that is seen: see `HandlerMemory.introduce`."""
        memory = self._memory
        place = self._stored(place)
        in_one_form(sensor_name)
        if self.recognizer.recognises(kind):
            return self.recognizer.introduce(sensor_name, kind, place).name
        item, news = memory.items.introduce(sensor_name, kind)
        before = self.value("location", item.name)
        self._set("class", item.name, item.kind, "true")
        self._set("location", item.name, place)
        if news:
            memory.tell("know-sensor-name")
            self._tell(ItemIntroduced, item, place)
        elif before != place:
            self._tell(ItemMoved, item, place)
        return item.name

    def move(self, item: str, place: Atom) -> None:
        """Put an accessible item at `place`; the item stays accessible.

        Raises:
            FactError: for a name that no handler introduced.
        """
        known = self._introduced(item)
        place = self._stored(place)
        if isinstance(known, Description):
            self.recognizer.move(known, place)
            return
        before = self.value("location", known.name)
        self._set("location", known.name, place)
        if before != place:
            self._tell(ItemMoved, known, place)

    def lose(self, item: str) -> None:
        """Set the place of an item to `unknown`. Raises FactError as `move`."""
        known = self._introduced(item)
        if isinstance(known, Description):
            self.recognizer.lose(known)
            return
        self._memory.items.put_out_of_reach(known)
        self._memory.tell("know-sensor-name")
        self._set("location", known.name, UNKNOWN)
        self._tell(ItemLost, known, UNKNOWN)

    def fix_cardinality(self, place: Atom) -> None:
        """Lose all items at `place` that are not accessible at the end of the batch.

        The items believed at the place and not accessible then get the place `unknown`.
        """
        with self.batch():
            self._counted[self._stored(place)] = None

    def _lose_others(self, place: Atom) -> None:
        for fact in self._memory.facts.matching(("location", None, place)):
            item = self._memory.items.known.get(str(fact[1]))
            if item is None or item.accessible or isinstance(item, Description):
                continue
            self.lose(item.name)

    def expire(self) -> None:
        """Forget all sensor names, because the robot has moved."""
        reached = bool(self._memory.items.accessible())
        self.recognizer.expire()
        if reached:
            self._memory.tell("know-sensor-name")

    def arrive(self, place: Atom) -> None:
        """Set the place of the robot, which `external` denotes from now on.

        Raises:
            FactError: for a value that is no symbol, number or string.
        """
        self._memory.arrive(self._memory.items.canonical(in_one_form(place)))

    def _introduced(self, item: str) -> Item:
        known = self._memory.items.known.get(str(self._memory.items.canonical(item)))
        if known is None:
            raise FactError(f"no handler has introduced an item `{item}`")
        return known

    def _stored(self, place: Atom) -> Atom:
        if place == EXTERNAL and self._memory.place is not None:
            return self._memory.place
        return self._memory.items.canonical(in_one_form(place))

    def _set(self, *fact: Atom) -> None:
        self._memory.store(self.checked(fact), "handler")

    def _tell(self, kind: type[ItemEvent], item: Item, place: Atom) -> None:
        if self._recorder.on:
            self._recorder.emit(
                kind,
                item=item.name,
                sensor=item.sensor if item.accessible else None,
                kind=item.kind,
                location=place,
            )
