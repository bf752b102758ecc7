"""Explanations of blocked tasks, rejected methods and false queries.

An explanation evaluates the same clauses as a cycle, in the same order [L 3]: inputs,
`succeed`, monitors, conditions, methods. A clause is evaluated conjunct by conjunct, to
find the first conjunct without a solution and the missing facts. For an ended task, the
explanation uses the moment before its last cycle. An explanation does not change the
run.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import msgspec

from rapc.base.names import did_you_mean, plural
from rapc.base.resources import Value
from rapc.base.values import Fact, format_list
from rapc.compiler.query.query import Query
from rapc.compiler.rap_plan import MethodPlan
from rapc.debug.answer import Answer, bound_to, numbers, question, say
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.sources import Origin, origins
from rapc.errors import ArgumentError
from rapc.events import Goal, KnownFact, TaskCreated, TaskRemoved, TaskSelected
from rapc.ir import clauses, nodes
from rapc.parser.parse import parse_formula
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.memory.access import Evidence, Pattern
from rapc.runtime.snapshot import AgendaEntry
from rapc.runtime.state.task import Env, Task

MOST = 100
"""The greatest number of solutions that are counted."""

_NEAR = 3
"""The number of similar facts that an explanation lists."""

_CLAUSES = tuple(clause.word for clause in clauses.RAP if not clause.hands_on)
"""The clauses of a RAP that a user can name in `:why-not`."""


class ClauseAsked(msgspec.Struct, frozen=True):
    """The result of evaluating a clause."""

    #: The clause as text.
    clause: str
    #: The conjuncts up to the first without a solution, each with the number of
    #: solutions of all conjuncts up to that conjunct: at most `MOST`.
    parts: tuple[tuple[str, int], ...]
    #: The number of conjuncts.
    count: int
    #: The bindings that the first solution adds; without a solution, the bindings of
    #: the variables of the failing conjunct.
    bindings: Mapping[str, Value] = {}
    #: Details about the failing conjunct; may be empty.
    note: str = ""
    #: Facts, each of which would give the failing conjunct a solution.
    missing: tuple[Fact, ...] = ()
    #: Facts that contradict a negated conjunct.
    unwanted: tuple[KnownFact, ...] = ()
    #: Facts similar to the missing facts.
    near: tuple[KnownFact, ...] = ()
    #: The file and line of the failing conjunct; empty without a source text.
    place: str = ""
    #: The facts that make a clause of a user true.
    rests_on: tuple[Origin, ...] = ()
    #: The results inside the deciding conjunct: of the formula of a named query, or
    #: of each branch of an `or`.
    opened: tuple[ClauseAsked, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the whole clause has a solution."""
        return len(self.parts) == self.count and all(found for _, found in self.parts)

    @property
    def at(self) -> str:
        """The place of the failing conjunct, after ` at `; empty without a place."""
        return f" at {self.place}" if self.place else ""

    def lines(self) -> Iterator[str]:
        """Yield lines about the conjuncts that hold and the missing facts."""
        yield f"{self.clause}{self.at}: {'holds' if self.holds else 'does not hold'}"
        for text, found in self.parts:
            told = str(found) if found < MOST else f"{MOST} or more"
            yield f"  {' ' if found else '>'} {text}: {told}"
        left = self.count - len(self.parts)
        if left:
            yield f"    {left} more, not evaluated"
        if self.bindings:
            yield f"  {bound_to(self.bindings).strip()}"
        if self.note:
            yield f"  {self.note}"
        for fact in self.missing:
            yield f"  would hold with {format_list(fact)}"
        for known in self.unwanted:
            yield f"  contradicted by {known}"
        for known in self.near:
            yield f"  similar fact: {known}"
        for origin in self.rests_on:
            yield f"  {origin}"
        for inner in self.opened:
            yield from (f"  {line}" for line in inner.lines())

    def in_a_line(self) -> str:
        """Return a line: whether the clause holds, or the failing conjunct."""
        pairs = bound_to(self.bindings)
        if self.holds:
            return f"holds{pairs}"
        told = f"{self.parts[-1][0]} fails"
        if self.count > 1:
            told += f", conjunct {len(self.parts)} of {self.count}"
        told += f",{pairs}" if pairs else ""
        told += f" ({self.note})" if self.note else ""
        told += "".join(f": contradicted by {known}" for known in self.unwanted[:1])
        for inner in self.opened:
            told += f"; {inner.clause}{inner.at}: {inner.in_a_line()}"
        return told


