"""Every node of the IR: what a RAP file says, without judging it.

Nodes are frozen; sequences are tuples; the span is the last field and takes no part in
comparison, so two spellings of one definition are equal. Nodes hold no meaning: what a
name refers to is found by `rapc.library.library` and `rapc.analysis`.

Sources: [T 4], [T A], [S 3], [S 4]; those of tests are in docs/testing.md.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Literal

import msgspec

from rapc.base.source import NOWHERE, Span
from rapc.base.values import Atom, Number


class Node(
    msgspec.Struct,
    frozen=True,
    eq=False,
    tag=True,
    gc=False,
    array_like=True,
    kw_only=True,
):
    """The base of all nodes: compared by type and fields, the span left out.

    Nodes are trees, so the garbage collector need not look after them. In a compiled
    library a node is a list: its type's name, then its fields.
    """

    #: The position in the text; the last field of each node.
    span: Span = NOWHERE

    def __eq__(self, other: object) -> bool:
        kind = type(self)
        if kind is not type(other):
            return NotImplemented
        told = _told(kind)
        return bool(told(self) == told(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        kind = type(self)
        return hash((kind.__name__, _told(kind)(self)))


@cache
def compared_fields(kind: type[Node]) -> tuple[str, ...]:
    """Return the fields of a kind of node that make two nodes equal."""
    return tuple([f for f in kind.__struct_fields__ if not f.endswith("span")])


@cache
def _told(kind: type[Node]) -> Callable[[Node], object]:
    """Return what takes the values that make two nodes equal from a node of a kind."""
    fields = compared_fields(kind)
    return attrgetter(*fields) if fields else lambda node: ()


# --- terms -------------------------------------------------------------------


class Const(Node, frozen=True, eq=False):
    """A symbol, number or string. A `:keyword` is a symbol that starts so."""

    value: Atom


class Var(Node, frozen=True, eq=False):
    """A variable by its name with the question mark; a bare `?` matches anything."""

    name: str

    @property
    def anonymous(self) -> bool:
        """Whether this is the bare `?`, a new variable at each place."""
        return self.name == "?"


class Call(Node, frozen=True, eq=False):
    """A computed term: `+ - * /`, `size-of`, `value` or a declared function."""

    function: str
    args: tuple[Term, ...]


Term = Const | Var | Call

Used = Term
"""An operand that needs its value: unbound variables in it are a fault."""

Matched = Term
"""An operand that is held against a value: an unbound variable takes it."""


# --- formulas [L 2] -----------------------------------------------------------


class Truth(Node, frozen=True, eq=False):
    """`t` or `true` (always succeeds), `nil` or `false` (never does)."""

    value: bool


class Pattern(Node, frozen=True, eq=False):
    """A name with terms for arguments; which kind of name, the types below say."""

    name: str
    args: tuple[Term, ...]


class Proposition(Pattern, frozen=True, eq=False):
    """A fact asked, asserted or erased, or a declared test.

    Which of these it is follows from where it stands and from what its name is
    declared to be: a property, a proposition, or a function used as a test.
    """


class Request(Pattern, frozen=True, eq=False):
    """What a primitive asks of the world."""


class Signal(Pattern, frozen=True, eq=False):
    """A signal or event of the world; its name keeps its colon."""


class Skill(Pattern, frozen=True, eq=False):
    """A skill that is enabled or disabled; its name keeps its colon."""


class Datum(Pattern, frozen=True, eq=False):
    """A sensor datum that a scripted world sends."""


class Thing(Pattern, frozen=True, eq=False):
    """What is used or claimed: `wheels`, without arguments, or `(arm ?arm)`."""


class And(Node, frozen=True, eq=False):
    """All parts hold, left to right with backtracking; without parts: true."""

    parts: tuple[Formula, ...]


class Or(Node, frozen=True, eq=False):
    """One part holds, tried in order; without parts: false."""

    parts: tuple[Formula, ...]


class Not(Node, frozen=True, eq=False):
    """The part has no solution (negation as failure)."""

    part: Closed


class Compare(Node, frozen=True, eq=False):
    """`=`, `n=`, `<`, `>`, `<=` or `>=` between two terms; binds nothing."""

    op: Literal["=", "n=", "<", ">", "<=", ">="]
    left: Used
    right: Used


class Believe(Node, frozen=True, eq=False):
    """`(believe p n)`: p is believed with an age below n, or n becomes its age."""

    pattern: Proposition
    age: Matched


class SetTest(Node, frozen=True, eq=False):
    """`(member ?set thing)` or `(empty ?set)`."""

    test: Literal["member", "empty"]
    args: tuple[Used, ...]


class HistoryTest(Node, frozen=True, eq=False):
    """`method-tried`, `last-result` or `result-with-method` (T 4.1.2)."""

    query: Literal["method-tried", "last-result", "result-with-method"]
    args: tuple[Term, ...]


class SensorName(Node, frozen=True, eq=False):
    """`(know-sensor-name x)`, `(know-sensor-name x true)` or `... false)`."""

    item: Matched
    value: Matched


class Count(Node, frozen=True, eq=False):
    """`(count class place ?n)`: the size all layers of a set share [T 2.3.3]."""

    kind: Used
    place: Used
    number: Matched


class Otherwise(Node, frozen=True, eq=False):
    """`otherwise` in a context: no method before this one in the text holds now."""


Formula = (
    Truth
    | Otherwise
    | Proposition
    | And
    | Or
    | Not
    | Compare
    | Believe
    | SetTest
    | HistoryTest
    | SensorName
    | Count
)

Closed = Formula
"""A part that hands nothing out: what is bound in it is known in it alone."""


# --- RAPs: clauses, methods, task-nets, annotations [T 4], [S 3] ----------------


class MonitorTime(Node, frozen=True, eq=False):
    """`(monitor-time now|absolute start stop)`; start and stop in time units."""

    reference: Literal["now", "absolute"]
    start: Term
    stop: Term


class Resource(Node, frozen=True, eq=False):
    """`(set ?name [set])` or `(counter ?name [number-or-counter])`."""

    kind: Literal["set", "counter"]
    variable: Var
    initial: Term | None


class DeclaredEffect(Node, frozen=True, eq=False):
    """A fact that is brought about or, negated, taken away: `p`, `(not p)`, `(may p)`.

    For planner and checker, of RAPs, of the results of primitives and of data.
    """

    pattern: Proposition
    negated: bool
    #: Whether the fact can, but need not, come or go; never so of RAPs.
    possible: bool


class Goal(Node, frozen=True, eq=False):
    """`(rap args... [=> outs...])`: what a step or a top-level task asks for."""

    name: str
    args: tuple[Term, ...]
    outputs: tuple[Term, ...]


class For(Node, frozen=True, eq=False):
    """`(formula for tag)`, or `(for tag)` with no formula."""

    formula: Formula | None
    tag: str


class UntilStart(Node, frozen=True, eq=False):
    """`(until-start tag)`."""

    tag: str


class UntilEnd(Node, frozen=True, eq=False):
    """`(until-end tag)`."""

    tag: str


class Window(Node, frozen=True, eq=False):
    """`(window tag|now|absolute start stop)`.

    `reference` is a tag; the words `now` and `absolute` are never tags here.
    """

    reference: str
    start: Term
    stop: Term


class WaitFor(Node, frozen=True, eq=False):
    """`(wait-for (:signal args...) [:proceed|:succeed|:fail])`."""

    signal: str
    args: tuple[Term, ...]
    mode: Literal["proceed", "succeed", "fail"]


class ResourceChange(Node, frozen=True, eq=False):
    """`(set-add ?s x)`, `(set-sub ?s x)`, `(counter-add ?c n)`, `(counter-sub ...)`."""

    op: Literal["set-add", "set-sub", "counter-add", "counter-sub"]
    resource: Term
    amount: Term


Annotation = For | UntilStart | UntilEnd | Window | WaitFor | ResourceChange


class Step(Node, frozen=True, eq=False):
    """`(tag [priority] goal annotation...)`; the priority adds to the parent's."""

    tag: str
    priority: int
    goal: Goal
    annotations: tuple[Annotation, ...]


