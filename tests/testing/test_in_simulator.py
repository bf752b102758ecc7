"""Tests in a simulator: seed, options and agenda, without a script."""

from __future__ import annotations

import json
from base64 import b64decode, b64encode
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest

from rapc.runtime.saving.format import sealed
from rapc.testing.discover import find
from rapc.testing.faults import read_fault
from rapc.testing.run import Case, Outcome, Status, run_case
from rapc.testing.session import TestSession

from ..cli.command import rapc
from ..effort import first
from .small_suite import happened

COURIER = Path(__file__).parents[2] / "examples" / "courier"

DELIVERED = "(succeeds (deliver meals ward-4))"


def outcome_of(folder: Path, clauses: str, seed: int = 0) -> Outcome:
    """The outcome of a test of the courier's library in its world."""
    return run_case(written(folder, clauses), seed)


def written(folder: Path, clauses: str) -> Case:
    """A test of the courier's library in its world, beside a copy of the library."""
    for file in COURIER.glob("*.rap"):
        if not file.name.endswith(".test.rap"):
            (folder / file.name).write_bytes(file.read_bytes())
    path = folder / "it.test.rap"
    text = f'(require "shift") (define-test it (world courier) {clauses})'
    path.write_text(text, encoding="utf-8")
    found = find([path])
    assert found.reports == ()
    return found.cases[0]


def test_agenda_runs_in_the_world_with_the_seed_of_the_test(tmp_path: Path) -> None:
    clauses = "(seed 4) (agenda shift) (until 3000) (expect {})"
    for expected, status in (
        (f"(ends-by 1236 (deliver meals ward-4)) {DELIVERED}", Status.PASSED),
        ("(ends-by 1235 (deliver meals ward-4))", Status.FAILED),
    ):
        for seed in (0, 1):
            outcome = outcome_of(tmp_path, clauses.format(expected), seed)
            assert (outcome.status, outcome.seed) == (status, 4), happened(outcome)


def test_options_change_the_world_of_the_run(tmp_path: Path) -> None:
    clauses = "(options (battery {})) (until 0) (task (deliver linen ward-1)) "
    clauses += "(expect (memory (battery 33)))"
    assert outcome_of(tmp_path, clauses.format(33)).status is Status.PASSED
    assert outcome_of(tmp_path, clauses.format(34)).status is Status.FAILED


def test_expectations_at_a_time_precede_the_next_request(tmp_path: Path) -> None:
    """At time 0 the robot is at the base; later it is elsewhere."""
    clauses = "(seed 4) (agenda shift) (until 3000) (at {} (expect {}))"
    known = "(memory (robot-at base))"
    assert outcome_of(tmp_path, clauses.format(0, known)).status is Status.PASSED
    late = outcome_of(tmp_path, clauses.format(200, "(memory (robot-at base))"))
    assert late.status is Status.FAILED


def test_faults_reach_the_simulator(tmp_path: Path) -> None:
    clauses = f"(seed 4) (agenda shift) (until 3000) (expect {DELIVERED})"
    session = TestSession(faults=(read_fault("(hand-over ? ?) nobody-there"),))
    case = written(tmp_path, clauses)
    assert TestSession().run_one(case).status is Status.PASSED
    assert session.run_one(case).status is Status.FAILED


def test_mended_failures_are_in_the_outcome_and_bounded(tmp_path: Path) -> None:
    clauses = "(seed 4) (agenda shift) (until 3000) (expect (fails-at-most {}))"
    outcome = outcome_of(tmp_path, clauses.format(5))
    assert outcome.status is Status.FAILED
    assert happened(outcome)[0] == "mended failures: 6"
    assert [line.split() for line in outcome.mended] == [
        ["travel-to", "3", "blocked"],
        ["deliver", "1", "sold-out"],
        ["fetch", "1", "sold-out"],
        ["stay-charged", "1", "interference"],
    ]
    assert outcome_of(tmp_path, clauses.format(6)).status is Status.PASSED


