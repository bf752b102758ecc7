"""PDDL domains as RAP libraries."""

from __future__ import annotations

import random
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rapc
from rapc.base.source import SourceFile
from rapc.errors import TextError
from rapc.planning.from_pddl import Converted, converted
from rapc.planning.pddl import written
from tests.planning.logistics import DOMAIN, PROBLEM
from tests.planning.test_plans import Literals, Row, Strips, literal, literals, operator


def made(domain: str, problem: str | None = None) -> Converted:
    files = [SourceFile("d.pddl", domain)]
    if problem is not None:
        files.append(SourceFile("p.pddl", problem))
    return converted(*files)


def action(parts: str) -> str:
    """Return the RAP of an action of a small domain."""
    predicates = "(:predicates (p ?x - ball) (q ?x ?y - ball) (r ?x) (s))"
    text = f"(define (domain d) (:types ball) {predicates} (:action act {parts}))"
    _, form = made(text).library.split("(define-rap ")
    return " ".join(f"(define-rap {form}".split())


def test_domain_becomes_kinds_propositions_and_operators() -> None:
    library = made(DOMAIN).library
    assert "(declare-kind truck :is vehicle)\n" in library
    assert "(declare-memory-proposition at ((?thing thing) (?loc place)))" in library
    drive = library[
        library.index("(define-rap (drive") : library.index("(define-rap (fly")
    ]
    assert " ".join(drive.split()) == (
        "(define-rap (drive (?t truck) (?from place) (?to place) (?c city)) "
        "(preconditions (and (at ?t ?from) (in-city ?from ?c) (in-city ?to ?c) "
        "(n= ?from ?to))) (effects (not (at ?t ?from)) (at ?t ?to)) (duration 3))"
    )


def test_problem_of_a_domain_is_solved() -> None:
    found = made(DOMAIN, PROBLEM)
    assert found.goal is not None
    assert "(declare-kind truck :is vehicle (t1 t2))\n" in found.library
    plan = rapc.plan(rapc.loads(found.library), found.goal, facts=found.facts)
    assert plan
    assert not plan.left_out
    flights = [one.goal for one in plan.steps if one.goal.startswith("(fly")]
    assert all(one.startswith("(fly a1") for one in flights)
    assert len(flights) == 2


@pytest.mark.parametrize(
    ("parts", "clauses"),
    [
        (":parameters (?x) :effect (r ?x)", "(act ?x) (effects (r ?x)))"),
        (":precondition () :effect (s)", "(act) (effects (s)))"),
        (
            ":parameters (?x - ball) :precondition (not (and (s) (p ?x))) :effect (s)",
            "(preconditions (or (not (s)) (not (p ?x)))) (effects (s)))",
        ),
        (
            ":precondition (forall (?x - ball) (imply (p ?x) (q ?x ?x))) :effect (s)",
            "(preconditions (not (and (p ?x) (not (q ?x ?x))))) (effects (s)))",
        ),
        (
            ":precondition (exists (?x - ball) (or (p ?x) (q ?x ?x))) :effect (s)",
            "(preconditions (or (p ?x) (q ?x ?x))) (effects (s)))",
        ),
        (
            ":effect (and (when (s) (not (s))) (forall (?x - ball) (when (s) (p ?x))))",
            "(act) (effects (may (s)) (may (p ?))))",
        ),
    ],
)
def test_action_becomes_clauses(parts: str, clauses: str) -> None:
    assert clauses in action(parts)


def test_names_with_a_meaning_in_rap_get_an_ending() -> None:
    text = (
        "(define (domain d) (:types item) (:predicates (count ?x - item))"
        "(:action index :parameters (?x - item) :effect (count ?x)))"
    )
    library = made(text).library
    assert "(declare-memory-proposition count-1 ((?x item-1)))" in library
    assert "(define-rap (index-1 (?x item-1))" in library


def test_cost_that_is_not_constant_is_left_out() -> None:
    text = DOMAIN.replace("(total-cost) 3", "(total-cost) (distance ?from ?to)")
    (said,) = made(text).left_out
    assert said == "d.pddl:24:50: a cost that is not constant"


def test_parameter_without_use_is_left_out() -> None:
    text = (
        "(define (domain d) (:types cup) (:predicates (clean ?x - cup))"
        "(:action wash :parameters (?x - cup ?by - cup) :effect (clean ?x)))"
    )
    found = made(text)
    assert "(define-rap (wash (?x cup))\n" in found.library
    said = "the parameter `?by`: no condition or effect has it"
    assert found.left_out == (f"d.pddl:1:99: {said}",)


def test_argument_of_several_types_has_no_kind() -> None:
    text = (
        "(define (domain d) (:types cup pan) (:predicates (at ?x - (either cup pan)))"
        "(:action put :parameters (?x - cup) :effect (at ?x)))"
    )
    library = made(text).library
    assert "(declare-memory-proposition at (?x))\n" in library
    assert "(define-rap (put (?x cup))\n" in library


