"""What the interpreter relies on in every world, whatever package it comes from."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rapc.base.values import Fact, Text
from rapc.library.library import Library
from rapc.world import Drawable, Finished, Reply, Savable, World

from .robot import Robot

Make = Callable[[], World]
"""Makes a new world, each time from the same seed."""


def check_world(make: Make, library: Library, requests: Sequence[Fact]) -> None:
    """See that a world keeps to the port.

    Args:
        make: makes the world.
        library: declares what it offers and the words its handlers use.
        requests: requests that it can carry out, one after the other.
    """
    check_description(make())
    check_knowledge(make(), library)
    check_requests(make, library, requests)
    check_time(make())
    check_saving(make, requests)
    check_picture(make, requests)


def check_description(world: World) -> None:
    """Options, offer and handlers fit together."""
    options = world.kit.options
    assert len({option.name for option in options}) == len(options)
    types = {"flag": bool, "integer": int, "symbol": str, "text": Text}
    for option in options:
        assert isinstance(option.default, types.get(option.kind, int | float)), option
        assert option.doc
    offer, handlers = world.kit.offer, world.kit.handlers
    for arity, results in offer.primitives.values():
        assert arity >= 0
        assert "okay" in results
        assert len(set(results)) == len(results)
    assert set(handlers.results) <= set(offer.primitives)
    assert set(offer.data) <= set(handlers.data)
    assert set(offer.sensors) <= set(offer.primitives)


def check_knowledge(world: World, library: Library) -> None:
    """What the robot knows at first is flat and declared; nothing has happened yet."""
    for fact in world.facts():
        assert all(type(part) in (str, int, float, Text) for part in fact), fact
    robot = Robot(world, library)
    assert robot.world.now() == 0
    assert world.ended() is None


def check_requests(make: Make, library: Library, requests: Sequence[Fact]) -> None:
    """Answers are declared, time never goes back, and all of it is repeatable."""
    histories = []
    for _ in range(2):
        world = make()
        robot = Robot(world, library)
        histories.append([answer(robot, request) for request in requests])
    assert histories[0] == histories[1]


def answer(robot: Robot, request: Fact) -> tuple[object, ...]:
    """What comes of a request, once it has been checked and digested."""
    world, offer = robot.world, robot.world.kit.offer
    before = world.now()
    reply = world.perform(7, request)
    if reply is None:
        reply = wait_for_end(world)
    assert isinstance(reply, Reply)
    assert world.now() >= before
    assert reply.result in offer.primitives[str(request[0])][1]
    for datum in reply.data:
        assert offer.data[str(datum[0])] == len(datum) - 1, datum
    robot.digest(request, reply.result, reply.data)
    robot.listen()
    assert list(world.messages()) == []
    return reply, world.now(), sorted(robot.memory.facts, key=str)


def wait_for_end(world: World) -> Reply:
    """Move time on until a primitive under way ends."""
    while (due := world.next_time()) is not None:
        world.advance(due)
        for message in world.messages():
            if isinstance(message, Finished) and message.ticket == 7:
                return message.reply
    raise AssertionError("a primitive under way never ends")


def check_time(world: World) -> None:
    """Time goes where it is told, and what is announced comes."""
    list(world.messages())
    for _ in range(5):
        now, due = world.now(), world.next_time()
        assert due is None or due >= now
        world.advance(due if due is not None else now + 10)
        assert world.now() >= (due if due is not None else now + 10)
        assert due is None or list(world.messages())
    before = world.now()
    world.advance(0)
    assert world.now() == before


def check_saving(make: Make, requests: Sequence[Fact]) -> None:
    """A simulator goes on from a saved state as if nothing had been."""
    world, other = make(), make()
    if not (isinstance(world, Savable) and isinstance(other, Savable)):
        return
    list(world.messages())
    half = len(requests) // 2
    for request in requests[:half]:
        world.perform(0, request)
    state = world.save()
    other.restore(state)
    assert other.save() == state
    for request in requests[half:]:
        assert world.perform(0, request) == other.perform(0, request)
        assert (world.now(), world.next_time()) == (other.now(), other.next_time())
    assert world.save() == other.save()


def check_picture(make: Make, requests: Sequence[Fact]) -> None:
    """A picture, if there is one, hangs together, and drawing it changes nothing."""
    world, other = make(), make()
    if not isinstance(world, Drawable):
        return
    for request in requests:
        picture = world.picture()
        names = [spot.name for spot in picture.spots]
        assert len(set(names)) == len(names)
        assert {picture.here, *sum(picture.roads, ())} <= set(names)
        assert world.perform(0, request) == other.perform(0, request)
