"""Rules over memory: run at ends of tasks and at signals [S 4.2, 4.3; L 9].

Of the cases of a rule the interpreter takes only the first that matches. In each of its
rules the first query with a solution acts. An impossible action is a query fault and
has no effect.
"""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.resources import Value
from rapc.base.values import Atom, Fact
from rapc.compiler.query.term_value import TermValue
from rapc.compiler.rules import (
    ActionPlan,
    AlternativePlan,
    CasePlan,
    MemoryRulePlan,
    RulesPlan,
)
from rapc.errors import FactError
from rapc.events import RuleRun
from rapc.ir import nodes
from rapc.runtime.run import Run
from rapc.runtime.state.task import Env, Task
from rapc.runtime.tasks.primitives import fill_in
from rapc.world import OKAY

SUCCEED = "succeed"
"""The name of the result `okay` in rules."""


def run_finish_rules(machine: Run, task: Task, result: str, outputs: Env) -> None:
    """Run the `:finish` rules of a task that has ended with `result`."""
    symbol = SUCCEED if result == OKAY else result
    for rule in task.plan.finish_rules:
        env = _index(machine, task, rule, outputs)
        if env is None:
            continue
        for case in rule.cases:
            found = _any(machine, case, symbol, env)
            if found is not None:
                _run(machine, task, case.rules, found, symbol)
                break


def run_rules_of(machine: Run, task: Task, content: Fact) -> None:
    """Run the `:event` rules of a task for a signal."""
    for rule in task.plan.event_rules:
        env = _index(machine, task, rule, {})
        if env is None:
            continue
        for case in rule.cases:
            found = _heard(machine, case, content, env)
            if found is not None:
                _run(machine, task, case.rules, found, content)
                break


def run_event_rules(machine: Run, content: Fact) -> None:
    """Run the rules outside of RAPs for a signal."""
    for rule in machine.library.event_rules:
        env: Env = {}
        machine.context.task = None
        if rule.signal.name == content[0] and _match(
            machine, rule.signal.args, content[1:], env
        ):
            _run(machine, None, rule.rules, env, content)


# --- matching ---------------------------------------------------------------------


def _index(machine: Run, task: Task, rule: MemoryRulePlan, outputs: Env) -> Env | None:
    """Return the bindings of a rule's index for a task; None without a match."""
    env: Env = {}
    machine.context.task = task
    given = [outputs.get(name) for name in task.plan.outputs]
    matches = _match(machine, rule.inputs.args, task.goal_args, env) and _match(
        machine, rule.outputs.args, given[: len(rule.outputs.args)], env
    )
    return env if matches else None


def _any(machine: Run, case: CasePlan, symbol: str, env: Env) -> Env | None:
    """Return the environment of a case of results that matches `symbol`, else None."""
    if case.symbol is not None:
        return env if case.symbol == symbol else None
    if case.variable is None:
        return None
    env = env.copy()
    return env if _match(machine, (case.variable,), (symbol,), env) else None


def _heard(machine: Run, case: CasePlan, content: Fact, env: Env) -> Env | None:
    """Return the environment of a case that matches a signal, else None."""
    name = str(content[0])
    if case.variable is not None:
        return _any(machine, case, name.removeprefix(":"), env)
    env = env.copy()
    pattern = case.signal
    if pattern is None or pattern.name != name:
        return None
    return env if _match(machine, pattern.args, content[1:], env) else None


def _match(
    machine: Run,
    terms: Sequence[TermValue],
    values: Sequence[Value | None],
    env: Env,
) -> bool:
    """Match values with terms and bind variables; missing values bind none."""
    if len(terms) != len(values):
        return False
    for term, value in zip(terms, values, strict=True):
        node = term.term
        if isinstance(node, nodes.Var):
            if node.anonymous or value is None:
                continue
            if env.setdefault(node.name, value) != value:
                return False
        elif term.value(machine.context, env) != value:
            return False
    return True


# --- acting -----------------------------------------------------------------------


def _run(
    machine: Run, task: Task | None, plan: RulesPlan, env: Env, what: str | Fact
) -> None:
    for rule in plan:
        for alternative in rule:
            machine.context.task = task
            found: Env | None = {}
            if alternative.query is not None:
                found = alternative.query.first(machine.context, env)
            if found is not None:
                _act(machine, task, alternative, {**env, **found}, what)
                break


def _act(
    machine: Run,
    task: Task | None,
    alternative: AlternativePlan,
    env: Env,
    what: str | Fact,
) -> None:
    if machine.recorder.on:
        number = None if task is None else task.number
        machine.recorder.emit(RuleRun, task=number, what=what, at=alternative.row)
    for action in alternative.actions:
        machine.context.task = task
        fact = fill_in(machine, action.plan, env)
        if fact is None:
            continue
        try:
            _change(machine, action, fact)
        except FactError as error:
            machine.context.task = task
            machine.context.fault(action.plan.where, str(error))


def _change(machine: Run, action: ActionPlan, fact: tuple[Atom, ...]) -> None:
    """Do one action, and recognise the items of the fact. Raises FactError."""
    access = machine.access
    if action.adds:
        checked = machine.beliefs.checked(fact)
        access.check_owner(checked)
        machine.beliefs.store(checked, "rule")
    else:
        access.erase_for("rule", fact)
    if machine.recognizer.unsettled:
        access.recognise()