class MethodAnswer(msgspec.Struct, frozen=True):
    """Whether a method could be chosen, with the reasons against the choice."""

    name: str
    #: The result of the context; None for a method without a context.
    context: ClauseAsked | None
    #: Whether an `otherwise` rejects the method, because an earlier method holds.
    otherwise: bool
    #: The numbers of failures and of choices of the method.
    failures: int
    tries: int
    #: The holder of a thing that the method needs; empty without a conflict.
    held_by: str = ""
    #: Whether a problem solver or the planner has just added the method.
    solved: bool = False

    @property
    def holds(self) -> bool:
        """Whether the context of the method holds."""
        return not self.otherwise and (self.context is None or self.context.holds)


class TaskAnswer(msgspec.Struct, frozen=True):
    """The reasons why a task does not go on."""

    task: int
    goal: Goal
    #: The cycle at whose end the clauses were evaluated.
    cycle: int
    #: The state of the task, as lines.
    stands: tuple[str, ...]
    #: The clauses of the task, in the order of a cycle.
    clauses: tuple[ClauseAsked, ...]
    methods: tuple[MethodAnswer, ...]


# --- the question -------------------------------------------------------------------


@question(
    "[TASK] [METHOD | CLAUSE] | QUERY",
    ":why-not 12",
    ":why-not fill-order",
    ":why-not 132 take",
    ":why-not 132 succeed",
    ":why-not (and (p ?x) (q ?x))",
)
def why_not(history: History, args: Arguments) -> Answer:
    """Explain why a task waits, a method is not chosen, or a query is false.

    Each conjunct is listed with the number of solutions up to this conjunct. The answer
    for an ended task describes the state before its last cycle, and for a removed task
    the state before the cycle of its removal.
    """
    if args.peek().startswith("("):
        return say(*why_not_query(history, args.word("query")).lines())
    answer = task_asked(history, args.task(history, ended=True))
    if args:
        return say(*_one_method(answer, args.word("method")))
    clauses = (f"  {one.clause}{one.at}: {one.in_a_line()}" for one in answer.clauses)
    methods = (
        f"  method {one.name}{one.context.at if one.context else ''}: "
        f"{method_in_words(one)}"
        for one in answer.methods
    )
    return say(*answer.stands, *clauses, *methods)


def _one_method(answer: TaskAnswer, name: str) -> Iterator[str]:
    yield f"[{answer.task}] {answer.goal}, after cycle {answer.cycle}"
    asked = [one for one in answer.clauses if one.clause.split()[0] == name]
    for one in asked:
        yield from one.lines()
    if asked:
        return
    if name in _CLAUSES:
        yield f"  `{answer.goal.name}` has no clause `{name}`"
        return
    method = next((one for one in answer.methods if one.name == name), None)
    if method is None:
        names = [one.name for one in answer.methods]
        said = did_you_mean(name, names, f"it has {', '.join(names) or 'none'}")
        raise ArgumentError(f"[{answer.task}] has no method `{name}`; {said}")
    if method.context is None:
        yield f"method {name}: {method_in_words(method)}"
        return
    yield from method.context.lines()
    rest = method_in_words(method).partition("; ")[2]
    if rest:
        yield f"  {rest}"
    if method.otherwise:
        yield "  excluded by `otherwise`: a preceding method holds"


def method_in_words(method: MethodAnswer) -> str:
    """Return as text whether a method could be chosen, with its past results."""
    if method.otherwise:
        told = "excluded by `otherwise`: a preceding method holds"
    elif method.solved:
        told = "added during the run"
    elif method.context is None:
        told = "no context"
    else:
        told = method.context.in_a_line()
    if method.failures:
        told += f"; failed {plural(method.failures, 'time')}"
    if method.tries:
        told += f"; chosen {plural(method.tries, 'time')}"
    return f"{told}; waits for {method.held_by}" if method.held_by else told


# --- tasks and methods --------------------------------------------------------------


