"""Requests and activations with an unknown outcome: `Lost`."""

from __future__ import annotations

from typing import Any

import pytest

import rapc
from rapc.events import Event, MethodEnded, RequestRefused
from rapc.world import Kit, Lost, Offer, Reply, SimpleWorld

LIBRARY = """
(declare-primitive drive () (okay) :atomic false)
(declare-primitive walk () (okay))
(define-rap (go)
  (method by-car (primitive (drive)))
  (method on-foot (primitive (walk))))
"""


class Road(SimpleWorld):
    """A world that loses the request to drive."""

    name = "road"
    kit = Kit(
        Offer(
            primitives={"drive": (0, ("okay",)), "walk": (0, ("okay",))},
            not_atomic=("drive",),
        )
    )
    #: The difference between the ticket of the request and the lost ticket.
    off = 0

    def perform(self, ticket: int, request: Any) -> Reply | None:
        if request == ("walk",):
            return Reply("okay")
        self.send(Lost(ticket + self.off, "the drive did not answer"), after=5)
        return None


def test_lost_request_ends_like_a_refused_request() -> None:
    seen: list[Event] = []
    run = rapc.loads(LIBRARY).start(Road(), tasks="(go)", listeners=[seen.append])
    assert run.run() == "done"
    assert [one.outcome for one in run.results()] == ["succeeded"]
    refused = [one for one in seen if isinstance(one, RequestRefused)]
    assert [(one.request, one.because) for one in refused] == [
        (("drive",), "the drive did not answer")
    ]
    ended = [one for one in seen if isinstance(one, MethodEnded)]
    assert [(one.method, one.result) for one in ended] == [
        ("by-car", "interference"),
        ("on-foot", "okay"),
    ]
    assert run.now == 5


def test_lost_ticket_must_be_under_way() -> None:
    world = Road()
    world.off = 1
    run = rapc.loads(LIBRARY).start(world, tasks="(go)")
    with pytest.raises(rapc.PortError, match="lost a request that is not under way: 2"):
        run.run()


@pytest.mark.parametrize(
    ("treatments", "said"),
    [
        ({"fly": "repeat"}, "unknown primitive `fly`"),
        ({"drive": "again"}, "expected one of repeat, fail, ask for `drive`"),
    ],
)
def test_invalid_treatment_after_a_crash_is_refused(
    treatments: dict[str, str], said: str
) -> None:
    with pytest.raises(TypeError, match=said):
        Offer({"drive": (0, ("okay",))}, after_crash=treatments)
