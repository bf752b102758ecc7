"""Executable rules over memory: patterns, queries and changes [S 4.2, 4.3]."""

from __future__ import annotations

from collections.abc import Iterable

from rapc.compiler.compiler import Compiler, RequestPlan
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.ir import nodes


class ActionPlan:
    """`(mem-add p)` or `(mem-del prefix)`, with arguments to compute."""

    def __init__(self, compiler: Compiler, node: nodes.RuleAction) -> None:
        self.adds = node.op == "mem-add"
        self.plan: RequestPlan = compiler.assertion(node.pattern, node.op)


class AlternativePlan:
    """A query of a rule, None where it is always true, with its actions."""

    def __init__(self, compiler: Compiler, node: nodes.Alternative) -> None:
        self.query: Query | None = None
        if not (isinstance(node.query, nodes.Truth) and node.query.value):
            self.query = compiler.query(node.query, "rule", node.span)
        self.actions = tuple([ActionPlan(compiler, one) for one in node.actions])
        #: The file and row of the alternative: `doors.rap:12`.
        self.row = compiler.row(node.span)


RulesPlan = tuple[tuple[AlternativePlan, ...], ...]
"""The rules of one pattern: each rule is a tuple of its alternatives."""


def _rules(compiler: Compiler, rules: Iterable[nodes.Rule]) -> RulesPlan:
    return tuple(
        [
            tuple([AlternativePlan(compiler, one) for one in rule.alternatives])
            for rule in rules
        ]
    )


class Matched:
    """A pattern for a list of values: a name, and a term for each value."""

    def __init__(
        self, compiler: Compiler, name: str, args: Iterable[nodes.Term], what: str
    ) -> None:
        self.name = name
        self.args = tuple([TermValue(arg, what) for arg in args])


class CasePlan:
    """One case of a `match-result`: its pattern and its rules."""

    def __init__(self, compiler: Compiler, node: nodes.ResultCase) -> None:
        result = node.result
        #: The pattern: a result, any result (bound to a variable), or a signal.
        self.symbol = str(result.value) if isinstance(result, nodes.Const) else None
        self.variable: TermValue | None = None
        if isinstance(result, nodes.Var):
            self.variable = TermValue(result, "rule")
        self.signal: Matched | None = None
        if isinstance(result, nodes.Signal):
            self.signal = matched_signal(compiler, result.name, result)
        self.rules = _rules(compiler, node.rules)


class MemoryRulePlan:
    """A rule of a RAP: its index, and a case for each result or event."""

    def __init__(self, compiler: Compiler, node: nodes.MemoryRule) -> None:
        where = compiler.place("memory rule", node.span)
        index = node.index
        self.inputs = Matched(compiler, index.name, index.args, where)
        self.outputs = Matched(compiler, index.name, index.outputs, where)
        self.cases = tuple([CasePlan(compiler, case) for case in node.cases])


class EventRulePlan:
    """A rule that belongs to no RAP, run whenever its signal comes."""

    def __init__(self, compiler: Compiler, node: nodes.EventRule) -> None:
        self.signal = matched_signal(compiler, node.signal, node)
        self.rules = _rules(compiler, node.rules)


def matched_signal(
    compiler: Compiler, name: str, node: nodes.Signal | nodes.EventRule
) -> Matched:
    """Return the pattern of a signal."""
    return Matched(compiler, name, node.args, compiler.place("rule", node.span))


def memory_rules(compiler: Compiler, rap: str, when: str) -> tuple[MemoryRulePlan, ...]:
    """Return the rules of a RAP that run at its end (`finish`) or at an `event`."""
    return tuple(
        [
            MemoryRulePlan(compiler, rule)
            for rule in compiler.library.memory_rules
            if rule.index.name == rap and rule.when == when
        ]
    )


def event_rules(compiler: Compiler) -> tuple[EventRulePlan, ...]:
    """Return the rules that belong to no RAP, in the order of the text."""
    rules = compiler.library.event_rules
    return tuple([EventRulePlan(compiler, rule) for rule in rules])
