"""Functions of rapc for Python programs: load and check a library, run tasks.

These functions are the public functions of `import rapc`. Libraries of sources and
saved libraries (`rapc compile`) are loaded in the same way. Every error that a caller
can cause is a `rapc.Error`. Not here: stepping and querying a run
(`rapc.runtime.interpreter`), new worlds (`rapc.world`).
"""

from __future__ import annotations

import os
from collections.abc import Container, Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from itertools import count
from math import inf
from types import ModuleType
from typing import TYPE_CHECKING, Any

import msgspec
from msgspec.structs import replace

from rapc.analysis.check_files import check_files
from rapc.analysis.driver import CheckReport, check_library
from rapc.analysis.graphs import library_graph
from rapc.analysis.selection import Selection, errors
from rapc.base import files
from rapc.base.gc_paused import gc_paused
from rapc.base.source import SourceFile, place
from rapc.base.values import Atom, Fact, format_list
from rapc.compiler.program import Program
from rapc.errors import ArgumentError, Error, RefusedError, TextError
from rapc.events import TaskResult
from rapc.ir.nodes import DefineMethod, DefineRap, Method, Node, Require
from rapc.ir.printer import format_node
from rapc.language.atoms import kind, need_fact
from rapc.library import loader, saved, saved_check
from rapc.library.kinds import UNKNOWN
from rapc.library.loader import Loaded
from rapc.parser.parse import parse
from rapc.runtime.achieve import achieving
from rapc.runtime.arguments import (
    need_count,
    need_part,
    need_program,
    need_seed,
    need_settings,
    need_table,
    need_task,
    need_time,
)
from rapc.runtime.events.recorder import Listener
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.planner import BUILT_IN, Planned, Planner, PlanRequest
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest, as_text
from rapc.spec import RunSpec
from rapc.world import Callables, Time, World
from rapc.worlds.registry import (
    build_world,
    check_options,
    find_world,
    plain_values,
    refuse_incomplete,
)

PLAN = "<plan>"
"""The file name of text for `CheckedLibrary.extend`, in findings and faults."""

Path = str | os.PathLike[str]
Task = str | TaskRequest

if TYPE_CHECKING:
    import networkx

    from rapc.planning.engines import Engine
    from rapc.planning.plan import Plan


class CheckError(Error):
    """A library with findings of severity error."""

    #: The findings of severity error only.
    report: CheckReport

    def __init__(self, report: CheckReport) -> None:
        count = len(report.findings) - 1
        more = f", and {count} more" if count else ""
        found = report.findings[0].diagnostic
        where = place(found.span, report.files)
        super().__init__(f"{where}: {found.message}{more}", found.help)
        self.report = report


