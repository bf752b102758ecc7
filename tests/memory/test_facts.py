"""The store of facts against a plain list, whatever is asserted, erased and asked."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rapc.base.values import Atom, Fact
from rapc.library.loader import load_text
from rapc.library.signatures import Signatures
from rapc.runtime.memory.facts import FactStore, Mentions
from tests.effort import examples

RELATIONS = Signatures.of(
    load_text(
        """
        (declare-memory-proposition near (?this ?that))
        (declare-memory-proposition wet ())
        (declare-memory-proposition loose)
        (declare-memory-property color (?thing ?color) unknown)
        (declare-memory-property road (?from ?to ?kind) unknown)
        (declare-memory-property mode (?mode) idle)
        (declare-memory-property free unknown)
        """
    ).library
).relations
ATOMS: st.SearchStrategy[Atom] = st.sampled_from(("item-1", "item-2", "a", 1, 2.5))


@st.composite
def facts(draw: st.DrawFn) -> Fact:
    """A fact of one of the relations."""
    relation = RELATIONS[draw(st.sampled_from(sorted(RELATIONS)))]
    size = relation.most
    if size is None:
        size = draw(st.integers(int(relation.is_property), 3))
    values: list[Atom] = draw(st.lists(ATOMS, min_size=size, max_size=size))
    return (relation.name, *values)


class Plain:
    """Facts in the order of their last assertion, with their stamps."""

    def __init__(self) -> None:
        self.stamps: dict[Fact, float] = {}

    def add(self, fact: Fact, time: float) -> Fact | None:
        """Assert a fact; returns the one that it replaces."""
        replaced = None
        if RELATIONS[str(fact[0])].is_property:
            same = (f for f in self.stamps if f[:-1] == fact[:-1] and f != fact)
            replaced = next(same, None)
        for gone in (replaced, fact):
            if gone in self.stamps:
                del self.stamps[gone]
        self.stamps[fact] = time
        return replaced


@examples(150)
@given(st.data())
def test_the_store_says_what_a_list_says(data: st.DataObject) -> None:
    store, plain, mentions = FactStore(RELATIONS.get), Plain(), Mentions()
    for time in range(data.draw(st.integers(1, 25))):
        fact = data.draw(facts())
        if fact in plain.stamps and data.draw(st.booleans()):
            store.table(fact[0]).remove(fact)
            del plain.stamps[fact]
            mentions.removed(fact)
        else:
            replaced = store.table(fact[0]).add(fact, time)
            assert replaced == plain.add(fact, time)
            if replaced is not None:
                mentions.removed(replaced)
            mentions.added(fact)
        asked = data.draw(facts())
        agree(store, plain, asked, data.draw(st.integers(1, 4)))
        agree(store, plain, fact, data.draw(st.integers(1, 4)))
        for item in ("item-1", "item-2"):
            assert mentions.of(item) == [f for f in plain.stamps if item in f[1:]]
    assert set(store) == set(plain.stamps)


def agree(store: FactStore, plain: Plain, asked: Fact, bits: int) -> None:
    """All ways to look for a fact, what begins like it, and what resembles it."""
    known = plain.stamps
    assert (asked in store) is (asked in known)
    assert store.stamp(asked) == known.get(asked)
    size = min(bits, len(asked))
    prefix = asked[:size]
    assert store.starting(prefix) == [f for f in known if f[:size] == prefix]
    parts = [v if at == 0 or bits >> at & 1 else None for at, v in enumerate(asked)]
    pattern: tuple[Atom | None, ...] = tuple(parts)
    assert store.matching(pattern) == [
        fact
        for fact in known
        if len(fact) == len(pattern)
        and all(p in (None, v) for p, v in zip(pattern, fact, strict=True))
    ]
    if RELATIONS[str(asked[0])].is_property:
        same = [fact for fact in known if fact[:-1] == asked[:-1]]
        assert store.asserted(asked[:-1]) == (same[0] if same else None)
