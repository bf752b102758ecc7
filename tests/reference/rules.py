"""Rules over memory: what ends of tasks and signals mean (section 9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rapc import events
from rapc.base.resources import Value
from rapc.base.values import Fact, format_atom, format_list
from rapc.ir import nodes
from rapc.ir.walk import variables
from tests.reference.run import Run
from tests.reference.tasks import Task
from tests.reference.terms import Fault

Env = dict[str, Any]


def at_end(run: Run, task: Task, result: str, outputs: Mapping[str, Value]) -> None:
    """A task has ended: the `:finish` rules whose index it matches run."""
    for rule in run.library.memory_rules:
        env = index(run, task, rule, "finish", outputs)
        cases = rule.cases if env is not None else ()
        for case in cases:
            assert env is not None
            wanted = case.result
            if isinstance(wanted, nodes.Signal):
                continue
            found = unified(run, task, (wanted,), (result,), env)
            if found is not None:
                act(run, task, case.rules, found, result)
                break


def at_event(run: Run, task: Task, content: Fact) -> None:
    """A signal has come: the `:event` rules of a task run."""
    for rule in run.library.memory_rules:
        env = index(run, task, rule, "event", {})
        cases = rule.cases if env is not None else ()
        for case in cases:
            assert env is not None
            wanted, found = case.result, None
            if isinstance(wanted, nodes.Signal) and wanted.name == content[0]:
                found = unified(run, task, wanted.args, content[1:], env)
            elif isinstance(wanted, nodes.Var):
                name = str(content[0]).removeprefix(":")
                found = unified(run, task, (wanted,), (name,), env)
            if found is not None:
                act(run, task, case.rules, found, format_list(content))
                break


def of_none(run: Run, content: Fact) -> None:
    """A signal has come: the rules that belong to no RAP run."""
    for rule in run.library.event_rules:
        if rule.signal == content[0]:
            found = unified(run, None, rule.args, content[1:], {})
            if found is not None:
                act(run, None, rule.rules, found, format_list(content))


def index(
    run: Run,
    task: Task,
    rule: nodes.MemoryRule,
    when: str,
    outputs: Mapping[str, Value],
) -> Env | None:
    """What the index of a rule binds for a task; None if it is not one of its rules."""
    if rule.index.name != task.rap.name or rule.when != when:
        return None
    env = unified(run, task, rule.index.args, task.args, {})
    if env is None:
        return None
    found = [outputs.get(variable.name) for variable in task.rap.outputs]
    return unified(run, task, rule.index.outputs, found[: len(rule.index.outputs)], env)


def unified(
    run: Run,
    task: Task | None,
    terms: Sequence[nodes.Term],
    values: Sequence[Value | None],
    known: Env,
) -> Env | None:
    """Bindings that make terms equal to values; what has no value binds nothing."""
    env = dict(known)
    if len(terms) != len(values):
        return None
    for term, value in zip(terms, values, strict=True):
        if isinstance(term, nodes.Var):
            if term.anonymous or value is None:
                continue
            if env.setdefault(term.name, value) != value:
                return None
            continue
        try:
            wanted: Value | None = run.asker(task).term(term, env)
        except Fault:
            wanted = None
        if wanted is None or wanted != value:
            return None
    return env


def act(
    run: Run, task: Task | None, rules: Sequence[nodes.Rule], env: Env, what: str
) -> None:
    """In each rule the first query with a solution acts."""
    for rule in rules:
        for alternative in rule.alternatives:
            found: Any = run.holds(task, alternative.query, env, "rule", alternative)
            if found is None:
                continue
            number = None if task is None else task.number
            source = run.library.files[alternative.span.file]
            row = source.position(alternative.span.start).row
            at = f"{alternative.span.file}:{row}"
            bound = {**env, **found}
            places = sorted(
                (one.span.start, one.name) for one in variables(alternative.query)
            )
            names = [*env, *(name for _, name in places if name in bound)]
            told = {name: format_atom(bound[name]) for name in dict.fromkeys(names)}
            run.tell(events.RuleRun, task=number, what=what, at=at, bindings=told)
            for action in alternative.actions:
                change(run, task, action, bound)
            break


def change(run: Run, task: Task | None, action: nodes.RuleAction, env: Env) -> None:
    """One action: a fact is asserted, or all that begin so are erased."""
    fact = run.ground(task, action.pattern, env, action.op)
    if fact is None:
        return
    if action.op == "mem-add":
        run.memory.assert_fact(fact, "rule")
    else:
        run.memory.erase(fact, "rule")
