"""Commands that let the run go on, or stop it, or take it back."""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.names import plural
from rapc.debug.acts import live_task
from rapc.debug.history import History, Stop
from rapc.errors import ArgumentError
from rapc.events import PrimitiveEnded
from rapc.repl.answer import ShownAnswer, say, table
from rapc.repl.arguments import Arguments
from rapc.repl.shell import Shell, command

_SHOWN = 40
"""How many lines of what has happened are shown at once."""


def _went(shell: Shell, go: Callable[[], Stop]) -> ShownAnswer:
    """Let the run go on, and tell what has happened and where it stands."""
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
    return ShownAnswer(tuple(told), failed=stop.kind == "broken")


@command("[N]", ":step", ":step 10")
def _step(shell: Shell, args: Arguments) -> ShownAnswer:
    """Run a cycle, or N of them.

    A cycle is what happens to one task from being chosen to succeeding, failing,
    waiting, or beginning a method.
    """
    cycles = args.count("how many cycles", 1)
    return _went(shell, lambda: shell.history.step(cycles))


@command("", ":run")
def _run(shell: Shell, args: Arguments) -> ShownAnswer:
    """Run until a breakpoint, Ctrl-C or the end stops it."""
    return _went(shell, shell.history.go)


@command("[TASK]", ":out", ":out 12")
def _out(shell: Shell, args: Arguments) -> ShownAnswer:
    """Run until a task has ended."""
    history = shell.history
    task = live_task(history.run, shell.task(args))

    def ended() -> str | None:
        return None if task.live else f"task [{task.number}] has ended"

    return _went(shell, lambda: history.go(ended))


@command("[TASK]", ":parent", ":parent 12")
def _parent(shell: Shell, args: Arguments) -> ShownAnswer:
    """Run until the task above a task comes up again."""
    history = shell.history
    parent = live_task(history.run, shell.task(args)).parent
    if parent is None:
        raise ArgumentError("a top-level task has no parent")

    def came_up() -> str | None:
        if not parent.live:
            return f"task [{parent.number}] has ended"
        if history.selected == parent.number:
            return f"task [{parent.number}] has come up"
        return None

    return _went(shell, lambda: history.go(came_up))


@command("", ":primitive")
def _primitive(shell: Shell, args: Arguments) -> ShownAnswer:
    """Run until the next primitive has been carried out."""
    history, heard = shell.history, shell.history.serial

    def answered() -> str | None:
        nonlocal heard
        told, heard = history.log.since(heard), history.serial
        return "" if any(one.kind is PrimitiveEnded for one in told) else None

    return _went(shell, lambda: history.go(answered))


@command("CYCLE | at TIME", ":to 264", ":to at 240")
def _to(shell: Shell, args: Arguments) -> ShownAnswer:
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


def _moved(shell: Shell, move: Callable[[History], Stop]) -> ShownAnswer:
    """Go somewhere else in time, without telling what happens on the way."""
    stop = move(shell.history)
    shell.forget_trace()
    failed = stop.kind == "broken"
    lines = [stop.said] if failed else []
    return ShownAnswer((*lines, *shell.watched(), shell.history.stand()), failed=failed)


@command("[N]", ":back", ":back 100")
def _back(shell: Shell, args: Arguments) -> ShownAnswer:
    """Go back a cycle, or N of them.

    The run is then as it was, and goes on as it did. Changing it there begins a new
    branch.
    """
    cycles = args.count("how many cycles", 1)
    cycles -= shell.history.over  # the end of the run is a step of its own
    return _moved(shell, lambda history: history.goto(history.cycle - cycles))


@command("CYCLE | at TIME | end", ":goto 264", ":goto at 240", ":goto end")
def _goto(shell: Shell, args: Arguments) -> ShownAnswer:
    """Go to the end of a cycle, or to a time, back or forth."""
    if args.takes("at"):
        time = args.time("a time")
        return _moved(shell, lambda history: history.goto_time(time))
    if args.takes("end"):
        return _moved(shell, lambda one: one.goto(one.seen + one.seen_over))
    cycle = args.count("a cycle")
    return _moved(shell, lambda history: history.goto(cycle))


@command("[NAME]", ":branch", ":branch main", ":branch with-fuel")
def _branch(shell: Shell, args: Arguments) -> ShownAnswer:
    """Go on in another branch, or begin a new one here."""
    history = shell.history
    name = args.peek() and args.word("a name")
    if any(branch.name == name for branch in history.branches):
        history.switch(name)
        shell.forget_trace()
    else:
        history.branch_off(name)
    return say(f"on {history.branch.name}", history.stand())


@command("", ":branches")
def _branches(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the branches."""
    history = shell.history
    rows = [
        (
            "*" if branch is history.branch else "",
            branch.name,
            branch.begun,
            branch.end.cycle,
            "; ".join(f"{cycle}: {act}" for cycle, act in branch.acts),
        )
        for branch in history.branches
    ]
    return table(("", "branch", "from", "seen to", "acts"), rows)


@command("[all | requests | none]", ":show requests")
def _show(shell: Shell, args: Arguments) -> ShownAnswer:
    """Say what is shown of the events after a step."""
    ways = ("all", "requests", "none")
    if args:
        way = args.word("what to show")
        if way not in ways:
            raise ArgumentError(f"`:show` takes {', '.join(ways)}; not `{way}`")
        shell.shows = way
    return say(f"after a step is shown: {shell.shows}")


@command("[N]", ":trace", ":trace 20")
def _trace(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show what has happened in the last cycles once more."""
    cycles = args.count("how many cycles", 5)
    history = shell.history
    first = max(history.cycle - cycles + 1, 1)
    told = history.scan(first=first)
    return ShownAnswer(tuple(shell.trace(told)))


MOVING = (_step, _out, _parent, _primitive, _to, _run, _show, _trace)

TIME = (_back, _goto, _branch, _branches)
