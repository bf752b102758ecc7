"""One random program with its world and tasks, and how both interpreters run it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import msgspec

from rapc import events
from rapc.base.source import SourceFile
from rapc.base.values import Atom, Fact, Text, number
from rapc.compiler.program import Program
from rapc.errors import FactError, PortError, RefusedError
from rapc.ir import nodes
from rapc.library.library import Library, link
from rapc.parser.parse import parse, parse_fact
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import (
    TaskRequest,
    as_text,
    of_agenda,
    read_task_request,
)
from rapc.world import HandlerMemory, Handlers, Kit, Time
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld
from tests.reference.interpreter import Reference
from tests.reference.kinds import Broken, WrongKind
from tests.reference.run import Limits


class Case(msgspec.Struct, frozen=True):
    """A library as nested lists of words, its world, and what is asked of it.

    `source`, if given, is the library instead. The tasks of the `agenda`, if it has a
    name, come before `tasks`. `solvers` are names of RAPs with
    methods, the first of which is always returned, the others where `(p a 1)` is not
    believed. `host` are a time, what the host does then (`assert`, `erase`, `signal`,
    `cancel`, `submit`) and with what.
    """

    seed: int
    forms: tuple[Any, ...] = ()
    rows: tuple[Row, ...] = ()
    at: tuple[At, ...] = ()
    facts: tuple[str, ...] = ()
    tasks: tuple[str, ...] = ()
    agenda: str = ""
    solvers: tuple[tuple[str, Any], ...] = ()
    host: tuple[tuple[Time, str, str], ...] = ()
    until: int | None = 60
    cycles: int | None = 150
    settings: Settings = Settings(idle_cycles=40)
    source: str = ""

    @property
    def text(self) -> str:
        """The library as text, one clause or step to a line."""
        return self.source or "\n".join(print_form(form) for form in self.forms) + "\n"


def stepwise(case: Case) -> Case:
    """Return a case that steps get through: no host, and nothing goes on without end.

    A task may wait for a belief younger than another one, whose age grows as well. It
    is tested again and again: only `until` ends such a run, and a step has none.
    """
    rows = tuple([msgspec.structs.replace(row, every=None) for row in case.rows])
    return msgspec.structs.replace(case, host=(), rows=rows, forms=_aged(case.forms))


def _aged(form: Any) -> Any:
    """The same form, with a number for each age that a belief is given otherwise."""
    if isinstance(form, str):
        return form
    match form:
        case ("believe", found, age) if age != "9":
            return ("believe", found, "9")
    return tuple([_aged(part) for part in form])


def print_form(form: Any, depth: int = 0) -> str:
    """Nested words as text, one clause or step to a line."""
    if isinstance(form, str):
        return form
    head = form[0] if form and isinstance(form[0], str) else ""
    broken = head in ("define-rap", "define-method", "method", "task-net") or depth == 3
    parts = [print_form(part, depth + 1) for part in form]
    gap = "\n" + " " * (2 * depth + 2) if broken else " "
    return f"({gap.join(parts)})"


def read_library(text: str) -> Library:
    """Parse and link a text that has nothing wrong with it.

    Raises:
        ValueError: with what is wrong.
    """
    source = SourceFile("lib.rap", text)
    parsed = parse(source)
    library, found = link([parsed])
    for diagnostic in (*parsed.diagnostics, *found):
        raise ValueError(diagnostic.message)
    return library


def with_added_methods(text: str, library: Library) -> Library:
    """The library of a text, with the methods added to its RAPs once more, by hand."""
    raps: dict[str, nodes.DefineRap] = {}
    forms = parse(SourceFile("lib.rap", text)).forms
    for form in forms:
        if isinstance(form, nodes.DefineRap):
            raps[form.name] = form
    for form in forms:
        if isinstance(form, nodes.DefineMethod):
            own = raps[form.rap].methods
            method = msgspec.structs.replace(form.method, position=len(own) + 1)
            raps[form.rap] = msgspec.structs.replace(
                raps[form.rap], methods=(*own, method)
            )
    return msgspec.structs.replace(library, raps=raps)


# --- functions that libraries may declare -----------------------------------------


def twice(_: Any, value: Atom) -> Atom:
    """Twice a number; of anything else, nobody knows."""
    return value * 2 if isinstance(value, int | float) else "unknown"


def odd(_: Any, value: Atom) -> bool:
    """Whether a number is odd."""
    return isinstance(value, int) and value % 2 == 1


def look_up(memory: Any, item: Atom) -> Atom:
    """What memory holds under `p`, or `nothing`."""
    found: Atom | None = memory.value("p", item)
    return "nothing" if found is None else found


def guess(memory: Any, index: tuple[Atom, ...]) -> Atom:
    """A default that depends on the place in memory."""
    found: Atom | None = memory.value("p", index[-1])
    return "a" if found is None else found


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "twice": twice,
    "odd": odd,
    "look-up": look_up,
    "peek": look_up,
    "guess": guess,
}
"""What is registered for all libraries; `peek` is declared without `:reads`."""


def _seen(memory: HandlerMemory, datum: Fact) -> None:
    """The handler of the datum `seen`."""
    memory.assert_fact("p", *datum[1:])


def _solvers(case: Case) -> dict[str, Callable[..., list[nodes.Method]]]:
    found: dict[str, Callable[..., list[nodes.Method]]] = {}
    for name, methods in case.solvers:
        text = print_form(("define-rap", ("index", ("solved",)), *methods))
        form = parse(SourceFile("solver.rap", text)).forms[0]
        assert isinstance(form, nodes.DefineRap)
        found[name] = functools.partial(_solve, form.methods)
    return found


def _solve(methods: Sequence[nodes.Method], _: Fact, view: Any) -> list[nodes.Method]:
    return list(methods[:1] if view.value("p", "a") == 1 else methods)


def _act(interpreter: Any, told: list[Any], kind: str, text: str) -> None:
    """What a host does to either interpreter; `told` hears of what is refused."""
    try:
        if kind == "submit":
            interpreter.submit(read_task_request(text))
        elif kind == "cancel":
            interpreter.cancel(read_words(text))
        elif kind == "assert":
            interpreter.assert_fact(*parse_fact(text))
        else:
            getattr(interpreter, kind)(*read_words(text))
    except (FactError, RefusedError, WrongKind):
        told.append(_refused(f"{kind} {text}"))


def _refused(what: str) -> dict[str, object]:
    """What stands in a trace for something that did not come in."""
    return {"event": "refused", "n": 0, "cycle": 0, "time": 0, "what": what}


def read_words(text: str) -> Fact:
    """A flat list of words as a fact, prefix, signal or goal with variables."""
    return tuple(read_atom(word) for word in text.strip("()").split())


def read_atom(word: str) -> Atom:
    """A word as a number, string or symbol."""
    if word.startswith('"'):
        return Text(word.strip('"'))
    try:
        return number(float(word))
    except ValueError:
        return word


# --- running ----------------------------------------------------------------------


def _world(case: Case, library: Library) -> ScriptedWorld:
    return ScriptedWorld(
        case.rows,
        case.at,
        declared=library,
        kit=Kit(handlers=Handlers(data={"seen": _seen})),
    )


def interpreter_of(case: Case) -> Interpreter:
    """Return rapc's interpreter for a case, nothing begun."""
    library = read_library(case.text)
    return Interpreter(
        Program(library),
        _world(case, library),
        case.seed,
        case.settings,
        functions=FUNCTIONS,
        solvers=_solvers(case),
    )