class TaskNet(Node, frozen=True, eq=False):
    """The steps of a method; none means the method ends well at once."""

    steps: tuple[Step, ...]


class Primitive(Node, frozen=True, eq=False):
    """`(primitive (name args...))`: one request to the world."""

    request: Request


class Skills(Node, frozen=True, eq=False):
    """`(primitive (enable ...) (wait-for ...)... (disable ...))` [S 3.2].

    Skills are patterns whose names are keywords. Each wait's mode is `succeed` or
    `fail`.
    """

    enable: tuple[Skill, ...]
    waits: tuple[WaitFor, ...]
    disable: tuple[Skill, ...]


Body = TaskNet | Primitive | Skills


class Method(Node, frozen=True, eq=False):
    """One way to carry a RAP out. `position` counts from 1 in the text.

    `constraints` and `skills` stand with a task-net alone.
    """

    name: str | int | None
    position: int
    context: Formula | None
    notations: tuple[Proposition, ...]
    body: Body
    #: What must hold for all tasks below while the method is under way.
    constraints: Formula | None = None
    #: What nobody else may use while the method is under way.
    claims: tuple[Thing, ...] = ()
    #: What is switched on while the method is under way.
    skills: tuple[Skill, ...] = ()


class VariableKind(Node, frozen=True, eq=False):
    """`(?variable kind)` in an index: of which kind its values are."""

    variable: str
    kind: str


