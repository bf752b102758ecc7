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
from rapc.runtime.state.task import Env, Task, as_told
from rapc.runtime.tasks.primitives import fill_in
from rapc.world import OKAY

SUCCEED = "succeed"
"""The name of the result `okay` in rules."""


def run_finish_rules(run: Run, task: Task, result: str, outputs: Env) -> None:
    """Run the `:finish` rules of a task that has ended with `result`."""
    symbol = SUCCEED if result == OKAY else result
    for rule in task.plan.finish_rules:
        env = _index(run, task, rule, outputs)
        if env is None:
            continue
        for case in rule.cases:
            found = _any(run, case, symbol, env)
            if found is not None:
                _run(run, task, case.rules, found, symbol)
                break


def run_rules_of(run: Run, task: Task, content: Fact) -> None:
    """Run the `:event` rules of a task for a signal."""
    for rule in task.plan.event_rules:
        env = _index(run, task, rule, {})
        if env is None:
            continue
        for case in rule.cases:
            found = _heard(run, case, content, env)
            if found is not None:
                _run(run, task, case.rules, found, content)
                break


def run_event_rules(run: Run, content: Fact) -> None:
    """Run the rules outside of RAPs for a signal."""
    for rule in run.library.event_rules:
        env: Env = {}
        run.context.task = None
        if rule.signal.name == content[0] and _match(
            run, rule.signal.args, content[1:], env
        ):
            _run(run, None, rule.rules, env, content)


# --- matching ---------------------------------------------------------------------


def _index(run: Run, task: Task, rule: MemoryRulePlan, outputs: Env) -> Env | None:
    """Return the bindings of a rule's index for a task; None without a match."""
    env: Env = {}
    run.context.task = task
    given = [outputs.get(name) for name in task.plan.outputs]
    matches = _match(run, rule.inputs.args, task.goal_args, env) and _match(
        run, rule.outputs.args, given[: len(rule.outputs.args)], env
    )
    return env if matches else None


def _any(run: Run, case: CasePlan, symbol: str, env: Env) -> Env | None:
    """Return the environment of a case of results that matches `symbol`, else None."""
    if case.symbol is not None:
        return env if case.symbol == symbol else None
    if case.variable is None:
        return None
    env = env.copy()
    return env if _match(run, (case.variable,), (symbol,), env) else None


def _heard(run: Run, case: CasePlan, content: Fact, env: Env) -> Env | None:
    """Return the environment of a case that matches a signal, else None."""
    name = str(content[0])
    if case.variable is not None:
        return _any(run, case, name.removeprefix(":"), env)
    env = env.copy()
    pattern = case.signal
    if pattern is None or pattern.name != name:
        return None
    return env if _match(run, pattern.args, content[1:], env) else None


def _match(
    run: Run,
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
        elif term.value(run.context, env) != value:
            return False
    return True


# --- acting -----------------------------------------------------------------------


def _run(
    run: Run, task: Task | None, plan: RulesPlan, env: Env, what: str | Fact
) -> None:
    for rule in plan:
        for alternative in rule:
            run.context.task = task
            found: Env | None = {}
            if alternative.query is not None:
                found = alternative.query.first(run.context, env)
            if found is not None:
                _act(run, task, alternative, {**env, **found}, what)
                break


def _act(
    run: Run,
    task: Task | None,
    alternative: AlternativePlan,
    env: Env,
    what: str | Fact,
) -> None:
    if run.recorder.on and run.recorder.wants(RuleRun):
        run.recorder.emit(
            RuleRun,
            task=None if task is None else task.number,
            what=what,
            at=alternative.row,
            bindings=as_told(env),
        )
    for action in alternative.actions:
        run.context.task = task
        fact = fill_in(run, action.plan, env)
        if fact is None:
            continue
        try:
            _change(run, action, fact)
        except FactError as error:
            run.context.task = task
            run.context.fault(action.plan.where, str(error))


def _change(run: Run, action: ActionPlan, fact: tuple[Atom, ...]) -> None:
    """Do one action, and recognise the items of the fact. Raises FactError."""
    access = run.access
    if action.adds:
        checked = run.beliefs.checked(fact)
        access.check_owner(checked)
        run.beliefs.store(checked, "rule")
    else:
        access.erase_for("rule", fact)
    if run.recognizer.unsettled:
        access.recognise()