def task_asked(history: History, number: int) -> TaskAnswer:
    """Return the reasons why a task does not go on.

    Raises:
        ArgumentError: if the task is unknown.
        StateError: if the task has ended and the run cannot go back.
    """
    live = {task.number: task for task in history.run.tasks()}
    if number in live:
        if history.no_way_back and live[number].bound:
            return _answer(history.run, number, history.cycle)
        with history.at() as run:
            return _answer(run, number, history.cycle)
    with history.at_choice(_last_moment(history, number)) as run:
        return _answer(run, number, history.cycle)


def _last_moment(history: History, number: int) -> int:
    """Return the cycle in which a task was removed, or else its last cycle."""
    own = [
        told.cycle
        for told in history.scan(
            *(TaskCreated, TaskRemoved), want=lambda told: told.keys["task"] == number
        )
    ]
    if len(own) == 2 and own[0] < own[1]:
        return own[1]
    return last_cycle(history, number)


def last_cycle(history: History, number: int) -> int:
    """Return the last cycle in which a task was selected.

    Raises:
        ArgumentError: if the task was never selected.
    """
    if not 0 < number <= history.run.created:
        raise ArgumentError(f"unknown task [{number}]")
    found = history.last(TaskSelected, want=lambda told: told.keys["task"] == number)
    if found is None:
        raise ArgumentError(f"task [{number}] was never selected")
    return found.cycle


def _answer(run: Interpreter, number: int, cycle: int) -> TaskAnswer:
    task = run.task(number)
    entries = {entry.task: entry for entry in run.agenda()}
    own = entries[number]
    run.read_inputs(task)
    return TaskAnswer(
        task=number,
        goal=task.goal(),
        cycle=cycle,
        stands=tuple(_stands(task, own, entries.values(), cycle)),
        clauses=tuple(_clauses(run, task)),
        methods=tuple(methods(run, task)) if task.bound else (),
    )


def _stands(
    task: Task, own: AgendaEntry, all_: Iterable[AgendaEntry], cycle: int
) -> Iterator[str]:
    """Yield lines about the state of a task and the tasks with precedence."""
    at = f"after cycle {cycle}"
    waits = f", waiting for {own.waits_for}" if own.waits_for else ""
    yield f"[{own.task}] {task.goal()} {at}: {own.state}{waits}"
    could_go_on = [one for one in all_ if one.state == own.state == "eligible"]
    higher = [one.task for one in could_go_on if one.priority > own.priority]
    if higher:
        yield f"  of higher priority: {numbers(higher)}"
    if task.run is not None:
        yield f"  method {task.run.plan.name} is under way"


def _clauses(run: Interpreter, task: Task) -> Iterator[ClauseAsked]:
    """Evaluate the clauses that a cycle evaluates before the methods."""
    plan, env = task.plan, task.env
    for clause in clauses.RAP if task.bound else ():
        if clause.word in plan.clauses and not clause.is_condition:
            words = f"{clause.word} of `{plan.name}`"
            yield ask(run, words, plan.clauses[clause.word], task, env)
    for words, query, asker, bound in run.conditions(task):
        yield ask(run, words, query, asker, bound)
    method = task.within
    while method is not None:
        if method.plan.constraints is not None:
            words = f"constraints of method `{method.plan.name}`"
            yield ask(run, words, method.plan.constraints, method.task, method.env)
        method = method.task.within


def methods(run: Interpreter, task: Task) -> Iterator[MethodAnswer]:
    """Yield, for each method of a task, whether the method could be chosen now."""
    held = False
    for method in run.methods(task.plan):
        context = None
        if method.choice is not None:
            clause = f"context of method `{method.name}`"
            context = ask(run, clause, method.choice, task, task.env)
        answer = MethodAnswer(
            name=method.name,
            context=context,
            otherwise=method.otherwise and held,
            failures=task.failures_of(method),
            tries=task.times_tried(method),
            held_by=_held_by(run, task, method, context),
        )
        held = held or answer.holds
        yield answer