class DefineRap(Node, frozen=True, eq=False):
    """A RAP. `name_span` is where its name stands in the index."""

    name: str
    inputs: tuple[Var, ...]
    outputs: tuple[Var, ...]
    #: The kinds of those inputs and outputs of which one is told.
    kinds: tuple[VariableKind, ...]
    duration: Term | None
    monitor_state: Formula | None
    monitor_time: MonitorTime | None
    repeat_while: Formula | None
    succeed: Formula | None
    preconditions: Formula | None
    constraints: Formula | None
    resources: tuple[Resource, ...]
    effects: tuple[DeclaredEffect, ...]
    methods: tuple[Method, ...]
    name_span: Span = NOWHERE


# --- declarations [T A] ---------------------------------------------------------


class Argument(Node, frozen=True, eq=False):
    """A declared argument: its variable and, if given, its kind (`number`, ...)."""

    variable: Var
    kind: str | None


class DeclareKind(Node, frozen=True, eq=False):
    """`(declare-kind name [:is kind] [(value...)] ["doc"])`: a kind of values."""

    name: str
    #: The kind of which all its values are too.
    above: str | None
    #: The only values there are; None where any symbol may be one.
    values: tuple[Atom, ...] | None
    doc: str


class Exclusion(Node, frozen=True, eq=False):
    """`:excludes value (pattern)` of a property (docs/memory.md)."""

    value: Atom
    pattern: Proposition


class DeclareProposition(Node, frozen=True, eq=False):
    """`(declare-memory-proposition name (arg...) ["doc"])`; `args` may be missing."""

    name: str
    args: tuple[Argument, ...] | None
    doc: str


class DeclareProperty(Node, frozen=True, eq=False):
    """`(declare-memory-property name (arg... value) default ["doc"])`.

    `default` is `unknown`, `true`, `false` or the name of a registered function;
    `args` is None in T's form without the list, else the value comes last.
    """

    name: str
    args: tuple[Argument, ...] | None
    default: str
    excludes: tuple[Exclusion, ...]
    doc: str


class DeclareFunction(Node, frozen=True, eq=False):
    """`(declare-memory-function name (arg...) [:reads (pred...)] ["doc"])`.

    `reads` is None where nothing was said.
    """

    name: str
    args: tuple[Argument, ...] | None
    reads: tuple[str, ...] | None
    doc: str


class DeclareIndistinctClass(Node, frozen=True, eq=False):
    """`(declare-indistinct-class name [comparator])`."""

    name: str
    comparator: str | None


class ComparatorRow(Node, frozen=True, eq=False):
    """One property of a comparator declared in RAP: `veto`, `ignore` or a weight."""

    property: str
    treatment: Literal["veto", "ignore", "score"]
    weight: int | float


class DeclareComparator(Node, frozen=True, eq=False):
    """`(declare-class-comparator class [place] comparator-name | rows...)` (T A.5)."""

    class_name: str
    place: str | None
    function: str | None
    rows: tuple[ComparatorRow, ...]


class ResultEffects(Node, frozen=True, eq=False):
    """`:on (result effect...)`: what memory holds after a result of a primitive."""

    result: str
    effects: tuple[DeclaredEffect, ...]


class DeclarePrimitive(Node, frozen=True, eq=False):
    """`(declare-primitive name (arg...) (result...) option... ["doc"])`."""

    name: str
    args: tuple[Argument, ...]
    results: tuple[str, ...]
    atomic: bool
    #: What a request needs for itself while it is under way.
    uses: tuple[Thing, ...]
    #: The names of the data that may come with it.
    tells: tuple[str, ...]
    #: What its results do to memory; a result that is not named: nothing is known.
    on: tuple[ResultEffects, ...]
    doc: str


class DeclareDatum(Node, frozen=True, eq=False):
    """`(declare-sensor-datum name (arg...) [:on (effect...)] ["doc"])`."""

    name: str
    args: tuple[Argument, ...]
    #: What the datum does to memory; None where nothing is said.
    on: tuple[DeclaredEffect, ...] | None
    doc: str


