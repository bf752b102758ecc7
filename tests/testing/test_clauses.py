"""What clauses of a test mean for its run: seed, agenda, answers, options, defaults."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.console.testing import explain
from rapc.testing.run import Outcome, Status, run_case
from rapc.testing.session import TestSession

from .small_suite import GRAB, LIBRARY, cases, happened, run

CHANCE = """
(define-rap (choose)
  (method one (primitive (look a)))
  (method two (primitive (look b))))
"""
CHOICE = "(script ((look ?))) (task (choose)) (expect (primitives (look {})))"


def outcomes(folder: Path, text: str, seed: int = 0) -> dict[str, Outcome]:
    """The outcomes of all tests of a text that follows the small library."""
    found = cases(folder, LIBRARY + CHANCE + text)
    return {name: run_case(case, seed) for name, case in found.items()}


def chosen(folder: Path, seed: int, clauses: str = "") -> str:
    """What the library chooses by chance: `a` or `b`."""
    text = f"(define-test it {clauses} {CHOICE.format('a')})"
    ended = outcomes(folder, text, seed)["it"]
    return "a" if ended.status is Status.PASSED else "b"


def test_seed_of_a_test_overrides_the_command(tmp_path: Path) -> None:
    free = [chosen(tmp_path, seed) for seed in range(6)]
    assert set(free) == {"a", "b"}
    for seed, told in enumerate(free):
        assert {chosen(tmp_path, n, f"(seed {seed})") for n in range(3)} == {told}


def test_a_test_with_its_own_seed_runs_once(tmp_path: Path) -> None:
    found = cases(tmp_path, LIBRARY + "(define-test it (seed 7) (expect (memory nil)))")
    session = TestSession(range(20, 25))
    outcome = session.run_one(found["it"])
    assert outcome.seed == 7
    assert explain.test_title(outcome) == "it (seed 7)"
    free = cases(tmp_path, LIBRARY + "(define-test it (expect (memory nil)))")
    assert session.run_one(free["it"]).seed == 20


AGENDA = f"""
(define-agenda chores
  (task (fetch cup) :priority 2)
  (task (fetch box) :at 5)
  (task (watch mug) :background true))
(define-test-defaults (script {GRAB}))
"""


def test_the_tasks_of_an_agenda_come_before_those_of_the_test(tmp_path: Path) -> None:
    text = """
      (define-test it (agenda chores) (task (fetch jug) :priority 1)
        (expect (primitives (grab cup) (grab jug) (grab box))
                (ends-by 7 (fetch box))
                (trace (task-created :task 1 :goal (fetch cup) :priority 2)
                       (task-created :task 2 :goal (watch mug))
                       (task-created :task 3 :goal (fetch jug))
                       (task-created :task 4 :goal (fetch box) :time 5))))
    """
    assert happened(outcomes(tmp_path, AGENDA + text)["it"]) == []


def test_undefined_agenda_is_an_error(tmp_path: Path) -> None:
    text = "(define-test it (agenda chorse))"
    ended = outcomes(tmp_path, AGENDA + text)["it"]
    assert ended.status is Status.ERROR
    assert happened(ended) == ["unknown agenda `chorse`; did you mean `chores`?"]


ASK = """
(declare-memory-function distance (?from ?to))
(declare-memory-function heavy (?x))
(declare-memory-function usual (?name ?x))
(declare-memory-property weight (?x ?kilos) usual)
(define-rap (reach ?from ?to)
  (preconditions (and (< (distance ?from ?to) 5) (not (heavy ?to)) (weight ?to 3)))
  (method (primitive (look ?to))))
"""
GOING = "(script ((look ?))) (task (reach a b))"


def asked(folder: Path, *answers: str) -> Outcome:
    """What becomes of a test with some answers."""
    clauses = f"(answers {' '.join(answers)}) {GOING} (expect (succeeds (reach a b)))"
    return outcomes(folder, f"{ASK} (define-test it {clauses})")["it"]


def test_answers_replace_unregistered_functions(tmp_path: Path) -> None:
    more = ("((heavy ?) false)", "((usual weight ?) 3)")
    assert happened(asked(tmp_path, "((distance a b) 4)", *more)) == []
    first = ("((distance ?x ?x) 0)", "((distance a ?) 9)", "((distance ? ?) 1)")
    assert asked(tmp_path, *first, *more).status is Status.FAILED
    heavy = ("((distance a b) 4)", "((heavy ?) true)", "((usual weight ?) 3)")
    assert asked(tmp_path, *heavy).status is Status.FAILED


def test_a_question_without_an_answer_fails_the_test(tmp_path: Path) -> None:
    ended = asked(tmp_path, "((distance b ?) 1)", "((heavy ?) nil)", "((usual ? ?) 3)")
    assert ended.status is Status.FAILED
    (told,) = happened(ended)
    assert told.startswith(
        "no answer of the test matches (distance a b), asked by precond"
    )
    ended = asked(tmp_path, "((distance a b) 1)", "((heavy ?) nil)", "((usual a b) 3)")
    assert "no answer of the test matches (usual weight b)" in happened(ended)[0]


def test_a_function_without_any_answer_is_told_before_the_run(tmp_path: Path) -> None:
    ended = asked(tmp_path, "((distance ? ?) 1)", "((heavy ?) nil)")
    assert ended.status is Status.ERROR
    assert "unknown function `usual`" in happened(ended)[-1]


OTHER_WORLD = """
from random import Random
from rapc.world import Handlers, Kit, Offer, Option, Reply, World

