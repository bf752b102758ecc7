"""Codecs: how values in the state of a run are saved, by type, in both directions.

The table `FIELDS` of a state class states the type of each field. A saved object is a
record of these fields, which msgspec encodes. On reading, msgspec validates the form,
and the codecs here validate references. References to tasks are their numbers, to plans
their names and positions. Sets, counters and environments may be shared: they are in
lists of their own, and references to them are positions. References to items are their
memory names, to descriptions of items their numbers.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from operator import attrgetter
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

import msgspec

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Atom, Fact, Number, Text
from rapc.compiler.net_plan import WindowPlan
from rapc.compiler.program import Program
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.compiler.watches import WatchKey
from rapc.runtime.fields import LEFT_OUT, Limit, Natural, Stamp
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.memory.exclusions import Excluded, Exclusions, Past
from rapc.runtime.memory.facts import NEVER, FactStore, FactTable, Mentions, Tables
from rapc.runtime.memory.items import Item, Items, ItemsByName
from rapc.runtime.memory.memory import Memory
from rapc.runtime.memory.notations import Notation
from rapc.runtime.memory.recognition.recognizer import Recognizer
from rapc.runtime.memory.recognition.sets import Description, ExpectationSet, View
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.run_state import RunState
from rapc.runtime.state.states import State
from rapc.runtime.state.task import Ends, Env, MethodRun, Task, TopLevelTask
from rapc.runtime.state.things import Ask, Hold, ThingWait
from rapc.world import Time


class WrongRecordError(Exception):
    """Saved data that no run can have written; the text gives the reason."""


def need(holds: object, wrong: str) -> None:
    """Raise a WrongRecordError with the text `wrong` unless `holds` is true."""
    if not holds:
        raise WrongRecordError(wrong)


class Ref(msgspec.Struct, frozen=True, tag="resource"):
    """A reference to a set or counter: its position in the saved `resources`."""

    at: Natural


class Key(msgspec.Struct, frozen=True, tag="key", omit_defaults=True):
    """A tuple in a detector's key, or a set in the tuple; members in a fixed order."""

    parts: tuple[str | int | float | Text | Key | None, ...]
    is_set: bool = False


Saved = str | int | float | Text | Ref
"""Value of a variable."""


class Writer:
    """The shared values of a saved run, collected while its records are written.

    Args:
        access: the memory of the run, for records of memory and of methods.
    """

    def __init__(self, access: MemoryAccess | None = None) -> None:
        self.access: Any = access
        #: Counters as numbers, sets as their members in the order of arrival.
        self.resources: list[Number | tuple[Atom, ...]] = []
        self.environments: list[dict[str, Saved]] = []
        #: The task whose field is being written.
        self.task: Any = None
        self._places: dict[int, int] = {}

    def environment(self, env: Env) -> int:
        """Return the position of an environment; write the environment on first use."""
        place = self._places.get(id(env))
        if place is None:
            place = self._places[id(env)] = len(self.environments)
            self.environments.append({n: self.value(v) for n, v in env.items()})
        return place

    def value(self, value: Any) -> Any:
        """Return a value in saved form, a resource as its position."""
        if not isinstance(value, Counter | SetResource):
            return value
        place = self._places.get(id(value))
        if place is None:
            place = self._places[id(value)] = len(self.resources)
            if isinstance(value, Counter):
                self.resources.append(value.value)
            else:
                self.resources.append(tuple(value.members))
        return Ref(place)


