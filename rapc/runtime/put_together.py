"""A library, a world and its authors' Python code put together into a machine.

What does not fit is refused here, before anything happens.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from rapc.base.later import later
from rapc.compiler.program import Program
from rapc.errors import RefusedError
from rapc.runtime.admission import misfitting, refusals, refuse_other_world
from rapc.runtime.authors import Named, blame, is_time, wrong_type
from rapc.runtime.host_query import HandlerQuestions
from rapc.runtime.machine import Machine
from rapc.runtime.settings import Settings
from rapc.runtime.tasks.rename_items import rename
from rapc.world import Kit, World

if TYPE_CHECKING:
    from rapc.runtime import strict
else:
    strict = later("rapc.runtime.strict")


def code_of_authors(
    kit: Kit,
    functions: Named | None,
    solvers: Named | None,
    comparators: Named | None,
) -> dict[str, Named]:
    """Return all Python code of authors by what messages call it, then by name.

    The last three are the host's; one of them stands for that of the world which has
    the same name.
    """
    return {
        "the handler of": kit.handlers.results,
        "the handler of the datum": kit.handlers.data,
        "the function": {**kit.functions, **(functions or {})},
        "the solver of": {**kit.solvers, **(solvers or {})},
        "the comparator": {**kit.comparators, **(comparators or {})},
    }


def put_together(
    library: Program,
    world: World,
    seed: int,
    settings: Settings,
    code: Mapping[str, Named],
    fast: bool,
) -> Machine:
    """Return the machine of a run that has not begun.

    Args:
        library: the compiled library.
        world: the world, freshly made.
        seed: the run's seed.
        settings: those of the interpreter.
        code: what `code_of_authors` has made of that of world and host.
        fast: see `Machine`.

    Raises:
        RefusedError: if the library cannot run in this world.
        PortError: if an author's code breaks meanwhile.
    """
    found = misfitting(library, world, code)
    if found:
        raise RefusedError(found)
    refuse_other_world(library, world)
    functions, comparators = code["the function"], code["the comparator"]
    try:
        if not is_time(now := world.now()):
            raise wrong_type(world, "now", "the time", now)
        machine = Machine(
            library,
            world,
            random.Random(f"{seed}:interpreter"),
            settings,
            functions,
            code["the solver of"],
            comparators,
            fast,
        )
        machine.recognizer.renamed = partial(rename, machine)
        machine.access.answers = HandlerQuestions(machine).ask
        if settings.strict:
            strict.hold_handlers(machine)
        found = refusals(library, world, functions, comparators)
    except BaseException as error:
        blame(error, world, code)
    if found:
        raise RefusedError(found)
    return machine
