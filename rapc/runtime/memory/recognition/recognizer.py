"""The memory that recognises items: items come, go, and merge [T 2.3, A.5].

A robot that comes back sees a drum under another sensor name. Which of the remembered
drums is it? Memory compares the known properties of the drums, and waits where the
comparison does not decide. docs/explanation/memory.md describes the rules; this text
describes the implementation.

*Descriptions.* Each introduced item of an indistinct class gets a description: a memory
name (`item-7`), a sensor name as long as the item is in reach, and its properties,
which are the facts of memory about that name. One item may have several descriptions
until memory recognises them as one.

*Sets and views.* The descriptions of one class at one place form an expectation set. An
expectation set consists of views. The local model holds the items in reach now; when
the robot leaves (`expire`), the local model becomes a layer. Members of one view are
different items: the robot saw them side by side. Members of two views may be the same
item. All layers of a set hold as many descriptions as items are expected. If the robot
saw fewer, empty descriptions fill the layer; an empty description only states that an
item is there.

*Matching* (`matching`, `candidates`, `scoring`). After every change of a set, memory
compares each description `x` of a view with the candidates of each other view.
Candidates out of reach with equal known properties form a group. If one group alone has
the highest score with `x`, and has room for all descriptions with as high a score on
the group, `x` is a member of that group: memory merges the two descriptions. Of several
matches the match with the highest score comes first. After a merge the search starts
again, because one identification rules out others. A tie waits.

*Merging* (`merging`). The older name stays. Memory rewrites the facts about the younger
name, with their stamps; where two values disagree, the newer value stays. If the item
is a container, memory joins the sets of the items expected in the container, their
layers oldest first.

*Departure* (`departure`). An item that moves away or is lost leaves its set by one
description in every layer. If several descriptions may be the item, memory makes a
smallest collection with a member of each candidate group alike: properties that its
members do not share become `unknown`. Then each layer loses one of the members.

*Forgetting* (`_tidy`, `_forget`). Memory drops a layer that is equal to another layer,
and the oldest layer if there are more than `max_layers`. Memory also drops descriptions
that are then in no view, and lost descriptions at the next expiry.

An example, the empty boxes of [T 2.3.2]. In a warehouse the robot saw two boxes:
`item-1`, red, big and empty, and `item-2`, red, small, with bars in it. The robot left,
and the set has one layer {item-1, item-2}. The robot comes back and sees two boxes,
both empty: the local model is {item-3, item-4}. The comparator for boxes in this place
ignores `is-empty`, because the property changes. Each new box scores 10, for its class,
with each old box: a tie, and no merge. Then the robot looks closer: `item-3` is big.
`item-3` scores 20 with `item-1` and 10 with `item-2`: one group alone is best, and
`item-3` is `item-1`. This leaves `item-4` with one candidate: it is `item-2`, at a
score of 10. When merging them, memory finds "empty", with the present stamp, and
"contains bars", with an earlier stamp. The two facts exclude each other and the newer
stays: the bars are gone. `item-2` is still red and small, as the robot saw it. The
layer then states nothing that the local model does not state, and is dropped.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import ClassVar

from rapc.base.values import Atom, Fact
from rapc.events import ItemIntroduced, ItemLost, ItemMoved
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.fields import LEFT_OUT, Fields, Natural
from rapc.runtime.memory.facts import PREFIX, Mentions
from rapc.runtime.memory.memory import REPLACED, STORED, Memory
from rapc.runtime.memory.recognition import departure, merging
from rapc.runtime.memory.recognition.item_events import ItemEvents
from rapc.runtime.memory.recognition.matching import Match, best_match
from rapc.runtime.memory.recognition.scoring import Scores
from rapc.runtime.memory.recognition.sets import (
    UNKNOWN,
    Description,
    ExpectationSet,
    View,
)

MAX_LAYERS = 8
"""The default number of layers that a set keeps."""


class Recognizer:
    """The expectation sets, with all operations that change them.

    Args:
        memory: the memory whose facts the descriptions are of.
        recorder: receives the events about items.
        classes: the indistinct classes.
        scores: their comparators.
        max_layers: how many layers a set keeps after an expiry, at least 1.
        sets: a table for the expectation sets, if other parts read them.
    """

    FIELDS: ClassVar[Fields] = {
        "number": Natural,
        "layers": Natural,
        "sets": dict[tuple[str, Atom], ExpectationSet],
        "unsettled": dict[ExpectationSet, None],
        "lost": dict[Description, None],
        "renamed": LEFT_OUT,
        "_memory": LEFT_OUT,
        "_mentions": LEFT_OUT,
        "_item_events": LEFT_OUT,
        "_classes": LEFT_OUT,
        "_scores": LEFT_OUT,
        "_max_layers": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(
        self,
        memory: Memory,
        recorder: Recorder,
        classes: Collection[str] = (),
        scores: Scores | None = None,
        max_layers: int = MAX_LAYERS,
        sets: dict[tuple[str, Atom], ExpectationSet] | None = None,
    ) -> None:
        self.sets: dict[tuple[str, Atom], ExpectationSet] = {} if sets is None else sets
        #: Called after a merge, with the removed and the kept name, once the facts have
        #: been rewritten: tasks that hold the removed name have to change too.
        self.renamed: Callable[[str, str], None] = lambda lost, kept: None
        self._memory = memory
        self._mentions = memory.mentions or Mentions()
        self._item_events = ItemEvents(recorder)
        self._classes = frozenset(classes)
        self._scores = scores or Scores((), (), {})
        self._max_layers = max_layers
        #: The number of the youngest description, and the number of the latest layer.
        self.number = self.layers = 0
        #: The sets that have changed since the last settling.
        self.unsettled: dict[ExpectationSet, None] = {}
        #: The descriptions with an unknown place: the next expiry forgets them.
        self.lost: dict[Description, None] = {}

    def recognises(self, kind: str) -> bool:
        """Return whether items of a class are recognised by comparison."""
        return kind in self._classes

    def take_up(self, other: Recognizer) -> None:
        """Replace the expectation sets by those of another recogniser."""
        self.number, self.layers = other.number, other.layers
        self.sets.clear()
        self.sets.update(other.sets)
        for home in self.sets.values():
            home.settle()
        self.unsettled.clear()
        self.unsettled.update(other.unsettled)
        self.lost.clear()
        self.lost.update(other.lost)

    # --- descriptions -----------------------------------------------------------

    def fact_changed(self, fact: Fact, how: str) -> None:
        """Update a description from a fact; its set must then be settled."""
        there = how == STORED
        if there:
            self._mentions.added(fact)
        else:
            self._mentions.removed(fact)
        if how == REPLACED or len(fact) < 3:
            return
        item = self._memory.items.known.get(fact[1])  # type: ignore[arg-type]
        if not isinstance(item, Description) or fact[0] == "location":
            return
        if fact[0] == "class" and fact[2] == item.kind:
            return
        relation = self._memory.signatures.relations[str(fact[0])]
        index, value = (fact[0], *fact[2:-1]), fact[-1]
        if relation.is_property and item.values.get(index) != (value if there else ""):
            item.learn(index, value if there else None)
            if item.home is not None:
                item.home.changed(item.mask)
                self._touch(item.home)

    def other_changed(self, word: str) -> None:
        """Do nothing: these changes come from this module or concern no item."""

    def _touch(self, changed: ExpectationSet | None) -> None:
        if changed is not None:
            self.unsettled[changed] = None

    def _new(self, kind: str, sensor: str) -> Description:
        self.number += 1
        while f"{PREFIX}{self.number}" in self._memory.items.known:
            self.number += 1
        name = f"{PREFIX}{self.number}" if sensor else ""
        return Description(self.number, name, sensor, kind)

    def _new_layer(self, home: ExpectationSet) -> View:
        self.layers += 1
        return home.new_layer(self.layers)

    def _set(self, kind: str, place: Atom) -> ExpectationSet | None:
        if place == UNKNOWN:
            return None
        found = self.sets.get((kind, place))
        if found is None:
            found = self.sets[kind, place] = ExpectationSet(kind, place)
        return found

    def _fill(self, of: ExpectationSet) -> None:
        """Put empty descriptions into layers that hold fewer than the set's size."""
        size = max(len(view) for view in of.views())
        for layer in of.layers:
            while len(layer) < size:
                of.add(layer, self._new(of.kind, ""))

    # --- calls of handlers -------------------------------------------------------

    def introduce(self, sensor: str, kind: str, place: Atom) -> Description:
        """Add an item of an indistinct class, seen under a sensor name."""
        items = self._memory.items
        item = items.known.get(items.name_of(sensor))
        if isinstance(item, Description) and item.accessible:
            self._assert("class", item.name, item.kind, "true")
            return self.move(item, place)
        item = self._new(kind, sensor)
        items.enter(item)
        self._assert("class", item.name, kind, "true")
        self._assert("location", item.name, place)
        home = self._set(kind, place)
        if home is not None:
            home.add(home.local, item)
            self._fill(home)
            self._touch(home)
        else:
            self.lost[item] = None
        self._memory.tell("know-sensor-name")
        self._item_events.emit(ItemIntroduced, item, place)
        return item

    def move(self, item: Description, place: Atom) -> Description:
        """Put an item at a place; return its description after the move."""
        home = item.home
        if place == self._place(item):
            self._assert("location", item.name, place)
            return item
        gone: departure.Collection | None = None
        before = item.name
        if home is not None:
            item, gone = self._leave(home, item)
        self.lost.pop(item, None)
        self._assert("location", item.name, place)
        target = self._set(item.kind, place)
        if target is None:
            self.lost[item] = None
        else:
            self._arrive(target, item)
        self._item_events.moved(ItemMoved, item, place, before, gone)
        return item

    def _place(self, item: Description) -> Atom:
        return UNKNOWN if item.home is None else item.home.place

    def _arrive(self, target: ExpectationSet, item: Description) -> None:
        """Add an item as itself to the local model and to every layer."""
        if not item.accessible and not target.layers:
            layer = self._new_layer(target)
            for member in target.local.members:
                target.add(layer, member)
        for layer in target.layers:
            target.add(layer, item)
        if item.accessible:
            target.add(target.local, item)
        self._touch(target)

    def lose(self, item: Description) -> None:
        """Set the place of a lost item to `unknown`; the item is out of reach."""
        gone: departure.Collection | None = None
        before = item.name
        if item.home is not None:
            item, gone = self._leave(item.home, item)
        self._out(item)
        self._item_events.moved(ItemLost, item, UNKNOWN, before, gone)

    def _out(self, item: Description) -> None:
        if item.accessible:
            self._memory.items.put_out_of_reach(item, keep_sensor=False)
            self._memory.tell("know-sensor-name")
        self._assert("location", item.name, UNKNOWN)
        self.lost[item] = None

    def expire(self) -> None:
        """Turn local models into layers and forget sensor names after a move."""
        for item in list(self.lost):
            self._forget(item)
        for home in list(self.sets.values()):
            if home.local.members:
                layer = self._new_layer(home)
                for member in list(home.local.members):
                    home.add(layer, member)
                    home.discard(home.local, member)
                self._fill(home)
                self._touch(home)
        for reached in self._memory.items.expire():
            if isinstance(reached, Description):
                self._memory.items.drop_sensor(reached)

    def _assert(self, *fact: Atom) -> None:
        self._memory.store(fact, "handler")

    # --- leaving ----------------------------------------------------------------

    def _leave(
        self, home: ExpectationSet, item: Description
    ) -> tuple[Description, departure.Collection | None]:
        """Remove an item from its set, with one description from every layer.

        If the item was out of reach, fewer descriptions may leave than are in reach
        there.

        Return the item with the properties of the removed descriptions, and the
        collection that contained them; None if nothing could be merged.
        """
        score = self._scores.of(home.kind, home.place)
        served, found = departure.collect(home, item, score)
        choice = departure.smallest(served, found)
        for view in home.views():
            home.discard(view, item)
        self._touch(home)
        self._memory.tell("location")
        if choice is None:
            for member in departure.drop_each(home, served, found):
                self._forget(member)
            self._fill(home)
            return item, None
        merging.make_alike(self._memory, choice.members)
        for member in choice.leaving:
            for layer in home.layers:
                home.discard(layer, member)
            item = self._one(item, member, item.name)
        self._fill(home)
        return item, choice

    def fix(self, place: Atom) -> None:
        """Remove all items from a place but the accessible ones."""
        for home in [s for (_, at), s in self.sets.items() if at == place]:
            while home.size > len(home.local):
                item, gone = self._leave(home, self._new(home.kind, ""))
                if not item.empty:
                    self._out(item)
                    self._item_events.moved(ItemLost, item, UNKNOWN, item.name, gone)

    def _forget(self, item: Description) -> None:
        """Remove an item, with its facts and the items in it."""
        stack = [item]
        while stack:
            gone = stack.pop()
            self.lost.pop(gone, None)
            if gone.empty or gone.name not in self._memory.items.known:
                continue
            merging.forget_facts(self._memory, gone.name)
            self._memory.items.forget(gone)
            for home in [s for (_, at), s in self.sets.items() if at == gone.name]:
                for member in home.members():
                    stack.append(member)
                    member.home, member.mask = None, 0
                del self.sets[home.kind, home.place]
                self.unsettled.pop(home, None)

    # --- merging ----------------------------------------------------------------

    def _one(self, one: Description, other: Description, own: str = "") -> Description:
        """Merge two descriptions of the same item; return the older one."""
        older, younger = sorted((one, other), key=lambda d: (d.empty, d.number))
        if younger.mask and younger.home is not None:
            younger.home.replace(younger, older)
            self._touch(older.home)
        if younger.empty:
            return older
        first = older.name if older.accessible else younger.name
        if younger.accessible or older.accessible:
            self._memory.tell("know-sensor-name")
        if younger in self.lost:
            del self.lost[younger]
        self._memory.items.merge(older, younger)
        merging.merge_facts(self._memory, older.name, younger.name, first, own)
        self._merge_places(older.name, younger.name)
        self.renamed(younger.name, older.name)
        return older

    def _merge_places(self, kept: str, lost: str) -> None:
        """Join the sets at two places, of containers that have merged."""
        if self._memory.place == lost:
            self._memory.place = kept
        for home in [s for (_, at), s in self.sets.items() if at == lost]:
            del self.sets[home.kind, lost]
            target = self._set(home.kind, kept)
            assert target is not None
            rows = [(v.serial, list(v.members)) for v in (home.local, *home.layers)]
            for member in home.members():
                member.mask = 0
            for serial, row in rows:
                into = target.new_layer(serial) if serial else target.local
                for member in row:
                    target.add(into, member)
            self.unsettled.pop(home, None)
            self._fill(target)
            self._touch(target)

    # --- settling ---------------------------------------------------------------

    def settle(self) -> None:
        """Make all identifications that the changed sets allow, until none is left."""
        while self.unsettled:
            home = next(iter(self.unsettled))
            match = self._next(home)
            if match is not None:
                kept = self._one(match.one, match.other)
                self._item_events.merged(kept, match)
            elif not self._tidy(home):
                del self.unsettled[home]

    def _next(self, home: ExpectationSet) -> Match | None:
        return best_match(home, self._scores.of(home.kind, home.place))

    def _tidy(self, home: ExpectationSet) -> bool:
        """Drop equal and surplus layers; return whether matches may follow."""
        seen = [home.local.members.keys()]
        for layer in list(home.layers):
            if any(layer.members.keys() == other for other in seen):
                home.drop_layer(layer)
            else:
                seen.append(layer.members.keys())
        changed = False
        while len(home.layers) > self._max_layers:
            for member in home.drop_layer(home.layers[0]):
                self._forget(member)
            changed = True
        if not home.size:
            self.sets.pop((home.kind, home.place), None)
        return changed
