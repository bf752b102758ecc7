"""A robot in hallways, rooms and an elevator, driven by networks of skills [S 1.1].

`map` and `plan` are the building, `robot`, `people` and `doors` what moves in it,
`simulation` lets time pass for all of them; `channels` and `skills/` are what the robot
can do by itself; `world` puts all that behind the port, with the `planner` of ways.
"""

from rapc.worlds.hallway.world import HallwayWorld

__all__ = ["HallwayWorld"]
