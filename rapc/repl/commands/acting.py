"""Commands that change the run."""

from __future__ import annotations

from msgspec.structs import replace

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
from rapc.debug.answer import Answer, command, failure, say, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.reload import reread
from rapc.errors import TextError
from rapc.host import plan
from rapc.ir.printer import format_node
from rapc.repl.shell import Actor, Shell
from rapc.runtime.achieve import achieving
from rapc.runtime.task_request import read_task_request


def _do(actor: Actor, args: Arguments, act: Act) -> Answer:
    args.end()
    return actor.act(act)


@command("FACT", ":assert (truck-status ready)")
def _assert(actor: Actor, args: Arguments) -> Answer:
    """Assert a fact.

    A replay repeats all acts of the user. An act in the past begins a new branch.
    """
    return _do(actor, args, AssertFact(args.fact("fact")))


@command("PREFIX", ":erase (color item-1)")
def _erase(actor: Actor, args: Arguments) -> Answer:
    """Erase all facts that begin with PREFIX."""
    return _do(actor, args, EraseFacts(args.fact("fact")))


@command("GOAL [OPTIONS]", ":submit (rock-order red 1) :priority 2 :deadline 400")
def _submit(actor: Actor, args: Arguments) -> Answer:
    """Submit a task; a goal without a command does the same."""
    args.word("goal")
    args.rest()
    return actor.submit(args.text)


@command(
    "GOAL [do [OPTIONS]]",
    ":plan (truck-location depot)",
    ":plan (truck-location depot) do :priority 2",
)
def _plan(shell: Shell, args: Arguments) -> Answer:
    """Show a plan for GOAL, a formula, that begins with the present memory.

    The plan uses RAPs with `effects`. `do` also adds a RAP with this goal and the
    clause `(plan)` to the library, and submits its task.
    """
    goal, run = args.word("goal"), shell.history.run
    limits, library = run.settings, shell.history.library
    found = plan(
        library, goal, run=run, limit=limits.plan_limit, tries=limits.plan_tries
    )
    submits = args.takes("do")
    options = args.rest() if submits else []
    if not found:
        return failure(found.summary) if submits else say(found.summary)
    rows = [(step.tag, step.goal, step.purpose) for step in found.steps]
    columns = "step", "goal", "purpose"
    assumed = [
        f"the planner takes this part of the goal to hold: {part}"
        for part in found.unseen
    ]
    notes = [*assumed, found.summary]
    answer = table(columns, rows, none="no step is needed", notes=notes)
    if not submits:
        return answer
    rap = achieving(library.program, goal)
    task = " ".join([f"({rap.name})", *options])
    read_task_request(task)  # invalid options are refused before the library changes
    added = shell.define(format_node(rap))
    submitted = shell.submit(task)
    lines = (*answer.notes, *added.lines, *submitted.lines)
    return replace(answer, notes=lines)


@command("GOAL", ":cancel (rock-order red ?)")
def _cancel(actor: Actor, args: Arguments) -> Answer:
    """Cancel the top-level tasks that match GOAL."""
    return _do(actor, args, CancelTasks(read_pattern(args.word("goal"))))


@command("SIGNAL", ":signal (:door-open hall)")
def _signal(actor: Actor, args: Arguments) -> Answer:
    """Send a signal to the tasks that wait for it."""
    return _do(actor, args, SendSignal(args.signal()))


@command(
    "REQUEST RESULT [TIMES]",
    ":force (arm-grasp ? ?) arm-dropped",
    ":force (truck-move) okay 3",
)
def _force(actor: Actor, args: Arguments) -> Answer:
    """Force the result of the next request that matches REQUEST.

    The request is not sent to the world, which does not change; it takes its usual
    time. Items in REQUEST have their names in the sensors.
    """
    request = read_pattern(args.word("request"))
    result = args.word("result").lower()
    times = max(args.count("number of requests", 1), 1)
    return _do(actor, args, ForceResult(request, result, times))


@command("[TASK]", ":fail 12")
def _fail(actor: Actor, args: Arguments) -> Answer:
    """Make a task fail, as if one of its conditions were false."""
    return _do(actor, args, FailTask(actor.task(args)))


@command("[TASK]", ":retry 12")
def _retry(actor: Actor, args: Arguments) -> Answer:
    """Make the method of a task fail, so that the task chooses again."""
    return _do(actor, args, RetryTask(actor.task(args)))


@command(
    "[OPTION VALUE]",
    ":option",
    ":option rapc.futile-limit 3",
    ":option truck.arm1-drops 0",
)
def _option(shell: Shell, args: Arguments) -> Answer:
    """Change an option of the world or a setting, or list them.

    The list contains the options and settings that can be changed during a run.
    """
    run = shell.history.run
    if not args:
        known = changeable_options(run).items()
        rows = [(name, typed(value)) for name, value in known]
        return table(("option", "value"), rows)
    given, _, value = args.word("option").partition("=")
    owner, dot, name = given.partition(".")
    if not (owner and dot and name):
        raise TextError(f"expected `{run.port.name}.NAME` or `rapc.NAME`")
    if not value:
        value = args.word(f"value of `{given}`").removeprefix("=")
        value = value or args.word(f"value of `{given}`")
    return _do(shell, args, change_option(run, owner, name, value))


@command()
def _reload(shell: Shell, args: Arguments) -> Answer:
    """Reload the files of the library and continue with the new text.

    Findings are shown; a library with errors is refused. A method under way keeps its
    old text; the next choice uses the new text.
    """
    if not shell.paths:
        raise TextError("cannot reload: the library was not loaded from files")
    name = shell.history.run.library.name
    typed = "\n\n".join(shell.typed.values())
    return shell.renew(reread(shell.paths, typed, name))
