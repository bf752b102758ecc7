"""All nodes of the IR, which represents the content of RAP files without checks.

Nodes are frozen, and sequences are tuples. The span is the last field and is not
compared: two spellings of a definition are equal.
Not here: the meaning of names (`rapc.library.library` and `rapc.analysis`).

Sources: [T 4], [T A], [S 3], [S 4]; for tests: docs/reference/tests.md.
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
    """The base of all nodes, compared by type and fields without the span.

    Nodes are trees without cycles, and the garbage collector ignores them. In a
    compiled library a node is a list: its type's name, then its fields.
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
    """Return a function that returns the compared values of a node of a kind."""
    fields = compared_fields(kind)
    return attrgetter(*fields) if fields else lambda node: ()


# --- terms -------------------------------------------------------------------


class Const(Node, frozen=True, eq=False):
    """A symbol, number or string. A `:keyword` is a symbol with a leading colon."""

    value: Atom


class Var(Node, frozen=True, eq=False):
    """A variable by its name with the question mark; a bare `?` matches anything."""

    name: str

    @property
    def anonymous(self) -> bool:
        """Whether the variable is the bare `?`, a new variable at each occurrence."""
        return self.name == "?"


class Call(Node, frozen=True, eq=False):
    """A computed term: `+ - * /`, `size-of`, `value` or a declared function."""

    function: str
    args: tuple[Term, ...]


Term = Const | Var | Call

Used = Term
"""An operand that needs its value: an unbound variable in the operand is a fault."""

Matched = Term
"""An operand that is matched with a value, which binds an unbound variable."""


# --- formulas [L 2] -----------------------------------------------------------


class Truth(Node, frozen=True, eq=False):
    """`t` or `true` (always succeeds), `nil` or `false` (never succeeds)."""

    value: bool


class Pattern(Node, frozen=True, eq=False):
    """A name with terms as arguments; the subclasses are the kinds of names."""

    name: str
    args: tuple[Term, ...]


class Proposition(Pattern, frozen=True, eq=False):
    """A fact that is queried, asserted or erased, or a declared test.

    The use follows from the position and from the declaration of the name: a property,
    a proposition, or a function used as a test.
    """


class Request(Pattern, frozen=True, eq=False):
    """The request of a primitive to the world."""


class Signal(Pattern, frozen=True, eq=False):
    """A signal or event of the world; its name keeps its colon."""


class Skill(Pattern, frozen=True, eq=False):
    """A skill that is enabled or disabled; its name keeps its colon."""


class Datum(Pattern, frozen=True, eq=False):
    """A sensor datum that a scripted world sends."""


class Thing(Pattern, frozen=True, eq=False):
    """A thing used or claimed: `wheels`, without arguments, or `(arm ?arm)`."""


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


class Is(Node, frozen=True, eq=False):
    """`(is ?x term)`: binds a free variable to the term's value, else compares both."""

    variable: Matched
    value: Used


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
    """`otherwise` in a context: no preceding method in the text applies."""


Formula = (
    Truth
    | Otherwise
    | Proposition
    | And
    | Or
    | Not
    | Compare
    | Is
    | Believe
    | SetTest
    | HistoryTest
    | SensorName
    | Count
)

Closed = Formula
"""A part with local bindings.

The `Closed` fields of a formula are one scope, which the formula's other fields and the
text after the formula do not see: a part sees the bindings of the preceding parts.
"""


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
    """A fact that is asserted or, if negated, erased: `p`, `(not p)`, `(may p)`.

    Planner and checker use the declared effects of RAPs, results and data.
    """

    pattern: Proposition
    negated: bool
    #: Whether the effect is possible, but not certain.
    possible: bool


class Plan(Node, frozen=True, eq=False):
    """`(plan rap...)`: the planner may find methods; without names, of all RAPs."""

    raps: tuple[str, ...]


class Goal(Node, frozen=True, eq=False):
    """`(rap args... [=> outs...])`: the goal of a step or of a top-level task."""

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
    """The steps of a method; without steps the method succeeds at once."""

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
    """A method of a RAP. `position` counts from 1 in the text.

    Only a method with a task-net has `constraints` and `skills`.
    """

    name: str | int | None
    position: int
    context: Formula | None
    notations: tuple[Proposition, ...]
    body: Body
    #: The formula that must hold for all descendants while the method is under way.
    constraints: Formula | None = None
    #: The things that no other task may use while the method is under way.
    claims: tuple[Thing, ...] = ()
    #: The skills that are switched on while the method is under way.
    skills: tuple[Skill, ...] = ()

    @property
    def traced_name(self) -> str:
        """The name in traces: the name of the method, or `#` and its position."""
        return f"#{self.position}" if self.name is None else str(self.name)


