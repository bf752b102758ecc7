"""Commands that run cycles and show their events."""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.names import plural
from rapc.debug.answer import Answer, command, say
from rapc.debug.arguments import Arguments
from rapc.debug.history import Stop
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
        lines = [f"... {plural(left, 'line')} left out", *lines[-_SHOWN:]]
    said = {
        "break": f"stopped: {stop.said}",
        "pause": "paused",
        "broken": f"the run broke off: {stop.said}",
    }.get(stop.kind, stop.said if stop.kind == "asked" else "")
    watched = shell.watched()
    told = [*lines, *([said] if said else []), *watched, shell.history.stand()]
    return Answer(tuple(told), failed=stop.kind == "broken")


@command("[N]", ":step", ":step 10")
def _step(shell: Shell, args: Arguments) -> Answer:
    """Run a cycle, or N of them.

    A cycle is what happens to one task from being chosen to succeeding, failing,
    waiting, or beginning a method.
    """
    cycles = args.count("how many cycles", 1)
    return _went(shell, lambda: shell.history.step(cycles))


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
    """Run until the task above a task comes up again."""
    history = shell.history
    parent = history.run.task(args.task(shell.history)).parent
    if parent is None:
        raise ArgumentError("a top-level task has no parent")

    def came_up() -> str | None:
        if not parent.live:
            return f"task [{parent.number}] has ended"
        if history.selected == parent.number:
            return f"task [{parent.number}] has come up"
        return None

    return _went(shell, lambda: history.go(came_up))


@command()
def _primitive(shell: Shell, args: Arguments) -> Answer:
    """Run until the next primitive has been carried out."""
    history, heard = shell.history, shell.history.serial

    def answered() -> str | None:
        nonlocal heard
        told, heard = history.log.since(heard), history.serial
        return "" if any(one.kind is PrimitiveEnded for one in told) else None

    return _went(shell, lambda: history.go(answered))


@command("CYCLE | at TIME", ":to 264", ":to at 240")
def _to(shell: Shell, args: Arguments) -> Answer:
    """Run to the end of a cycle, or as far as a time."""
    history = shell.history
    if args.takes("at"):
        time = args.time("a time")
        if time < history.now:
            raise ArgumentError("that has been; `:goto` goes back")
        return _went(shell, lambda: history.goto_time(time, heed=True))
    cycle = args.count("a cycle")
    if cycle < history.cycle:
        raise ArgumentError("that has been; `:goto` goes back")
    return _went(shell, lambda: history.goto(cycle, heed=True))


@command()
def _run(shell: Shell, args: Arguments) -> Answer:
    """Run until a breakpoint, Ctrl-C or the end stops it."""
    return _went(shell, shell.history.go)


@command("[all | requests | none]", ":show requests")
def _show(shell: Shell, args: Arguments) -> Answer:
    """Say what is shown of the events after a step."""
    ways = ("all", "requests", "none")
    if args:
        way = args.word("what to show")
        if way not in ways:
            raise ArgumentError(f"`:show` takes {', '.join(ways)}; not `{way}`")
        shell.shows = way
    return say(f"after a step is shown: {shell.shows}")


@command("[N]", ":trace", ":trace 20")
def _trace(shell: Shell, args: Arguments) -> Answer:
    """Show what has happened in the last cycles once more."""
    cycles = args.count("how many cycles", 5)
    history = shell.history
    first = max(history.cycle - cycles + 1, 1)
    told = history.scan(first=first)
    return Answer(tuple(shell.trace(told)))
