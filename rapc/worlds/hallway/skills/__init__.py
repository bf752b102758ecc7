"""The skills of the hallway robot, by the names of [S 2] and [S 2.1].

`avoiding` goes along a trajectory without bumping into anything; `halls`, `doorways`,
`landmarks` and `moving` say where the trajectory leads; `passages` notices a doorway
that lies behind the robot; `reporting` watches and tells, `services` speaks, charges
and calls the lift; `sonar` is geometry they share. `all` is the whole catalogue.
"""