class DeclareSkill(Node, frozen=True, eq=False):
    """`(declare-skill :name (arg...) option... ["doc"])`; the name keeps its colon."""

    name: str
    args: tuple[Argument, ...]
    #: The names of the events that it may tell, with colons; None where none are said.
    events: tuple[str, ...] | None
    #: What it needs for itself while it is on.
    uses: tuple[Thing, ...]
    doc: str


class DeclareEvent(Node, frozen=True, eq=False):
    """`(declare-event :name (arg...) ["doc"])`; the name keeps its colon."""

    name: str
    args: tuple[Argument, ...]
    doc: str


# --- named formulas ----------------------------------------------------------------


class DefineQuery(Node, frozen=True, eq=False):
    """`(define-query (name arg...) formula ["doc"])`: a formula with a name.

    Where it is used, a proposition of that name stands.
    """

    name: str
    args: tuple[Argument, ...]
    formula: Formula
    doc: str
    name_span: Span = NOWHERE


# --- rules over memory (S 4.2, 4.3) ------------------------------------------------


class RuleAction(Node, frozen=True, eq=False):
    """`(mem-add p)` or `(mem-del prefix)`."""

    op: Literal["mem-add", "mem-del"]
    pattern: Proposition


class Alternative(Node, frozen=True, eq=False):
    """`(query action...)` of a rule; no query is written as true."""

    query: Formula
    actions: tuple[RuleAction, ...]


class Rule(Node, frozen=True, eq=False):
    """`(rule (query action...)...)`: the first query with a solution acts."""

    alternatives: tuple[Alternative, ...]


class ResultCase(Node, frozen=True, eq=False):
    """`(pattern (rule ...)...)` of a `match-result`.

    `result` is a `Const` symbol (`succeed` or a failure), a `Var`, or, for
    `(signal args...)`, a `Signal`.
    """

    result: Const | Var | Signal
    rules: tuple[Rule, ...]


class MemoryRule(Node, frozen=True, eq=False):
    """`(define-memory-rule index :finish|:event (match-result case...))`."""

    index: Goal
    when: Literal["finish", "event"]
    cases: tuple[ResultCase, ...]


class EventRule(Node, frozen=True, eq=False):
    """`(define-event-rule (:signal args...) (rule ...)...)`."""

    signal: str
    args: tuple[Term, ...]
    rules: tuple[Rule, ...]


class Require(Node, frozen=True, eq=False):
    """`(require "name")`."""

    name: str


# --- what is given -----------------------------------------------------------------


class Moved(Node, frozen=True, eq=False):
    """`(item place)`: an item that a handler has introduced is at another place now.

    Both are constants or, in a row of a script, variables.
    """

    item: Term
    place: Term


RowKind = Literal["request", "enable", "disable"]


class ScriptRow(Node, frozen=True, eq=False):
    """`((request) [result] option...)`: what the world answers, and what comes of it.

    `request` may hold variables; with `kind` `enable` or `disable` its name is that of
    a skill. `after` is None for an atomic primitive, `times` for a row without limit.
    `pauses` are the waits before each of the `signals`.
    """

    kind: RowKind
    request: Request | Skill
    result: str | None
    times: int | None
    takes: Number
    after: Number | None
    asserts: tuple[Proposition, ...]
    erases: tuple[Proposition, ...]
    moves: tuple[Moved, ...]
    loses: tuple[Term, ...]
    data: tuple[Datum, ...]
    signals: tuple[Signal, ...]
    refused: bool
    pauses: tuple[Number, ...] = ()
    #: How long after a skill has told its signals it tells them again; None: never.
    every: Number | None = None


class GivenTask(Node, frozen=True, eq=False):
    """`(task goal [:priority n] [:deadline t] [:at t] [:background true])`.

    `at` stands in agendas alone.
    """

    goal: Goal
    priority: int
    deadline: Number | None
    at: Number | None
    background: bool


class DefineAgenda(Node, frozen=True, eq=False):
    """`(define-agenda name (require "name")... task...)`: what is to be done."""

    name: str
    requires: tuple[Require, ...]
    tasks: tuple[GivenTask, ...]
    name_span: Span = NOWHERE


class Answer(Node, frozen=True, eq=False):
    """`((function arg...) value)`: what a function returns that nobody registered.

    The arguments are constants and variables.
    """

    call: Call
    value: Const


class WorldOption(Node, frozen=True, eq=False):
    """`(name value)`: an option of the world that a test runs in."""

    name: str
    value: Atom


