"""Commands that ask why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rapc.base.names import plural
from rapc.base.resources import Value
from rapc.base.values import format_atom, format_list, readable
from rapc.debug import clause, commitments, failures, why_not
from rapc.debug.why import Choice, Origin, Why, why
from rapc.debug.why_not import MethodAnswer, TaskAnswer
from rapc.repl.answer import ShownAnswer, say
from rapc.repl.arguments import Arguments
from rapc.repl.shell import Shell, command
from rapc.runtime.events.report import cause_lines


@command(
    "[TASK] [in CYCLE] | failed [TASK]",
    ":why",
    ":why 12",
    ":why 12 in 30",
    ":why failed",
    ":why failed 92",
)
def _why(shell: Shell, args: Arguments) -> ShownAnswer:
    """Say why a task came up and what it did then, or why it failed.

    Each rule of choice is told with the tasks that it left, then the method with
    the facts that its context rested on: when each was asserted, and by what.
    """
    if args.takes("failed"):
        return _why_failed(shell, args)
    number = shell.task(args)
    cycle = args.count("a cycle") if args.takes("in") else None
    found = why(shell.history, number, cycle)
    return say(*_choice(found.choice), *_doing(found))


def _choice(choice: Choice) -> Iterator[str]:
    at = f"in cycle {choice.cycle}, at time {readable(choice.time)}"
    yield f"[{choice.task}] came up {at}:"
    if len(choice.candidates) == 1:
        yield "  it was the only task that could go on"
        return
    yield f"  {len(choice.candidates)} could go on: {_numbers(choice.candidates)}"
    for rule in choice.rules:
        yield f"  {rule.rule}: {_numbers(rule.left)}"


def _numbers(tasks: tuple[int, ...]) -> str:
    return " ".join(f"[{number}]" for number in tasks)


def _doing(found: Why) -> Iterator[str]:
    doing = found.doing
    if doing.outcome == "method":
        yield f"It chose method {doing.said}{_with(doing.bindings)}:"
        yield from _methods(doing.methods, doing.said)
    elif doing.outcome == "succeeded":
        yield f"It succeeded{_with(doing.bindings)}:"
    elif doing.outcome == "failed":
        yield f"It failed ({doing.said}):"
        yield from (f"  {line}" for line in cause_lines(doing.because))
    elif doing.outcome == "blocked":
        yield f"It was blocked until {doing.said}"
    for origin in doing.rests_on:
        yield f"  {_origin(origin)}"


def _origin(origin: Origin) -> str:
    told = f"because of {format_list(origin.fact)}"
    if origin.time is not None:
        told += f", asserted at {readable(origin.time)}"
    if origin.cycle is not None:
        told += f" in cycle {origin.cycle}"
    return f"{told} by {origin.by}" if origin.by else told


def _with(bindings: Mapping[str, Value]) -> str:
    pairs = " ".join(f"{name} {format_atom(v)}" for name, v in bindings.items())
    return f" with {pairs}" if pairs else ""


def _methods(methods: tuple[MethodAnswer, ...], chosen: str) -> Iterator[str]:
    if len(methods) == 1 and not methods[0].solved:
        yield "  its only method"
        return
    for method in methods:
        mark = "*" if method.name == chosen else " "
        yield f" {mark} {method.name}: {_method(method)}"


def _method(method: MethodAnswer) -> str:
    if method.otherwise:
        told = "is for when no method before it holds"
    elif method.solved:
        told = "has come from the problem solver"
    elif method.context is None:
        told = "has no context"
    else:
        told = clause.in_a_line(method.context)
    if method.failures:
        told += f"; has failed {plural(method.failures, 'time')}"
    if method.tries:
        told += f"; was chosen {plural(method.tries, 'time')}"
    return f"{told}; waits for {method.held_by}" if method.held_by else told


def _why_failed(shell: Shell, args: Arguments) -> ShownAnswer:
    number = shell.task(args) if args else None
    found = failures.why_failed(shell.history, number)
    at = f"in cycle {found.cycle}, at time {readable(found.time)}"
    said = {
        "failed": "failed",
        "method ended": "had a method that ended badly",
        "removed": "was removed",
    }[found.what]
    lines = [f"[{found.task}] {found.goal} {said} {at}: {found.result}"]
    lines += [f"  {line}" for line in cause_lines(found.because)]
    return say(*lines)


@command(
    "[TASK] [METHOD | CLAUSE] | QUERY",
    ":why-not 12",
    ":why-not fill-order",
    ":why-not 132 take",
    ":why-not 132 succeed",
    ":why-not (and (p ?x) (q ?x))",
)
def _why_not(shell: Shell, args: Arguments) -> ShownAnswer:
    """Say what keeps a task from going on, a method from being chosen, a query from holding.

    Behind each conjunct stands how many solutions all up to it have. A task that
    has ended is asked about as it stood before its last cycle.
    """  # noqa: E501  # the help has it in one sentence
    if args.peek().startswith("("):
        return say(
            *clause.clause_in_lines(why_not.why_not_query(shell.history, args.word("")))
        )
    answer = why_not.why_not(shell.history, shell.task(args))
    if args:
        return say(*_one_method(answer, args.word("a method")))
    return say(*_task(answer))


def _one_method(answer: TaskAnswer, name: str) -> Iterator[str]:
    yield f"[{answer.task}] {answer.goal}, after cycle {answer.cycle}"
    asked = [one for one in answer.clauses if one.clause.split()[0] == name]
    if asked:
        for one in asked:
            yield from clause.clause_in_lines(one)
        return
    if name in why_not.CLAUSES:
        yield f"  `{answer.goal.name}` has no clause `{name}`"
        return
    method = why_not.named_method(answer, name)
    if method.context is None:
        yield f"method {name}: {_method(method)}"
        return
    yield from clause.clause_in_lines(method.context)
    rest = _method(method).partition("; ")[2]
    if rest:
        yield f"  {rest}"
    if method.otherwise:
        yield "  it is for when no method before it holds"


def _task(answer: TaskAnswer) -> Iterator[str]:
    stood = "stood" if answer.past else "stands"
    state = (
        answer.state
        if not answer.waits_for
        else (f"{answer.state}, waiting for {answer.waits_for}")
    )
    yield f"[{answer.task}] {answer.goal} {stood} after cycle {answer.cycle}: {state}"
    if answer.before_it:
        yield f"  of higher priority: {_numbers(answer.before_it)}"
    if answer.under_way is not None:
        yield f"  method {answer.under_way} is under way"
    for asked in answer.clauses:
        yield f"  {asked.clause}: {clause.in_a_line(asked)}"
    for method in answer.methods:
        yield f"  method {method.name}: {_method(method)}"


@command("chosen [TASK]", ":when chosen 106", ":when chosen")
def _when(shell: Shell, args: Arguments) -> ShownAnswer:
    """Say what the choice of a method rested on, and what of that is no longer so.

    Without a task: all methods under way that rest on what is no longer so.
    """
    args.takes("chosen")
    if args:
        found = [commitments.commitment(shell.history, shell.task(args))]
    else:
        found = commitments.stale(shell.history)
        if not found:
            return say("no method under way rests on what is no longer so")
    return say(*(line for one in found for line in _commitment(one)))


def _commitment(one: commitments.Commitment) -> Iterator[str]:
    at = f"in cycle {one.cycle}, at time {readable(one.time)}"
    yield f"[{one.task}] {one.goal} chose {one.method}{_with(one.bindings)} {at}"
    for fact in one.rested_on:
        mark = "no longer so" if fact in one.gone else "still so"
        yield f"  because of {format_list(fact)}: {mark}"
    if one.now is not None and not one.now.holds:
        yield f"  now: {clause.in_a_line(one.now)}"
    told = ", or ".join(f"{name}{_with(bound)}" for name, bound in one.would)
    yield f"  it would choose now: {told or 'nothing'}"


ASKING = (_why, _why_not, _when)