GAUGE = """
from rapc.world import Kit, Offer, Reply, World

class Gauge(World):
    name = "gauge"
    kit = Kit(Offer({"fill": (1, ("okay", "spilt"))}))

    def __init__(self, rng, options): self.filled = 0
    def now(self): return 0
    def perform(self, ticket, request):
        self.filled += request[1]
        return Reply("spilt" if self.filled < 5 else "okay")
    def next_time(self): return None
    def advance(self, to): pass
    def messages(self): return ()
    def figures(self): return {"all_filled": self.filled}
"""
FILL = """
(declare-primitive fill (?n) (okay spilt))
(define-rap (fill-up) (method (primitive (fill 3))))
"""


@pytest.fixture
def gauge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a world that has one figure."""
    (tmp_path / "gauge_of_a_test.py").write_text(GAUGE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def in_gauge(clauses: str) -> Outcome:
    """The outcome of a test in the world with one figure."""
    Path("it.test.rap").write_text(f"{FILL} (define-test it {clauses})", "utf-8")
    found = find(["it.test.rap"])
    assert found.reports == ()
    return run_case(found.cases[0], modules=["gauge_of_a_test"])


WORLD = '(world "gauge_of_a_test:Gauge") (task (fill-up))'


@pytest.mark.usefixtures("gauge")
@pytest.mark.parametrize(
    ("figure", "message"),
    [
        ("all-filled = 6", None),
        ("all-filled n= 5", None),
        ("all-filled < 7", None),
        ("all-filled <= 6", None),
        ("all-filled > 5", None),
        ("all-filled >= 6", None),
        ("all-filled >= 7", "the figure `all-filled` is 6"),
        ("all-filled < 6", "the figure `all-filled` is 6"),
        ("filled = 6", "the world `gauge_of_a_test:Gauge` has no figure `filled`"),
    ],
)
def test_figures_of_the_world_are_compared(figure: str, message: str | None) -> None:
    outcome = in_gauge(f"{WORLD} (expect (succeeds (fill-up)) (figure {figure}))")
    assert happened(outcome) == ([] if message is None else [message])


@pytest.mark.usefixtures("gauge")
@pytest.mark.parametrize("clauses", ["", f"{WORLD} (script ((fill ?)))"])
def test_figures_require_a_simulator(clauses: str) -> None:
    outcome = in_gauge(f"{clauses} (expect (figure all-filled = 0))")
    assert outcome.status is Status.ERROR
    assert happened(outcome) == ["figures require a world and no script"]


@pytest.mark.usefixtures("gauge")
def test_run_reports_figures_and_mended_failures() -> None:
    Path("fill.rap").write_text(FILL, "utf-8")
    options = ("--world", "gauge_of_a_test:Gauge", "--task", "(fill-up)", "-q")
    done = rapc("run", "fill.rap", *options, cwd=Path.cwd())
    assert [line.split() for line in done.stdout.splitlines()[-4:]] == [
        ["Failures", "mended", "by", "a", "retry:", "1."],
        ["fill-up", "1", "spilt"],
        ["Figures", "of", "the", "world:"],
        ["all-filled", "6"],
    ]


@pytest.mark.parametrize(
    ("clauses", "message"),
    [
        ("(options (batery 3))", "the world `courier` has no option `batery`"),
        ("(options (battery full))", "`courier.battery` takes one integer"),
    ],
)
def test_invalid_option_of_a_simulator_is_an_error(
    tmp_path: Path, clauses: str, message: str
) -> None:
    outcome = outcome_of(tmp_path, f"{clauses} (agenda shift)")
    assert outcome.status is Status.ERROR
    assert happened(outcome)[0].startswith(message)


# --- a saved state --------------------------------------------------------------------

RUN = ("run", str(COURIER), "--world", "courier", "--agenda", "shift", "--seed", "4")


def save(folder: Path, time: int, *more: str) -> None:
    """Save the state of a shift at a time."""
    file = str(folder / "it.state")
    done = rapc(*RUN, "-q", "--until", str(time), "--save", file, *more)
    assert done.returncode == 1, done.stderr  # tasks are left over


def test_test_continues_a_saved_state(tmp_path: Path) -> None:
    """The continued shift ends like the whole shift with the same seed."""
    save(tmp_path, 600)
    clauses = '(saved-state "it.state") (until 3000) (at {} (expect {}))'
    passed = f"{DELIVERED} (ends-by 1236 (deliver meals ward-4)) (fails-at-most 6)"
    for time, expected, status in (
        (3000, passed, Status.PASSED),
        (1235, "(ends-by 1235 (deliver meals ward-4))", Status.FAILED),
        (700, "(active (deliver meals ward-4))", Status.PASSED),
    ):
        outcome = outcome_of(tmp_path, clauses.format(time, expected))
        assert (outcome.status, outcome.seed) == (status, 4), happened(outcome)


def test_tasks_and_facts_of_a_test_join_a_saved_state(tmp_path: Path) -> None:
    save(tmp_path, 600)
    clauses = '(saved-state "it.state") (facts (battery 77)) (until (cycles 1)) '
    clauses += "(task (deliver linen ward-1) :priority 9) (expect (memory (battery 77))"
    outcome = outcome_of(tmp_path, f"{clauses} (succeeds (deliver linen ward-1)))")
    assert outcome.status is Status.PASSED, happened(outcome)


def test_changed_library_continues_a_saved_state(tmp_path: Path) -> None:
    """A RAP with a task under way may get other methods, and no other resources."""
    save(tmp_path, 600)
    clauses = f'(saved-state "it.state") (until 3000) (expect {DELIVERED})'
    case = written(tmp_path, clauses)
    library = tmp_path / "orders.rap"
    text = library.read_text(encoding="utf-8")
    head = "(define-rap (deliver (?goods goods) (?ward ward))"
    for old, new, status in (
        (head, head, Status.PASSED),
        (head, f";;; A comment.\n{head}", Status.PASSED),
        (head, f"{head} (preconditions nil)", Status.FAILED),
        ("?rounds", "?turns", Status.ERROR),
    ):
        library.write_text(text.replace(old, new), encoding="utf-8")
        case = find([tmp_path / "it.test.rap"]).cases[0]
        outcome = run_case(case)
        assert outcome.status is status, happened(outcome)
    under_way = "cannot change the resources of `deliver`: its tasks are under way"
    assert happened(outcome) == [under_way]


def test_saved_state_keeps_the_faults_of_its_world(tmp_path: Path) -> None:
    save(tmp_path, 300, "--fault", "(hand-over ? ?) nobody-there")
    clauses = '(saved-state "it.state") (until 3000) (expect {})'
    asked = "(primitives-include (hand-over ? ?) (hand-over ? ?))"
    outcome = outcome_of(tmp_path, clauses.format(asked))
    assert outcome.status is Status.PASSED, happened(outcome)
    lost = outcome_of(tmp_path, clauses.format(DELIVERED))
    assert lost.status is Status.FAILED


def test_saved_state_of_another_kind_is_refused(tmp_path: Path) -> None:
    save(tmp_path, 600)
    state = (tmp_path / "it.state").read_bytes()
    mark, _, body = state.partition(b"\n")
    expected = {
        b"": "the file is not a saved state",
        b"rapc-state 99\n" + body: "another version of rapc wrote the saved state",
        mark + b"\n[]": "the saved state is damaged",
        state[:-50]: "the saved state is damaged",
        state.replace(b"(define-rap", b"(define-rpa"): "the saved state is damaged",
    }
    clauses = f'(saved-state "it.state") (until 3000) (expect {DELIVERED})'
    for data, message in expected.items():
        (tmp_path / "it.state").write_bytes(data)
        outcome = outcome_of(tmp_path, clauses)
        assert outcome.status is Status.ERROR
        assert message in happened(outcome)[0]
    (tmp_path / "it.state").unlink()
    missing = happened(outcome_of(tmp_path, clauses))[0]
    assert missing.endswith("it.state`: missing file or folder")


def places(value: object, *above: object) -> Iterator[tuple[Any, ...]]:
    """The places of all values in a JSON text."""
    if above:
        yield above
    if isinstance(value, dict):
        for key, one in value.items():
            yield from places(one, *above, key)
    elif isinstance(value, list):
        for index, one in enumerate(value):
            yield from places(one, *above, index)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A saved state of a shift."""
    folder = tmp_path_factory.mktemp("saved")
    save(folder, 300)
    return (folder / "it.state").read_bytes()


