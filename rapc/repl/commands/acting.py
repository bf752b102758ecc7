"""Commands that change the run."""

from __future__ import annotations

from rapc.base.values import typed
from rapc.debug.acts import (
    Act,
    AssertFact,
    CancelTasks,
    EraseFacts,
    FailTask,
    ForceResult,
    RetryTask,
    SendSignal,
    change_option,
    changeable_options,
)
from rapc.debug.answer import Answer, command, say, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.reload import reread
from rapc.errors import TextError
from rapc.repl.shell import Shell


def _do(shell: Shell, act: Act) -> Answer:
    before, branch = shell.history.serial, shell.history.branch
    shell.history.act(act)
    return say(*shell.happened(before), *shell.branched(branch), f"done: {act}")


@command("FACT", ":assert (truck-status ready)")
def _assert(shell: Shell, args: Arguments) -> Answer:
    """Assert a fact.

    All that is done to the run is done again when it is replayed. Done in the past,
    it begins a new branch.
    """
    return _do(shell, AssertFact(args.fact("a fact")))


@command("PREFIX", ":erase (color item-1)")
def _erase(shell: Shell, args: Arguments) -> Answer:
    """Erase every fact that starts so."""
    return _do(shell, EraseFacts(args.fact("a fact")))


@command("GOAL [OPTIONS]", ":submit (rock-order red 1) :priority 2 :deadline 400")
def _submit(shell: Shell, args: Arguments) -> Answer:
    """Give the robot a task; a goal typed by itself does the same."""
    args.word("a goal")
    args.rest()
    return shell.submit(args.text)


@command("GOAL", ":cancel (rock-order red ?)")
def _cancel(shell: Shell, args: Arguments) -> Answer:
    """Take away the top-level tasks that a goal matches."""
    return _do(shell, CancelTasks(read_pattern(args.word("a goal"))))


@command("SIGNAL", ":signal (:door-open hall)")
def _signal(shell: Shell, args: Arguments) -> Answer:
    """Send a signal to the tasks that wait for it."""
    return _do(shell, SendSignal(args.signal()))


@command(
    "REQUEST RESULT [TIMES]",
    ":force (arm-grasp ? ?) arm-dropped",
    ":force (truck-move) okay 3",
)
def _force(shell: Shell, args: Arguments) -> Answer:
    """Let the next request that is like this end with a result.

    The request does not reach the world: nothing is done there, and it takes as
    long as such a request usually does. Items are those of the sensors.
    """
    request = read_pattern(args.word("a request"))
    result = args.word("a result").lower()
    return _do(shell, ForceResult(request, result, max(args.count("times", 1), 1)))


@command("[TASK]", ":fail 12")
def _fail(shell: Shell, args: Arguments) -> Answer:
    """Let a task fail, as if a condition of it did not hold."""
    return _do(shell, FailTask(args.task(shell.history)))


@command("[TASK]", ":retry 12")
def _retry(shell: Shell, args: Arguments) -> Answer:
    """Let the method of a task end badly, so that the task chooses again."""
    return _do(shell, RetryTask(args.task(shell.history)))


@command(
    "[OPTION VALUE]",
    ":option",
    ":option rapc.futile-limit 3",
    ":option truck.arm1-drops 0",
)
def _option(shell: Shell, args: Arguments) -> Answer:
    """Change a setting of the interpreter or an option of the world, or list them.

    Listed are those that can be changed while a run goes on, with their values.
    """
    run = shell.history.run
    if not args:
        known = changeable_options(run).items()
        rows = [(name, typed(value)) for name, value in known]
        return table(("option", "value"), rows)
    given, _, value = args.word("an option").partition("=")
    owner, dot, name = given.partition(".")
    if not (owner and dot and name):
        raise TextError(f"an option is `{run.port.name}.NAME` or `rapc.NAME`")
    if not value:
        value = args.word(f"a value of `{given}`").removeprefix("=")
        value = value or args.word(f"a value of `{given}`")
    return _do(shell, change_option(run, owner, name, value))


@command()
def _reload(shell: Shell, args: Arguments) -> Answer:
    """Read the files of the library again, and go on with what they say now.

    What is found in them is shown, and a faulty file is refused. A method under way
    keeps the text that it began with; the next choice sees the new one.
    """
    if not shell.paths:
        raise TextError("it is not known which files the library was read from")
    name = shell.history.run.library.name
    typed = "\n\n".join(shell.typed.values())
    return shell.renew(reread(shell.paths, typed, name))
