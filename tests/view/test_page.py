"""The page of a run as text: its data, and the policy against requests."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from pathlib import Path
from typing import Any

import pytest

from rapc import load, open_world
from rapc.durable import journal
from rapc.durable.folder import Options
from rapc.spec import RunSpec
from rapc.view.page import page
from tests.cli.command import rapc
from tests.durable.helpers import Run

COURIER = "examples/courier"
SHIFT = ("--world", "courier", "--agenda", "shift", "--until", "3000")


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the trace of a run of the courier."""
    file = tmp_path_factory.mktemp("traces") / "shift.jsonl"
    run = ("run", COURIER, *SHIFT, "--seed", "1", "-q", "--trace", str(file))
    assert rapc(*run).returncode == 0
    return file


def data_of(text: str) -> dict[str, bytes]:
    """Return the data in a page, by name."""
    elements = re.findall(r'id="data-([a-z0-9-]+)">([A-Za-z0-9+/=]*)</script>', text)
    return {name: gzip.decompress(base64.b64decode(data)) for name, data in elements}


def viewed(*args: str, output: Path) -> dict[str, bytes]:
    done = rapc("view", *args, "-o", str(output))
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert done.stdout == f"wrote {output}\n"
    return data_of(output.read_text(encoding="utf-8"))


def more_of(data: dict[str, bytes], at: int = 0) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(data[f"more-{at}"])
    return found


def test_policy_allows_only_the_script_and_the_style_of_the_page() -> None:
    text = page()
    [policy] = re.findall(r'http-equiv="Content-Security-Policy" content="(.*?)"', text)
    assert policy.startswith("default-src 'none'; ")
    for tag in ("script", "style"):
        [content] = re.findall(f"<{tag}>(.*?)</{tag}>", text, re.S)
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy
    assert not re.search(r"\b(src|href)=|https://|@import|\burl\(", text)


def test_page_has_the_trace_the_library_and_the_truth(
    trace: Path, tmp_path: Path
) -> None:
    data = viewed(str(trace), output=tmp_path / "shift.html")
    assert data["trace-0"] == trace.read_bytes()
    more = more_of(data)
    assert more["note"] == ""
    rap = more["raps"]["stay-until-charged"]
    text = more["sources"][rap["file"]].split("\n")
    assert text[rap["rows"][0] - 1].startswith("(define-rap (stay-until-charged)")
    method = more["raps"]["fetch"]["methods"]["from-a-store"]
    assert method["claims"] == ["wheels"]
    for tag, (first, _) in method["steps"].items():
        assert f"({tag} " in more["sources"][method["file"]].split("\n")[first - 1]


def test_page_of_a_library_that_is_run_has_the_same_trace(
    trace: Path, tmp_path: Path
) -> None:
    data = viewed(COURIER, *SHIFT, "--seed", "1", output=tmp_path / "page.html")
    assert data["trace-0"] == trace.read_bytes()


def test_page_of_a_report_has_the_trace_of_the_run(trace: Path, tmp_path: Path) -> None:
    report = str(tmp_path / "shift.bug")
    assert rapc("bug", str(trace), "-o", report).returncode == 0
    data = viewed(report, output=tmp_path / "page.html")
    assert data["trace-0"].splitlines()[1:] == trace.read_bytes().splitlines()[1:]


@pytest.mark.slow
def test_page_of_a_long_run_has_all_events(tmp_path: Path) -> None:
    """The log of a history drops the oldest events of a long run."""
    run = ("stdlib/truck", "--world", "truck", "--agenda", "nine-orders")
    more = ["--task", "(fill-order red 4 factory-2)"] * 9
    data = viewed(*run, *more, output=tmp_path / "page.html")
    lines = data["trace-0"].splitlines()
    assert len(lines) > 60_000
    assert [json.loads(line)["n"] for line in lines] == [*range(len(lines))]


