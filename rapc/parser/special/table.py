"""The readers written by hand, and what makes nodes that are called otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from rapc.ir import nodes
from rapc.parser import terms
from rapc.parser.context import Read
from rapc.parser.declared import declaration
from rapc.parser.elaborate import GrammarReaders, Maker
from rapc.parser.special import (
    declarations,
    expectations,
    formulas,
    memory_rules,
    method,
    parameters,
    rap,
    steps,
    tests,
)

_DECLARED: Mapping[str, type[nodes.Node]] = {
    "declare_memory_proposition": nodes.DeclareProposition,
    "declare_memory_property": nodes.DeclareProperty,
    "declare_memory_function": nodes.DeclareFunction,
    "declare_indistinct_class": nodes.DeclareIndistinctClass,
    "declare_primitive": nodes.DeclarePrimitive,
    "declare_sensor_datum": nodes.DeclareDatum,
    "declare_skill": nodes.DeclareSkill,
    "declare_event": nodes.DeclareEvent,
    "declare_kind": nodes.DeclareKind,
}
"""The nodes of declarations that are read as the grammar has them."""

SPECIAL: Mapping[str, Read] = {
    # forms
    "define_rap": rap.define_rap,
    **{rule: declaration(rule, kind) for rule, kind in _DECLARED.items()},
    "declare_class_comparator": declarations.comparator,
    "define_memory_rule": memory_rules.memory_rule,
    "define_event_rule": memory_rules.event_rule,
    "define_query": declarations.query,
    "define_agenda": tests.define_agenda,
    "define_test": tests.define_test,
    "define_test_defaults": tests.define_test_defaults,
    # operands and options of declarations
    "arguments": parameters.arguments,
    "valued": parameters.valued,
    "results": declarations.results,
    "kind_values": declarations.kind_values,
    "excludes": declarations.excludes,
    "datum_effects": declarations.datum_effects,
    "result_effects": declarations.result_effects,
    # clauses
    **dict.fromkeys(
        (
            *("succeed", "preconditions", "constraints", "repeat_while"),
            *("monitor_state", "context"),
        ),
        formulas.lone_formula,
    ),
    "monitor_time": rap.monitor_time,
    "resources": rap.resources,
    "effects": declarations.rap_effects,
    "task_net": steps.task_net,
    "primitive": method.primitive,
    "wait_for": steps.wait_for,
    # formulas, terms and lists with arguments
    "formula": formulas.formula,
    "and": formulas.conjunction,
    "or": formulas.disjunction,
    "not": formulas.negation,
    "believe": formulas.believe,
    "sensor_name": formulas.sensor_name,
    "truth": formulas.truth,
    "term": terms.term,
    "goal": terms.goal,
    "thing": terms.thing,
    # tests
    "task": tests.given("_once_task_option"),
    "agenda_task": tests.given("_once_agenda_option"),
    "at": tests.at,
    "script_row": tests.row,
    "moved": tests.pair("moved", "a value or a variable", (nodes.Const, nodes.Var)),
    "placed": tests.pair("placed", "a value", (nodes.Const,)),
    "memory": expectations.memory,
    "method_chosen": expectations.method_chosen,
    "event_pattern": expectations.event_pattern,
}
"""Readers by rule; all other rules are read as the grammar has them."""

MAKERS: Mapping[str, Maker] = {
    "skills": lambda head, values, span: values[0],
    "order": lambda head, values, span: nodes.For(None, values[0], span),
    **dict.fromkeys(
        ("set_add", "set_sub", "counter_add", "counter_sub"),
        lambda head, values, span: nodes.ResourceChange(
            head, values[0], values[1], span
        ),
    ),
    "compare": lambda head, values, span: nodes.Compare(
        head, values[0], values[1], span
    ),
    **dict.fromkeys(
        ("member", "empty"),
        lambda head, values, span: nodes.SetTest(head, tuple(values), span),
    ),
    **dict.fromkeys(
        ("method_tried", "last_result", "result_with_method"),
        lambda head, values, span: nodes.HistoryTest(head, tuple(values), span),
    ),
    "cycles": lambda head, values, span: nodes.Until(None, values[0], span),
    "until": lambda head, values, span: (
        values[0]
        if isinstance(values[0], nodes.Until)
        else nodes.Until(values[0], None, span)
    ),
    "world_option": lambda head, values, span: nodes.WorldOption(
        values[0], values[1].value, span
    ),
    "trace": lambda head, values, span: nodes.TraceHas(values[0], span),
}
"""What makes the nodes of rules whose nodes are called otherwise, or are none."""


@cache
def readers() -> GrammarReaders:
    """Return the readers of all rules."""
    return GrammarReaders(SPECIAL, MAKERS)
