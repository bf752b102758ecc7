"""Commands about breakpoints and watches, and searching through time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from rapc.base.names import plural
from rapc.base.outputs import BREAKPOINTS, TRACE
from rapc.base.values import readable
from rapc.debug import differences, recorded
from rapc.debug.breakpoints import KINDS, Breakpoint
from rapc.debug.find import Finder, find_event, is_before
from rapc.debug.history import History
from rapc.debug.recording import UNREADABLE
from rapc.errors import ArgumentError, TextError
from rapc.repl.answer import ShownAnswer, say, table
from rapc.repl.arguments import Arguments
from rapc.repl.shell import Shell, command

_KINDS = f"Kinds: {'; '.join(f'`{kind}`: {said}' for kind, said in KINDS.items())}."


@command(
    "[KIND [WHAT] [if QUERY] [after N] [log] [before]] | save FILE | load FILE",
    ":break rap fill-order",
    ":break rap (travel-road ?from ?way zone-2)",
    ":break task 12",
    ":break method look",
    ":break method look of fuel-up",
    ":break failure interference",
    ":break primitive (arm-grasp ? ?) if (truck-status ready)",
    ":break fact (location ?thing bay1) after 2",
    ":break true (truck-location zone-4) before",
    ":break deadline log",
    ":break time 200",
    ":break save my-breakpoints.json",
    more=_KINDS,
)
def _break(shell: Shell, args: Arguments) -> ShownAnswer:
    """Set a breakpoint, or list them.

    A cycle is one piece: the run stops after the cycle in which it happened, or with
    `before` at the end of the one before. `if` asks memory then, `after N` lets it
    happen N times first, `log` takes note and goes on.
    """
    if not args:
        return _listed(shell)
    kind = args.word("what to stop at")
    if kind == "save":
        return _save(shell, Path(args.word("a file")))
    if kind == "load":
        return _load(shell, Path(args.word("a file")))
    point = Breakpoint(kind)
    if args and args.peek() not in _OPTIONS:
        point.what = args.word("what to stop at")
    if kind == "method" and args.takes("of"):
        point.what += f" of {args.word('a RAP')}"
    while args:
        option = args.word("an option")
        if option == "if":
            point.condition = args.word("a condition")
        elif option == "after":
            point.passes = args.count("how many times")
        elif option == "log":
            point.logs = True
        elif option == "before":
            point.before = True
        else:
            raise TextError(f"`{option}` is none of if, after, log, before")
    number = shell.breakpoints.add(point)
    return say(f"breakpoint {number}: {point}", *_several(shell, point))


def _several(shell: Shell, point: Breakpoint) -> list[str]:
    """Return what to say where several RAPs have the method of a breakpoint."""
    raps = shell.breakpoints.raps_with(point.what.lower())
    if point.kind != "method" or len(raps) < 2:
        return []
    listed = ", ".join(f"`{rap}`" for rap in raps)
    one = f"`:break method {point.what} of {raps[0]}` stops at that of one RAP"
    return [f"`{point.what}` is a method of {listed}; {one}"]


_OPTIONS = ("if", "after", "log", "before")


def _listed(shell: Shell) -> ShownAnswer:
    rows = [
        (number, str(point), point.met)
        for number, point in shell.breakpoints.all.items()
    ]
    columns = ("number", "stops at", "met")
    logged = shell.breakpoints.logged[-20:]
    return table(columns, rows, none="there are no breakpoints", notes=logged)


def _save(shell: Shell, path: Path) -> ShownAnswer:
    shell.refuse_output(path, BREAKPOINTS)
    points = [
        msgspec.structs.replace(point, met=0)
        for point in shell.breakpoints.all.values()
    ]
    try:
        path.write_bytes(msgspec.json.format(msgspec.json.encode(points)) + b"\n")
    except OSError as error:
        raise ArgumentError(f"cannot write `{path}`: {error.strerror}") from error
    return say(f"{plural(len(points), 'breakpoint')} in {path}")


def _load(shell: Shell, path: Path) -> ShownAnswer:
    try:
        points = msgspec.json.decode(path.read_bytes(), type=list[Breakpoint])
    except OSError as error:
        raise ArgumentError(f"cannot read `{path}`: {error.strerror}") from error
    except UNREADABLE as error:
        raise ArgumentError(f"`{path}` holds no breakpoints: {error}") from error
    for point in points:
        shell.breakpoints.add(point)
    return _listed(shell)


@command("NUMBER | all", ":unbreak 2", ":unbreak all")
def _unbreak(shell: Shell, args: Arguments) -> ShownAnswer:
    """Remove a breakpoint, or all."""
    if args.takes("all"):
        for number in list(shell.breakpoints.all):
            shell.breakpoints.remove(number)
    else:
        shell.breakpoints.remove(args.count("a breakpoint"))
    return _listed(shell)


@command("[QUERY]", ":watch (truck-location ?where)")
def _watch(shell: Shell, args: Arguments) -> ShownAnswer:
    """Show the answers to a query after every stop, and mark what has changed."""
    if args:
        shell.watch(args.word("a query"))
    lines = shell.watched()
    return say(*(lines or ["nothing is watched"]))


@command("NUMBER | all", ":unwatch 1")
def _unwatch(shell: Shell, args: Arguments) -> ShownAnswer:
    """Watch a query no more."""
    if args.takes("all"):
        shell.watches.clear()
    else:
        number = args.count("a watch")
        if not 0 < number <= len(shell.watches):
            raise ArgumentError(f"there is no watch {number}")
        del shell.watches[number - 1]
    return say(*(shell.watched() or ["nothing is watched"]))


@command(
    "[back] KIND [KEY=VALUE | TEXT]...",
    ":find task-failed",
    ":find back method-chosen task=12",
    ":find fact-asserted location bay1",
    ":find primitive-ended result=arm-dropped",
)
def _find(shell: Shell, args: Arguments) -> ShownAnswer:
    """Go to the next event of a kind, or back to the last one.

    Kinds and keys are those of a trace. Other words must occur in the event. The
    session then stands at the end of the cycle in which it happened.
    """
    back = args.takes("back")
    kind = args.word("a kind of event")
    said = args.rest()
    finder = Finder.of(kind, said)
    found = find_event(shell.history, finder, back=back)
    shell.forget_trace()
    if found is None:
        lines = _not_found(shell.history, finder, " ".join([kind, *said]), back=back)
        return say(*lines, shell.history.stand())
    return say(*shell.trace([found]), f"in cycle {found.cycle}", shell.history.stand())


def _not_found(
    history: History, finder: Finder, said: str, *, back: bool
) -> Iterator[str]:
    """Yield what to say of a search in vain, with what lies the other way."""
    yield f"no {said} is found {'before' if back else 'after'} this cycle"
    if not (back or history.no_way_back):
        found = history.scan(finder.kind, want=is_before(history, finder))
        count = sum(1 for _ in found)
        if count:
            yield f"{plural(count, 'event')} before it: `:find back {said}`"


@command("FILE", ":record run.jsonl")
def _record(shell: Shell, args: Arguments) -> ShownAnswer:
    """Write the trace of the run up to now, in the form jsonl.

    `rapc repl run.jsonl` opens it again.
    """
    path = Path(args.word("a file"))
    shell.refuse_output(path, TRACE)
    count = recorded.write_trace(shell.history, path)
    done = len(shell.history.branch.acts)
    notes = ["what was done by hand is not in it"] if done else []
    return say(f"{plural(count, 'event')} in {path}", *notes)


def _diff_of_runs(shell: Shell, path: Path) -> ShownAnswer:
    found = recorded.parting(shell.history, path)
    if found is None:
        return say("all decisions are the same, as far as both have gone")
    return say(
        f"the first decision that differs, in cycle {found.cycle}:",
        f"  here:  {_decision(found.here)}",
        f"  there: {_decision(found.there)}",
    )


def _decision(event: dict[str, Any] | None) -> str:
    if event is None:
        return "nothing more"
    at = f"at {readable(event['time'])}"
    if event["event"] == "task-selected":
        return f"{event['goal']} [{event['task']}] came up {at}"
    bound = " ".join(f"{name} {value}" for name, value in event["bindings"].items())
    chose = f"[{event['task']}] chose {event['method']} of {event['rap']} {at}"
    return f"{chose} with {bound}" if bound else chose


@command("CYCLE [CYCLE] | FILE", ":diff 20", ":diff 20 60", ":diff other-seed.jsonl")
def _diff(shell: Shell, args: Arguments) -> ShownAnswer:
    """Say what differs between two moments, or from a run that was recorded.

    Of two runs the first decision is told that differs: which task came up, or
    which method was chosen.
    """
    if args and not args.peek().isdecimal():
        return _diff_of_runs(shell, Path(args.word("a file")))
    history = shell.history
    first = args.count("a cycle")
    second = args.count("a cycle", history.cycle)
    found = differences.between(history, first, second)
    rows = [("+", "fact", one) for one in found.came]
    rows += [("-", "fact", one) for one in found.went]
    rows += [("+", "task", f"[{n}] {goal}") for n, goal in found.joined]
    rows += [("-", "task", f"[{n}] {goal}") for n, goal in found.left]
    rows += [
        ("~", "task", f"[{number}] {goal}: {before}, now {after}")
        for number, goal, before, after in found.changed
    ]
    head = f"cycle {first} to cycle {second}"
    return table(("", "of", "what"), rows, head, none="no difference")


STOPPING = (_break, _unbreak, _watch, _unwatch)

SEARCHING = (_find, _diff, _record)