class CheckedLibrary:
    """A library without errors, ready to be run any number of times."""

    #: The name of the library in traces.
    name: str
    #: The library in executable form, for `Interpreter` and `Interpreter.extend`.
    program: Program

    def __init__(self, program: Program) -> None:
        need_program(program, "`program`")
        self.name = program.name
        self.program = program

    def __repr__(self) -> str:
        return f"<rapc.CheckedLibrary {self.name!r}: {len(self.raps)} RAPs>"

    @property
    def raps(self) -> tuple[str, ...]:
        """Return the names of all RAPs, in the order of the text."""
        return tuple(self.program.library.raps)

    @property
    def files(self) -> tuple[str, ...]:
        """Return the names of all files, each after the files that it requires."""
        return tuple(self.program.library.files)

    def extend(self, text: str) -> CheckedLibrary:
        """Return a library with the forms of `text` added, checked together.

        `text` may define RAPs, and methods for RAPs of this library (`define-method`).
        `Interpreter.extend` adds RAPs to a run in progress, but no methods [T 4.10.1].

        Raises:
            CheckError: for findings of severity error.
        """
        sources = [*self.program.library.files.values(), SourceFile(PLAN, _text(text))]
        return checked(loader.load_sources(sources), self.name)

    def graph(self) -> networkx.MultiDiGraph[str]:
        """Return the names of the library as a graph of networkx.

        A node is called `KIND NAME`, for example `rap fill-order`; its attributes are
        `kind`, `name` and, where a form declares it, `file` and `row`. Kinds are `rap`,
        `primitive`, `skill`, `agenda`, `fact`, `query`, `thing`, `datum`, `event`.
        An edge leads from what calls, asks, changes or claims to what is called, asked,
        changed or claimed; its attribute `relation` is `submits`, `calls`, `requests`,
        `enables`, `asks`, `waits for`, `notes`, `asserts`, `erases`, `may change`,
        `claims`, `uses` or `tells`, its `label` the method or clause.
        """
        return library_graph(self.program.library)

    def start(  # noqa: PLR0913  # each has a default and goes by name
        self,
        world: str | World | type[World],
        *,
        agenda: str | None = None,
        tasks: Task | Iterable[Task] = (),
        facts: str | Iterable[str | Fact] = (),
        seed: int = 0,
        options: Mapping[str, Atom | bool] | None = None,
        settings: Settings | None = None,
        functions: Callables | None = None,
        solvers: Callables | None = None,
        comparators: Callables | None = None,
        listeners: Iterable[Listener] = (),
        engine: str | Engine | None = None,
        begin: bool = True,
    ) -> Interpreter:
        """Start a run for stepping, queries, and further tasks.

        Args:
            world: the name of an installed world or `module:Class`, a class, or a new
                instance.
            agenda: the name of an agenda of the library, whose tasks come first.
            tasks: initial tasks, as text: `"(rap args) :priority 4"`.
            facts: initial facts, in addition to the facts of the world.
            seed: the seed of all chance in the run, and of the world unless it is an
                instance.
            options: values for options of the world, unless it is an instance.
            settings: settings of the interpreter.
            functions: functions and default functions, in addition to those of the
                world.
            solvers: problem solvers, in addition to those of the world, by the name of
                a RAP.
            comparators: comparators, in addition to those of the world.
            listeners: called with every event of the run.
            engine: the planner for RAPs with `(plan)`, see `rapc.engine`; None for the
                planner of rapc.
            begin: whether to begin the run; `rapc.durable.runs.begin` begins a run with
                a journal.

        Raises:
            WorldError: if the world or an option is unknown, or the world cannot be
                made.
            RefusedError: if the library or a task cannot be run in the world, or the
                agenda is unknown.
            TextError: for an invalid task or fact.
            FactError: for a fact that the declarations do not allow.
            PortError: if the world violates the port.
            PlanError: for an engine that is not installed, or an invalid command.
        """
        if agenda is not None and not isinstance(agenda, str):
            raise ArgumentError(f"`agenda` is {kind(agenda)}, not a name")
        need_seed(seed)
        need_table(options, "`options`")
        if settings is not None:
            need_settings(settings)
        made, chosen = _world(world, seed, options)
        spec = RunSpec(
            world_class=world if isinstance(world, str) and ":" in world else "",
            options=plain_values(chosen),
            settings={} if settings is None else settings.named(),
            seed=seed,
            agenda=agenda,
            tasks=tuple([_task(task) for task in _listed(tasks, "tasks")]),
            facts=tuple([_fact(fact) for fact in _listed(facts, "facts")]),
        )
        run = Interpreter.prepared(
            self.program,
            made,
            spec,
            functions=functions,
            solvers=solvers,
            comparators=comparators,
            planner=planner_of(engine),
        )
        for listener in listeners:
            run.listen(listener)
        if begin:
            run.start()
        return run


class RunResult(msgspec.Struct, frozen=True):
    """The result of a run."""

    #: Why the run ended: `done`, `until`, `world`, `stuck`, `runaway` or `cycles`.
    reason: str
    #: The time of the clock at the end.
    time: Time
    #: The result of each task, in the order of arrival.
    tasks: tuple[TaskResult, ...]
    #: The run itself, for queries of memory or the agenda.
    run: Interpreter

    @property
    def world(self) -> World:
        """Return the world of the run, for example to draw it."""
        return self.run.world

    @property
    def succeeded(self) -> bool:
        """Return whether every task that is not in the background succeeded."""
        given = [task for task in self.tasks if not task.background]
        return all(task.outcome == "succeeded" for task in given)


# --- the functions --------------------------------------------------------------------


@gc_paused()
def load(*paths: Path | Iterable[Path], check: bool = True) -> CheckedLibrary:
    """Load files and folders as one library and check it; or load a saved library.

    Args:
        paths: files, folders (all `.rap` below), or `-` for standard input.
        check: whether to run the checker; see `linked`. A saved library was checked
            when it was saved.

    Raises:
        LoadError: for a path that cannot be read.
        SavedError: for a saved library that this rapc cannot run.
        CheckError: for findings of severity error.
        RefusedError: without `check`, for a library that cannot be run.
    """
    names = _paths(paths)
    data = files.read_compiled(names[0]) if len(names) == 1 else None
    if data is not None:
        compiled = saved.SavedLibrary(data, names[0])
        return CheckedLibrary(Program(compiled.library, compiled.name))
    made = checked if check else linked
    return made(loader.load(names), ", ".join(names))