@pytest.mark.parametrize("dice", first(12, range(600)), ids=str)
def test_changed_value_in_a_saved_state_raises_no_exception(
    tmp_path: Path, saved: bytes, dice: int
) -> None:
    """The checksums of the changed states are right."""
    rng, file = Random(dice), tmp_path / "it.state"
    mark, _, text = saved.partition(b"\n")
    contents = json.loads(text)
    run = json.loads(b64decode(contents["run"]).partition(b"\n")[2])
    *above, last = rng.choice(list(places(run)))
    value: Any = run
    for key in above:
        value = value[key]
    value[last] = rng.choice((None, -1, 10**30, "x", "", [], {}, True, [1, 2]))
    contents["run"] = b64encode(sealed(json.dumps(run).encode())).decode()
    file.write_bytes(mark + b"\n" + json.dumps(contents).encode())
    clauses = '(saved-state "it.state") (until (cycles 60)) (expect (memory true))'
    outcome = outcome_of(tmp_path, clauses)
    assert outcome.status in (Status.ERROR, Status.PASSED), happened(outcome)


@pytest.mark.parametrize(
    ("clauses", "message"),
    [
        ("(script ((drive ?) okay))", "`saved-state` requires a world and no script"),
        ("(options (battery 33))", "a different value of the option `courier.battery`"),
        ("(at 5 (loses cup))", "the saved state is of time 6"),
    ],
)
def test_test_that_contradicts_its_saved_state_is_in_error(
    tmp_path: Path, clauses: str, message: str
) -> None:
    save(tmp_path, 600)
    outcome = outcome_of(tmp_path, f'(saved-state "it.state") {clauses}')
    assert outcome.status is Status.ERROR
    assert message in happened(outcome)[0]


