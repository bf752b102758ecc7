"""Commands that show what stands now."""

from __future__ import annotations

from rapc.base.source import SourceFile, Span
from rapc.base.values import format_atom, format_list, readable
from rapc.debug import look
from rapc.debug.acts import live_task
from rapc.errors import ArgumentError, TextError
from rapc.events import Goal, TaskCreated
from rapc.ir.nodes import Const, Proposition
from rapc.parser.parse import parse_formula, parse_pattern
from rapc.repl.answer import Cell, ShownAnswer, table
from rapc.repl.arguments import Arguments
from rapc.repl.shell import Shell, command
from rapc.runtime.events.report import cause_lines
from rapc.world import Drawable, Thing


@command("", ":agenda")
def _agenda(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the tasks under way, and what keeps each from going on."""
    entries = shell.history.run.agenda()
    rows = [
        (
            one.task,
            one.goal,
            one.state,
            one.priority or None,
            one.deadline,
            one.slack,
            one.waits_for,
        )
        for one in entries
    ]
    columns = ("task", "goal", "state", "priority", "deadline", "slack", "waits for")
    return table(columns, rows, none="no task is under way")


@command("", ":tree")
def _tree(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show the families of tasks, with states, methods and last results."""
    history = shell.history
    if history.is_run:
        nodes = look.tree(history.run)
    else:
        nodes = look.tree_told(history.scan(*look.TOLD_OF_TREES))
    rows = [
        (
            "  " * one.depth + f"[{one.task}] {one.goal}",
            one.state,
            one.method,
            one.result,
            "" if one.because is None else one.because.clause,
        )
        for one in nodes
    ]
    columns = ("task", "state", "method", "last result", "because of")
    return table(columns, rows, none="no task is under way")


@command("[TASK]", ":chain 157")
def _chain(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show a task and all above it, up to its top-level task."""
    found = look.chain(shell.history.run, shell.task(args))
    return table(("task", "goal", "method"), found)


@command("[TASK]", ":task", ":task 12")
def _task(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show all of a task: its bindings, method, times, and what it came to."""
    run = shell.history.run
    number = shell.task(args)
    task = live_task(run, number)
    entry = next(one for one in run.agenda() if one.task == number)
    rows: list[tuple[Cell, ...]] = [
        ("goal", str(entry.goal)),
        ("state", entry.state),
        ("waits for", entry.waits_for or None),
        ("family", f"[{entry.family}]"),
        ("parent", None if entry.parent is None else f"[{entry.parent}]"),
        ("step", None if task.step is None else str(task.step.node.tag)),
        ("priority", entry.priority),
        ("deadline", entry.deadline),
        ("slack", entry.slack),
        ("method", None if task.method is None else task.method.name),
        ("last result", task.last_result),
        ("defined at", shell.place(task.plan.node.name_span)),
    ]
    rows += [(name, format_atom(value)) for name, value in task.env.items()]
    if task.run is not None:
        own = task.env
        rows += [
            (name, format_atom(value))
            for name, value in task.run.env.items()
            if name not in own
        ]
    history = task.history
    if history is not None:
        plans = run.machine.state.methods(task.plan)
        rows += [
            (f"failures of {plans[at].name}", count)
            for at, count in history.failures.items()
        ]
    notes = () if history is None else tuple(cause_lines(history.because))
    kept = [row for row in rows if row[1] is not None]
    return table(("of", "is"), kept, f"task [{number}]", notes=notes)


@command(
    "[NAME | QUERY]", ":memory", ":memory location", ":memory (location ?item depot)"
)
def _memory(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show facts with their ages, or the answers to a query."""
    run = shell.history.run
    if not args:
        names = look.names_with_facts(run)
        return table(("facts of", "number"), names, none="memory is empty")
    text = args.word("a query")
    if not text.startswith("("):
        return _beliefs(shell, Proposition(text.lower(), ()))
    formula = parse_formula(text)
    if isinstance(formula, Proposition):
        plain = shell.history.library.program.signatures.relations
        if formula.name in plain:
            return _beliefs(shell, parse_pattern(text))
    return shell.ask(text)


def _beliefs(shell: Shell, pattern: Proposition) -> ShownAnswer:
    """The facts that a proposition matches, each with its age."""
    run = shell.history.run
    values = [a.value if isinstance(a, Const) else None for a in pattern.args]
    found = look.beliefs(run, pattern.name, *values)
    rows = [
        (
            format_list(one.fact),
            one.since,
            None if one.since is None else run.now - one.since,
        )
        for one in found
    ]
    return table(("fact", "since", "age"), rows, none="no such fact")


@command("", ":items")
def _items(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the items that memory knows."""
    columns = ("item", "class", "location", "sensor name")
    found = look.items(shell.history.run)
    return table(columns, found, none="memory knows no items")


@command("", ":monitors")
def _monitors(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the tasks with monitors, and what each waits for."""
    columns = ("task", "goal", "state", "waits for", "looks at", "deadline")
    found = look.monitored_tasks(shell.history.run)
    return table(columns, found, none="no task has a monitor")


@command("", ":claims")
def _claims(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the things that are held, by whom, and who waits for them.

    Circles of tasks that wait for each other are named below.
    """
    found, deadlocks = look.claims(shell.history.run)
    rows = [
        (
            one.thing,
            one.holder,
            str(one.goal),
            "uses" if one.used else "claims",
            " ".join(f"[{number}]" for number in one.waiters) or None,
        )
        for one in found
    ]
    columns = ("thing", "held by", "goal", "how", "waited for by")
    return table(columns, rows, none="no thing is held", notes=deadlocks)


@command("", ":requests")
def _requests(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the requests under way: sent, neither ended nor cancelled."""
    found = look.requests(shell.history.run)
    return table(("ticket", "task", "request"), found, none="no request is under way")


@command("", ":stack")
def _stack(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show the families that were chosen, the one that is preferred now first."""
    rows = [
        (priority, f"[{family}]", goal)
        for priority, family, goal in look.stack(shell.history.run)
    ]
    columns = ("priority", "family", "goal")
    return table(columns, rows, none="no family has been chosen yet")


@command("", ":skills")
def _skills(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the skills that methods have switched on."""
    rows = [
        (one.ticket, one.task, one.skills, "on" if one.on else "off")
        for one in look.skills(shell.history.run)
    ]
    return table(("ticket", "task", "skills", ""), rows, none="no skill is on")


@command("", ":world")
def _world(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show what is true in the world, which the robot need not know."""
    world = shell.history.run.machine.world
    if not isinstance(world, Drawable):
        raise ArgumentError(f"the world `{world.name}` has no picture of itself")
    picture = world.picture()
    rows = [
        (
            ("* " if spot.name == picture.here else "") + spot.name,
            " ".join(map(_thing, spot.things)),
            spot.note or None,
        )
        for spot in picture.spots
    ]
    gauges = [f"{one.name}: {readable(one.value)}" for one in picture.gauges]
    said = "what is true in the world; the robot does not know it"
    return table(("place", "things", "besides"), rows, said, notes=gauges)


def _thing(thing: Thing) -> str:
    return (
        thing.kind if thing.look is None else f"{format_atom(thing.look)} {thing.kind}"
    )


@command("[TASK | RAP]", ":source", ":source 12", ":source fill-order")
def _source(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show the text of a RAP, or of the RAP of a task."""
    library = shell.history.library.program.library
    name = args.peek()
    if not name or name.strip("[]").isdecimal():
        node = library.raps[_goal_of(shell, shell.task(args)).name]
    else:
        name = args.word("a RAP").lower()
        found = library.raps.get(name)
        if found is None:
            known = shell.history.library.program.signatures
            raise ArgumentError(str(known.unknown("goal", name)))
        node = found
    source = library.files.get(node.span.file)
    if source is None or not source.text:
        raise TextError(f"the text of `{node.name}` is not at hand")
    return ShownAnswer(tuple(_numbered(source, node.span)), is_code=True)


def _goal_of(shell: Shell, number: int) -> Goal:
    """Return the goal of a task, whether it has ended or not.

    Raises:
        ArgumentError: if there is no such task.
    """
    history = shell.history
    told = history.last(TaskCreated, want=lambda one: one.keys["task"] == number)
    if told is None:
        return live_task(history.run, number).goal()
    goal = told.keys["goal"]
    assert isinstance(goal, Goal)
    return goal


def _numbered(source: SourceFile, span: Span) -> list[str]:
    """Return the lines of a span, each behind its number, under the file's name."""
    first, last = source.row(span.start), source.row(span.end)
    width = len(str(last))
    rows = range(first, last + 1)
    return [source.name, *(f"{row:>{width}} {source.line(row)}" for row in rows)]


@command("", ":more")
def _more(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show further answers to the query that was asked last."""
    return shell.more()


LOOKING = (
    _agenda,
    _tree,
    _task,
    _chain,
    _memory,
    _more,
    _items,
    _monitors,
    _claims,
    _requests,
    _stack,
    _skills,
    _world,
    _source,
)