def loads(text: str, name: str = "<text>", *, check: bool = True) -> CheckedLibrary:
    """Check a library in a text, like a file in the working directory.

    Args:
        text: definitions and declarations; it may `require` files.
        name: the name in findings and traces.
        check: whether to run the checker; see `linked`.

    Raises:
        LoadError: for a required file that cannot be read.
        CheckError: for findings of severity error.
        RefusedError: without `check`, for a library that cannot be run.
    """
    if not isinstance(name, str):
        raise ArgumentError(f"`name` is {kind(name)}, not a text")
    made = checked if check else linked
    return made(loader.load_text(_text(text), name), name)


def check(*paths: Path | Iterable[Path]) -> CheckReport:
    """Load files and folders as one library and return a report of all findings.

    Args:
        paths: files, folders (all `.rap` below), or `-` for standard input.

    Raises:
        LoadError: for a path that cannot be read. Findings raise no error.
    """
    return check_files(_paths(paths))


def run(
    library: CheckedLibrary,
    world: str | World | type[World],
    tasks: Task | Iterable[Task] = (),
    *,
    agenda: str | None = None,
    until: Time | None = None,
    cycles: int | None = None,
    **more: Any,
) -> RunResult:
    """Run tasks of a library in a world until all end, and return the result.

    Args:
        library: the result of `load` or `loads`.
        world: see `CheckedLibrary.start`.
        tasks: the tasks, as text: `"(rap args) :priority 4"`.
        agenda: the name of an agenda of the library, whose tasks come first.
        until: the time at which to stop.
        cycles: the highest number of cycles.
        more: further arguments of `CheckedLibrary.start`: `seed`, `options`, ...

    Raises:
        Error: as `CheckedLibrary.start`; failures of the robot during the run are in
            the result.
    """
    if not isinstance(library, CheckedLibrary):
        wanted = "`rapc.load(path)` or `rapc.loads(text)` returns one"
        raise ArgumentError(f"`library` is {kind(library)}, not a library", wanted)
    if until is not None:
        need_time(until, "`until`")
    if cycles is not None:
        need_count(cycles, "`cycles`")
    going = library.start(world, agenda=agenda, tasks=tasks, **more)
    reason = going.run(until=until, cycles=cycles)
    return RunResult(reason, going.now, going.results(), going)


def find_plan(request: PlanRequest) -> Planned:
    """Return a method for a RAP with `(plan)`: the planner of each run of a host."""
    planned: Planned = _planning("solver").plan_for_task(request)
    return planned


def planner_of(asked: str | Engine | None) -> Planner:
    """Return the planner of a run: that of rapc, or one that asks an engine first.

    Raises:
        PlanError: for an engine that is not installed, or an invalid command.
    """
    found = _engine(asked)
    if found is None:
        return find_plan
    return partial(_planning("solver").plan_for_task, engine=found)


def engine_of(planner: Planner | None) -> Engine | None:
    """Return the engine that a planner from `planner_of` asks first, if any."""
    return planner.keywords["engine"] if isinstance(planner, partial) else None


def _engine(asked: str | Engine | None) -> Engine | None:
    if asked is None or isinstance(asked, str):
        return engine(asked or BUILT_IN)
    if not callable(getattr(asked, "ask", None)):
        raise ArgumentError(f"`engine` is {kind(asked)}, not an engine")
    return asked


def engine(name: str, timeout: float = 10, *, costs: bool = True) -> Engine | None:
    """Return a planner that is not part of rapc, for `rapc.plan` and `library.start`.

    An engine runs in a process of its own. rapc checks each of its plans; the planner
    of rapc is asked if the engine has no valid plan.

    Args:
        name: `up:NAME` for an engine of unified-planning; a command with the words
            `{domain}`, `{problem}` and `{plan}` for the names of the files; or
            `builtin`, for which the result is None.
        timeout: the limit in seconds for an answer.
        costs: whether the engine gets the costs of steps, if these are different whole
            numbers.

    Raises:
        PlanError: for an engine that is not installed, or an invalid command.
    """
    if not isinstance(name, str):
        raise ArgumentError(f"`name` is {kind(name)}, not a text")
    if type(timeout) not in (int, float) or not 0 < timeout < inf:
        raise ArgumentError("`timeout` takes a number of seconds above 0")
    if name == BUILT_IN:
        return None
    found: Engine = _planning("engines").find_engine(name, timeout, costs=costs)
    return found


