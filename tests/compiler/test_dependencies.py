"""What a monitor listens to: every change that counts, and hardly another."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Fact
from rapc.compiler.program import Program
from rapc.compiler.query.formulas import watches
from rapc.compiler.watches import ANYTHING
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.library.loader import load_text
from rapc.library.signatures import Signatures
from rapc.runtime.monitors.listeners import Listeners
from rapc.runtime.state.task import Task
from tests.effort import examples

from .dice import Dice, dice, sizes
from .memories import SIGNATURES, Change, Memories, apply, erase, memories, query
from .test_queries import formula

_NOBODY = Program(load_text("(define-rap (nobody) (succeed nil))").library).known_rap(
    "nobody"
)


class Ear:
    """Listens as a monitor does to what a formula depends on."""

    def __init__(
        self, both: Memories, asked: nodes.Formula, env: dict[str, Value]
    ) -> None:
        found = watches(asked, SIGNATURES)
        self.aging = any(w.age is not None and w.age not in env for w in found)
        self._heard: dict[int, Task] = {}
        listeners = Listeners(self._heard)
        task = Task(_NOBODY, None, None)
        for key in {watch.resolve(env) for watch in found}:
            if key is not None:
                listeners.add(key, task)
        both.memory.observe(listeners)

    @property
    def heard(self) -> bool:
        """Whether anything was heard since this was last asked."""
        heard = bool(self._heard)
        self._heard.clear()
        return heard


@examples(1500)
@given(dice(), sizes, st.integers(1, 6))
def test_no_change_of_the_answer_goes_unheard(
    thrown: Dice, size: int, leaves: int
) -> None:
    both = memories(thrown.changes(size))
    asked, env = thrown.formula(leaves), thrown.env()
    ready = query(asked)
    for _ in range(6):
        ear = Ear(both, asked, env)
        both.context.horizon = []
        before = ready.holds(both.context, env)
        horizon, both.context.horizon = both.context.horizon, None
        change = thrown.change()
        apply(both, change)
        heard = ear.heard
        if ready.holds(both.context, env) is not before:
            stale = bool(horizon) and min(horizon) <= both.recorder.time
            clock = change[0] == "wait" and (ear.aging or stale)
            assert heard or clock, f"{format_formula(asked)} after {change}"


@pytest.mark.parametrize(
    ("text", "heard", "unheard"),
    [
        ("(p a)", ("p", "a"), ("p", "b")),
        ("(q ?in ?x)", ("q", 5, "a"), ("q", 6, 5)),
        ("(q ?x b)", ("q", "a", "b"), ("q", "b", "a")),
        ("(q ?x ?y)", ("q", "a", "b"), ("p", "q")),
        ("(not (r))", ("r",), ("p", "r")),
        ("(color a ?x)", ("color", "a", "red"), ("color", "red", "a")),
        ("(heavy a)", ("heavy", "a", "false"), ("heavy", "b", "true")),
        ("(and (p ?x) (heavy ?x false))", ("heavy", "a", "true"), ("q", "heavy", 1)),
        ("(and (p ?x) (heavy ?x))", ("heavy", "a", "true"), ("heavy", "a", "false")),
        ("(power true)", ("power", "low"), ("heavy", "power", "true")),
        ("(believe (p a) 5)", ("p", "a"), ("p", "b")),
        ("(and (p ?x) (color ?x red))", ("color", "z", "red"), ("color", "z", "blue")),
        ("(or (p a) (q b ?))", ("q", "b", 1), ("q", "a", "b")),
        ("(location ?x kitchen)", ("location", "a", "kitchen"), ("location", "a", "b")),
    ],
)
def test_a_fact_is_heard_by_who_asks_about_it(
    text: str, heard: Fact, unheard: Fact
) -> None:
    both = memories([])
    for fact, expected in ((heard, True), (unheard, False)):
        ear = Ear(both, formula(text), {"?in": 5})
        both.memory.store(both.memory.checked(fact), "test")
        assert ear.heard is expected
        erase(both, fact)
        assert ear.heard is expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(location ?x external)", True),
        ("(location a ?in)", True),
        ("(location a kitchen)", False),
        ("(count thing external ?n)", True),
        ("(p external)", False),
    ],
)
def test_who_asks_for_external_hears_of_arrivals(text: str, expected: bool) -> None:
    both = memories([("introduce", ("a", "kitchen"))])
    ear = Ear(both, formula(text), {"?in": "external"})
    both.access.arrive("kitchen")
    assert ear.heard is expected


@pytest.mark.parametrize(
    "change", [("introduce", ("b", "a")), ("expire", None), ("lose", "a")]
)
def test_who_asks_for_sensor_names_hears_when_they_come_and_go(change: Change) -> None:
    both = memories([("introduce", ("a", "b"))])
    ear = Ear(both, formula("(know-sensor-name ?x)"), {})
    if change[0] == "lose":
        both.access.lose("a")
    else:
        apply(both, change)
    assert ear.heard


def test_a_resource_is_heard_by_who_asks_what_it_holds() -> None:
    counter, full = Counter(1), SetResource()
    env: dict[str, Value] = {"?c": counter, "?s": full}
    texts = ("(> (value ?c) 1)", "(member ?s a)", "(empty ?s)", "(= (size-of ?s) 1)")
    wanted = (counter, full, full, full)
    for text, resource in zip(texts, wanted, strict=True):
        keys = [w.resolve(env) for w in watches(formula(text), SIGNATURES)]
        assert keys == [resource]


def test_a_function_is_heard_through_what_it_reads() -> None:
    text = """
        (declare-memory-function near :reads (p q))
        (declare-memory-function far)
    """
    signatures = Signatures.of(load_text(text).library)
    near = watches(formula("(near a)"), signatures)
    assert [w.resolve({}) for w in near if w.key] == [("p",), ("q",)]
    far = watches(formula("(= (far a) 1)"), signatures)
    assert [w.resolve({}) for w in far] == [ANYTHING]
