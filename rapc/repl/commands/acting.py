"""Commands that do something to the run."""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.values import Fact, typed
from rapc.debug.acts import (
    Act,
    AssertFact,
    CancelTasks,
    EraseFacts,
    FailTask,
    RetryTask,
    SendSignal,
)
from rapc.debug.forced import ForceResult
from rapc.debug.log import ToldEvent
from rapc.debug.options import change_option, changeable_options
from rapc.debug.texts import reread
from rapc.debug.what_if import what_if
from rapc.errors import TextError
from rapc.repl.answer import ShownAnswer, say, table
from rapc.repl.arguments import Arguments, read_pattern, split
from rapc.repl.shell import Shell, command


def _do(shell: Shell, act: Act) -> ShownAnswer:
    before, branch = shell.history.serial, shell.history.branch
    shell.history.act(act)
    return say(*shell.happened(before), *shell.branched(branch), f"done: {act}")


@command("FACT", ":assert (truck-status ready)")
def _assert(shell: Shell, args: Arguments) -> ShownAnswer:
    """Assert a fact.

    All that is done to the run is done again when it is replayed. Done in the past,
    it begins a new branch.
    """
    return _do(shell, AssertFact(args.fact("a fact")))


@command("PREFIX", ":erase (color item-1)")
def _erase(shell: Shell, args: Arguments) -> ShownAnswer:
    """Erase every fact that starts so."""
    return _do(shell, EraseFacts(args.fact("a fact")))


@command("GOAL [OPTIONS]", ":submit (rock-order red 1) :priority 2 :deadline 400")
def _submit(shell: Shell, args: Arguments) -> ShownAnswer:
    """Give the robot a task; a goal typed by itself does the same."""
    args.word("a goal")
    args.rest()
    return shell.submit(args.text)


@command("GOAL", ":cancel (rock-order red ?)")
def _cancel(shell: Shell, args: Arguments) -> ShownAnswer:
    """Take away the top-level tasks that a goal matches."""
    return _do(shell, CancelTasks(read_pattern(args.word("a goal"))))


@command("SIGNAL", ":signal (:door-open hall)")
def _signal(shell: Shell, args: Arguments) -> ShownAnswer:
    """Send a signal to the tasks that wait for it."""
    return _do(shell, SendSignal(args.signal()))


@command(
    "(assert FACT) | (erase PREFIX) ... [CYCLES]",
    ":what-if (assert (truck-fuel 2))",
    ":what-if (erase (color item-1)) 5",
)
def _what_if(shell: Shell, args: Arguments) -> ShownAnswer:
    """Say what the next cycles would bring if memory were another.

    It is tried aside and undone.
    """
    acts: list[Act] = []
    cycles = 1
    for said in args.rest():
        if said.isdecimal():
            cycles = int(said)
        else:
            acts.append(_act(said))
    if not acts:
        raise TextError("say what if: (assert FACT...) or (erase PREFIX...)")
    found = what_if(shell.history, acts, cycles)
    if not found.differs:
        return say("the same would be done:", *_told(shell, found.as_it_is))
    return say(
        "as it is:",
        *_told(shell, found.as_it_is),
        "it would be:",
        *_told(shell, found.would_be),
    )


def _act(text: str) -> Act:
    """Return what `(assert FACT)` or `(erase PREFIX)` does."""
    words = split(text[1:].rstrip().removesuffix(")"))
    makes: dict[str, Callable[[Fact], Act]] = {
        "assert": AssertFact,
        "erase": EraseFacts,
    }
    if len(words) != 2 or words[0] not in makes:
        raise TextError(f"(assert FACT) or (erase PREFIX) is wanted, not {text}")
    return makes[words[0]](read_pattern(words[1]))


def _told(shell: Shell, told: tuple[ToldEvent, ...]) -> list[str]:
    shell.forget_trace()
    lines = shell.trace(told)
    shell.forget_trace()
    return lines or ["  nothing"]


@command(
    "REQUEST RESULT [TIMES]",
    ":force (arm-grasp ? ?) arm-dropped",
    ":force (truck-move) okay 3",
)
def _force(shell: Shell, args: Arguments) -> ShownAnswer:
    """Let the next request that is like this end with a result.

    The request does not reach the world: nothing is done there, and it takes as
    long as such a request usually does. Items are those of the sensors.
    """
    request = read_pattern(args.word("a request"))
    result = args.word("a result").lower()
    return _do(shell, ForceResult(request, result, max(args.count("times", 1), 1)))


@command("[TASK]", ":fail 12")
def _fail(shell: Shell, args: Arguments) -> ShownAnswer:
    """Let a task fail, as if a condition of it did not hold."""
    return _do(shell, FailTask(shell.task(args)))


@command("[TASK]", ":retry 12")
def _retry(shell: Shell, args: Arguments) -> ShownAnswer:
    """Let the method of a task end badly, so that the task chooses again."""
    return _do(shell, RetryTask(shell.task(args)))


@command("", ":reload")
def _reload(shell: Shell, args: Arguments) -> ShownAnswer:
    """Read the files of the library again, and go on with what they say now.

    What is found in them is shown, and a faulty file is refused. A method under way
    keeps the text that it began with; the next choice sees the new one.
    """
    if not shell.paths:
        raise TextError("it is not known which files the library was read from")
    name = shell.history.run.machine.library.name
    typed = "\n\n".join(shell.typed.values())
    return shell.renew(reread(shell.paths, typed, name))


@command(
    "[OPTION VALUE]",
    ":option",
    ":option rapc.futile-limit 3",
    ":option truck.arm1-drops 0",
)
def _option(shell: Shell, args: Arguments) -> ShownAnswer:
    """Change a setting of the interpreter or an option of the world, or list them.

    Listed are those that can be changed while a run goes on, with their values.
    """
    run = shell.history.run
    if not args:
        rows = [
            (f"{one.owner}.{one.name}", typed(one.value))
            for one in changeable_options(run)
        ]
        return table(("option", "value"), rows)
    given, _, value = args.word("an option").partition("=")
    owner, dot, name = given.partition(".")
    if not (owner and dot and name):
        raise TextError(f"an option is `{run.machine.world.name}.NAME` or `rapc.NAME`")
    if not value:
        value = args.word(f"a value of `{given}`").removeprefix("=")
        value = value or args.word(f"a value of `{given}`")
    return _do(shell, change_option(run, owner, name, value))


ACTING = (
    _assert,
    _erase,
    _submit,
    _cancel,
    _signal,
    _force,
    _fail,
    _retry,
    _option,
    _reload,
    _what_if,
)
