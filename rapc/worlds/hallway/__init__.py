"""A robot in hallways, rooms and an elevator, driven by networks of skills [S 1.1].

`map` and `plan` are the building, `robot`, `people` and `doors` what moves in it,
`simulation` lets time pass for all of them; `channels` and `skills/` are what the robot
can do by itself. The interpreter and its port are not known here.
"""
