"""What holds of any memory that recognises, whatever happens [T 2.3].

Each function looks at a memory before and after a batch, and asserts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.base.values import Atom

from .pictures import Described, Operation, Picture

Batch = Sequence[Operation]


def may_leave(before: Picture, batch: Batch) -> bool:
    """Whether a batch may make an item leave its set.

    One that is seen again while in reach may be at another place.
    """
    seen = [f"@{args[0]}" for what, *args in batch if what == "introduce"]
    again = len(set(seen)) < len(seen) or any(each in before.names for each in seen)
    return again or any(what in ("move", "lose", "fix") for what, *_ in batch)


def layers_are_equally_large(after: Picture) -> None:
    """Every layer of a set holds equally many, and what is in reach is not more."""
    for found in after.sets.values():
        assert {len(layer) for layer in found.layers} <= {found.size}
        assert len(found.local) <= found.size
        if not found.layers:
            assert len(found.local) == found.size


def a_layer_stays_apart(before: Picture, after: Picture) -> None:
    """No two that stood in one view are one item afterwards."""
    for found in before.sets.values():
        for view in (found.local, *found.layers):
            names = [after.names[each.item] for each in view if each.item]
            assert len(names) == len(set(names)), names


def the_newest_value_stays(before: Picture, after: Picture, batch: Batch) -> None:
    """Without leaving or erasing, no value gives way to an older one."""
    if may_leave(before, batch) or any(what == "erase" for what, *_ in batch):
        return
    for fact, stamp in before.facts.items():
        name, item, value = fact[0], _now(after, fact[1]), fact[-1]
        known = [s for f, s in after.facts.items() if f[:2] == ("class", item)]
        if name not in ("color", "size") or not known:
            continue
        (now,) = [f for f in after.facts if f[:-1] == (name, item)]
        newer = after.facts[now]
        assert stamp is None or newer is not None
        if stamp is not None and newer is not None:
            assert newer >= stamp, (fact, stamp, now, newer)
            if newer == stamp and not _asserted(batch, str(name)):
                assert value == now[-1] or _another(before, after, fact, stamp)


def _now(after: Picture, name: Atom) -> Atom:
    return after.names.get(name, name) if isinstance(name, str) else name


def _asserted(batch: Batch, name: str) -> bool:
    return any(what == "assert" and args[0] == name for what, *args in batch)


def _another(
    before: Picture, after: Picture, fact: Sequence[Atom], stamp: float
) -> bool:
    """Whether another value of the same time was there too, of the same item now."""
    item = _now(after, fact[1])
    return any(
        other[0] == fact[0] and other[-1] != fact[-1] and at == stamp
        for other, at in before.facts.items()
        if _now(after, other[1]) == item
    )


def what_is_shared_stays_known(before: Picture, after: Picture, batch: Batch) -> None:
    """What became unknown, nobody said to be: then an item left, and the set differs.

    Only batches that do nothing else say which set that was.
    """
    new = [
        fact
        for fact, stamp in after.facts.items()
        if stamp is None and fact[-1] == "unknown" and not _was(before, after, fact)
    ]
    if not may_leave(before, batch):
        assert new == []
    if all(what in ("lose", "fix", "expire") for what, *_ in batch):
        for fact in new:
            assert _differ(before, after, fact), fact


def _was(before: Picture, after: Picture, fact: Sequence[Atom]) -> bool:
    """Whether some name of what is the item now had that fact."""
    for other, stamp in before.facts.items():
        renamed = tuple(_now(after, part) for part in other)
        if stamp is None and renamed == tuple(fact):
            return True
    return False


def _differ(before: Picture, after: Picture, fact: Sequence[Atom]) -> bool:
    """Whether in the item's set not all had one value of the property."""
    index = (fact[0], *fact[2:-1])
    for found in before.sets.values():
        members = list(_members(found.local, *found.layers))
        names = {_now(after, each.item) for each in members if each.item}
        if fact[1] in names:
            values = {_value(each, index, after) for each in members}
            return len(values) > 1
    return False


def _members(*views: Sequence[Described]) -> Iterator[Described]:
    for view in views:
        yield from view


def _value(of: Described, index: Sequence[Atom], after: Picture) -> Atom | None:
    """A value by an index in which names may have been renamed since."""
    for known, (value, _) in of.values:
        if tuple(_now(after, part) for part in known) == tuple(index):
            return value
    return None


def check(before: Picture, after: Picture, batch: Batch) -> None:
    """All of them."""
    layers_are_equally_large(after)
    a_layer_stays_apart(before, after)
    the_newest_value_stays(before, after, batch)
    what_is_shared_stays_known(before, after, batch)
