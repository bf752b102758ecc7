"""Runs as all of them begin: those of Python programs, commands, tests and experiments.

A run is prepared first: what cannot be run is refused, and nothing has happened yet.
Whoever is to hear its first event listens then, and files are opened for it. Then it
begins: facts first, then tasks.

Not here: how a library, a world and settings are had; each of those who prepare a run
has them from somewhere else.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from rapc.base.values import Fact, format_list
from rapc.compiler.program import Program
from rapc.parser.parse import parse_fact
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import TaskRequest, as_text, of_agenda, read_task_request
from rapc.spec import RunSpec
from rapc.world import Callables, World


class PreparedRun(msgspec.Struct, frozen=True):
    """A run that has not begun, and can."""

    interpreter: Interpreter
    world: World
    spec: RunSpec
    #: The top-level tasks, those of the agenda first, and the facts of the spec.
    tasks: tuple[TaskRequest, ...]
    facts: tuple[Fact, ...]

    def begin(self) -> Interpreter:
        """Begin the run and return its interpreter, to be stepped or run.

        Raises:
            PortError: if the world breaks.
        """
        run = self.interpreter
        run.start(
            msgspec.structs.replace(
                self.spec,
                agenda=None,
                tasks=tuple([as_text(task) for task in self.tasks]),
                facts=tuple([format_list(fact) for fact in self.facts]),
            )
        )
        for fact in self.facts:
            run.assert_fact(*fact)
        for task in self.tasks:
            run.submit(task)
        return run


def prepare(  # Python code goes beside the spec, by name
    library: Program,
    world: World,
    spec: RunSpec,
    *,
    later: Sequence[TaskRequest] = (),
    functions: Callables | None = None,
    solvers: Callables | None = None,
    comparators: Callables | None = None,
) -> PreparedRun:
    """Return a run of a library in a world, freshly made, that can begin.

    Args:
        library: the library.
        world: the world, made with the seed, options and faults of the spec.
        spec: what the run is begun with.
        later: tasks that may be submitted later, checked with the others.
        functions: Python code besides that of the world, see `Interpreter`; so are
            the others.
        solvers: see `functions`.
        comparators: see `functions`.

    Raises:
        TextError: for a task or a fact that cannot be read.
        SettingError: for a setting that there is not, or a value it does not take.
        RefusedError: if the library or a task cannot be run in the world, or there is
            no such agenda.
        FactError: for a fact that the declarations do not allow.
    """
    agenda = () if spec.agenda is None else of_agenda(library.library, spec.agenda)
    tasks = (*agenda, *map(read_task_request, spec.tasks))
    facts = tuple([parse_fact(text) for text in spec.facts])
    settings = read_settings(spec.settings)
    code = functions, solvers, comparators
    run = Interpreter(library, world, spec.seed, settings, *code)
    run.check([*tasks, *later])
    for fact in facts:
        run.check_fact(*fact)
    return PreparedRun(run, world, spec, tasks, facts)
