"""Running a small library against a script, and reading what happened."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rapc import events
from rapc.base.source import SourceFile
from rapc.base.values import Atom, Fact, format_list
from rapc.compiler.program import Program
from rapc.ir import nodes
from rapc.library.library import link
from rapc.parser.parse import parse, parse_pattern
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import read_task_request
from rapc.world import Time
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld

DECLARATIONS = """
(declare-memory-proposition p (?x))
(declare-memory-proposition q (?x ?y))
(declare-memory-proposition go ())
(declare-memory-proposition stop ())
(declare-memory-property color (?item ?value) unknown)
(declare-memory-property ready (?item ?value) false)
(declare-primitive act (?x) (okay dropped jammed lost))
(declare-primitive look (?x) (okay dropped))
(declare-primitive slow (?x) (okay dropped) :atomic false)
"""
"""Facts and primitives that most tests get along with."""


def fact(text: str) -> Fact:
    """A fact, prefix, request or pattern from text; variables are `?` symbols."""
    found: list[Atom] = []
    pattern = parse_pattern(text)
    for arg in pattern.args:
        assert not isinstance(arg, nodes.Call)
        found.append(arg.name if isinstance(arg, nodes.Var) else arg.value)
    return (pattern.name, *found)


def row(
    request: str,
    result: str = "okay",
    *,
    asserts: Sequence[str] = (),
    erases: Sequence[str] = (),
    **more: Any,
) -> Row:
    """A row of a script; `more` are its other fields."""
    return Row(
        fact(request),
        result,
        asserts=tuple(fact(one) for one in asserts),
        erases=tuple(fact(one) for one in erases),
        **more,
    )


def at(time: Time, *asserts: str, erases: Sequence[str] = ()) -> At:
    """Facts that come, and before that others that go, at a time."""
    return At(
        time,
        asserts=tuple(fact(one) for one in asserts),
        erases=tuple(fact(one) for one in erases),
    )


ANY = (row("(act ?)"), row("(look ?)"), row("(slow ?)", after=1))
"""The last rows of every script: whatever is asked is okay."""


def compiled(text: str) -> Program:
    """A library from text, with the declarations above."""
    source = SourceFile("t.rap", DECLARATIONS + text)
    parsed = parse(source)
    assert not parsed.diagnostics, parsed.diagnostics
    library, wrong = link([parsed])
    assert not wrong, wrong
    return Program(library, "t")


class Play:
    """One run of a library against a script, with all its events.

    Tasks are texts as on the command line. Nothing has run when this returns.
    """

    def __init__(
        self,
        text: str,
        *tasks: str,
        rows: Sequence[Row] = (),
        times: Sequence[At] = (),
        facts: Sequence[str] = (),
        seed: int = 0,
        settings: Settings | None = None,
        functions: Mapping[str, Callable[..., Any]] | None = None,
        solvers: Mapping[str, Callable[..., Any]] | None = None,
        world: type[ScriptedWorld] = ScriptedWorld,
    ) -> None:
        library = compiled(text)
        self.world = world((*rows, *ANY), times, declared=library.library)
        self.interpreter = Interpreter(
            library, self.world, seed, settings, functions, solvers
        )
        self.events: list[events.Event] = []
        self.interpreter.listen(self.events.append)
        self.interpreter.start()
        for one in facts:
            self.interpreter.assert_fact(*fact(one))
        for task in tasks:
            self.interpreter.submit(read_task_request(task))

    def run(self, until: Time | None = None, cycles: int | None = None) -> Play:
        """Run to the end, and return this."""
        self.interpreter.run(until, cycles)
        return self

    def of(self, kind: type[events.Event]) -> list[Any]:
        """The events of a kind."""
        return [event for event in self.events if type(event) is kind]

    def told(self, *words: str, times: bool = False) -> list[str]:
        """What happened, a line for each event of the kinds named by `words`.

        Tasks are called by their RAP; with `times` each line begins with the time.
        """
        lines = []
        names = self._names()
        for event in self.events:
            entry = _LINES.get(type(event))
            if entry is None or entry[0] not in words:
                continue
            line = f"{entry[0]} {entry[1](event, names)}"
            lines.append(f"{event.time} {line}" if times else line)
        return lines

    def memory(self, pattern: str) -> list[str]:
        """The facts that match a pattern, as text, oldest first."""
        name, *args = fact(pattern)
        wanted = [None if str(arg).startswith("?") else arg for arg in args]
        found = self.interpreter.memory.query(name, *wanted)
        return ["(" + " ".join(map(str, one)) + ")" for one in found]

    def _names(self) -> dict[int | None, str]:
        """The RAP of each task."""
        names: dict[int | None, str] = {None: "-"}
        for event in self.of(events.TaskCreated):
            names[event.task] = event.goal.name
        return names


def play(text: str, *tasks: str, **more: Any) -> Play:
    """Run a library to the end of its tasks; see `Play`."""
    return Play(text, *tasks, **more).run()


def _text(event: events.PrimitiveEnded) -> str:
    return format_list(event.request)


_Line = Callable[[Any, Mapping[int | None, str]], str]

_LINES: Mapping[type[events.Event], tuple[str, _Line]] = {
    events.TaskCreated: ("created", lambda e, n: str(e.goal)),
    events.TaskSelected: ("selected", lambda e, n: n[e.task]),
    events.MethodChosen: ("chosen", lambda e, n: f"{n[e.task]} {e.method}"),
    events.MethodEnded: ("ended", lambda e, n: f"{n[e.task]} {e.method} {e.result}"),
    events.TaskBlocked: ("blocked", lambda e, n: f"{n[e.task]} on {e.on}"),
    events.TaskWoken: ("woken", lambda e, n: n[e.task]),
    events.MethodSuspended: (
        "suspended",
        lambda e, n: f"{n[e.task]} for {e.for_} by {n[e.by]}",
    ),
    events.TaskSucceeded: ("succeeded", lambda e, n: str(e.goal)),
    events.TaskFailed: ("failed", lambda e, n: f"{e.goal} {e.reason} {e.result}"),
    events.TaskRemoved: ("removed", lambda e, n: f"{n[e.task]} {e.cause}"),
    events.PrimitiveRequested: ("asked", lambda e, n: format_list(e.request)),
    events.PrimitiveEnded: (
        "done",
        lambda e, n: f"{n[e.task]} {_text(e)} {e.result}",
    ),
    events.FactAsserted: ("asserted", lambda e, n: f"{format_list(e.fact)} by {e.by}"),
    events.FactErased: ("erased", lambda e, n: f"{format_list(e.fact)} by {e.by}"),
    events.ResourceChanged: ("changed", lambda e, n: f"{n[e.task]} {e.what}"),
    events.QueryFaulted: ("fault", lambda e, n: f"{n[e.task]} {e.what}"),
    events.FamilySwitched: ("switched", lambda e, n: f"{e.from_} {e.to}"),
    events.DeadlineMissed: ("missed", lambda e, n: f"{n[e.task]} {e.deadline}"),
    events.SolverCalled: ("solver", lambda e, n: f"{e.goal} {e.methods}"),
    events.RunEnded: ("over", lambda e, n: e.reason),
}