def test_run_that_cannot_be_saved_ends_the_command(tmp_path: Path) -> None:
    save_it = ("--save", str(tmp_path / "it.state"))
    for more, message in (
        (save_it, "--save requires --until"),
        ((*save_it, "--until", "9000"), "cannot save: the run ended before time 9000"),
    ):
        done = rapc(*RUN, "-q", *more)
        assert done.returncode == 2
        assert message in done.stderr
        assert not (tmp_path / "it.state").exists()


# --- repeated actions -----------------------------------------------------------------


def test_repeated_actions_happen_at_each_of_their_times(tmp_path: Path) -> None:
    """The actions happen at 10, 13 and 16, with a simulator and with a script."""
    repeated = "(at 10 :every 3 :until 18 (asserts (battery 7)))"
    clear = "".join(f"(at {time} (asserts (battery 8)))" for time in (11, 14, 17))
    known = {9: "33", 10: "7", 11: "8", 12: "8", 13: "7", 14: "8", 16: "7", 19: "8"}
    asked = "".join(
        f"(at {time} (expect (memory (battery {value}))))"
        for time, value in known.items()
    )
    for begin in (
        "(options (battery 33))",
        "(facts (battery 33)) (script ((drive ?) okay))",
    ):
        outcome = outcome_of(tmp_path, f"{begin} {repeated} {clear} {asked} (until 25)")
        assert outcome.status is Status.PASSED, happened(outcome)


def test_repeated_expectations_must_hold_at_each_of_their_times(tmp_path: Path) -> None:
    clauses = "(at 5 (asserts (battery 9))) (at 1 :every 1 :until {} "
    clauses += "(expect (memory (battery 33)))) (options (battery 33)) (until 20)"
    assert outcome_of(tmp_path, clauses.format(4)).status is Status.PASSED
    assert outcome_of(tmp_path, clauses.format(5)).status is Status.FAILED
    early = outcome_of(tmp_path, clauses.format(4).replace("until 20", "until 2"))
    assert "never reached" in happened(early)[0]
