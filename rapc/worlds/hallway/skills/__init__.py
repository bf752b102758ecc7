"""The skills of the hallway robot, by the names of [S 2] and [S 2.1].

`avoiding` follows a trajectory around obstacles. `halls`, `doorways`, `landmarks` and
`moving` choose the trajectory. `passages` recognises a doorway behind the robot.
`reporting` watches and reports; `services` speaks, charges and calls the lift; `sonar`
is shared geometry. `all` is the complete catalogue.
"""
