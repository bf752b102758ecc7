"""The tables of special readers, of makers of nodes and of corrections."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from rapc.ir import nodes, schema
from rapc.ir.clauses import METHOD, RAP
from rapc.parser import forms, terms
from rapc.parser.context import Read
from rapc.parser.forms import declaration
from rapc.parser.generic import GrammarReaders, Maker, Mend
from rapc.parser.special import (
    declarations,
    expectations,
    formulas,
    memory_rules,
    method,
    rap,
    steps,
    tests,
)

SPECIAL: Mapping[str, Read] = {
    # forms
    "define_rap": rap.define_rap,
    "define_method": method.define_method,
    **{rule: declaration(rule, kind) for rule, kind in schema.declarations()},
    "declare_class_comparator": declarations.comparator,
    "define_memory_rule": memory_rules.memory_rule,
    "define_event_rule": memory_rules.event_rule,
    "alternative": memory_rules.alternative,
    "define_query": declarations.query,
    "define_agenda": tests.define_agenda,
    "define_test": tests.define_test,
    "define_test_defaults": tests.define_test_defaults,
    # operands and options of declarations
    "arguments": forms.arguments,
    "valued": forms.valued,
    "default": forms.default,
    "results": declarations.results,
    "kind_values": declarations.kind_values,
    "excludes": declarations.excludes,
    "datum_effects": declarations.datum_effects,
    "result_effects": declarations.result_effects,
    # clauses
    **{clause.field: formulas.lone_formula for clause in (*RAP, *METHOD)},
    "resources": rap.resources,
    "effects": lambda ctx, clause: declarations.effects(ctx, clause.items[1:]),
    "task_net": steps.task_net,
    "primitive": method.primitive,
    # formulas, terms and lists with arguments
    "formula": formulas.formula,
    "and": formulas.joined(nodes.And),
    "or": formulas.joined(nodes.Or),
    "not": formulas.negation,
    "truth": formulas.truth,
    "term": terms.term,
    "goal": terms.goal,
    "thing": terms.thing,
    # tests
    "at": tests.at,
    "script_row": tests.row,
    "memory": expectations.memory,
    "method_chosen": expectations.method_chosen,
    "event_pattern": expectations.event_pattern,
}
"""The special readers by rule; other rules have readers made from the grammar."""

MAKERS: Mapping[str, Maker] = {
    **dict.fromkeys(
        ("wait_for", "await"),
        lambda head, values, span: nodes.WaitFor(
            values[0].name, values[0].args, values[1] or "proceed", span=span
        ),
    ),
    "skills": lambda head, values, span: values[0],
    "order": lambda head, values, span: nodes.For(None, values[0], span=span),
    "sensor_name": lambda head, values, span: nodes.SensorName(
        values[0], values[1] or nodes.Const("true", span=span), span=span
    ),
    "cycles": lambda head, values, span: nodes.Until(None, values[0], span=span),
    "until": lambda head, values, span: (
        values[0]
        if isinstance(values[0], nodes.Until)
        else nodes.Until(values[0], None, span=span)
    ),
    "world_option": lambda head, values, span: nodes.WorldOption(
        values[0], values[1].value, span=span
    ),
}
"""The makers of nodes for rules without a node of the same name."""


MENDS: Mapping[str, Mend] = {
    "monitor_time": rap.bare_times,
    "rule": memory_rules.whole_rule,
    "believe": formulas.dated,
    "sensor_name": formulas.in_sight,
}
"""The corrections of lists with published variants in their spelling."""


@cache
def readers() -> GrammarReaders:
    """Return the readers of all rules."""
    return GrammarReaders(SPECIAL, MAKERS, MENDS)
