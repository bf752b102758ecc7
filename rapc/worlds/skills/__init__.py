"""A runtime for networks of skills, for worlds that have continuous processes [S 2].

A skill declares what it reads and writes; a network is wired from the declarations of
the skills that are active at a moment, so no skill knows another. `declarations` is
what the author of a skill writes, `catalogue` checks a set of skills once, `network`
wires the active ones and draws them, `runtime` switches them on and off and steps them.
Nothing here knows the interpreter, or any particular world.
"""
