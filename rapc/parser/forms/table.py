"""Which function reads which top-level form."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.parser.special import declarations, memory_rules, offers
from rapc.parser.special.context import Context
from rapc.parser.special.rap import define_rap
from rapc.parser.special.require import require
from rapc.parser.special.tests import define_test
from rapc.parser.syntax import List

FORMS: Mapping[str, Callable[[Context, List], nodes.TopForm | DefineTest | None]] = {
    "define-rap": define_rap,
    "declare-memory-proposition": declarations.proposition,
    "declare-memory-property": declarations.property_,
    "declare-memory-function": declarations.function,
    "declare-indistinct-class": declarations.indistinct_class,
    "declare-class-comparator": declarations.comparator,
    "declare-primitive": offers.primitive,
    "declare-sensor-datum": offers.datum,
    "declare-skill": offers.skill,
    "declare-event": offers.event,
    "define-memory-rule": memory_rules.memory_rule,
    "define-event-rule": memory_rules.event_rule,
    "define-test": define_test,
    "require": require,
}
"""The top-level forms by name."""