class Reader:
    """The objects to which saved values refer.

    Args:
        library: the library that names the plans.
        access: a new memory of the library, to be filled.
        resources: the shared sets and counters, as in `Writer`.
        environments: the shared environments.
    """

    def __init__(
        self,
        library: Program,
        access: MemoryAccess,
        resources: tuple[Number | tuple[Atom, ...], ...] = (),
        environments: tuple[dict[str, Saved], ...] = (),
    ) -> None:
        self.library = library
        self.access = access
        #: The items by memory name, and the descriptions by number.
        self.items: dict[str, Item] = {}
        self.descriptions: dict[int, Description] = {}
        #: The class of the items whose expectation set is being read.
        self.kind = ""
        self.state = RunState()
        #: The tasks of the host, in order, once they have been created.
        self.given: Iterator[Task] = iter(())
        #: The live tasks by number.
        self.live: dict[int, Task] = {}
        #: The task whose field is being read.
        self.task: Any = None
        self._resources = [
            SetResource(dict.fromkeys(one)) if isinstance(one, tuple) else Counter(one)
            for one in resources
        ]
        self.environments: list[Env] = [
            {name: self.value(value) for name, value in one.items()}
            for one in environments
        ]

    def value(self, saved: Any) -> Any:
        """Return the value of a saved value."""
        return self._resources[saved.at] if type(saved) is Ref else saved

    def known(self, items: Iterable[Any]) -> dict[str, Item]:
        """Return the items of memory by name, from their records."""
        for record in items:
            described = isinstance(record, fields_of(Description).saved)
            kind = Description if described else Item
            item = fields_of(kind).read(self, record)
            need(item.name not in self.items, "duplicate item")
            self.items[item.name] = item
            if isinstance(item, Description):
                need(item.number not in self.descriptions, "two items have one number")
                self.descriptions[item.number] = item
        return self.items

    def description(self, number: int) -> Description:
        """Return the description with a number, an empty one if no item has it."""
        found = self.descriptions.get(number)
        if found is None:
            found = Description(number, "", "", self.kind)
            self.descriptions[number] = found
        return found

    def any_run(self) -> MethodRun:
        """Return a method under way, as a placeholder."""
        found = [task.run for task in self.live.values() if task.run is not None]
        need(found, "a thing that no method holds")
        return found[0]

    def method(self, index: int) -> MethodPlan:
        """Return a method of the task that is being read."""
        return self.state.methods(self.task.plan)[index]

    def run(self, saved: Any) -> MethodRun:
        """Return the method under way of the task that is being read."""
        plan, env = self.method(saved.plan), self.environments[saved.env]
        method_run = MethodRun(self.task, plan, env, saved.started)
        need((method_run.ends is None) == (saved.ends is None), "times of steps")
        fields_of(MethodRun).fill(self, method_run, saved)
        return method_run


# --- the table ----------------------------------------------------------------------


_tuple: Any = tuple


class Codec(NamedTuple):
    """The codec of a type: its saved type, and functions to write and to read.

    Without `write`, or without `read`, the value is unchanged.
    """

    saved: Any
    write: Callable[[Writer, Any], Any] | None = None
    read: Callable[[Reader, Any], Any] | None = None

    @property
    def written(self) -> Callable[[Writer, Any], Any]:
        """Return the function that writes a value."""
        return self.write or _same

    @property
    def made(self) -> Callable[[Reader, Any], Any]:
        """Return the function that makes a value from a saved value."""
        return self.read or _same


def _same(_: object, value: Any) -> Any:
    return value


def _in_force(writer: Writer, notations: tuple[Notation, ...]) -> tuple[Fact, ...]:
    return tuple(writer.access.memory.notations.facts(notations)) if notations else ()


def _noted(reader: Reader, facts: tuple[Fact, ...]) -> tuple[Notation, ...]:
    return reader.access.memory.notations.note(facts) if facts else ()


def _stamps(_: Reader, saved: tuple[tuple[Fact, Any], ...]) -> dict[Fact, float]:
    found = {fact: NEVER if time is None else time for fact, time in saved}
    need(len(found) == len(saved), "duplicate fact")
    return found


def _past(reader: Reader, saved: tuple[Past, ...]) -> dict[Excluded, Past]:
    """Return the last assertions of facts, by all that these exclude."""
    exclusions = reader.access.memory.exclusions
    assert exclusions is not None
    found = {exclusions.excluded(fact): (fact, time) for fact, time in saved}
    need(len(found) == len(saved), "two last assertions")
    return found


def _item(writer: Writer, item: Item) -> Any:
    """Return the record of an item or of a description."""
    kind: Any = type(item)
    return fields_of(kind).write(writer, item)


