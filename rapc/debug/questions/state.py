"""Questions about the present state: memory, things, requests and world."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.base.values import Atom, format_atom, format_list, number, readable
from rapc.compiler.rap_plan import requests_of
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.names import (
    definition_in_words,
    definition_names,
    definitions,
    predicates,
)
from rapc.debug.questions.tasks import none_now
from rapc.errors import ArgumentError, TextError
from rapc.events import TaskCreated
from rapc.library.library import Library, Named
from rapc.world import Drawable, Thing, Time

_MOST_LISTED = 10
"""The number of facts of a name up to which the facts behind a query are listed."""


def names_with_facts(history: History) -> Answer:
    """Return the names of facts in memory, with the number of facts of each."""
    memory = history.run.memory
    rows = [(name, len(memory.facts(name))) for name in memory.names()]
    return table(("facts of", "number"), rows, none="no facts in memory")


def beliefs(history: History, name: str, *values: Atom | None) -> Answer:
    """Return the facts of a name that match values, with ages; None matches all.

    Raises:
        ArgumentError: if the name is not declared or a value has the wrong kind.
    """
    run = history.run
    signatures = run.library.signatures
    if name not in signatures.relations:
        return _beliefs_of(history, name)
    wrong = signatures.wrong_kind("erased", name, values)
    if wrong is not None:
        raise ArgumentError(wrong)
    rows = _ages(history, name, values)
    return table(("fact", "since", "age"), rows, none="no matching facts")


def _ages(
    history: History, name: str, values: Sequence[Atom | None] = ()
) -> Iterator[tuple[str, Time | None, Time | None]]:
    for fact, stamp in history.run.memory.facts(name).items():
        given = zip(values, fact[1:], strict=False)
        if all(want is None or want == value for want, value in given):
            since = None if stamp is None else number(stamp)
            age = None if since is None else history.now - since
            yield format_list(fact), since, age


def _beliefs_of(history: History, name: str) -> Answer:
    """Return the facts that a named query reads, with ages.

    Raises:
        ArgumentError: for another name.
    """
    program = history.library.program
    signatures, memory = program.signatures, history.run.memory
    known = signatures.predicates.get(name)
    if known is None or known.formula is None:
        if name not in dict(definition_names(program.library)):
            raise ArgumentError(str(signatures.unknown("test", name)))
        said = definition_in_words(definitions(program, name)[0])
        raise ArgumentError(f"{said} is not in memory", f"use `:source {name}`")
    rows: list[tuple[str, Time | None, Time | None]] = []
    notes: list[str] = []
    for read in predicates(program.library, known.formula):
        facts = memory.facts(read) if read in signatures.relations else {}
        if len(facts) > _MOST_LISTED:
            notes.append(f"{len(facts)} facts of `{read}`: use `:memory {read}`")
        else:
            rows += _ages(history, read) if facts else []
    said = f"facts that query `{name}` reads"
    columns = ("fact", "since", "age")
    return table(columns, rows, said, none="no facts", notes=notes)


@question()
def items(history: History, args: Arguments) -> Answer:
    """List the items in memory."""
    memory = history.run.memory
    rows = []
    for item in memory.items():
        place = memory.value("location", item.name)
        at = "" if place is None else format_atom(place)
        rows.append(
            (item.name, item.kind, at, item.sensor if item.accessible else None)
        )
    columns = ("item", "class", "location", "sensor name")
    return table(columns, rows, none="no items in memory")


@question()
def monitors(history: History, args: Arguments) -> Answer:
    """List the tasks with monitors, and the facts and events they wait for."""
    run, row = history.run, history.library.program.compiler.row
    entries = {entry.task: entry for entry in history.run.agenda()}
    rows = []
    for task in run.tasks():
        if task.plan.monitored:
            entry, wait = entries[task.number], task.wait
            formula = run.monitored(task) if task.bound else ""
            timer = None if wait is None else wait.timer
            plan = task.plan.monitor_state
            where = "" if plan is None else row(plan.formula.span)
            told = (task.number, entry.goal, entry.state, formula, where, timer)
            rows.append((*told, entry.deadline))
    columns = ("task", "goal", "state", "waits for", "where", "next test", "deadline")
    return table(columns, rows, none=none_now(history, "monitors"))


@question()
def claims(history: History, args: Arguments) -> Answer:
    """List the held things with the tasks that hold and wait for each.

    Deadlocks of tasks are listed below the table.
    """
    rows = [
        (
            *(one.said, one.task.number, str(one.task.goal())),
            "uses" if one.used else "claims",
            " ".join(f"[{number}]" for number in one.waiting) or None,
        )
        for one in history.run.claims()
    ]
    columns = ("thing", "held by", "goal", "how", "waited for by")
    notes = history.run.deadlocks()
    return table(columns, rows, none="no held things", notes=notes)


@question()
def requests(history: History, args: Arguments) -> Answer:
    """List the requests under way."""
    rows = [
        (ticket, task.number, format_list(asked))
        for ticket, (task, asked) in history.run.requests().items()
        if task is not None
    ]
    return table(("ticket", "task", "request"), rows, none="no requests under way")


@question()
def stack(history: History, args: Arguments) -> Answer:
    """List the families that were selected, the preferred family first."""
    goals = history.run.goals()
    rows = [
        (priority, f"[{family}]", str(goals.get(family, "ended")))
        for priority, family in history.run.families()
    ]
    columns = ("priority", "family", "goal")
    return table(columns, rows, none="no family selected")


@question()
def skills(history: History, args: Arguments) -> Answer:
    """List the active skills, with the line of their clause."""
    row = history.library.program.compiler.row
    rows = [
        (
            one.ticket,
            None if one.task is None else one.task.number,
            " ".join(map(format_list, one.skills)),
            "off" if one.run is None else "on",
            "" if one.run is None else row(requests_of(one.run.plan.node)[0].span),
        )
        for one in history.run.skills()
    ]
    columns = ("ticket", "task", "skills", "", "where")
    return table(columns, rows, none="no active skills")


@question()
def world(history: History, args: Arguments) -> Answer:
    """Show the true state of the world, which the robot does not know."""
    shown = history.run.port
    if not isinstance(shown, Drawable):
        raise ArgumentError(
            f"cannot show world `{shown.name}`: it has no `picture` method"
        )
    picture = shown.picture()
    rows = [
        (
            ("* " if spot.name == picture.here else "") + spot.name,
            " ".join(map(_thing, spot.things)),
            spot.note or None,
        )
        for spot in picture.spots
    ]
    gauges = [f"{one.name}: {readable(one.value)}" for one in picture.gauges]
    said = "true state of the world; unknown to the robot"
    return table(("place", "things", "note"), rows, said, notes=gauges)


def _thing(thing: Thing) -> str:
    return f"{format_atom(thing.look)} {thing.kind}" if thing.look else thing.kind


@question(
    "[TASK | NAME | QUERY | FILE:LINE]",
    ":source",
    ":source 12",
    ":source fill-order",
    ":source (truck-location ?)",
)
def source(history: History, args: Arguments) -> Answer:
    """Show the source text of a definition, or of the RAP of a task.

    NAME is a RAP, a query, an agenda, a declared name, or the signal of a rule. For a
    line between definitions, the nearest definition is shown.
    """
    program, name = history.library.program, args.peek()
    if not name or name.strip("[]").isdecimal():
        name = _rap_of(history, args.task(history))
    else:
        args.word("name")
    lines = [
        line
        for form in definitions(program, name, near=True)
        for line in _text_of(program.library, form)
    ]
    return Answer(tuple(lines), is_code=True)


def _text_of(library: Library, form: Named) -> Iterator[str]:
    """Yield the file of a definition and its numbered lines."""
    file = library.files.get(form.span.file)
    if file is None or not file.text:
        definition = definition_in_words(form)
        raise TextError(f"the source text of {definition} is not available")
    first, last = file.row(form.span.start), file.row(form.span.end)
    width = len(str(last))
    yield file.name
    for row in range(first, last + 1):
        yield f"{row:>{width}} {file.line(row)}"


def _rap_of(history: History, number: int) -> str:
    """Return the RAP of a live or ended task.

    Raises:
        ArgumentError: if the task is unknown.
    """
    told = history.last(TaskCreated, want=lambda one: one.keys["task"] == number)
    goal = history.run.task(number).goal() if told is None else told.keys["goal"]
    return str(goal.name)
