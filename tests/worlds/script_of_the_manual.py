"""The script that docs/reference/worlds-api.md shows."""

from rapc.library.loader import load_text
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld

library = load_text(
    """
    (declare-primitive grasp (?arm ?thing) (okay dropped))
    (declare-memory-proposition holding (?arm ?thing))
    (declare-memory-proposition raining)
    (define-rap (take ?thing)
      (succeed (holding ?arm ?thing))
      (method (primitive (grasp left ?thing))))
    """
).library

held = ("holding", "?arm", "?x")
world = ScriptedWorld(
    [
        Row(("grasp", "?arm", "cup"), "dropped", times=1),
        Row(("grasp", "?arm", "?x"), takes=2, asserts=(held,)),
    ],
    [At(30, asserts=(("raining",),))],
    declared=library,
)