HEAD = "(define (domain d) (:types ball) (:predicates (p ?x) (q ?x - ball)) "


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "d.pddl:1:1: expected `(define (domain NAME) ...)`"),
        ("(define (problem p))", "d.pddl:1:1: expected `(define (domain NAME) ...)`"),
        ("(define (domain d)\n  (", "d.pddl:2:3: "),
        ("(define (domain d) 7)", "d.pddl:1:20: expected a section of the domain"),
        ("(define (domain d) (:derived))", "1:21: unsupported section `:derived`"),
        ("(define (domain d)) ()", "1:21: expected the end of the file"),
        ("(define (domain d) (:types a - ))", "expected the name of a type after `-`"),
        (
            "(define (domain d) (:types a - b b - c c - b))",
            "d.pddl:1:20: a type is its own parent: `c`, `b`",
        ),
        ("(define (domain d) (:types a - a))", "a type is its own parent: `a`"),
        (f"{HEAD}(:action))", "1:69: expected the name of an action"),
        (f"{HEAD}(:action a :effect))", "expected one list after `:effect`"),
        (f"{HEAD}(:action a :effect (s)))", "unknown predicate `s`"),
        (f"{HEAD}(:action a :effect (p)))", "`p` takes 1 argument, not 0"),
        (f"{HEAD}(:action a :effect (p ?x)))", "unknown variable `?x`"),
        (f"{HEAD}(:action a :effect (p x)))", "unknown object `x`"),
        (f"{HEAD}(:action a :parameters (?x - cup)))", "unknown type `cup`"),
        (f"{HEAD}(:action a :parameters (?x - (either b c))))", "the name of a type"),
        (f"{HEAD}(:action a :effect (assign (f) 3)))", "unknown predicate `assign`"),
        (
            f"{HEAD}(:action a :effect (forall (?x) (p ?x))))",
            "unsupported: an effect that adds several facts",
        ),
        (
            f"{HEAD}(:action a :effect (forall (?x - ball) (not (p ?x)))))",
            "unsupported: an effect on `p` for the values of one type",
        ),
        (
            f"{HEAD}(:action a :precondition (forall (?x) (p ?x))))",
            "unsupported: no fact in `forall` gives `?x` a value of its type",
        ),
        (
            f"{HEAD}(:action a :precondition (exists (?x - ball) (p ?x))))",
            "unsupported: no fact in `exists` gives `?x` a value of its type",
        ),
        ("(" * 200_000, "d.pddl:1:"),
        (f"{HEAD}(:action a :effect {'(and ' * 200}{')' * 200}))", "nested"),
        (
            f"{HEAD}(:action a :precondition (and {'(p ?x) ' * 300}) "
            ":parameters (?x)))",
            "cannot express the domain as RAPs",
        ),
    ],
)
def test_invalid_domain_is_refused_with_its_position(text: str, said: str) -> None:
    with pytest.raises(TextError) as caught:
        made(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("(define (problem p) (:goal (at ?x l1)))", "p.pddl:1:32: unknown variable"),
        ("(define (problem p) (:objects x - cup))", "p.pddl:1:31: unknown type `cup`"),
        ("(define (problem p) (:init (at x)))", "`at` takes 2 arguments, not 1"),
        ("(define (problem p) (:constraints))", "unsupported section `:constraints`"),
    ],
)
def test_invalid_problem_is_refused_with_its_position(text: str, said: str) -> None:
    with pytest.raises(TextError) as caught:
        made(DOMAIN, text)
    assert said in str(caught.value)


def test_large_domain_is_read_in_linear_time() -> None:
    actions = "".join(f"(:action a{at} :effect (p{at}))" for at in range(1500))
    predicates = "".join(f"(p{at})" for at in range(1500))
    began = time.process_time()
    made(f"(define (domain d) (:predicates {predicates}) {actions})")
    assert time.process_time() - began < 10


def mutated(text: str, seed: int) -> str:
    """Return a text with some tokens removed, doubled, moved or replaced."""
    rng = random.Random(seed)
    words = text.replace("(", " ( ").replace(")", " ) ").split()
    for _ in range(rng.randint(1, 4)):
        at, other = rng.randrange(len(words)), rng.randrange(len(words))
        kind = rng.randrange(4)
        if kind == 0:
            del words[at]
        elif kind == 1:
            words.insert(at, words[other])
        elif kind == 2:
            words[at], words[other] = words[other], words[at]
        else:
            words[at] = rng.choice(["when", "forall", "?x", "-", "(", ":types", "\x00"])
    return " ".join(words)


def test_mutated_domains_are_refused_or_planned_with() -> None:
    outcomes = set()
    for seed in range(400):
        domain, problem = DOMAIN, PROBLEM
        if seed % 2:
            domain = mutated(DOMAIN, seed)
        else:
            problem = mutated(PROBLEM, seed)
        try:
            found = made(domain, problem)
            library = rapc.loads(found.library, check=False)
            assert found.goal is not None
            plan = rapc.plan(library, found.goal, facts=found.facts, limit=200)
            outcomes.add(plan.reason)
        except rapc.Error as error:
            outcomes.add("two lines" if "\n" in error.message else "refused")
    assert "two lines" not in outcomes
    assert outcomes >= {"refused", "solved", "unsolvable"}


@settings(max_examples=40, deadline=None)
@given(
    st.lists(operator(), min_size=1, max_size=5),
    st.sets(literal(()).map(lambda one: one[1]), max_size=5),
    literals((), 3),
)
def test_exported_problem_can_be_read_back(
    operators: list[Row], facts: set[tuple[str, ...]], goal: Literals
) -> None:
    solution = Strips(operators, facts, goal).plan()
    if solution.problem is None:
        return
    found = made(*written(solution.problem)[:2])
    library = rapc.loads(found.library, check=False)
    assert found.goal is not None
    if found.goal == "true":
        return
    plan = rapc.plan(library, found.goal, facts=found.facts)
    assert bool(plan) == (solution.outcome == "solved")