def _set(reader: Reader, saved: Any) -> ExpectationSet:
    """Return a set whose views are to be read."""
    reader.kind = saved.kind
    return ExpectationSet(saved.kind, saved.place)


def _sets(reader: Reader, saved: Any) -> dict[tuple[str, Atom], ExpectationSet]:
    """Return the table of sets of the new memory, filled."""
    sets, record = reader.access.recognizer.sets, fields_of(ExpectationSet)
    for one in saved:
        sets[one.kind, one.place] = record.read(reader, one)
    need(len(sets) == len(saved), "duplicate set")
    return sets


def _tables(reader: Reader, saved: Any) -> Tables:
    """Return the table of facts of the new memory, filled."""
    tables, record = reader.access.memory.facts.tables, fields_of(FactTable)
    for name, one in saved:
        tables[name] = record.read(reader, one)
    need(len(tables) == len(saved), "duplicate table")
    return tables


def _part_of(reader: Reader, name: str) -> Any:
    """Return a part that only memories of some libraries have."""
    found = getattr(reader.access.memory, name)
    need(found is not None, f"{name} of a library without any")
    return found


def _live(task: Task | None) -> int | None:
    """Return the number of a task or, if ended, of its nearest live ancestor."""
    while task is not None and not task.live:
        task = task.parent
    return None if task is None else task.number


def _key(part: Any) -> Any:
    """Return a part of a detector's key in saved form."""
    if isinstance(part, tuple):
        return Key(tuple([_key(one) for one in part]))
    if isinstance(part, frozenset):
        ordered = sorted(part, key=lambda m: (type(m).__name__, str(m)))
        return Key(tuple(ordered), is_set=True)
    return part


def _part(saved: Any) -> Any:
    if type(saved) is not Key:
        return saved
    parts = [_part(one) for one in saved.parts]
    return frozenset(parts) if saved.is_set else tuple(parts)


_STATES: dict[str, str] = {state: state for state in get_args(State)}

CODECS: dict[Any, Codec] = {
    Limit: Codec(Time | None, None, lambda _, it: math.inf if it is None else it),
    RapPlan: Codec(str, lambda _, it: it.name, lambda r, it: r.library.known_rap(it)),
    MethodPlan: Codec(Natural, lambda _, it: it.index, Reader.method),
    WindowPlan: Codec(
        Natural,
        lambda w, it: w.task.step.windows.index(it),
        lambda r, it: r.task.step.windows[it],
    ),
    Task: Codec(int, lambda _, it: it.number, lambda r, it: r.live[it]),
    Task | None: Codec(
        int | None,
        lambda _, it: _live(it),
        lambda r, it: None if it is None else r.live[it],
    ),
    # the loop compares states by identity
    State: Codec(State, None, lambda _, it: _STATES[it]),
    Env: Codec(Natural, Writer.environment, lambda r, it: r.environments[it]),
    Value: Codec(Saved, Writer.value, Reader.value),
    Value | None: Codec(Saved | None, Writer.value, Reader.value),
    tuple[WatchKey, ...] | None: Codec(
        bool, lambda _, it: it is not None, lambda _, it: () if it else None
    ),
    tuple[object, ...]: Codec(Key, lambda _, it: _key(it), lambda _, it: _part(it)),
    dict[int, Task]: Codec(
        tuple[int, ...],
        lambda _, it: tuple(sorted(it)),
        lambda r, it: {number: r.live[number] for number in it},
    ),
    Ask: Codec(tuple[tuple[Atom, ...], int, bool], None, lambda _, it: Ask(*it)),
    tuple[Notation, ...]: Codec(tuple[Fact, ...], _in_force, _noted),
    # JSON has no negative infinity: it is written as null
    dict[Fact, Stamp]: Codec(
        tuple[tuple[Fact, Time | None], ...], lambda _, it: tuple(it.items()), _stamps
    ),
    dict[Excluded, Past]: Codec(
        tuple[Past, ...], lambda _, it: tuple(it.values()), _past
    ),
    ItemsByName: Codec(
        tuple[tuple[str, str], ...],
        lambda w, it: tuple(
            [
                (key, item.name)
                for key, item in it.items()
                if item.name in w.access.memory.items.known
            ]
        ),
        lambda r, it: {key: r.items[name] for key, name in it},
    ),
    Description: Codec(Natural, lambda _, it: it.number, Reader.description),
    dict[ExpectationSet, None]: Codec(
        tuple[tuple[str, Atom], ...],
        lambda w, it: tuple(
            [
                key
                for one in it
                if w.access.recognizer.sets.get(key := (one.kind, one.place)) is one
            ]
        ),
        lambda r, it: {r.access.recognizer.sets[key]: None for key in it},
    ),
}
"""The codecs of types that are more than data; those of memory with parts are below."""