def begin(case: Case, interpreter: Interpreter, told: list[Any] | None = None) -> None:
    """Give an interpreter what a case has for it; nothing runs yet.

    `told` hears of what is refused.
    """
    interpreter.start()
    library = interpreter.library.library
    given = of_agenda(library, case.agenda) if case.agenda else ()
    _give(case, interpreter, given, interpreter.call_at, [] if told is None else told)


def _give(
    case: Case,
    interpreter: Any,
    given: Iterable[TaskRequest],
    at: Callable[[Time, Callable[[], None]], None],
    told: list[Any],
) -> None:
    """Give either interpreter facts, what the host will do, and tasks."""
    act = functools.partial(_act, interpreter, told)
    for fact in case.facts:
        act("assert", fact)
    for time, kind, what in case.host:
        at(time, functools.partial(act, kind, what))
    for text in (*map(as_text, given), *case.tasks):
        act("submit", text)


Trace = Sequence[events.Event | dict[str, object]]
"""Events, and what was refused or broke a run off."""


def run_rapc(case: Case) -> Trace:
    """The trace of rapc's interpreter, without `run-started`."""
    interpreter = interpreter_of(case)
    found: list[Any] = []
    interpreter.listen(found.append)
    begin(case, interpreter, found)
    try:
        interpreter.run(case.until, case.cycles)
    except (FactError, PortError):
        found.append(_refused("the world"))
    return found[1:]


def run_reference(case: Case) -> Trace:
    """The trace of the reference interpreter."""
    library = with_added_methods(case.text, read_library(case.text))
    settings = case.settings
    limits = Limits(
        case.until,
        case.cycles,
        settings.futile_limit,
        settings.idle_cycles,
        settings.cycle_cost,
        settings.query_steps,
        settings.idle_waits,
        settings.max_choices,
        max_resources=settings.max_resources,
    )
    world, solvers = _world(case, library), _solvers(case)
    reference = Reference(library, world, case.seed, limits, FUNCTIONS, solvers)
    told: list[Any] = reference.events
    given = reference.take_up(case.agenda) if case.agenda else ()
    _give(case, reference, given, reference.at, told)
    try:
        reference.run()
    except (Broken, WrongKind):
        told.append(_refused("the world"))
    return told