def test_wrong_beliefs_of_the_hallway_are_in_the_page(tmp_path: Path) -> None:
    run = ("stdlib/hallway", "--world", "hallway", "--agenda", "errand")
    data = viewed(*run, "--seed", "3", output=tmp_path / "page.html")
    events = [json.loads(line) for line in data["trace-0"].splitlines()]
    for one in more_of(data)["beliefs"]:
        assert events[one["n"]]["event"] in ("task-selected", "run-ended")
        assert one["fact"].startswith("(")


def test_text_of_the_run_is_not_in_the_markup(tmp_path: Path) -> None:
    events = [
        {"event": "run-started", "format": 2, "spec": {"library": "</script><b>x"}},
        {
            **{
                "event": "task-created",
                "task": 1,
                "goal": "<img src=x onerror=alert(1)>",
            },
            **{"parent": None, "family": 1, "priority": 0, "step": None},
        },
    ]
    lines = [{**one, "n": n, "cycle": 0, "time": 0} for n, one in enumerate(events)]
    file = tmp_path / "odd.jsonl"
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    output = tmp_path / "odd.html"
    done = rapc("view", str(file), "-o", str(output))
    assert done.returncode == 0
    text = output.read_text(encoding="utf-8")
    assert "onerror" not in text
    assert text.count("<b>") == 0
    assert data_of(text)["trace-0"] == file.read_bytes()


def test_changed_library_is_not_in_the_page(trace: Path, tmp_path: Path) -> None:
    text = trace.read_text().replace('"digest":"', '"digest":"0', 1)
    changed = tmp_path / "changed.jsonl"
    changed.write_text(text)
    output = tmp_path / "page.html"
    done = rapc("view", str(changed), "-o", str(output))
    assert "the library has changed since the recording" in done.stderr
    more = more_of(data_of(output.read_text(encoding="utf-8")))
    assert (more["sources"], more["raps"]) == ({}, {})


def test_two_runs_are_compared(trace: Path, tmp_path: Path) -> None:
    slow = tmp_path / "slow"
    slow.mkdir()
    for file in Path(COURIER).glob("*.rap"):
        text = file.read_text().replace("(>= ?level 90)", "(> ?level 100)")
        (slow / file.name).write_text(text)
    output = tmp_path / "page.html"
    data = viewed(str(trace), "--compare", str(slow), output=output)
    found = json.loads(data["comparison"])
    assert found["lines"][0] == "time: before 831, after 1118 (+34.5 %)"
    assert len(found["rows"]) > 3
    for name, first in zip(("trace-0", "trace-1"), found["first"], strict=True):
        event = json.loads(data[name].splitlines()[first])
        assert event["event"] in ("task-selected", "method-chosen")


def test_journal_is_viewed_and_a_report_is_compared_with_it(tmp_path: Path) -> None:
    folder, report, output = (tmp_path / name for name in ("day", "day.bug", "p.html"))
    begin = (COURIER, "--world", "courier", "--task", "(deliver linen ward-1)")
    assert rapc("run", *begin, "-q", "--journal", str(folder)).returncode == 0
    assert rapc("bug", *begin, "-o", str(report)).returncode == 0
    data = viewed(str(folder), "--compare", str(report), output=output)
    assert data["trace-0"].splitlines()[1:] == data["trace-1"].splitlines()[1:]
    assert json.loads(data["comparison"])["first"] == []


