"""A robot in hallways, rooms and a lift, driven by networks of skills [S 1.1].

`map` and `plan` are the building; `robot`, `people` and `doors` are its moving parts.
`simulation` advances their time; `channels` and `skills/` are the robot's skills.
`world` adapts the simulation to the port, and `planner` finds ways.
"""

from rapc.worlds.hallway.world import HallwayWorld

__all__ = ["HallwayWorld"]
