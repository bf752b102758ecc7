"""A driver that is served to an interpreter in another process."""

from __future__ import annotations

from tests.live.rover import SimulatedRover
from tests.worlds.remote.test_server import answers


class Kept(SimulatedRover):
    """A rover that is known after its connection has ended."""

    last: Kept

    def connect(self) -> None:
        Kept.last = self


def test_end_of_the_connection_halts_and_closes_the_driver() -> None:
    opening = "open", {"seed": 1}
    request = "perform", {"ticket": 1, "request": ["drive", "hall"]}
    _, told = answers(Kept, opening, request)
    assert told["result"]["next"] == "unknown"
    assert Kept.last._watchdog.armed is False
    acts = [one[1] for one in Kept.last.log]
    assert acts[0] == "drive"
    assert sorted(acts[1:]) == ["halt", "stop"]