class DefineMethod(Node, frozen=True, eq=False):
    """`(define-method rap [name] clause...)`: a method of a RAP of the library.

    `name_span` is the span of the name of the RAP. Linking moves the method to its RAP.
    """

    rap: str
    method: Method
    name_span: Span = NOWHERE


class VariableKind(Node, frozen=True, eq=False):
    """`(?variable kind)` in an index: the kind of the variable's values."""

    variable: str
    kind: str


class DefineRap(Node, frozen=True, eq=False):
    """A RAP. `name_span` is the span of its name in the index."""

    name: str
    inputs: tuple[Var, ...]
    outputs: tuple[Var, ...]
    #: The declared kinds of inputs and outputs.
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
    plan: Plan | None
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
    #: The parent kind, which includes all values of this kind.
    above: str | None
    #: The values of a closed kind; None for an open kind.
    values: tuple[Atom, ...] | None
    doc: str


class Exclusion(Node, frozen=True, eq=False):
    """`:excludes value (pattern)` of a property (docs/explanation/memory.md)."""

    value: Atom
    pattern: Proposition


class DeclareProposition(Node, frozen=True, eq=False):
    """`(declare-memory-proposition name (arg...) [:at-most number] ["doc"])`.

    `args` may be missing; `at_most` is None if it is not declared.
    """

    name: str
    args: tuple[Argument, ...] | None
    at_most: int | None
    doc: str


class DeclareProperty(Node, frozen=True, eq=False):
    """`(declare-memory-property name (arg... value) default ["doc"])`.

    `default` is a value or the name of a declared function, which computes the value;
    `args` is None in T's form without the list, else the value comes last.
    """

    name: str
    args: tuple[Argument, ...] | None
    default: Atom
    excludes: tuple[Exclusion, ...]
    doc: str


class DeclareFunction(Node, frozen=True, eq=False):
    """`(declare-memory-function name (arg...) [:reads (pred...)] ["doc"])`.

    `reads` is None if it is not declared.
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
    """A property of a comparator declared in RAP: `veto`, `ignore` or a weight."""

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
    """`:on (result effect...)`: the declared effects of a result of a primitive."""

    result: str
    effects: tuple[DeclaredEffect, ...]


class DeclarePrimitive(Node, frozen=True, eq=False):
    """`(declare-primitive name (arg...) (result...) option... ["doc"])`."""

    name: str
    args: tuple[Argument, ...]
    results: tuple[str, ...]
    atomic: bool
    #: The things that a request uses while it is under way.
    uses: tuple[Thing, ...]
    #: The names of the data that may come with the result.
    tells: tuple[str, ...]
    #: The declared effects of results; the effects of other results are unknown.
    on: tuple[ResultEffects, ...]
    doc: str


class DeclareDatum(Node, frozen=True, eq=False):
    """`(declare-sensor-datum name (arg...) [:on (effect...)] ["doc"])`."""

    name: str
    args: tuple[Argument, ...]
    #: The declared effects of the datum; None if not declared.
    on: tuple[DeclaredEffect, ...] | None
    doc: str


class DeclareSkill(Node, frozen=True, eq=False):
    """`(declare-skill :name (arg...) option... ["doc"])`; the name keeps its colon."""

    name: str
    args: tuple[Argument, ...]
    #: The names of the events that the skill may send, with colons; None if not
    #: declared.
    events: tuple[str, ...] | None
    #: The things that the skill uses while it is on.
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

    A use of the query is a proposition of that name.
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
    """`(query action...)` of a rule; a missing query is true."""

    query: Formula
    actions: tuple[RuleAction, ...]


class Rule(Node, frozen=True, eq=False):
    """`(rule (query action...)...)`: the first query with a solution is carried out."""

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


# --- scripts, tasks and agendas ----------------------------------------------------


class Moved(Node, frozen=True, eq=False):
    """`(item place)`: the move of an introduced item to a place.

    Both are constants or, in a row of a script, variables.
    """

    item: Term
    place: Term


RowKind = Literal["request", "enable", "disable"]


class ScriptRow(Node, frozen=True, eq=False):
    """`((request) [result] option...)`: the world's reply to a request, with effects.

    `request` may have variables; with the `kind` `enable` or `disable` it is a skill.
    `after` is None for an atomic primitive, `times` is None for a row without limit.
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
    #: The time after which a skill repeats its signals; None: no repetition.
    every: Number | None = None