class Asserts(Node, frozen=True, eq=False):
    """`(asserts fact...)`."""

    facts: tuple[Proposition, ...]


class Erases(Node, frozen=True, eq=False):
    """`(erases prefix...)`."""

    prefixes: tuple[Proposition, ...]


class Moves(Node, frozen=True, eq=False):
    """`(moves (item place)...)`."""

    moves: tuple[Moved, ...]


class Loses(Node, frozen=True, eq=False):
    """`(loses item...)`."""

    items: tuple[Term, ...]


class Signals(Node, frozen=True, eq=False):
    """`(signals (:name args...)...)`."""

    signals: tuple[Signal, ...]


class Cancel(Node, frozen=True, eq=False):
    """`(cancel goal)`: every live top-level task that matches it."""

    goal: Goal


class Until(Node, frozen=True, eq=False):
    """`(until t)` or, with `cycles`, `(until (cycles n))` and `(cycles n)`."""

    time: Number | None
    cycles: int | None


# --- what is expected --------------------------------------------------------------


class ListPattern(Node, frozen=True, eq=False):
    """A list in an event pattern: a goal, a fact, a list of data."""

    items: tuple[TracePattern, ...]


TracePattern = Const | Var | ListPattern


class EventPattern(Node, frozen=True, eq=False):
    """`(task-failed :goal (x ?a) ...)`: an event's name and some of its keys.

    Keys are named without the colon.
    """

    event: str
    keys: tuple[tuple[str, TracePattern], ...]


class Succeeds(Node, frozen=True, eq=False):
    """`(succeeds goal [output...])`."""

    goal: Goal
    outputs: tuple[Term, ...]


class Fails(Node, frozen=True, eq=False):
    """`(fails goal [result])`; the result is a symbol or a variable."""

    goal: Goal
    result: Const | Var | None


class Active(Node, frozen=True, eq=False):
    """`(active goal)`."""

    goal: Goal


class Primitives(Node, frozen=True, eq=False):
    """`(primitives request...)`: all of them, and skills enabled, in order."""

    requests: tuple[Request | Skill, ...]


class PrimitivesInclude(Node, frozen=True, eq=False):
    """`(primitives-include request...)`: in order, with others between."""

    requests: tuple[Request | Skill, ...]


class Never(Node, frozen=True, eq=False):
    """`(never request)`."""

    request: Request | Skill


class MemoryHolds(Node, frozen=True, eq=False):
    """`(memory formula)`."""

    formula: Formula


class MethodChosen(Node, frozen=True, eq=False):
    """`(method rap name [n times])`.

    `method` is written as the trace has it: a name, or `#1` for one without;
    `times` is None where any number from one will do.
    """

    rap: str
    method: str
    times: int | None


class SelectedBefore(Node, frozen=True, eq=False):
    """`(selected-before goal goal)`."""

    first: Goal
    second: Goal


class EndsBy(Node, frozen=True, eq=False):
    """`(ends-by time goal)`."""

    time: Number
    goal: Goal


class TraceHas(Node, frozen=True, eq=False):
    """`(trace event-pattern...)`: in order, with others between."""

    events: tuple[EventPattern, ...]


Expectation = (
    Succeeds
    | Fails
    | Active
    | Primitives
    | PrimitivesInclude
    | Never
    | MemoryHolds
    | MethodChosen
    | SelectedBefore
    | EndsBy
    | TraceHas
)


class Expect(Node, frozen=True, eq=False):
    """`(expect expectation...)`."""

    expectations: tuple[Expectation, ...]


# --- the whole -----------------------------------------------------------------------

Action = Asserts | Erases | Moves | Loses | Signals | GivenTask | Cancel | Expect


class At(Node, frozen=True, eq=False):
    """`(at time action...)`, the actions in the order of the text."""

    time: Number
    actions: tuple[Action, ...]


class DefineTest(Node, frozen=True, eq=False):
    """`(define-test name ["doc"] clause...)`, with what its file says of all tests.

    `name_span` is where its name stands.
    """

    name: str
    doc: str
    requires: tuple[Require, ...]
    world: str | None
    options: tuple[WorldOption, ...]
    seed: int | None
    agenda: str | None
    answers: tuple[Answer, ...]
    facts: tuple[Proposition, ...]
    script: tuple[ScriptRow, ...]
    ats: tuple[At, ...]
    tasks: tuple[GivenTask, ...]
    until: Until | None
    expectations: tuple[Expectation, ...]
    name_span: Span = NOWHERE


TopForm = (
    DefineRap
    | DefineQuery
    | DefineAgenda
    | DeclareKind
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