def _held_by(
    run: Interpreter, task: Task, method: MethodPlan, context: ClauseAsked | None
) -> str:
    """Return the thing that a method would wait for, with its holder."""
    if not method.things or (context is not None and not context.holds):
        return ""
    env = task.env if context is None else {**task.env, **context.bindings}
    found = run.obstacle(task, method, env)
    if found is None:
        return ""
    thing = " ".join(map(str, found.thing))
    return f"{thing}, held by {found.task.goal()} [{found.task.number}]"


# --- clauses ------------------------------------------------------------------------


def why_not_query(history: History, text: str) -> ClauseAsked:
    """Evaluate a formula over memory, conjunct by conjunct.

    Raises:
        TextError: if `text` is not a formula.
        ValueError: for names that the library does not declare.
    """
    history.run.question(text)  # validates the names
    formula, run = parse_formula(text), history.run
    query = run.library.compiler.query(formula, "question", formula.span)
    found = ask(run, "query", query, None, {})
    if not found.holds:
        return found
    opened = run.library.opened(formula, found.bindings)
    supports = run.supporting(formula, found.bindings)
    return msgspec.structs.replace(
        found,
        rests_on=origins(history, supports, (history.cycle + 1, 0)),
        opened=tuple(ask(run, words, one, None, env) for words, one, env in opened),
    )


def ask(
    run: Interpreter, clause: str, query: Query, asker: Task | None, env: Env
) -> ClauseAsked:
    """Evaluate a clause as a task would, conjunct by conjunct.

    Args:
        run: the run.
        clause: the clause as text.
        query: the query of the clause.
        asker: the task with the clause; None for a query of the user.
        env: the initial bindings.
    """
    asked = list(run.explain(query, asker, env, MOST))
    parts = tuple([(one.text, len(one.solutions)) for one in asked])
    count, last = len(query.beginnings()), asked[-1] if asked else None
    if last is None or last.solutions:  # `(and)` has no conjuncts and holds
        return ClauseAsked(clause, parts, count, last.solutions[0] if last else {})
    before = asked[-2].solutions if asked[1:] else [{}]
    known = [{**env, **one} for one in before]
    missing, unwanted, near = _facts_about(run, last.part, known)
    return ClauseAsked(
        clause=clause,
        parts=parts,
        count=count,
        bindings={n: v for n, v in known[0].items() if n in Query.names(last.part)},
        note=last.note,
        missing=missing,
        unwanted=unwanted,
        near=near,
        place=run.library.compiler.row(last.part.span),
        opened=tuple(
            ask(run, words, inner, asker, bound)
            for words, inner, bound in run.library.opened(last.part, known[0])
        ),
    )


def _known(run: Interpreter, found: Evidence) -> tuple[KnownFact, ...]:
    """Return facts with their ages."""
    return tuple([KnownFact.at(run.now, *one) for one in found.items()])


_Known = tuple[KnownFact, ...]


def _facts_about(
    run: Interpreter, part: nodes.Formula, known: list[dict[str, Value]]
) -> tuple[tuple[Fact, ...], _Known, _Known]:
    """Return the missing, contradicting and similar facts of a failing conjunct.

    Args:
        run: the run.
        part: the conjunct.
        known: the solutions of the preceding conjuncts.
    """
    if isinstance(part, nodes.Not):
        found: Evidence = {}
        for env in known[:_NEAR]:
            found |= run.opposing(part, env)
        return (), _known(run, found)[:_NEAR], ()
    inner = part.pattern if isinstance(part, nodes.Believe) else part
    if not isinstance(inner, nodes.Proposition):
        return (), (), ()
    patterns = [one for env in known if (one := run.pattern(inner, env)) is not None]
    if not patterns:
        return (), (), ()
    ground = dict.fromkeys(pattern for pattern in patterns if None not in pattern)
    return tuple(ground)[:_NEAR], (), _known(run, _nearest(run, patterns[0]))


def _nearest(run: Interpreter, pattern: Pattern) -> Evidence:
    """Return the facts that match most arguments of a pattern."""

    def agreement(fact: Fact) -> int:
        given = zip(pattern[1:], fact[1:], strict=False)
        return sum(1 for want, value in given if want is not None and want == value)

    facts = run.memory.facts(str(pattern[0]))
    agreeing = sorted(filter(agreement, facts), key=agreement, reverse=True)
    return {fact: facts[fact] for fact in agreeing[:_NEAR]}
