"""Queries, one property of theirs at a time."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from typing import Any

import pytest

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.source import SourceFile
from rapc.base.values import Atom, Fact, Text
from rapc.compiler.query.term_value import TermValue
from rapc.ir import nodes
from rapc.library.library import link
from rapc.library.signatures import Signatures
from rapc.parser.parse import parse
from rapc.runtime.memory.facts import FactStore, FactTable

from .memories import Faults, Memories, apply, erase, memories, query

X = nodes.Var("?x")


def formula(text: str) -> nodes.Formula:
    """A formula from text, with the signatures of `memories` in mind."""
    source = SourceFile("t.rap", f"(define-rap (r ?in) (succeed {text}))")
    parsed = parse(source)
    assert not parsed.diagnostics
    rap = parsed.forms[0]
    assert isinstance(rap, nodes.DefineRap)
    assert rap.succeed is not None
    return rap.succeed


def ask(both: Memories, text: str, **env: Value) -> list[dict[str, Value]]:
    """All answers to a formula; variables are bound by name without `?`."""
    bound = {f"?{name}": value for name, value in env.items()}
    return list(query(formula(text)).solutions(both.context, bound))


def told(*facts: Fact) -> Memories:
    """A memory to which some facts were told, a time unit apart."""
    both = memories([])
    for fact in facts:
        apply(both, ("assert", fact))
        apply(both, ("wait", 1))
    return both


# --- the order of answers ---------------------------------------------------------


def test_answers_come_in_the_order_of_the_last_assertion() -> None:
    both = told(("q", "a", 1), ("q", "b", 1), ("q", "c", 1), ("q", "a", 1))
    order = [{"?x": "b"}, {"?x": "c"}, {"?x": "a"}]
    assert ask(both, "(q ?x 1)") == order  # by the index of the value
    assert ask(both, "(q ?x ?)") == order  # by the name alone


def test_a_new_value_comes_last() -> None:
    both = told(("color", "a", "red"), ("color", "b", "red"), ("color", "a", "blue"))
    assert ask(both, "(color ?x ?y)") == [
        {"?x": "b", "?y": "red"},
        {"?x": "a", "?y": "blue"},
    ]


def test_what_an_or_offers_comes_branch_by_branch() -> None:
    both = told(("p", "b"), ("q", "a", 1), ("p", "a"))
    found = ask(both, "(and (or (p ?x) (q ?x ?)) (or (p ?x) (q ?x 1)))")
    assert [one["?x"] for one in found] == ["b", "a", "a", "a", "a"]


# --- erasing, refreshing -----------------------------------------------------------


def test_erasing_takes_every_fact_that_starts_so() -> None:
    both = told(("s", "a", 1, 1), ("s", "a", 1, 2), ("s", "a", 2, 1), ("s", "b", 1, 1))
    erase(both, ("s", "a", 1))
    assert ask(both, "(s ?x ?y ?)") == [{"?x": "a", "?y": 2}, {"?x": "b", "?y": 1}]
    erase(both, ("s",))
    assert ask(both, "(s ? ? ?)") == []


def test_a_property_erased_has_its_default_again() -> None:
    both = told(("color", "a", "red"))
    assert ask(both, "(color a ?x)") == [{"?x": "red"}]
    erase(both, ("color", "a"))
    assert ask(both, "(color a ?x)") == [{"?x": "unknown"}]


def test_erasing_in_the_short_form_is_erasing_a_prefix() -> None:
    both = told(("heavy", "a", "true"), ("heavy", "b", "false"))
    erase(both, ("heavy", "b"))
    assert ask(both, "(heavy ?x ?)") == [{"?x": "a"}]


def test_asserting_again_refreshes_the_stamp() -> None:
    both = told(("p", "a"), ("p", "b"))
    assert ask(both, "(believe (p a) 2)") == []
    both.memory.store(("p", "a"), "test")
    assert ask(both, "(believe (p a) 2)") == [{}]
    assert ask(both, "(believe (p a) ?x)") == [{"?x": 0}]


def test_younger_means_strictly_younger() -> None:
    both = told(("p", "a"))
    assert ask(both, "(believe (p a) 1)") == []
    assert ask(both, "(believe (p a) 1.5)") == [{}]


def test_an_age_that_is_whole_is_an_integer() -> None:
    both = memories([("wait", 0.5), ("assert", ("p", "a")), ("wait", 1.5)])
    (found,) = ask(both, "(believe (p a) ?x)")
    assert repr(found["?x"]) == "1.5"
    apply(both, ("wait", 0.5))
    (found,) = ask(both, "(believe (p a) ?x)")
    assert repr(found["?x"]) == "2"


def test_a_number_is_one_number_however_it_was_made() -> None:
    both = told(("size", "a", 2.0))
    (found,) = ask(both, "(size a ?x)")
    assert repr(found["?x"]) == "2"


# --- defaults ------------------------------------------------------------------------


def test_a_default_needs_an_index_without_a_fact() -> None:
    both = told(("heavy", "a", "true"))
    assert ask(both, "(heavy b false)") == [{}]
    assert ask(both, "(heavy a false)") == []
    assert ask(both, "(heavy ?x false)") == []


def test_a_belief_that_is_too_old_does_not_fall_back_on_the_default() -> None:
    both = told(("heavy", "a", "false"))
    apply(both, ("wait", 9))
    assert ask(both, "(believe (heavy a false) 5)") == []
    assert ask(both, "(believe (heavy b false) 5)") == [{}]


def test_asking_for_an_age_needs_an_assertion() -> None:
    assert ask(told(), "(believe (heavy b false) ?x)") == []


def test_an_age_bound_by_the_pattern_itself_is_a_limit() -> None:
    both = told(("size", "a", 5), ("size", "b", 1))
    assert ask(both, "(believe (size a ?x) ?x)") == [{"?x": 5}]
    assert ask(both, "(believe (size ?y ?x) (+ ?x 0))") == [{"?y": "a", "?x": 5}]


# --- equality, tests, faults -------------------------------------------------------


@pytest.mark.parametrize(
    ("test", "answer"),
    [
        ("(= 2 2.0)", True),
        ('(= a "a")', False),
        ("(n= a 1)", True),
        ("(< 1 unknown)", False),
        ("(>= unknown 1)", False),
        ("(<= 2 2)", True),
        ("(= (/ 6 3) 2)", True),
        ("(= (/ 1 2) 0.5)", True),
        ("(= (- 3) (- 1 4))", True),
    ],
)
def test_comparisons(test: str, answer: bool) -> None:
    assert bool(ask(told(), test)) is answer


@pytest.mark.parametrize(
    ("test", "what"),
    [
        ("(< ?x 1)", "clause: ?x is not bound"),
        ("(= (/ 1 0) 1)", "clause: division by zero"),
        ("(= (+ a 1) 1)", "clause: `a` is not a number"),
        ("(member a b)", "clause: `a` is not a set"),
        ("(= (value ?in) 1)", "clause: `5` is not a counter"),
        ("(believe (p a) a)", "clause: the age of a `believe` is not a number"),
        ("(p (- ?x 1))", "clause: ?x is not bound"),
    ],
)
def test_a_fault_is_told_and_fails(test: str, what: str) -> None:
    both = told(("p", "a"))
    faults = Faults()
    both.recorder.listen(faults)
    assert ask(both, test, **{"in": 5}) == []
    assert faults == [what]


@pytest.mark.parametrize(
    "term", ["(* ?b ?b)", "(+ ?m ?b)", "(- 0 ?m ?b)", "(/ ?m 0.5)"]
)
def test_a_result_beyond_measure_is_a_fault(term: str) -> None:
    both = told()
    faults = Faults()
    both.recorder.listen(faults)
    big = {"b": 2**999, "m": 2**1000}
    assert ask(both, f"(= {term} 1)", **big) == []
    assert faults == ["clause: the result is too large"]
    assert ask(both, "(> (+ ?m 0.5) 1)", **big) == [{}]


def test_a_fault_in_one_branch_leaves_the_others_alone() -> None:
    assert ask(told(("p", "a")), "(or (< ?y 1) (p ?x))") == [{"?x": "a"}]


def test_nothing_is_no_branch() -> None:
    nothing = query(nodes.Or(()))
    assert list(nothing.solutions(told().context, {})) == []


def test_sets_and_counters() -> None:
    both = told()
    full, empty = SetResource({"a": None}), SetResource()
    env: dict[str, Value] = {"s": full, "e": empty, "c": Counter(3)}
    yes = "(and (member ?s a) (not (member ?s b)) (empty ?e) (not (empty ?s)))"
    assert ask(both, yes, **env) == [{}]
    assert ask(both, "(and (= (value ?c) 3) (= (size-of ?s) 1))", **env) == [{}]


def test_a_term_without_a_value_is_a_fault_where_it_is_needed() -> None:
    both = told()
    faults = Faults()
    both.recorder.listen(faults)
    term = TermValue(nodes.Call("+", (X, nodes.Const(1))), "place")
    assert term.value(both.context, {"?x": 2}) == 3
    for env in ({}, {"?x": Text("a")}):
        assert term.value(both.context, env) is None
        assert faults == []
    assert term.needed(both.context, {}) is None
    assert term.needed(both.context, {"?x": Text("a")}) is None
    assert faults == ["place: ?x is not bound", 'place: `"a"` is not a number']


@pytest.mark.parametrize("text", ["(odd ?x)", "(p (next-to ?x))", "(size ?x ?y)"])
def test_what_a_function_raises_says_which_clause_has_asked_it(text: str) -> None:
    def fail(*_: object) -> None:
        raise LookupError("no such thing")

    both = told()
    both.context.functions = dict.fromkeys(("odd", "next-to", "zero"), fail)
    with pytest.raises(LookupError) as raised:
        ask(both, text, x="a")
    assert raised.value.__notes__ == ["clause"]
    term = TermValue(nodes.Call("next-to", (X,)), "place")
    with pytest.raises(LookupError) as raised:
        term.needed(both.context, {"?x": 2})
    assert raised.value.__notes__ == ["place"]


def test_the_short_form_of_a_declaration_without_a_list_is_unknown() -> None:
    source = SourceFile("t.rap", "(declare-memory-property hot unknown)")
    library, _ = link([parse(source)])
    relation = Signatures.of(library).relations["hot"]
    assert relation.full((X,)) == (X,)


# --- how much is looked at ----------------------------------------------------------


class Watched:
    """Facts that count how many of them are run through."""

    def __init__(self, store: FactStore) -> None:
        self.store = store
        self.seen = 0

    def table(self, name: str) -> WatchedTable:
        """The facts of a name."""
        return WatchedTable(self, self.store.table(name))


class WatchedTable:
    """One table under watch."""

    def __init__(self, whole: Watched, table: FactTable) -> None:
        self.whole = whole
        self.table = table
        self.values = table.values
        self.stamps = WatchedFacts(whole, table.stamps)

    def index(self, at: int) -> dict[Atom, WatchedFacts]:
        """The facts by one argument."""
        buckets = self.table.index(at).items()
        return {value: WatchedFacts(self.whole, facts) for value, facts in buckets}


class WatchedFacts(dict[Fact, Any]):
    """Facts of one name, or of one name and argument, under watch."""

    def __init__(self, whole: Watched, facts: dict[Fact, Any]) -> None:
        super().__init__(facts)
        self.whole = whole

    def __iter__(self) -> Iterator[Fact]:
        for fact in super().__iter__():
            self.whole.seen += 1
            yield fact


@pytest.mark.parametrize(
    ("text", "most"),
    [
        ("(q i77 ?x)", 1),
        ("(q i77 77)", 0),  # all known: is it there?
        ("(q ?x 7)", 10),
        ("(s ?x 8 0)", 10),  # the smaller of two indexes: 10 facts, not 500
        ("(s ?x ?y 0)", 500),
        ("(color i77 ?x)", 0),  # a property with its index is looked up
        ("(color ?x c7)", 10),
        ("(and (q ?x 7) (color ?x ?y))", 10),
        ("(and (color ?x c7) (q ?x ?y) (s ?x ? 1))", 30),
        ("(and (or (q ?x 7) (p nobody)) (q ?x ?y))", 20),
        ("(not (q i77 7))", 0),
        ("(believe (q ?x 7) 5)", 10),
    ],
)
def test_a_bound_argument_keeps_a_query_from_scanning(text: str, most: int) -> None:
    both = memories([])
    for at in range(1000):
        both.memory.store(("q", f"i{at}", at % 100), "test")
        both.memory.store(("s", f"i{at}", at % 100, at % 2), "test")
        both.memory.store(("color", f"i{at}", f"c{at % 100}"), "test")
    watched = Watched(both.context.facts)
    both.context.facts = watched  # type: ignore[assignment]
    assert list(query(formula(text)).solutions(both.context, {})) or "not" in text
    assert watched.seen <= most


def test_many_variables_that_may_be_bound_do_not_multiply() -> None:
    """Code is made for the cases that occur; all together would be two to the 40."""
    names = [f"?v{at}" for at in range(40)]
    either = " ".join(f"(or (p {name}) true)" for name in names)
    total = f"(= (+ {' '.join(names)}) 40)"
    both = memories([])
    both.memory.store(("p", 1), "test")
    asked = query(formula(f"(and {either} {total})"))
    assert asked.first(both.context, {}) == dict.fromkeys(names, 1)


def test_a_traceback_shows_the_generated_line() -> None:
    def broken(view: object, number: object) -> bool:
        raise RuntimeError("the host's own")

    both = memories([("assert", ("p", 1))])
    functions = both.context.functions
    both.context.functions = {**functions, "odd": broken}
    asked = query(formula("(and (p ?x) (odd ?x))"))
    with pytest.raises(RuntimeError) as raised:
        asked.holds(both.context, {})
    told = "".join(traceback.format_exception(raised.value))
    assert "holds(ctx.functions[" in told
    assert "def ask(env): return variants[" in told
    assert "<string>" not in told
