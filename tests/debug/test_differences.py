"""Two runs compared: the first different decision, its reasons, and its cost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import pytest

import rapc
from rapc.debug import costs, recorded
from rapc.debug.acts import EraseFacts
from rapc.debug.answer import Answer
from rapc.debug.history import History
from rapc.debug.questions.differences import diff
from rapc.debug.story import Story
from rapc.errors import ArgumentError
from tests.debug.sessions import row, scripted, truck

COURIER = Path("examples/courier")


def _courier(folder: Path = COURIER, seed: int = 1) -> History:
    library = rapc.load(folder)
    return History.open(library, "courier", agenda="shift", seed=seed)


@pytest.fixture
def never_charged(tmp_path: Path) -> Path:
    """Return a courier library whose robot waits for a battery that is never full."""
    for file in COURIER.glob("*.rap"):
        text = file.read_text().replace("(>= ?level 90)", "(> ?level 100)")
        (tmp_path / file.name).write_text(text)
    return tmp_path


def _row(found: Answer, of: str, what: str) -> tuple[object, object]:
    [row] = [one for one in found.rows if (one["of"], one["what"]) == (of, what)]
    here, there = [row[key] for key in row][2:4]
    return here, there


def test_comparison_with_another_library_names_cause_and_cost(
    never_charged: Path,
) -> None:
    history = _courier()
    history.go()
    found = diff(history, f"library {never_charged}")
    there = str(never_charged)
    assert found.lines[:11] == (
        f"time: here 831, {there} 1118 (+34.5 %)",
        "first different decision, in cycle 24:",
        "  here: (stay-until-charged) [20] was selected at 116",
        "    woken by (or (charged) (not (robot-at base)))",
        "    (>= ?level 90) at examples/courier/charging.rap:13",
        "    after datum (battery 94) at 116",
        f"    {there}: [20] at 116: blocked until (or (charged) (not (robot-at base))) "
        "since 76",
        f"      (> ?level 100) at {there}/charging.rap:13",
        f"  {there}: (answer-calls) [1] was selected at 131",
        "    woken by (can-help ?)",
        f"    (> ?level (+ (way ?here ?room) (way ?room base) ?spare)) at {there}"
        "/moving.rap:40",
    )
    assert _row(found, "kind", "waiting") == (272, 456)
    assert _row(found, "family", "(stay-charged)") == (300, 447)
    assert _row(found, "waiting", "monitor of stay-until-charged") == (180, 323)
    waited = "(stay-charged): waiting for monitor of stay-until-charged"
    assert _row(found, "in family", waited) == (180, 323)
    place = str(never_charged / "charging.rap")
    assert found.notes == (f"{place}:11:1: query `charged` changed",)


def test_times_by_kind_and_family_add_up(never_charged: Path) -> None:
    history = _courier()
    history.go()
    found = diff(history, f"library {never_charged}")
    for of in ("kind", "family"):
        rows = [one for one in found.rows if one["of"] == of]
        assert sum(float(str(one["difference"])) for one in rows) == 1118 - 831


def test_equal_runs_have_no_difference(tmp_path: Path) -> None:
    history = _courier()
    history.go()
    recorded.write_trace(history, tmp_path / "run.jsonl")
    same = (
        "no difference in time and successes",
        "no difference in decisions",
        "no difference in times",
    )
    for other in ("seed 1", "branch main", f"library {COURIER}"):
        assert diff(history, other).lines == same
    assert diff(history, str(tmp_path / "run.jsonl")).lines == same


def test_runs_are_compared_up_to_the_present_moment(tmp_path: Path) -> None:
    history = _courier()
    history.go()
    recorded.write_trace(history, tmp_path / "run.jsonl")
    history.goto(60)
    for other in ("seed 1", "branch main", str(tmp_path / "run.jsonl")):
        assert diff(history, other).lines[1] == "no difference in decisions"
        assert diff(history, other).lines[0] == "no difference in time and successes"


def test_branch_is_compared_with_the_branch_before() -> None:
    history = truck("(rock-order red 1)")
    history.go()
    history.goto(30)
    history.act(EraseFacts(("truck-location",)))
    history.go()
    assert history.branch.name == "branch-1"
    serial, state = history.serial, history.run.save()
    found = diff(history, "branch main")
    assert any("first different decision, in cycle " in one for one in found.lines)
    assert (history.serial, history.run.save()) == (serial, state)
    with pytest.raises(ArgumentError, match="unknown branch `x`"):
        diff(history, "branch x")


def test_other_seed_differs_by_an_event_of_the_world() -> None:
    history = _courier()
    history.go()
    found = diff(history, "seed 2")
    at = found.lines.index("first different event before:")
    assert found.lines[at + 1 :] == (
        "  here: (call ward-2) asserted at 131 by handler",
        "  seed 2: (robot-at corridor) asserted at 136 by handler",
    )


def test_reasons_of_a_choice_are_the_facts_that_differ(tmp_path: Path) -> None:
    for file in Path("stdlib/hallway").glob("*.rap"):
        text = file.read_text().replace("(+ ?heading 3.14159)", "?heading")
        (tmp_path / file.name).write_text(text)
    library = rapc.load("stdlib/hallway")
    history = History.open(library, "hallway", agenda="errand", seed=1)
    history.goto_time(40)
    found = diff(history, f"library {tmp_path}")
    at = found.lines.index("first different decision, in cycle 22:")
    here, because, there, otherwise = found.lines[at + 1 : at + 5]
    assert here.startswith("  here: [23] chose search of go-to-landmark-here at 14.9")
    assert "?facing 1.57159 " in here
    assert "?facing -1.57 " in there
    assert because.startswith("    because of (base lab-door 4.951 14.03 1.571589")
    assert " at stdlib/hallway/travel.rap:" in because
    assert otherwise.startswith("    because of (base lab-door 4.951 14.03 -1.57), ")
    assert f" at {tmp_path}/travel.rap:" in otherwise


def _changed(folder: Path, file: str, old: str, new: str) -> Path:
    """Return a courier library with a changed line."""
    for one in COURIER.glob("*.rap"):
        text = one.read_text()
        assert one.name != file or old in text
        (folder / one.name).write_text(text.replace(old, new))
    return folder


def test_different_step_is_named_with_its_method_and_line(tmp_path: Path) -> None:
    slow = _changed(tmp_path, "moving.rap", "(halt-for 10)", "(halt-for 100)")
    recorded_file = tmp_path / "run.jsonl"
    options = {"blocked": 40}
    before = History.open(
        rapc.load(COURIER), "courier", agenda="shift", seed=1, options=options
    )
    before.go()
    recorded.write_trace(before, recorded_file)
    history = History.open(
        rapc.load(slow), "courier", agenda="shift", seed=1, options=options
    )
    history.go()
    found = diff(history, str(recorded_file))
    at = found.lines.index("first different event before:")
    here, because = found.lines[at + 1 : at + 3]
    assert here.startswith("  here: creating task (halt-for 100) ")
    step = f"step t1 of method let-pass of travel-to at {slow}/moving.rap:23"
    assert because == f"    {step}"


def test_different_method_is_named_with_its_line(tmp_path: Path) -> None:
    there = """
    (declare-primitive tick () (okay))
    (define-rap (go)
      (method one (context true) (primitive (tick)))
      (method two (context otherwise) (primitive (tick))))
    """
    for text in (there, there.replace("context true", "context (not true)")):
        session = scripted(text, "(go)", rows=(row("(tick)"),))
        session.go()
        if text is there:
            recorded.write_trace(session, tmp_path / "run.jsonl")
    found = diff(session, str(tmp_path / "run.jsonl"))
    here, because = found.lines[2:4]
    assert here.startswith("  here: [1] chose two of go at 0")
    assert because == "    method two of go at small.rap:5"


def test_wait_names_the_limit_of_age_in_a_query() -> None:
    story = Story((), rapc.load("examples/laboratory").program)
    assert story.wait("(not (known-standard ?))", 1) == (
        "(believe (standard-value ?value) 80)",
        "examples/laboratory/measuring.rap:6",
    )


def test_run_with_faults_is_not_begun_again(tmp_path: Path) -> None:
    history = _courier()
    history.spec = rapc.RunSpec(faults=("(dock) stuck",))
    with pytest.raises(ArgumentError, match="cannot begin a run with faults again"):
        diff(history, "seed 2")


# --- figures ------------------------------------------------------------------------


def _times(
    time: float,
    succeeded: int = 1,
    families: Mapping[str, float] = MappingProxyType({}),
) -> costs.Times:
    shares = tuple([(goal, "acting", "go", t) for goal, t in families.items()])
    return costs.Times(time, "done", succeeded, 0, shares, shares, (), {}, {})


def test_change_of_pairs_has_a_confidence_interval() -> None:
    pairs = [(10.0, 12.0), (20.0, 21.0), (30.0, 33.0)]
    found = costs.change("run", "time", pairs)
    assert (found.before, found.after, found.difference) == (20, 22, 2)
    assert found.margin == pytest.approx(4.303 / 3**0.5, rel=1e-3)
    assert not found.is_significant
    assert costs.change("run", "time", [(10.0, 12.0), (20.0, 22.0)]).is_significant
    many = costs.change("run", "time", [(0.0, n % 2 + 1.0) for n in range(30)])
    assert many.margin == pytest.approx(2.0452 * 0.5085 / 30**0.5, rel=1e-3)


@pytest.mark.parametrize(
    ("after", "threshold", "lines", "worse"),
    [
        (_times(100), 0, ("no difference in time and successes",), False),
        (_times(104), 5, ("time: a 100, b 104 (+4.0 %)",), False),
        (_times(105), 5, ("time: a 100, b 105 (+5.0 %)",), True),
        (_times(50), 5, ("time: a 100, b 50 (-50.0 %)",), False),
        (
            _times(50, 0),
            5,
            ("time: a 100, b 50 (-50.0 %)", "tasks succeeded: a 1, b 0 (-100.0 %)"),
            True,
        ),
    ],
)
def test_verdict_compares_successes_before_time(
    after: costs.Times, threshold: float, lines: tuple[str, ...], worse: bool
) -> None:
    found = costs.verdict([(_times(100), after)], ("a", "b"), threshold)
    assert (found.lines, found.worse) == (lines, worse)


def test_rows_beyond_the_most_are_counted() -> None:
    many = {f"(go {n})": float(n + 1) for n in range(9)}
    found = costs.changes([(_times(45), _times(45, 1, many))])
    rows = [row for row in costs.rows(found) if row[0] == "family"]
    assert [row[1] for row in rows[:2]] == ["(go 8)", "(go 7)"]
    assert rows[-1][:2] == ("family", "... and 3 more")
