"""A library, a world and its authors' Python code put together into a machine.

What does not fit is refused here, before anything happens.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from functools import partial

from rapc.compiler.program import Program
from rapc.errors import RefusedError
from rapc.runtime import strict
from rapc.runtime.admission import misfitting, refusals, refuse_other_world
from rapc.runtime.authors import Named
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.host_query import HandlerQuestions
from rapc.runtime.machine import Machine
from rapc.runtime.settings import Settings
from rapc.runtime.tasks.rename_items import rename
from rapc.world import World


def put_together(
    library: Program,
    world: World,
    seed: int,
    settings: Settings,
    code: Mapping[str, Named],
) -> Machine:
    """Return the machine of a run that has not begun.

    Args:
        library: the compiled library.
        world: the world, freshly made.
        seed: the run's seed.
        settings: those of the interpreter.
        code: what `code_of_authors` has made of that of world and host.

    Raises:
        RefusedError: if the library cannot run in this world.
        PortError: if an author's code breaks meanwhile.
    """
    held = HeldWorld(world, library, code, settings.strict)
    found = misfitting(library, held)
    if found:
        raise RefusedError(found)
    refuse_other_world(library, world)
    try:
        machine = wired(library, held, seed, settings)
        found = refusals(library, held)
    except BaseException as error:
        held.blame(error)
    if found:
        raise RefusedError(found)
    return machine


def wired(library: Program, world: HeldWorld, seed: int, settings: Settings) -> Machine:
    """Return a machine whose handlers can ask memory, and are held if so wanted."""
    machine = Machine(
        library,
        world,
        random.Random(f"{seed}:interpreter"),
        settings,
        world.code["the function"],
        world.code["the solver of"],
        world.code["the comparator"],
    )
    machine.recognizer.renamed = partial(rename, machine)
    machine.access.answers = HandlerQuestions(machine).ask
    if settings.strict:
        strict.hold_handlers(machine)
    return machine
