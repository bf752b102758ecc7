"""Commands for breakpoints and watches."""

from __future__ import annotations

from pathlib import Path

import msgspec

from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.names import plural
from rapc.base.outputs import BREAKPOINTS
from rapc.debug.answer import Answer, command, say, table
from rapc.debug.arguments import Arguments
from rapc.debug.breakpoints import KINDS, Breakpoint
from rapc.errors import ArgumentError, TextError
from rapc.repl.shell import Shell

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
def _break(shell: Shell, args: Arguments) -> Answer:
    """Set a breakpoint, or list all breakpoints.

    The run stops at the end of the cycle in which the event happened; with `before`, at
    the end of the preceding cycle. With `if`, the run stops only if the query holds.
    With `after N`, the first N events do not stop the run. With `log`, the event is
    listed and the run continues.
    """
    if not args:
        return _listed(shell)
    kind = args.word("kind of breakpoint")
    if kind == "save":
        return _save(shell, Path(args.word("file")))
    if kind == "load":
        return _load(shell, Path(args.word("file")))
    point = Breakpoint(kind)
    if args and args.peek() not in _OPTIONS:
        point.what = args.word("kind of breakpoint")
    if kind == "method" and args.takes("of"):
        point.what += f" of {args.word('a RAP')}"
    while args:
        option = args.word("option")
        if option == "if":
            point.condition = args.word("condition")
        elif option == "after":
            point.passes = args.count("number of events")
        elif option == "log":
            point.logs = True
        elif option == "before":
            point.before = True
        else:
            raise TextError(f"expected if, after, log or before, not `{option}`")
    number = shell.breakpoints.add(point)
    return say(f"breakpoint {number}: {point}", *_several(shell, point))


def _several(shell: Shell, point: Breakpoint) -> list[str]:
    """Return a note if several RAPs have the method of a breakpoint."""
    raps = shell.breakpoints.raps_with(point.what.lower())
    if point.kind != "method" or len(raps) < 2:
        return []
    listed = ", ".join(f"`{rap}`" for rap in raps)
    one = f"`:break method {point.what} of {raps[0]}` stops at one RAP only"
    return [f"`{point.what}` is a method of {listed}; {one}"]


_OPTIONS = ("if", "after", "log", "before")


def _listed(shell: Shell) -> Answer:
    rows = [
        (number, str(point), point.met)
        for number, point in shell.breakpoints.all.items()
    ]
    columns = ("number", "stops at", "hits")
    logged = shell.breakpoints.logged[-20:]
    return table(columns, rows, none="no breakpoints", notes=logged)


def _save(shell: Shell, path: Path) -> Answer:
    shell.refuse_output(path, BREAKPOINTS)
    points = [
        msgspec.structs.replace(point, met=0)
        for point in shell.breakpoints.all.values()
    ]
    try:
        path.write_bytes(msgspec.json.format(msgspec.json.encode(points)) + b"\n")
    except OSError as error:
        raise ArgumentError(f"cannot write `{path}`: {error.strerror}") from error
    return say(f"{plural(len(points), 'breakpoint')} written to {path}")


def _load(shell: Shell, path: Path) -> Answer:
    try:
        points = msgspec.json.decode(path.read_bytes(), type=list[Breakpoint])
    except OSError as error:
        raise ArgumentError(f"cannot read `{path}`: {error.strerror}") from error
    except UNREADABLE as error:
        raise ArgumentError(
            f"`{path}` is not a list of breakpoints: {flaw(error)}"
        ) from error
    for point in points:
        shell.breakpoints.add(point)
    return _listed(shell)


@command("NUMBER | all", ":unbreak 2", ":unbreak all")
def _unbreak(shell: Shell, args: Arguments) -> Answer:
    """Remove a breakpoint, or all breakpoints."""
    if args.takes("all"):
        for number in list(shell.breakpoints.all):
            shell.breakpoints.remove(number)
    else:
        shell.breakpoints.remove(args.count("breakpoint"))
    return _listed(shell)


@command("[QUERY]", ":watch (truck-location ?where)")
def _watch(shell: Shell, args: Arguments) -> Answer:
    """Show the solutions of a query after each stop; mark changes."""
    if args:
        shell.watch(args.word("query"))
    lines = shell.watched()
    return say(*(lines or ["no watches"]))


@command("NUMBER | all", ":unwatch 1")
def _unwatch(shell: Shell, args: Arguments) -> Answer:
    """Remove a watch, or all watches."""
    if args.takes("all"):
        shell.watches.clear()
    else:
        number = args.count("watch")
        if not 0 < number <= len(shell.watches):
            raise ArgumentError(f"unknown watch {number}")
        del shell.watches[number - 1]
    return say(*(shell.watched() or ["no watches"]))