@cache
def codec(kind: Any) -> Codec:
    """Return the codec of a type.

    Raises:
        TypeError: for a type without a codec.
    """
    if kind in CODECS:
        return CODECS[kind]
    if hasattr(kind, "FIELDS"):
        found = fields_of(kind).codec
        return found._replace(read=Reader.run) if kind is MethodRun else found
    if get_origin(kind) in (Annotated, Literal) or _is_data(kind):
        return Codec(kind)
    return _composed(kind, get_origin(kind), get_args(kind))


def _composed(kind: Any, origin: Any, args: tuple[Any, ...]) -> Codec:
    """Return the codec of a type with parts."""
    parts = [codec(arg) for arg in args if arg not in (None, NoneType, ...)]
    if origin is dict:
        return _of_dict(*parts) if len(parts) == 2 else _of_keys(*parts)
    if origin is set:
        return Codec(
            _tuple[*args, ...], lambda _, it: sorted(it), lambda _, it: set(it)
        )
    if parts and not any(part.write or part.read for part in parts):
        return Codec(kind)
    if origin in (Union, UnionType) and len(parts) == 1:
        return _of_optional(*parts)
    if origin in (tuple, list) and len(parts) == 1:
        return _of_row(origin, *parts)
    if origin is tuple:
        return _of_tuple(parts)
    raise TypeError(f"no codec for {kind}")


