"""Commands that run cycles and show their events."""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.names import plural
from rapc.base.values import readable
from rapc.debug.answer import Answer, command, say
from rapc.debug.arguments import Arguments
from rapc.debug.history import Stop
from rapc.debug.questions.ends import why_end
from rapc.errors import ArgumentError
from rapc.events import PrimitiveEnded
from rapc.repl.shell import Shell

_SHOWN = 40

"""The number of lines of events shown at once."""


def _went(shell: Shell, go: Callable[[], Stop]) -> Answer:
    """Run until `go` returns; return the events, the stop and the moment."""
    before = shell.history.serial
    stop = go()
    lines = shell.happened(before)
    left = len(lines) - _SHOWN
    if left > 0:
        lines = [f"... {plural(left, 'line')} omitted", *lines[-_SHOWN:]]
    said = {
        "break": f"stopped: {stop.said}",
        "pause": "paused",
        "broken": f"run ended by an error: {stop.said}",
    }.get(stop.kind, stop.said if stop.kind == "asked" else "")
    watched = shell.watched()
    told = [*lines, *([said] if said else []), *watched, shell.history.stand()]
    if stop.kind == "over" and shell.history.over:
        end = why_end(shell.history)
        return Answer((*told, *end.lines[1:]), end.table, end.notes)
    return Answer(tuple(told), failed=stop.kind == "broken")


@command("[N]", ":step", ":step 10")
def _step(shell: Shell, args: Arguments) -> Answer:
    """Run one cycle, or N cycles.

    In a cycle, one task is selected; the task then succeeds, fails, waits or starts a
    method.
    """
    cycles = args.count("number of cycles", 1)
    return _went(shell, lambda: shell.history.step(cycles))


@command()
def _wait(shell: Shell, args: Arguments) -> Answer:
    """Run until something arrives, or to the end of the next cycle.

    Data, signals and ends of requests arrive, and timers become due. The run then
    stands between two cycles.
    """
    return _went(shell, shell.history.wait)


@command("[TASK]", ":out", ":out 12")
def _out(shell: Shell, args: Arguments) -> Answer:
    """Run until a task has ended."""
    history = shell.history
    task = history.run.task(args.task(shell.history))

    def ended() -> str | None:
        return None if task.live else f"task [{task.number}] has ended"

    return _went(shell, lambda: history.go(ended))


@command("[TASK]", ":parent", ":parent 12")
def _parent(shell: Shell, args: Arguments) -> Answer:
    """Run until the parent of a task is selected."""
    history = shell.history
    parent = history.run.task(args.task(shell.history)).parent
    if parent is None:
        raise ArgumentError("a top-level task has no parent")

    def came_up() -> str | None:
        if not parent.live:
            return f"task [{parent.number}] has ended"
        if history.selected == parent.number:
            return f"task [{parent.number}] was selected"
        return None

    return _went(shell, lambda: history.go(came_up))


@command()
def _primitive(shell: Shell, args: Arguments) -> Answer:
    """Run until a primitive has ended."""
    history, heard = shell.history, shell.history.serial

    def answered() -> str | None:
        nonlocal heard
        told, heard = history.log.since(heard), history.serial
        return "" if any(one.kind is PrimitiveEnded for one in told) else None

    return _went(shell, lambda: history.go(answered))


@command("CYCLE | at TIME", ":to 264", ":to at 240")
def _to(shell: Shell, args: Arguments) -> Answer:
    """Run to the end of a cycle, or to a time."""
    history = shell.history
    if args.takes("at"):
        time = args.time("time")
        if time < history.now:
            past = readable(time)
            raise ArgumentError(f"time {past} is in the past; use `:goto at {past}`")
        return _went(shell, lambda: history.goto_time(time, heed=True))
    cycle = args.count("cycle")
    if cycle < history.cycle:
        raise ArgumentError(f"cycle {cycle} is in the past; use `:goto {cycle}`")
    return _went(shell, lambda: history.goto(cycle, heed=True))


@command()
def _run(shell: Shell, args: Arguments) -> Answer:
    """Run until a breakpoint, Ctrl-C or the end of the run.

    At the end, the symptoms of the run are listed; see `:why end`.
    """
    return _went(shell, shell.history.go)


@command("[all | requests | none]", ":show requests")
def _show(shell: Shell, args: Arguments) -> Answer:
    """Choose the events that are shown after each step."""
    ways = ("all", "requests", "none")
    if args:
        way = args.word("events to show")
        if way not in ways:
            raise ArgumentError(f"expected {', '.join(ways)}, not `{way}`")
        shell.shows = way
    return say(f"shown after each step: {shell.shows}")


@command("[N]", ":trace", ":trace 20")
def _trace(shell: Shell, args: Arguments) -> Answer:
    """Show the trace of the last N cycles (default: 5)."""
    cycles = args.count("number of cycles", 5)
    history = shell.history
    first = max(history.cycle - cycles + 1, 1)
    told = history.scan(first=first)
    return Answer(tuple(shell.trace(told)))
