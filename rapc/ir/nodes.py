"""Every node of the IR: what a RAP file says, without judging it.

Nodes hold no meaning: what a name refers to is found by `rapc.library.library` and
`rapc.analysis`. Those of `define-test` are in `rapc.ir.tests`.

Sources: T chapter 4 and appendix A; S sections 3 and 4; semantics section 1.
"""

from __future__ import annotations

from rapc.ir.declarations import (
    Alternative,
    Argument,
    ComparatorRow,
    DeclareComparator,
    DeclareDatum,
    DeclareEvent,
    DeclareFunction,
    DeclareIndistinctClass,
    DeclarePrimitive,
    DeclareProperty,
    DeclareProposition,
    DeclareSkill,
    EventRule,
    Exclusion,
    MemoryRule,
    Require,
    ResultCase,
    Rule,
    RuleAction,
)
from rapc.ir.formulas import (
    And,
    Believe,
    Call,
    Compare,
    Const,
    Count,
    Formula,
    History,
    Node,
    Not,
    Or,
    Pattern,
    SensorName,
    SetTest,
    Term,
    Truth,
    Var,
)
from rapc.ir.raps import (
    Annotation,
    Body,
    DefineRap,
    Effect,
    For,
    Goal,
    Method,
    MonitorTime,
    Primitive,
    Resource,
    ResourceEffect,
    Skills,
    Step,
    TaskNet,
    UntilEnd,
    UntilStart,
    WaitFor,
    Window,
)

__all__ = (
    "Alternative",
    "And",
    "Annotation",
    "Argument",
    "Believe",
    "Body",
    "Call",
    "ComparatorRow",
    "Compare",
    "Const",
    "Count",
    "DeclareComparator",
    "DeclareDatum",
    "DeclareEvent",
    "DeclareFunction",
    "DeclareIndistinctClass",
    "DeclarePrimitive",
    "DeclareProperty",
    "DeclareProposition",
    "DeclareSkill",
    "DefineRap",
    "Effect",
    "EventRule",
    "Exclusion",
    "For",
    "Formula",
    "Goal",
    "History",
    "MemoryRule",
    "Method",
    "MonitorTime",
    "Node",
    "Not",
    "Or",
    "Pattern",
    "Primitive",
    "Require",
    "Resource",
    "ResourceEffect",
    "ResultCase",
    "Rule",
    "RuleAction",
    "SensorName",
    "SetTest",
    "Skills",
    "Step",
    "TaskNet",
    "Term",
    "TopForm",
    "Truth",
    "UntilEnd",
    "UntilStart",
    "Var",
    "WaitFor",
    "Window",
)

TopForm = (
    DefineRap
    | DeclareProposition
    | DeclareProperty
    | DeclareFunction
    | DeclareIndistinctClass
    | DeclareComparator
    | DeclarePrimitive
    | DeclareDatum
    | DeclareSkill
    | DeclareEvent
    | MemoryRule
    | EventRule
    | Require
)
