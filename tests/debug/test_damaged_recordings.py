"""Damaged recordings end in a line that says so, never in a fault of rapc."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import pytest

import rapc
from rapc.debug.history import History
from rapc.debug.recorded import Replay, write_trace
from rapc.debug.recording import Playback, Recording
from rapc.errors import LoadError
from rapc.repl.commands.table import commands
from rapc.repl.draw import draw
from rapc.repl.shell import Shell
from tests.cli.command import rapc as command
from tests.debug.sessions import truck
from tests.effort import first

Lines = list[bytes]

OPTIONS = {"arm1-drops": 60, "arm2-drops": 60}

JUNK: tuple[Any, ...] = (
    *(None, True, -1, 0, 3, 1.5, 10**30, -1e308, 1e16, 2**63, "", "x", "(", ")", "()"),
    *('"', "(a", "(a (b c))", '(a "b', "(a 1e999)", "=>", "(=> a)", "\x00\x1b[2J", "é"),
    *([], [1], ["(a)"], [[]], {}, {"a": 1}, {"task": 1}, [{"task": 1}], "(" * 2000),
    *({"clause": 1}, {"clause": "c", "because": {}}, {"?x": "(a"}, {"?x": 3}),
)

COMMANDS = (
    *(":goto 5", ":tree", ":step", ":trace 9", ":primitive", ":find task-failed"),
    *(":find back fact-asserted a", ":timeline", ":retries", ":deadlines", ":run"),
    *(":history (location ?)", ":history item-1", ":back 2", ":goto at 30", ":tree"),
    *(":goto end", ":trace", ":to at 1e9", ":find run-ended"),
)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Lines]:
    """The lines of a run of the truck, and of one of the hallway."""
    path = tmp_path_factory.mktemp("whole") / "run.jsonl"
    hallway = History.open(rapc.load("stdlib/hallway"), "hallway", agenda="errand")
    found = []
    for session in (truck(options=OPTIONS), hallway):
        session.go()
        write_trace(session, path)
        found.append(path.read_bytes().splitlines(keepends=True))
    return found


def _key(lines: Lines, chance: random.Random) -> None:
    """Put junk in the place of the value of a key, or of a key of it."""
    at = chance.randrange(len(lines))
    event = json.loads(lines[at])
    inner: Any = event
    while True:
        places = list(inner) if isinstance(inner, dict) else range(len(inner))
        place = chance.choice(list(places))
        if not (isinstance(inner[place], dict | list) and inner[place]):
            break
        inner = inner[place]
    inner[place] = chance.choice(JUNK)
    lines[at] = json.dumps(event).encode() + b"\n"


def _no_key(lines: Lines, chance: random.Random) -> None:
    at = chance.randrange(len(lines))
    event = json.loads(lines[at])
    del event[chance.choice(list(event))]
    lines[at] = json.dumps(event).encode() + b"\n"


def _bytes(lines: Lines, chance: random.Random) -> None:
    at = chance.randrange(len(lines))
    changed = bytearray(lines[at])
    for _ in range(chance.randrange(1, 4)):
        changed[chance.randrange(len(changed))] = chance.randrange(256)
    lines[at] = bytes(changed)


def _nested(lines: Lines, chance: random.Random) -> None:
    at = chance.randrange(len(lines))
    junk = chance.choice((b"[", b'{"because":')) * 100_000
    lines[at] = chance.choice((junk, lines[at][:-2] + b',"x":' + junk)) + b"\n"


def _cut(lines: Lines, chance: random.Random) -> None:
    at = chance.randrange(len(lines))
    lines[at] = lines[at][: chance.randrange(len(lines[at]))]
    del lines[at + 1 :]


def _order(lines: Lines, chance: random.Random) -> None:
    one, other = (chance.randrange(len(lines)) for _ in range(2))
    lines[one] = lines[other]


def _kind(lines: Lines, chance: random.Random) -> None:
    """Let an event call itself another, and have its keys."""
    at, other = (chance.randrange(len(lines)) for _ in range(2))
    event, told = json.loads(lines[at]), json.loads(lines[other])
    event.update({k: v for k, v in told.items() if k not in ("n", "cycle", "time")})
    lines[at] = json.dumps(event).encode() + b"\n"


DAMAGES: tuple[Callable[[Lines, random.Random], None], ...] = (
    *(_key, _no_key, _kind, _order, _bytes, _nested, _cut),
)
"""Those that need whole lines come first."""


def _damaged(lines: Lines, chance: random.Random) -> Lines:
    lines = lines[:]
    chosen = chance.choices(DAMAGES, (4, 2, 2, 1, 1, 1, 1), k=chance.randrange(1, 4))
    for damage in sorted(chosen, key=DAMAGES.index):
        damage(lines, chance)
    return lines


T = TypeVar("T")


def _made(make: Callable[[Path], T], path: Path) -> T | None:
    """Return what is made of a recording, or None for one that is refused in a line."""
    try:
        return make(path)
    except LoadError as error:
        if "not a trace" not in error.message:
            raise
        return None


def _asked(shell: Shell, chance: random.Random) -> bool:
    """Ask all sorts of things; return whether any was refused."""
    refused = False
    for text in chance.sample(COMMANDS, 9):
        answer = shell.answer(text)
        if answer.failed:
            refused = True
            assert len(answer.lines) == 1, (text, answer.lines)
            assert "not a trace" in answer.lines[0], (text, answer.lines)
        for line in draw(answer, 80, color=False).splitlines():
            assert line.isprintable(), (text, line)
    return refused


@pytest.mark.parametrize("seed", first(2, range(40), 12))
def test_damaged_recording_has_an_answer_to_every_command(
    seed: int, recordings: list[Lines], tmp_path: Path
) -> None:
    chance = random.Random(seed)
    path, refused = tmp_path / "run.jsonl", 0
    for _ in range(40):
        path.write_bytes(b"".join(_damaged(chance.choice(recordings), chance)))
        tape = _made(lambda path: History(Playback(Recording(path))), path)
        refused += tape is None or _asked(Shell(tape, commands()), chance)
    assert 5 < refused < 40


@pytest.mark.parametrize("seed", first(1, range(10), 4))
def test_run_beside_a_damaged_recording_goes_on(
    seed: int, recordings: list[Lines], tmp_path: Path
) -> None:
    chance = random.Random(seed)
    path, parted = tmp_path / "run.jsonl", 0
    for _ in range(8):
        whole = recordings[0]
        path.write_bytes(b"".join([whole[0], *_damaged(whole[1:], chance)]))
        session, recording = truck(options=OPTIONS), _made(Recording, path)
        if recording is None:
            continue
        replay = Replay(session, recording)
        assert not Shell(session, commands()).answer(":goto end").failed
        parted += replay.parted is not None
    assert parted


@pytest.mark.parametrize("seed", first(1, range(10), 4))
def test_damaged_beginning_of_a_recording_is_refused_or_looked_at(
    seed: int, recordings: list[Lines], tmp_path: Path
) -> None:
    chance = random.Random(seed)
    path = tmp_path / "run.jsonl"
    for _ in range(6):
        begun = [recordings[0][0]]
        chance.choice((_key, _no_key, _bytes, _nested))(begun, chance)
        path.write_bytes(b"".join([*begun, *recordings[0][1:]]))
        done = command("repl", str(path), "-c", ":goto 9", "-c", ":tree")
        assert done.returncode in (0, 1, 2)
        assert done.stderr or done.stdout
