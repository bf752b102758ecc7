"""Worlds behind the wire are like worlds in the process."""

from __future__ import annotations

import copy
import gc
import io
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import rapc
from rapc.errors import WorldError
from rapc.runtime.interpreter import Interpreter
from rapc.testing.contract.trials import try_world
from rapc.world import Finished, Reply, Savable, Skilled, World
from rapc.worlds.registry import build_world, find_permitted, find_world, world_of
from rapc.worlds.remote.world import RemoteWorld
from tests.worlds.remote.test_broken_peers import LIBRARY, PEER, peer

SERVED = f"exec:{sys.executable} -m rapc.worlds.remote"


RUNS = {
    "truck": ("stdlib/truck", "nine-orders", ()),
    "courier": ("examples/courier", "shift", ()),
    "hallway": ("stdlib/hallway", "errand", ()),
}
NAMES = ["truck", *(pytest.param(n, marks=pytest.mark.slow) for n in list(RUNS)[1:])]


def trace(name: str, world: str, seed: int) -> str:
    """Return the trace of a run, without the first line, which names the world."""
    library, agenda, tasks = RUNS[name]
    stream = io.StringIO()
    program = rapc.load(library, check=False).program
    spec = rapc.RunSpec(
        world=world, world_class=world, seed=seed, agenda=agenda, tasks=tasks
    )
    run = Interpreter.prepared(program, world_of(spec), spec)
    run.listen(rapc.JsonTrace(stream))
    run.start()
    run.run(until=500)
    return stream.getvalue().partition("\n")[2]


@pytest.mark.parametrize("name", NAMES)
def test_trace_is_equal_behind_the_wire(name: str) -> None:
    inside = trace(name, name, 1)
    assert inside.count("\n") > 500
    assert trace(name, f"{SERVED} {name}", 1) == inside


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_served_world_keeps_the_contract(name: str) -> None:
    found = find_world(f"{SERVED} {name}")
    trials = try_world(lambda seed: build_world(found, seed, {}), count=40)
    assert [fault for trial in trials for fault in trial.faults] == []


def test_peer_keeps_the_contract() -> None:
    found = find_world(peer(""))
    program = rapc.loads(LIBRARY).program
    trials = try_world(lambda seed: build_world(found, seed, {}), program)
    assert [fault for trial in trials for fault in trial.faults] == []
    passed = [trial.part for trial in trials if not trial.left_out]
    assert "save and restore" in passed
    assert "handlers" in passed


def test_description_becomes_a_class() -> None:
    found = find_world(peer(""))
    assert (found.name, found.__doc__) == ("lamps", "Two lamps with switches.")
    assert found.kit.offer.primitives["press"] == (1, ("okay", "stuck"))
    assert found.kit.offer.not_atomic == ("warm",)
    assert found.kit.offer.arguments["warm"] == ("lamp",)
    assert [option.name for option in found.kit.options] == ["speed"]
    assert issubclass(found, Savable)
    assert not issubclass(found, Skilled)


def test_file_may_not_name_a_command() -> None:
    with pytest.raises(WorldError, match="of the form `exec:` may not be used") as told:
        find_permitted(peer(""), [])
    assert "--world-module exec" in told.value.help
    assert find_permitted(peer(""), ["exec"]).name == "lamps"


def opened(address: str) -> World:
    return build_world(find_world(address), 0, {})


def test_fetched_end_is_dropped_by_cancel() -> None:
    world = opened(peer(""))
    assert world.perform(1, ("warm", "hall")) is None
    assert world.next_time() == 5
    world.advance(5)
    world.cancel(1)
    assert world.messages() == ()


def test_saved_state_has_messages_not_fetched() -> None:
    world, other = opened(peer("")), opened(peer(""))
    assert isinstance(world, Savable)
    assert isinstance(other, Savable)
    world.perform(1, ("warm", "hall"))
    world.advance(5)
    other.restore(world.save())
    assert other.now() == 5
    assert other.messages() == [Finished(1, Reply("okay"))]
    with pytest.raises(ValueError, match="no state of the world `lamps`"):
        other.restore(b"no state")
    with pytest.raises(ValueError, match="other options"):
        other.restore(world.save().replace(b'"speed":2', b'"speed":3'))


def test_copy_of_a_world_starts_a_peer_of_its_own() -> None:
    world = opened(peer(""))
    world.perform(1, ("press", "hall"))
    other = copy.deepcopy(world)
    assert (world.now(), other.now()) == (2, 0)
    assert list(other.facts()) == list(world.facts())


def test_refused_options_name_the_world() -> None:
    found = find_world(f"{SERVED} truck")
    world = build_world(found, 0, {"fuel": 9, "fuel-capacity": 5})
    with pytest.raises(WorldError, match="`truck` refuses: `fuel` is more than"):
        world.facts()


def test_exception_of_a_served_world_names_its_place() -> None:
    world = opened(f"{SERVED} tests.worlds.remote.clumsy:Clumsy")
    with pytest.raises(rapc.PortError, match=r"KeyError: 'cup' \(clumsy.py:\d+\)"):
        world.perform(1, ("grasp", "cup"))


@pytest.fixture(params=["unix", "tcp"])
def listening(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[str]:
    """The address of a served world."""
    monkeypatch.setenv("RAPC_TOKEN", "a secret")
    with socket.socket() as held:
        # The server may use the port, too; other processes do not get the port.
        held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        held.bind(("127.0.0.1", 0))
        port = held.getsockname()[1]
        address = (
            f"tcp:127.0.0.1:{port}" if request.param == "tcp" else f"unix:{tmp_path}/s"
        )
        command = [sys.executable, "-m", "rapc.worlds.remote", "truck", address]
        server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert server.stderr is not None
        assert server.stderr.readline() == f"serving truck at {address}\n"
        yield address
        server.kill()
        server.wait()
        server.stderr.close()


def test_trace_is_equal_through_a_socket(listening: str) -> None:
    assert trace("truck", listening, 2) == trace("truck", "truck", 2)


def test_wrong_token_is_refused(
    listening: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAPC_TOKEN", "another secret")
    if listening.startswith("tcp:"):
        with pytest.raises(WorldError, match="`describe`: the token is wrong"):
            find_world(listening)
    else:
        assert find_world(listening).name == "truck"


def test_changed_peer_is_described_again(tmp_path: Path) -> None:
    script = tmp_path / "lamps.py"
    script.write_text(PEER.read_text())
    address = f"exec:{sys.executable} -ISu {script}"
    before = find_world(address)
    assert before.__doc__ == "Two lamps with switches."
    script.write_text(PEER.read_text().replace("Two lamps", "A pair of lamps"))
    assert find_world(address).__doc__ == "A pair of lamps with switches."
    with pytest.raises(
        rapc.PortError, match="another answer to `describe` than before"
    ):
        build_world(before, 0, {}).facts()


def test_peer_ends_with_its_world() -> None:
    world = opened(peer(""))
    world.facts()
    assert isinstance(world, RemoteWorld)
    connection = world._connected()
    del world
    gc.collect()
    assert connection.broken