def check_later_start(data: dict[str, bytes], trace: Path) -> int:
    """Check the page of a run whose first events are unknown; return their number."""
    shown = [json.loads(line) for line in data["trace-0"].splitlines()]
    whole = [json.loads(line) for line in trace.read_bytes().splitlines()]
    begun = next(at for at, event in enumerate(shown) if event["cycle"])
    first: int = shown[begun]["n"]
    assert shown[0]["event"] == "run-started"
    assert shown[begun:] == whole[first:]
    assert [one["n"] for one in shown] == [*range(first - begun, len(whole))]
    facts: dict[str, int] = {}
    for event in whole[:first]:
        if event["event"] == "fact-asserted":
            facts[event["fact"]] = event["time"]
        elif event["event"] == "fact-erased":
            del facts[event["fact"]]
    given = [one for one in shown[:begun] if one["event"] == "fact-asserted"]
    assert {one["fact"]: one["time"] for one in given} == facts
    more = more_of(data)
    cycle = shown[begun]["cycle"]
    notes = [f"what happened up to cycle {n} is unknown" for n in (cycle - 1, cycle)]
    assert more["note"] in notes
    for at, _ in more["pictures"]:
        assert 0 <= at < len(shown)
    for one in more["beliefs"]:
        assert shown[one["n"]]["time"] >= shown[begun]["time"]
    return first


def test_saved_state_is_continued(tmp_path: Path) -> None:
    state, trace = tmp_path / "half.state", tmp_path / "whole.jsonl"
    run = ("run", COURIER, "--world", "courier", "--agenda", "shift", "-q")
    assert rapc(*run, "--trace", str(trace)).returncode == 0
    assert rapc(*run, "--until", "300", "--save", str(state)).returncode == 1
    data = viewed(str(state), output=tmp_path / "page.html")
    assert check_later_start(data, trace) > 100
    data = viewed(str(state), "--until", "400", output=tmp_path / "page.html")
    last = json.loads(data["trace-0"].splitlines()[-1])
    assert 400 <= last["time"] < 450
    for more, said in (
        (("--until", "299"), "--until: the saved state is at time 3"),
        (("--picture", "x.svg", "--at", "3"), "--at: expected a cycle from "),
    ):
        done = rapc("view", str(state), *more)
        assert (done.returncode, said in done.stderr) == (2, True)
    state.write_bytes(state.read_bytes()[:-40])
    done = rapc("view", str(state))
    assert (done.returncode, "damaged" in done.stderr) == (2, True)


def test_journal_without_its_first_parts_begins_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal, "CYCLES", 20)
    monkeypatch.setattr(journal, "PAUSE", 0)
    program = load(COURIER).program
    spec = RunSpec(agenda="shift", seed=3, until=1500)
    run = Run(tmp_path, program, spec, lambda: open_world("courier", seed=3))
    run.options = Options(sync="off", limit=0)
    durable = run.begin()
    durable.go()
    durable.close()
    data = viewed(str(run.journal), output=tmp_path / "page.html")
    assert check_later_start(data, run.trace) > 100


@pytest.mark.parametrize(
    ("path", "file"), [("rapc:truck", "truck.html"), (".", "stock.html")]
)
def test_page_has_the_name_of_its_library(
    path: str, file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "stock").mkdir()
    (tmp_path / "stock" / "all.rap").write_text('(require "truck")')
    monkeypatch.chdir(tmp_path / "stock")
    given = ("--world", "truck", "--agenda", "nine-orders", "--until", "5")
    assert rapc("view", path, *given).stdout == f"wrote {file}\n"


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("{trace}", "--seed", "2"), "cannot change the start of a recorded run"),
        ((COURIER, "--world", "courier"), "missing --task or --agenda"),
        (("none.jsonl",), "cannot read `none.jsonl`"),
        (("{trace}", "-o", "{trace}"), "is an input of the command"),
        (("{trace}", "-o", "x.rap"), "is the suffix of a RAP file"),
        (("{trace}", "--picture", "x.png"), "expected FILE.svg, not `x.png`"),
        (("{trace}", "--picture", "x.svg", "--at", "9999"), "from 0 to "),
    ],
)
def test_wrong_use_ends_with_an_error(
    trace: Path, args: tuple[str, ...], said: str
) -> None:
    done = rapc("view", *(one.replace("{trace}", str(trace)) for one in args))
    assert done.returncode == 2
    assert said in done.stderr