class GivenTask(Node, frozen=True, eq=False):
    """`(task goal [:priority n] [:deadline t] [:at t] [:background true])`.

    `at` occurs only in agendas.
    """

    goal: Goal
    priority: int
    deadline: Number | None
    at: Number | None
    background: bool


class DefineAgenda(Node, frozen=True, eq=False):
    """`(define-agenda name (require "name")... task...)`: a list of tasks."""

    name: str
    requires: tuple[Require, ...]
    tasks: tuple[GivenTask, ...]
    name_span: Span = NOWHERE


class Answer(Node, frozen=True, eq=False):
    """`((function arg...) value)`: the value of a function that is not registered.

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
    """`(cancel goal)`: cancel every live top-level task that matches the goal."""

    goal: Goal


class Until(Node, frozen=True, eq=False):
    """`(until t)` or, with `cycles`, `(until (cycles n))` and `(cycles n)`."""

    time: Number | None
    cycles: int | None


# --- expectations ------------------------------------------------------------------


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
    """`(primitives request...)`: all requests and enabled skills, in order."""

    requests: tuple[Request | Skill, ...]


class PrimitivesInclude(Node, frozen=True, eq=False):
    """`(primitives-include request...)`: in order, other requests allowed between."""

    requests: tuple[Request | Skill, ...]


class Never(Node, frozen=True, eq=False):
    """`(never request)`."""

    request: Request | Skill


class MemoryHolds(Node, frozen=True, eq=False):
    """`(memory formula)`."""

    formula: Formula


class MethodChosen(Node, frozen=True, eq=False):
    """`(method rap name [n times])`.

    `method` has the form of the trace: a name, or `#1` for a method without name;
    `times` is None for any number from 1.
    """

    rap: str
    method: str
    times: int | None


class Plans(Node, frozen=True, eq=False):
    """`(plans goal step...)`: all steps of a plan; none for any plan."""

    goal: Goal
    steps: tuple[Goal, ...]


class PlansNone(Node, frozen=True, eq=False):
    """`(plans-none goal)`."""

    goal: Goal


class SelectedBefore(Node, frozen=True, eq=False):
    """`(selected-before goal goal)`."""

    first: Goal
    second: Goal


class EndsBy(Node, frozen=True, eq=False):
    """`(ends-by time goal)`."""

    time: Number
    goal: Goal


class TraceHas(Node, frozen=True, eq=False):
    """`(trace event-pattern...)`: in order, other events allowed between."""

    events: tuple[EventPattern, ...]


class Figure(Node, frozen=True, eq=False):
    """`(figure name comparison number)`; the comparison as in formulas."""

    name: str
    comparison: str
    value: Const


class FailsAtMost(Node, frozen=True, eq=False):
    """`(fails-at-most n)`: a limit of the mended failures."""

    count: int


Expectation = (
    Succeeds
    | Fails
    | Active
    | Primitives
    | PrimitivesInclude
    | Never
    | MemoryHolds
    | MethodChosen
    | Plans
    | PlansNone
    | SelectedBefore
    | EndsBy
    | TraceHas
    | Figure
    | FailsAtMost
)


class Expect(Node, frozen=True, eq=False):
    """`(expect expectation...)`."""

    expectations: tuple[Expectation, ...]


# --- tests and top-level forms -------------------------------------------------------

Action = Asserts | Erases | Moves | Loses | Signals | GivenTask | Cancel | Expect


class At(Node, frozen=True, eq=False):
    """`(at time [:every n :until t] action...)`, the actions in the order of the text.

    `every` and `until` are both None, or neither is.
    """

    time: Number
    actions: tuple[Action, ...]
    every: Number | None = None
    until: Number | None = None


class DefineTest(Node, frozen=True, eq=False):
    """`(define-test name ["doc"] clause...)`, with the test defaults of its file.

    `name_span` is the span of its name.
    """

    name: str
    doc: str
    requires: tuple[Require, ...]
    world: str | None
    options: tuple[WorldOption, ...]
    seed: int | None
    agenda: str | None
    saved_state: str | None
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
    | DefineMethod
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
