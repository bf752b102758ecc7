"""`rapc view --export`: Chrome traces for Perfetto, and MCAP files."""

from __future__ import annotations

import json
from collections import Counter
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from jsonschema.protocols import Validator
from jsonschema.validators import validator_for
from mcap.reader import make_reader

from rapc.cli import view
from rapc.view.chrome import chrome_trace
from tests.cli.command import rapc

RUNS = {
    "truck": ("examples/rock-order.rap", "--task", "(rock-order red 1)"),
    "hallway": ("stdlib/hallway", "--agenda", "errand", "--until", "60"),
    "courier": ("examples/courier", "--agenda", "shift", "--until", "900"),
}

SCHEMA = json.loads(Path(__file__).with_name("chrome.schema.json").read_text())


@pytest.fixture(scope="module", params=sorted(RUNS))
def trace(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """Return the trace of a run of a world."""
    library, *given = RUNS[request.param]
    file = tmp_path_factory.mktemp("traces") / f"{request.param}.jsonl"
    run = ("run", library, "--world", request.param, *given, "-q")
    rapc(*run, "--trace", str(file))
    return file


def events_of(trace: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in trace.read_text().splitlines()]


def exported(trace: Path, suffix: str) -> Path:
    file = trace.with_suffix(suffix)
    done = rapc("view", str(trace), "--export", str(file))
    assert (done.returncode, done.stdout) == (0, f"wrote {file}\n"), done.stderr
    return file


def test_chrome_trace_holds_to_its_schema_and_has_all_events(trace: Path) -> None:
    found = json.loads(exported(trace, ".json").read_text())
    jsonschema.validate(found, SCHEMA)
    kinds = Counter(one["event"] for one in events_of(trace))
    entries = found["traceEvents"]
    phases = Counter((one["ph"], one.get("cat")) for one in entries)
    created, chosen = kinds["task-created"], kinds["method-chosen"]
    assert phases["b", "task"] == phases["e", "task"] == created + chosen
    assert phases["X", "request"] == kinds["primitive-requested"]
    assert phases["X", "skill"] == kinds["skill-enabled"]
    assert phases["i", "signal"] == kinds["signal"]
    assert phases["i", "data-received"] == kinds["data-received"]
    names = {one["pid"] for one in entries if one["name"] == "process_name"}
    assert {one["pid"] for one in entries} == names


def test_slices_of_a_chrome_trace_are_nested(trace: Path) -> None:
    found = json.loads(exported(trace, ".json").read_text())["traceEvents"]
    open_: dict[str, list[str]] = {}
    for one in found:
        if one["ph"] == "b":
            open_.setdefault(one["id"], []).append(one["name"])
        elif one["ph"] == "e":
            assert open_[one["id"]].pop() == one["name"]
    assert not any(open_.values())
    ends: dict[tuple[int, int], float] = {}
    for one in found:
        if one["ph"] == "X":
            lane = one["pid"], one["tid"]
            assert one["ts"] >= ends.get(lane, 0)
            ends[lane] = one["ts"] + one["dur"]


def test_chrome_trace_of_a_cut_run_ends_its_slices() -> None:
    created = {"task": 1, "goal": "(go)", "family": 1, "parent": None, "step": None}
    asked = {"task": 1, "request": "(drive)", "sent": "(drive)"}
    found = chrome_trace(
        [
            {"event": "task-created", "time": 0, "priority": 0, **created},
            {"event": "primitive-requested", "time": 1, **asked},
            {"event": "fact-asserted", "time": 3, "fact": "(a)", "by": "user"},
        ]
    )
    jsonschema.validate(found, SCHEMA)
    [drive] = [one for one in found["traceEvents"] if one["ph"] == "X"]
    assert (drive["ts"], drive["dur"]) == (1e6, 2e6)
    assert found["traceEvents"][-1]["args"]["outcome"] == "unfinished"


@cache
def validator(schema: bytes) -> Validator:
    """Return a validator; `jsonschema.validate` checks the schema at each call."""
    given = json.loads(schema)
    kind = validator_for(given)
    kind.check_schema(given)
    return kind(given)


def test_mcap_file_has_all_events_and_the_pose(trace: Path) -> None:
    reader = make_reader(BytesIO(exported(trace, ".mcap").read_bytes()))
    messages: dict[str, list[Any]] = {}
    for schema, channel, message in reader.iter_messages():
        assert schema is not None
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        given = json.loads(message.data)
        validator(schema.data).validate(given)
        if channel.topic in ("/tasks", "/requests", "/memory", "/events"):
            assert message.log_time == round(given["time"] * 1e9)
        messages.setdefault(channel.topic, []).append(given)
    own = [*messages["/tasks"], *messages.get("/requests", ()), *messages["/memory"]]
    own += messages["/events"]
    assert sorted(own, key=lambda one: int(one["n"])) == events_of(trace)
    assert all(one["event"].startswith(("fact", "item")) for one in messages["/memory"])
    assert len(messages["/pose"]) == len(messages["/picture"]) > 2
    [entity] = messages["/map"][0]["entities"]
    assert entity["texts"]
    if trace.stem == "hallway":
        assert len(messages["/pose/believed"]) > 2
        assert len(entity["lines"][0]["points"]) > 100


def test_recorded_pictures_are_exported(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    library, *given = RUNS["truck"]
    run = ("run", library, "--world", "truck", *given, "-q", "--trace", str(trace))
    assert rapc(*run, "--trace-pictures").returncode == 0
    reader = make_reader(BytesIO(exported(trace, ".mcap").read_bytes()))
    summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    topics = {one.topic: one.id for one in summary.channels.values()}
    pictured = [one for one in events_of(trace) if one["event"] == "pictured"]
    counts = summary.statistics.channel_message_counts
    assert counts[topics["/picture"]] == len(pictured)


def test_invalid_pictures_of_a_trace_are_refused(tmp_path: Path) -> None:
    started = '"event": "run-started", "n": 0, "format": 2, "spec": {"world": "none"}'
    pictured = '"event": "pictured", "n": 1, "changed": {"here": 1, "spots": [5]}'
    trace = tmp_path / "odd.jsonl"
    lines = [f'{{{one}, "cycle": 0, "time": 0}}\n' for one in (started, pictured)]
    trace.write_text("".join(lines))
    for option, name in (("--export", "odd.mcap"), ("--picture", "odd.svg")):
        done = rapc("view", str(trace), option, str(tmp_path / name))
        assert done.returncode == 2
        assert "error: the trace has an invalid picture: " in done.stderr


def test_other_suffixes_and_inputs_are_refused(trace: Path) -> None:
    done = rapc("view", str(trace), "--export", "run.bag")
    assert done.returncode == 2
    assert "expected FILE.json or FILE.mcap, not `run.bag`" in done.stderr
    done = rapc("view", str(trace), "--export", str(trace.with_suffix(".txt")))
    assert done.returncode == 2


def test_missing_package_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(view, "find_spec", lambda name: None)
    with pytest.raises(SystemExit):
        view.view.main(["run.jsonl", "--export", "run.mcap"], standalone_mode=False)
    assert "require: pip install 'rapc[mcap]'" in capsys.readouterr().err
