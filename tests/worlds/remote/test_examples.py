"""The examples of peers, and the JSON Schema of what the interpreter and peers send."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import rapc
from rapc.runtime.settings import Settings
from rapc.testing.contract.trials import try_world
from rapc.worlds.registry import build_world, find_world
from rapc.worlds.remote.protocol import METHODS, schema
from tests.worlds.remote.test_broken_peers import LIBRARY, PEER

EXAMPLES = Path(__file__).parents[3] / "examples" / "remote"
LAMPS = EXAMPLES / "lamps.rap"

RELAY = """
import subprocess, sys
peer = subprocess.Popen(sys.argv[2:], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
with open(sys.argv[1], "ab") as log:
    for line in sys.stdin.buffer:
        peer.stdin.write(line)
        peer.stdin.flush()
        answer = peer.stdout.readline()
        log.write(line + answer)
        log.flush()
        sys.stdout.buffer.write(answer)
        sys.stdout.flush()
"""
"""A peer that passes the calls to another peer, and logs all lines."""


def test_library_of_the_examples_has_no_findings() -> None:
    assert rapc.check(LAMPS).findings == ()


@pytest.mark.parametrize("name", ["lamps.js", "lamps.rap"])
def test_how_to_page_shows_the_examples(name: str) -> None:
    page = EXAMPLES.parents[1] / "docs" / "how-to" / "worlds-in-any-language.md"
    assert f'title="{name}"\n{(EXAMPLES / name).read_text()}```' in page.read_text()


def lights_all(address: str) -> None:
    """Check that a peer lights the lamps, and keeps the contract."""
    library = rapc.load(LAMPS)
    settings = Settings(strict=True)
    assert rapc.run(library, address, "(light-all)", settings=settings).run.now == 8
    found = find_world(address)
    trials = try_world(lambda seed: build_world(found, seed, {}), library.program)
    assert [fault for trial in trials for fault in trial.faults] == []


@pytest.mark.slow
def test_example_in_javascript_keeps_the_contract() -> None:
    if shutil.which("node") is None:
        pytest.skip("node is missing")
    lights_all(f"exec:node {EXAMPLES / 'lamps.js'}")


@pytest.mark.slow
def test_example_in_c_keeps_the_contract(tmp_path: Path) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("gcc is missing")
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2"]
    command = ["gcc", *strict, "-o", str(tmp_path / "lamps"), str(EXAMPLES / "lamps.c")]
    subprocess.run(command, check=True)
    lights_all(f"exec:{tmp_path / 'lamps'}")


def valid(method: str, part: str, value: Any) -> None:
    whole = schema()
    reference = {"$ref": f"#/$defs/{method}.{part}", "$defs": whole["$defs"]}
    jsonschema.Draft202012Validator(reference).validate(value)


def test_schema_is_valid() -> None:
    jsonschema.Draft202012Validator.check_schema(schema())


@pytest.mark.parametrize(
    ("peer", "library", "task"),
    [
        (f"{sys.executable} -ISu {PEER}", "lamps", "(light hall)"),
        (f"{sys.executable} -m rapc.worlds.remote truck", "stdlib/truck", "(set-up)"),
        pytest.param(
            f"{sys.executable} -m rapc.worlds.remote hallway",
            "stdlib/hallway",
            "",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_calls_and_answers_match_the_schema(
    peer: str, library: str, task: str, tmp_path: Path
) -> None:
    relay, log = tmp_path / "relay.py", tmp_path / "log"
    relay.write_text(RELAY)
    text = rapc.loads(LIBRARY) if library == "lamps" else rapc.load(library)
    address = f"exec:{sys.executable} {relay} {log} {peer}"
    agenda = None if task else "errand"
    made = rapc.run(text, address, task or (), agenda=agenda, until=30).run
    if library != "lamps":
        world: Any = made.world
        world.picture()
        world.truth()
        world.figures()
    made.restore(made.save())
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    seen = set()
    for call, answer in zip(lines[::2], lines[1::2], strict=True):
        method = call["method"]
        assert call["id"] == answer["id"]
        valid(method, "params", call["params"])
        valid(method, "result", answer["result"])
        seen.add(method)
    assert {"describe", "open", "save", "restore"} <= seen <= {*METHODS}
    assert seen & {"perform", "activate"}