class Rooms(World):
    name = "rooms"
    kit = Kit(
        Offer({"look": (1, ("okay", "nothing"))}, {"sighting": 1}),
        options=(
            Option("place", "symbol", "hall", "", "where all that is seen is"),
            Option("lit", "flag", False, "", "whether there is light"),
        ),
        functions={"heavy": lambda memory, x: False},
    )

    def __init__(self, rng, options):
        place = options["place"] if options["lit"] else "unknown"
        def seen(memory, datum):
            memory.assert_fact("where", datum[1], place)
        self.kit = Kit(
            self.kit.offer, Handlers({}, {"sighting": seen}), self.kit.options,
            self.kit.functions,
        )
        if options["place"] == "moon":
            raise ValueError("nobody is on the moon")

    def now(self): return 0
    def perform(self, ticket, request): return Reply("okay")
    def next_time(self): return None
    def advance(self, to): pass
    def messages(self): return ()
"""
SEEN = """
(define-test it (world "rooms_of_a_test:Rooms") {}
  (script ((look ?x) :data ((sighting ?x)))) (task (find cup))
  (expect (succeeds (find cup) {})))
"""


@pytest.fixture
def rooms(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "rooms_of_a_test.py").write_text(OTHER_WORLD, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def in_rooms(folder: Path, clauses: str, place: str = "hall") -> Outcome:
    """What becomes of a test that borrows the handlers of the world above."""
    text = f"{LIBRARY} (declare-memory-function heavy (?x)) "
    found = cases(folder, text + SEEN.format(clauses, place))
    return run_case(found["it"], modules=["rooms_of_a_test"])


def test_options_apply_to_the_world_of_the_test(rooms: Path) -> None:
    assert happened(in_rooms(rooms, "(options (lit true))")) == []
    given = "(options (lit true) (place attic))"
    assert happened(in_rooms(rooms, given, "attic")) == []
    assert in_rooms(rooms, "(options (lit false))").status is Status.FAILED


@pytest.mark.parametrize(
    ("clauses", "message"),
    [
        (
            "(options (plase attic))",
            "the world `rooms` has no option `plase`; did you mean `place`?",
        ),
        (
            "(options (lit 3))",
            "`rooms.lit` takes `true` or `false`, not `3`; whether there is light",
        ),
        (
            "(options (place moon))",
            "the world `rooms` refuses: nobody is on the moon",
        ),
        (
            "(answers ((heavy ?) true))",
            "the world `rooms_of_a_test:Rooms` answers for `heavy` itself",
        ),
    ],
)
def test_invalid_option_of_the_test_world_is_an_error(
    rooms: Path, clauses: str, message: str
) -> None:
    ended = in_rooms(rooms, clauses)
    assert ended.status is Status.ERROR
    assert happened(ended) == [message]


def test_options_without_a_world_are_an_error(tmp_path: Path) -> None:
    ended = run(tmp_path, "(options (lit true))")
    assert ended.status is Status.ERROR
    assert happened(ended) == ["options of a world require a world"]


def test_defaults_hold_for_all_tests_of_a_file(tmp_path: Path) -> None:
    text = f"""
      (define-test-defaults (seed 3) (facts (have jug)) (script {GRAB}) (until 1))
      (define-test one (task (fetch cup))
        (expect (active (fetch cup)) (memory (have jug))))
      (define-test two (until 9) (seed 4) (facts (have mug)) (task (fetch cup))
        (expect (succeeds (fetch cup)) (memory (and (have jug) (have mug)))))
    """
    ended = outcomes(tmp_path, text)
    assert [happened(one) for one in ended.values()] == [[], []]
    assert [one.seed for one in ended.values()] == [3, 4]


BACKGROUND = "(task (watch mug) :background true)"


@pytest.mark.parametrize("until", ["", "(cycles 40)"])
def test_end_with_only_background_tasks_is_reported(tmp_path: Path, until: str) -> None:
    ended = run(tmp_path, f"{BACKGROUND} {until} (expect (memory (have mug)))")
    assert ended.note == (
        "the test was over at time 0: only background tasks were left"
    )
    assert any(ended.note in line.text for line in explain.failure_lines(ended))


def test_background_tasks_alone_go_on_until_a_stated_time(tmp_path: Path) -> None:
    ended = run(tmp_path, f"{BACKGROUND} (until 60) (expect (ends-before 60))")
    assert ended.note == ""
    assert any("60" in line.text for line in explain.failure_lines(ended))


def test_nothing_is_told_of_background_tasks_where_they_made_no_end(
    tmp_path: Path,
) -> None:
    failing = "(expect (memory (have mug)))"
    for clauses in (
        f"(script {GRAB}) (task (fetch cup)) {failing}",
        f"(task (watch mug)) {failing}",
        f"(task (watch mug)) {BACKGROUND.replace('mug', 'jug')} (until 3) {failing}",
    ):
        assert run(tmp_path, clauses).note == ""
