"""Commands that go to other moments and branches, and search for events."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rapc.base.names import plural
from rapc.base.outputs import BUG, TRACE
from rapc.debug.answer import Answer, command, say, table
from rapc.debug.arguments import Arguments
from rapc.debug.bug import SUFFIX, write_bug
from rapc.debug.find import count_before, find_event
from rapc.debug.history import History, Stop
from rapc.debug.recorded import write_trace
from rapc.errors import TextError
from rapc.repl.shell import Shell


def _moved(shell: Shell, move: Callable[[History], Stop]) -> Answer:
    """Go to another moment without output of events on the way."""
    stop = move(shell.history)
    shell.forget_trace()
    failed = stop.kind == "broken"
    lines = [stop.said] if failed else []
    return Answer((*lines, *shell.watched(), shell.history.stand()), failed=failed)


@command("[N]", ":back", ":back 100")
def _back(shell: Shell, args: Arguments) -> Answer:
    """Go back one cycle, or N cycles.

    The state of the run at that moment is restored. An act there (for example
    `:assert`) begins a new branch; the old branch is kept.
    """
    cycles = args.count("number of cycles", 1)
    # The end of the run, or an arrival after a cycle, counts as a step.
    cycles -= shell.history.over or shell.history.between
    return _moved(shell, lambda history: history.goto(history.cycle - cycles))


@command("CYCLE | at TIME | end", ":goto 264", ":goto at 240", ":goto end")
def _goto(shell: Shell, args: Arguments) -> Answer:
    """Go to the end of a cycle, or to a time, in the past or future.

    A time is the last moment at or before TIME, which may be between two cycles.
    """
    if args.takes("at"):
        time = args.time("time")
        return _moved(shell, lambda history: history.goto_time(time))
    if args.takes("end"):
        return _moved(shell, lambda one: one.goto(one.seen + one.seen_over))
    cycle = args.count("cycle")
    return _moved(shell, lambda history: history.goto(cycle))


@command("[NAME]", ":branch", ":branch main", ":branch with-fuel")
def _branch(shell: Shell, args: Arguments) -> Answer:
    """Switch to a branch, or begin a new branch at this moment."""
    history = shell.history
    name = args.peek() and args.word("name")
    if any(branch.name == name for branch in history.branches):
        history.switch(name)
        shell.forget_trace()
    else:
        history.branch_off(name)
    return say(f"now on {history.branch.name}", history.stand())


@command()
def _branches(shell: Shell, args: Arguments) -> Answer:
    """List the branches."""
    history = shell.history
    history.check_is_run()
    rows = [
        (
            "*" if branch is history.branch else "",
            branch.name,
            branch.begun,
            branch.end.cycle,
            "; ".join(f"{done.cycle}: {done.act}" for done in branch.acts),
        )
        for branch in history.branches
    ]
    return table(("", "branch", "from", "last cycle", "acts"), rows)


@command(
    "[back] KIND [KEY=VALUE | TEXT]...",
    ":find task-failed",
    ":find back method-chosen task=12",
    ":find fact-asserted location bay1",
    ":find primitive-ended result=arm-dropped",
)
def _find(shell: Shell, args: Arguments) -> Answer:
    """Go to the next event of a kind, or back to the last event.

    Kinds and keys are those of the trace. TEXT must occur in the event. The session
    moves to the end of the cycle of the event.
    """
    back = args.takes("back")
    kind = args.word("kind of event")
    history, words = shell.history, args.rest()
    found = find_event(history, kind, words, back=back)
    shell.forget_trace()
    if found is not None:
        return say(*shell.trace([found]), f"in cycle {found.cycle}", history.stand())
    said = " ".join([kind, *words])
    lines = [f"no event {said} {'before' if back else 'after'} this cycle"]
    if not (back or history.no_way_back):
        count = count_before(history, kind, words)
        if count:
            lines.append(
                f"{plural(count, 'event')} before this cycle: use `:find back {said}`"
            )
    return say(*lines, history.stand())


@command("FILE", ":record run.jsonl")
def _record(shell: Shell, args: Arguments) -> Answer:
    """Write the trace of the run so far to FILE, as JSON lines.

    `rapc repl FILE` opens the recorded run.
    """
    path = Path(args.word("file"))
    shell.refuse_output(path, TRACE)
    count = write_trace(shell.history, path)
    done = len(shell.history.branch.acts)
    notes = ["acts of the user are not recorded: use `:bug`"] if done else []
    return say(f"{plural(count, 'event')} written to {path}", *notes)


@command("FILE", ":bug rocks.bug")
def _bug(shell: Shell, args: Arguments) -> Answer:
    """Write a report of the run so far to FILE, to be repeated by somebody else.

    The file has the specification of the run, the texts of the library and the acts of
    the user. `rapc repl FILE` repeats the run up to this moment. The name of FILE ends
    with `.bug`.
    """
    path = Path(args.word("file"))
    if path.suffix != SUFFIX:
        raise TextError(f"the file name must end with `{SUFFIX}`")
    shell.refuse_output(path, BUG)
    write_bug(shell.history, path)
    return say(f"report written to {path}; repeat the run with `rapc repl {path}`")