def _is_data(kind: Any) -> bool:
    """Return whether msgspec writes and reads values of a type unchanged."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return True
    return kind in (bool, int, float, str, bytes)


def _of_optional(part: Codec) -> Codec:
    write, read = part.written, part.made
    return Codec(
        part.saved | None,
        lambda w, it: None if it is None else write(w, it),
        lambda r, it: None if it is None else read(r, it),
    )


def _of_row(made: Any, part: Codec) -> Codec:
    write, read = part.written, part.made
    return Codec(
        _tuple[part.saved, ...],
        lambda w, it: tuple([write(w, one) for one in it]),
        lambda r, it: made([read(r, one) for one in it]),
    )


def _of_tuple(parts: list[Codec]) -> Codec:
    return Codec(
        _tuple[*[part.saved for part in parts]],
        lambda w, it: tuple([p.written(w, v) for p, v in zip(parts, it, strict=True)]),
        lambda r, it: tuple([p.made(r, v) for p, v in zip(parts, it, strict=True)]),
    )


def _of_dict(key: Codec, value: Codec) -> Codec:
    """Return the codec of a table: pairs, those with number keys in order."""

    def write(writer: Writer, table: Any) -> Any:
        pairs = sorted(table.items()) if key.saved is int else table.items()
        return tuple(
            [(key.written(writer, k), value.written(writer, v)) for k, v in pairs]
        )

    def read(reader: Reader, pairs: Any) -> Any:
        made = {key.made(reader, k): value.made(reader, v) for k, v in pairs}
        need(len(made) == len(pairs), "duplicate key in a table")
        return made

    return Codec(_tuple[_tuple[key.saved, value.saved], ...], write, read)


def _of_keys(key: Codec) -> Codec:
    """Return the codec of a table without values: its keys in their order."""
    write = key.written if key.write else None
    read = key.made if key.read else None

    def made(reader: Reader, keys: Any) -> Any:
        given = keys if read is None else [read(reader, one) for one in keys]
        found = dict.fromkeys(given)
        need(len(found) == len(keys), "duplicate key in a table")
        return found

    return Codec(
        _tuple[key.saved, ...],
        lambda w, it: tuple(it) if write is None else tuple([write(w, k) for k in it]),
        made,
    )


_MADE: dict[Any, Callable[[Reader, Any], Any]] = {
    MemoryAccess: lambda r, _: r.access,
    Memory: lambda r, _: r.access.memory,
    FactStore: lambda r, _: r.access.memory.facts,
    FactTable: lambda _r, _: FactTable(None),
    Items: lambda r, _: r.access.memory.items,
    Item: lambda _, it: Item(it.name, it.sensor, it.kind),
    Description: lambda _, it: Description(it.number, it.name, it.sensor, it.kind),
    Mentions: lambda r, _: _part_of(r, "mentions"),
    Exclusions: lambda r, _: _part_of(r, "exclusions"),
    Recognizer: lambda r, _: r.access.recognizer,
    ExpectationSet: _set,
    View: lambda _, it: View(0, it.serial),
    Agenda: lambda _r, _: Agenda(random.Random()),
    Activation: lambda _r, it: Activation(it.ticket, it.owner, None, None, ()),
    Ends: lambda _, it: Ends(len(it.times)),
    Hold: lambda r, _: Hold(r.any_run(), Ask((), 0, False), None),
    ThingWait: lambda r, it: ThingWait(r.live[it.task], (), "", 0),
    TopLevelTask: lambda r, _: TopLevelTask(next(r.given), False),
}
"""Factories of objects that take arguments; saved fields are set afterwards."""


# --- records ------------------------------------------------------------------------


class Record:
    """The saved fields of a state class, and the record that holds them."""

    def __init__(self, kind: Any) -> None:
        self._kind = kind
        codecs = {
            name: codec(saved_as)
            for name, saved_as in kind.FIELDS.items()
            if saved_as != LEFT_OUT
        }
        self.saved = msgspec.defstruct(
            kind.__name__,
            [(name.lstrip("_"), one.saved) for name, one in codecs.items()],
            frozen=True,
            # a table of items has records of two classes
            tag=kind.__name__.lower() if issubclass(kind, Item) else None,
        )
        get = attrgetter(*codecs)
        self._get = get if len(codecs) > 1 else lambda made: (get(made),)
        self._writes = [
            (at, one.write) for at, one in enumerate(codecs.values()) if one.write
        ]
        self._reads = [(name, one.read) for name, one in codecs.items()]
        self.codec = Codec(self.saved, self.write, self.read)

    def write(self, writer: Writer, made: Any) -> Any:
        """Return the record of an object."""
        values = list(self._get(made))
        for at, write in self._writes:
            values[at] = write(writer, values[at])
        return self.saved(*values)

    def read(self, reader: Reader, saved: Any) -> Any:
        """Return an object with the fields of a record."""
        new = _MADE.get(self._kind)
        made = self._kind() if new is None else new(reader, saved)
        return self.fill(reader, made, saved)

    def fill(self, reader: Reader, made: Any, saved: Any) -> Any:
        """Set the fields of an object from a record, in order; return the object."""
        values = msgspec.structs.astuple(saved)
        for (name, read), value in zip(self._reads, values, strict=True):
            setattr(made, name, value if read is None else read(reader, value))
        return made


fields_of = cache(Record)

_TABLE, _SET = fields_of(FactTable), fields_of(ExpectationSet)

CODECS |= {
    Tables: Codec(
        _tuple[_tuple[Atom, _TABLE.saved], ...],
        lambda w, it: tuple(
            [
                (name, _TABLE.write(w, it[name]))
                for name in sorted(name for name, table in it.items() if table.stamps)
            ]
        ),
        _tables,
    ),
    dict[str, Item]: Codec(
        _tuple[fields_of(Item).saved | fields_of(Description).saved, ...],
        lambda w, it: tuple([_item(w, one) for one in it.values()]),
        Reader.known,
    ),
    dict[tuple[str, Atom], ExpectationSet]: Codec(
        _tuple[_SET.saved, ...],
        lambda w, it: tuple([_SET.write(w, one) for one in it.values()]),
        _sets,
    ),
}