def plan(  # all but two have defaults and go by name
    library: CheckedLibrary,
    goal: str,
    *,
    facts: str | Iterable[str | Fact] = (),
    run: Interpreter | None = None,
    use: Iterable[str] = (),
    limit: int = 20_000,
    tries: int = 0,
    engine: str | Engine | None = None,
) -> Plan:
    """Return a plan for a goal, or the reason why there is none; nothing is run.

    Args:
        library: the library; a plan uses its RAPs with `effects`.
        goal: a formula as text: `"(and (delivered linen ward-1) (docked))"`.
        facts: the facts that hold, if there is no `run`.
        run: a run of the library; the plan begins with its memory.
        use: the names of the RAPs that the plan may use; all with `effects` if empty.
        limit: the greatest number of states to look at.
        tries: the number of further states to look at for a cheaper plan.
        engine: the planner to ask first, see `rapc.engine`; None for that of rapc.

    Raises:
        TextError: for a text that is no formula or fact, or with undeclared names.
        FactError: for a fact that the declarations do not allow.
        PlanError: for a RAP in `use` that has no `effects`, an engine that is not
            installed, and an invalid command.
    """
    if not isinstance(library, CheckedLibrary):
        raise ArgumentError(f"`library` is {kind(library)}, not a library")
    if run is not None:
        need_part(run, Interpreter, "`run`", "library.start")
    need_count(limit, "`limit`")
    need_count(tries, "`tries`")
    names, asked = tuple(_listed(use, "use")), _engine(engine)
    program = library.program if run is None else run.library
    rap = achieving(program, _text(goal), names)
    plans = _planning("plan")
    if run is None:
        unknown = dict.fromkeys(program.library.functions, _unknown)
        world = plans.still_world(program)
        run = library.start(world, facts=facts, functions=unknown)
    planned: Plan = plans.plan(
        program,
        rap,
        run.memory,
        use=names,
        limit=limit,
        tries=tries,
        engine=asked,
        compute=run.computed,
    )
    return planned


def _unknown(*args: object) -> str:
    """Stand for a function of a world: without a run its value is not known."""
    return UNKNOWN


def _planning(name: str) -> ModuleType:
    """Return a module that makes plans, imported for the first plan."""
    return import_module(f"rapc.planning.{name}")


def rap_text(run: Interpreter, name: str) -> str:
    """Return a RAP as text, with the methods that a solver has found in a run.

    A program can keep these methods for later runs [S 3.2]: the text may replace the
    RAP. The text is one line, which `rapc fmt` formats.

    Raises:
        RefusedError: if the library does not have the RAP.
    """
    if not isinstance(run, Interpreter):
        raise ArgumentError(f"`run` is {kind(run)}, not a run")
    if not isinstance(name, str):
        raise ArgumentError(f"`name` is {kind(name)}, not a text")
    rap = run.library.library.raps.get(name)
    if rap is None:
        raise RefusedError([f"unknown RAP `{name}`"])
    plans = run.methods(run.library.known_rap(name))
    nodes = tuple([plan.node for plan in plans])
    return format_node(replace(rap, methods=nodes))


def methods_text(run: Interpreter, requires: Iterable[str] = ()) -> str:
    """Return the methods that solvers have found in a run, as a library.

    The text has a `define-method` form for each method on a line, which `rapc fmt`
    formats. A method with the name of a different method of its RAP gets a number
    behind its name. The text is empty if the solvers have found no method.

    Args:
        run: the run.
        requires: the names of required files, for example of the library of the run.
    """
    if not isinstance(run, Interpreter):
        raise ArgumentError(f"`run` is {kind(run)}, not a run")
    if isinstance(requires, str) or not isinstance(requires, Iterable):
        raise ArgumentError(f"`requires` is {kind(requires)}, not names of files")
    forms: list[Node] = [Require(_text(name)) for name in requires]
    found = run.added_methods
    for name, plans in found.items():
        own = run.library.known_rap(name).methods
        taken = {plan.node.name for plan in own}
        for plan in plans:
            method = replace(plan.node, name=_free(plan.node.name, taken))
            taken.add(method.name)
            forms.append(DefineMethod(name, method))
    return "".join(f"{format_node(form)}\n" for form in forms) if found else ""


def _free(
    name: str | int | None, taken: Container[str | int | None]
) -> str | int | None:
    """Return the name of a method, or a similar name if the name is taken."""
    if name is None or name not in taken:
        return name
    return next(new for at in count(2) if (new := f"{name}-{at}") not in taken)


