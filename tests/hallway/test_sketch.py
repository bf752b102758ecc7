"""The picture of the hallway world for a terminal."""

from __future__ import annotations

from random import Random

from rapc.worlds.hallway import HallwayWorld


def test_the_picture_shows_the_robots_floor_and_what_is_true_there() -> None:
    picture = HallwayWorld(Random(0), {"doors": 0}).picture()
    spots = {spot.name: spot for spot in picture.spots}
    assert (picture.here, picture.heading) == ("lab", "west")
    assert {"lab", "lift", "north-hall"} <= set(spots)
    assert "attic" not in spots
    assert ("lab", "north-hall") in picture.roads
    assert spots["north-hall"].note == "somebody"
    places = [spot.at for spot in picture.spots if spot.at]
    assert min(x for x, _ in places) >= 0
    assert min(y for _, y in places) >= 0
    [gauge] = picture.gauges
    assert (gauge.value, gauge.believed) == ("lab", ("current-space", "robot"))


def test_a_closed_door_is_no_way() -> None:
    world = HallwayWorld(Random(0), {"doors": 20})
    world.advance(60)
    open_ways, shut = world.picture().roads, world.simulation.shut()
    assert shut
    for doorway in world.simulation.map.doorway:
        assert (doorway.joins in open_ways) == (doorway.name not in shut) or (
            world.simulation.openings[doorway.name].floor == 2
        )
