"""Runs as all of them begin: those of Python programs, commands, tests and experiments.

A run is prepared first: what cannot be run is refused, and nothing has happened yet.
Whoever is to hear its first event listens then, and files are opened for it. Then it
begins: facts first, then tasks.

Not here: how a library, a world and settings are had; each of those who prepare a run
has them from somewhere else.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from rapc.base.values import Atom, Fact, format_list
from rapc.compiler.program import Program
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest, as_text
from rapc.world import Callables, World


class Given(msgspec.Struct, frozen=True, kw_only=True):
    """What a run is given besides its library and its world."""

    #: The seed of the interpreter; a world is made with its own.
    seed: int = 0
    settings: Settings | None = None
    #: The top-level tasks that are submitted at the beginning, in this order.
    tasks: Sequence[TaskRequest] = ()
    #: Tasks that may be submitted later, looked at with the others.
    later: Sequence[TaskRequest] = ()
    #: What memory holds besides the facts of the world.
    facts: Sequence[Fact] = ()
    #: The name by which the world was given, for the trace: an installed name, or
    #: `module:Class`.
    world: str = ""
    #: The options that the world was made with, for the trace.
    options: Mapping[str, Atom | bool] = {}
    #: The faults put into the world, as texts, for the trace.
    faults: Sequence[str] = ()
    #: Python code besides that of the world, see `Interpreter`.
    functions: Callables | None = None
    solvers: Callables | None = None
    comparators: Callables | None = None


class PreparedRun(msgspec.Struct, frozen=True):
    """A run that has not begun, and can."""

    interpreter: Interpreter
    world: World
    given: Given

    def begin(self) -> Interpreter:
        """Begin the run and return its interpreter, to be stepped or run.

        Raises:
            PortError: if the world breaks.
        """
        run, given = self.interpreter, self.given
        tasks = [as_text(task) for task in given.tasks]
        facts = [format_list(fact) for fact in given.facts]
        named = given.world if ":" in given.world else ""
        run.start(given.options, tasks, given.faults, facts, named)
        for fact in given.facts:
            run.assert_fact(*fact)
        for task in given.tasks:
            run.submit(task)
        return run


def prepare(library: Program, world: World, given: Given) -> PreparedRun:
    """Return a run of a library in a world, freshly made, that can begin.

    Raises:
        RefusedError: if the library or a task cannot be run in the world.
        FactError: for a fact that the declarations do not allow.
    """
    run = Interpreter(
        library,
        world,
        given.seed,
        given.settings,
        given.functions,
        given.solvers,
        given.comparators,
    )
    run.check([*given.tasks, *given.later])
    for fact in given.facts:
        run.check_fact(*fact)
    return PreparedRun(run, world, given)