def methods(text: str) -> tuple[Method, ...]:
    """Return methods written as RAP text, for a problem solver to return.

    Args:
        text: one or more `(method ...)`, in the syntax of a RAP.

    Raises:
        TextError: if `text` is anything else.
    """
    unit = parse(SourceFile("<methods>", f"(define-rap (any) {_text(text)})"))
    for found in unit.diagnostics:
        raise TextError(f"{found.message}: {text.strip()}", found.help)
    forms = [form for form in unit.forms if isinstance(form, DefineRap)]
    if len(unit.forms) != 1 or not forms or not forms[0].methods:
        raise TextError(f"expected methods, such as (method ...), not {text.strip()}")
    return tuple(forms[0].methods)


def checked(loaded: Loaded, name: str) -> CheckedLibrary:
    """Check loaded sources; `name` is the name in traces.

    Raises:
        CheckError: for findings of severity error.
    """
    report = check_library(loaded, errors())
    if report.findings:
        raise CheckError(report)
    return CheckedLibrary(Program(loaded.library, name))


def linked(loaded: Loaded, name: str) -> CheckedLibrary:
    """Link loaded sources without the passes of the checker.

    Errors of the text and of `require`, and undeclared names are found. The other
    findings of `checked` appear during a run: for example, a variable without a value
    is a fault of its query.

    Raises:
        CheckError: for errors of reading and linking.
        RefusedError: for a library that cannot be run.
    """
    enabled = errors().enabled & {found.rule for found in loaded.diagnostics}
    report = check_library(loaded, Selection(enabled))
    if report.findings:
        raise CheckError(report)
    program = Program(loaded.library, name)
    verifier = saved_check.Verifier(program.signatures)
    try:
        library = loaded.library
        for form in (*library.forms, *library.methods):
            if not isinstance(form, DefineRap):
                verifier.declaration(form)
        for rap in library.raps.values():
            verifier.rap(rap)
    except saved_check.UnsoundError as error:
        raise RefusedError([str(error)]) from error
    return CheckedLibrary(program)


# --- arguments ------------------------------------------------------------------------


def _paths(paths: Sequence[Path | Iterable[Path]]) -> list[str]:
    """Return all paths, also the paths in a list."""
    found: list[str] = []
    for path in paths:
        inner = [path] if isinstance(path, str | os.PathLike) else path
        if isinstance(inner, bytes) or not isinstance(inner, Iterable):
            raise ArgumentError(f"a path is {kind(path)}, not a text")
        for one in inner:
            if not isinstance(one, str | os.PathLike):
                raise ArgumentError(f"a path is {kind(one)}, not a text")
            found.append(os.fspath(one))
    if not found:
        raise ArgumentError("missing path")
    return found


def _text(text: object) -> str:
    if not isinstance(text, str):
        raise ArgumentError(f"the text is {kind(text)}", "a file is read by `load`")
    return text


def _listed(given: Any, what: str) -> list[Any]:
    """Return several values as a list, and one value as a list of one."""
    if isinstance(given, str | TaskRequest):
        return [given]
    if isinstance(given, bytes | Mapping) or not isinstance(given, Sequence | Iterable):
        raise ArgumentError(f"`{what}` is {kind(given)}, not a list")
    return list(given)


def _task(task: object) -> str:
    if isinstance(task, TaskRequest):
        need_task(task)
        return as_text(task)
    if not isinstance(task, str):
        raise ArgumentError(f"a task is {kind(task)}", 'as text: "(rap args)"')
    return task


def _fact(fact: object) -> str:
    if isinstance(fact, tuple):
        need_fact(fact, "the fact")
        return format_list(fact)
    if not isinstance(fact, str):
        raise ArgumentError(f"a fact is {kind(fact)}", 'as text: "(name args)"')
    return fact


def _world(
    world: object, seed: int, options: Mapping[str, Atom | bool] | None
) -> tuple[World, Mapping[str, Atom | bool]]:
    """Return the world, made if necessary, with its options in the form of traces."""
    if isinstance(world, World):
        if options:
            raise ArgumentError(
                "options require the name or class of a world, not a world"
            )
        return world, {}
    if isinstance(world, str):
        world = find_world(world)
    if not (isinstance(world, type) and issubclass(world, World)):
        listed = "list the installed worlds with `rapc worlds`"
        raise ArgumentError(f"`world` is {kind(world)}, not a world", listed)
    refuse_incomplete(world, f"{world.__module__}:{world.__qualname__}")
    given = check_options(world, options or {})
    return build_world(world, seed, given), given
