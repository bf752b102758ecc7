"""Commands that do something to the run."""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.values import Fact
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
from rapc.debug.options import change_option, options
from rapc.debug.options import said as said_of
from rapc.debug.texts import reread
from rapc.debug.what_if import what_if
from rapc.errors import TextError
from rapc.repl.answer import ShownAnswer, say, table
from rapc.repl.arguments import Arguments, split
from rapc.repl.patterns import pattern
from rapc.repl.shell import Command, Shell


def _do(shell: Shell, act: Act) -> ShownAnswer:
    before, branch = shell.session.serial, shell.session.branch
    shell.session.act(act)
    return say(*shell.happened(before), *shell.branched(branch), f"done: {act}")


def _with_fact(
    make: Callable[[Fact], Act],
) -> Callable[[Shell, Arguments], ShownAnswer]:
    def does(shell: Shell, args: Arguments) -> ShownAnswer:
        return _do(shell, make(args.fact("a fact")))

    return does


def _with_task(make: Callable[[int], Act]) -> Callable[[Shell, Arguments], ShownAnswer]:
    def does(shell: Shell, args: Arguments) -> ShownAnswer:
        return _do(shell, make(shell.task(args)))

    return does


def _submit(shell: Shell, args: Arguments) -> ShownAnswer:
    args.word("a goal")
    args.rest()
    return shell.submit(args.text)


def _cancel(shell: Shell, args: Arguments) -> ShownAnswer:
    return _do(shell, CancelTasks(pattern(args.word("a goal"))))


def _signal(shell: Shell, args: Arguments) -> ShownAnswer:
    return _do(shell, SendSignal(args.signal()))


def _what_if(shell: Shell, args: Arguments) -> ShownAnswer:
    acts: list[Act] = []
    cycles = 1
    for said in args.rest():
        if said.isdecimal():
            cycles = int(said)
        else:
            acts.append(_act(said))
    if not acts:
        raise TextError("say what if: (assert FACT...) or (erase PREFIX...)")
    found = what_if(shell.session, acts, cycles)
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
    return makes[words[0]](pattern(words[1]))


def _told(shell: Shell, told: tuple[ToldEvent, ...]) -> list[str]:
    shell.forget_trace()
    lines = shell.trace(told)
    shell.forget_trace()
    return lines or ["  nothing"]


def _force(shell: Shell, args: Arguments) -> ShownAnswer:
    request = pattern(args.word("a request"))
    result = args.word("a result").lower()
    return _do(shell, ForceResult(request, result, max(args.count("times", 1), 1)))


def _reload(shell: Shell, args: Arguments) -> ShownAnswer:
    """Read the library again; what was typed stays in place of what the files say."""
    if not shell.paths:
        raise TextError("it is not known which files the library was read from")
    name = shell.session.run.machine.library.name
    typed = "\n\n".join(shell.typed.values())
    return shell.renew(reread(shell.paths, typed, name))


def _option(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the options that can be changed, or change one."""
    run = shell.session.run
    if not args:
        rows = [(f"{one.owner}.{one.name}", said_of(one.value)) for one in options(run)]
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
    Command(
        "assert",
        "FACT",
        "Assert a fact.",
        _with_fact(AssertFact),
        (":assert (truck-status ready)",),
        "All that is done to the run is done again when it is replayed. Done in the "
        "past, it begins a new branch.",
    ),
    Command(
        "erase",
        "PREFIX",
        "Erase every fact that starts so.",
        _with_fact(EraseFacts),
        (":erase (color item-1)",),
    ),
    Command(
        "submit",
        "GOAL [OPTIONS]",
        "Give the robot a task; a goal typed by itself does the same.",
        _submit,
        (":submit (rock-order red 1) :priority 2 :deadline 400",),
    ),
    Command(
        "cancel",
        "GOAL",
        "Take away the top-level tasks that a goal matches.",
        _cancel,
        (":cancel (rock-order red ?)",),
    ),
    Command(
        "signal",
        "SIGNAL",
        "Send a signal to the tasks that wait for it.",
        _signal,
        (":signal (:door-open hall)",),
    ),
    Command(
        "force",
        "REQUEST RESULT [TIMES]",
        "Let the next request that is like this end with a result.",
        _force,
        (":force (arm-grasp ? ?) arm-dropped", ":force (truck-move) okay 3"),
        "The request does not reach the world: nothing is done there, and it takes as "
        "long as such a request usually does. Items are those of the sensors.",
    ),
    Command(
        "fail",
        "[TASK]",
        "Let a task fail, as if a condition of it did not hold.",
        _with_task(FailTask),
        (":fail 12",),
    ),
    Command(
        "retry",
        "[TASK]",
        "Let the method of a task end badly, so that the task chooses again.",
        _with_task(RetryTask),
        (":retry 12",),
    ),
    Command(
        "option",
        "[OPTION VALUE]",
        "Change a setting of the interpreter or an option of the world, or list them.",
        _option,
        (":option", ":option rapc.futile-limit 3", ":option truck.arm1-drops 0"),
        "Listed are those that can be changed while a run goes on, with their values.",
    ),
    Command(
        "reload",
        "",
        "Read the files of the library again, and go on with what they say now.",
        _reload,
        (":reload",),
        "What is found in them is shown, and a faulty file is refused. A method under "
        "way keeps the text that it began with; the next choice sees the new one.",
    ),
    Command(
        "what-if",
        "(assert FACT) | (erase PREFIX) ... [CYCLES]",
        "Say what the next cycles would bring if memory were another.",
        _what_if,
        (":what-if (assert (truck-fuel 2))", ":what-if (erase (color item-1)) 5"),
        "It is tried aside and undone.",
    ),
)
