"""The index of a library: each node by its type, each name with its uses.

The index holds the nodes of all forms, in the order of the text. Each node has its
parent, which determines the role of the node, and its top-level form.
`rapc.library.signatures` determines the meaning of a name.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Generic, TypeVar, cast

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.clauses import METHOD, held
from rapc.ir.schema import CHILDREN
from rapc.language.heads import CALLS
from rapc.library.library import Library, word_span
from rapc.library.signatures import Use

N = TypeVar("N", bound=nodes.Node)
P = TypeVar("P", bound=nodes.Pattern)

Form = nodes.TopForm | nodes.DefineTest
"""A top-level form of a file."""


class Occurrence(msgspec.Struct, Generic[N], frozen=True, gc=False):
    """A node with its parent and its top-level form."""

    node: N
    #: The parent of the node.
    parent: nodes.Node
    #: The top-level form around the node.
    owner: Form


VariableAt = tuple[nodes.Var, nodes.Node, Form]
"""A variable with its parent and its top-level form."""


_FactAt = tuple[nodes.Proposition, nodes.Node, Form]


class NameUse(msgspec.Struct, frozen=True, gc=False):
    """A use of a name that requires a declaration."""

    use: Use
    name: str
    #: The number of arguments (inputs of a RAP) after the name.
    count: int
    #: The node that contains the name.
    node: nodes.Pattern | nodes.Goal | nodes.Call | nodes.WaitFor | nodes.EventRule
    #: The top-level form around the name.
    owner: Form
    #: The number of outputs of a RAP that are taken; None where no outputs are named.
    outputs: int | None = None

    @property
    def span(self) -> Span:
        """Return the list that the name heads, or the other node with the name."""
        return self.node.span

    def place(self, files: Mapping[str, SourceFile]) -> Span:
        """Return the span of the name, or of its node if the name heads no list."""
        heads = not isinstance(self.node, nodes.WaitFor | nodes.EventRule)
        return word_span(files, self.span, 0) if heads else self.span


class NamedKind(msgspec.Struct, frozen=True, gc=False):
    """A use of the name of a kind."""

    kind: str
    #: The node that names the kind.
    span: Span
    #: The top-level form around the name.
    owner: Form


_BODIES = (nodes.DefineRap, nodes.DefineQuery, nodes.MemoryRule, nodes.EventRule)
"""The forms with variables of their own."""


class Index:
    """The nodes of a library by type; constants are left out.

    Args:
        library: the library; its tests are part of it.
    """

    def __init__(self, library: Library) -> None:
        #: By node type: the node, its parent and its form; `of` makes occurrences.
        self._rows: dict[type, list[tuple[nodes.Node, nodes.Node, Form]]] = {}
        self._made: dict[type, Sequence[Occurrence[nodes.Node]]] = {}
        self._forms: dict[str, list[Form]] = {}
        self._uses: tuple[NameUse, ...] | None = None
        self._variables: list[tuple[Form, dict[str, list[VariableAt]]]] | None = None
        self._kinds: tuple[NamedKind, ...] | None = None
        self._by_name: dict[tuple[Use, str], list[NameUse]] | None = None
        self._roots: Sequence[Form] = (*library.forms, *library.tests)
        for form in (*self._roots, *library.methods):
            self._forms.setdefault(form.span.file, []).append(form)
        for forms in self._forms.values():
            forms.sort(key=lambda form: form.span.start)

    def of(self, kind: type[N]) -> Sequence[Occurrence[N]]:
        """Return all nodes of one type, in the order of the text."""
        made = self._made.get(kind)
        if made is None:
            made = [Occurrence(*row) for row in self._rows_of(kind)]
            self._made[kind] = made
        return cast(Sequence[Occurrence[N]], made)

    def at(self, file: str, offset: int) -> Occurrence[nodes.Node] | None:
        """Return the innermost node at an offset of a file; None between forms."""
        forms = self._forms.get(file, [])
        first = bisect_right(forms, offset, key=lambda form: form.span.start) - 1
        if first < 0 or offset >= forms[first].span.end:
            return None
        owner = forms[first]
        found = Occurrence[nodes.Node](owner, owner, owner)
        while (below := _child_at(found.node, offset)) is not None:
            found = Occurrence[nodes.Node](below, found.node, owner)
        return found

    def uses_of(self, use: Use, name: str) -> Sequence[NameUse]:
        """Return the uses of a name in one way, in the order of uses."""
        if self._by_name is None:
            self._by_name = {}
            for one in self.uses():
                self._by_name.setdefault((one.use, one.name), []).append(one)
        return self._by_name.get((use, name), ())

    def uses(self) -> Sequence[NameUse]:
        """Return each use of a declared name; the uses are collected once."""
        if self._uses is None:
            self._uses = tuple(self._gathered())
        return self._uses

    def variables(self) -> Sequence[tuple[Form, Mapping[str, Sequence[VariableAt]]]]:
        """Return the forms that have variables, with the variables by name."""
        if self._variables is None:
            names: dict[str, list[VariableAt]] = {}
            self._variables = []
            last: Form | None = None
            for row in cast(list[VariableAt], self._rows_of(nodes.Var)):
                variable, _, owner = row
                if owner is not last:
                    names, last = {}, owner
                    self._variables.append((owner, names))
                names.setdefault(variable.name, []).append(row)
        return self._variables

    def used_once(self) -> Iterator[VariableAt]:
        """Yield the variables that occur once in a form with a body.

        An input, an output, an argument or a resource is left out.
        """
        for owner, names in self.variables():
            for name, uses in names.items() if isinstance(owner, _BODIES) else ():
                _, parent, _ = uses[0]
                declared = isinstance(parent, nodes.Argument | nodes.Resource)
                if len(uses) == 1 and name != "?" and parent is not owner:
                    yield from () if declared else uses

    def kinds(self) -> Sequence[NamedKind]:
        """Return each use of the name of a kind; the uses are collected once."""
        if self._kinds is None:
            self._kinds = tuple(_named_kinds(self))
        return self._kinds

    def shrink(self) -> None:
        """Keep the uses of names alone; all else is collected again when needed."""
        self.uses()
        self.kinds()
        self._variables = None
        for table in (self._rows, self._made):
            while table:  # entry by entry: another thread may run after each
                table.popitem()

    def _rows_of(self, kind: type) -> list[tuple[nodes.Node, nodes.Node, Form]]:
        if not self._rows:
            self._rows = {one: [] for one in CHILDREN}
            for form in self._roots:
                self._add(form, form, form)
        return self._rows.get(kind, [])

    def _gathered(self) -> Iterator[NameUse]:
        facts = cast(list[_FactAt], self._rows_of(nodes.Proposition))
        for fact, parent, owner in facts:
            use = _use(fact, parent)
            if use is not None:
                yield NameUse(use, fact.name, len(fact.args), fact, owner)
        for kind, use in _SENT.items():
            for sent in self.of(kind):
                yield _list_use(use, sent)
        for goal in self.of(nodes.Goal):
            yield _goal_use(goal)
        for call in self.of(nodes.Call):
            if call.node.function not in CALLS:
                yield _call_use(call)
        for wait in self.of(nodes.WaitFor):
            yield _signal_use(wait.node, wait.owner)
        for rule in self.of(nodes.EventRule):
            yield _signal_use(rule.node, rule.owner)
        for row in self.of(nodes.ScriptRow):
            yield from _row_uses(row.node, row.owner)

    def _add(self, node: nodes.Node, parent: nodes.Node, owner: Form) -> None:
        rows, kind = self._rows, type(node)
        rows[kind].append((node, parent, owner))
        for field in CHILDREN[kind]:
            value = getattr(node, field)
            held = type(value)
            if held is tuple:
                for child in value:
                    held = type(child)
                    if held is nodes.Var:
                        rows[held].append((child, node, owner))
                    elif held is not nodes.Const:
                        self._add(child, node, owner)
            elif value is not None and held is not nodes.Const:
                self._add(value, node, owner)


def _named_kinds(index: Index) -> Iterator[NamedKind]:
    for argument in index.of(nodes.Argument):
        if argument.node.kind is not None:
            yield NamedKind(argument.node.kind, argument.node.span, argument.owner)
    for variable in index.of(nodes.VariableKind):
        yield NamedKind(variable.node.kind, variable.node.span, variable.owner)
    for declared in index.of(nodes.DeclareKind):
        if declared.node.above is not None:
            yield NamedKind(declared.node.above, declared.node.span, declared.owner)


def _child_at(node: nodes.Node, offset: int) -> nodes.Node | None:
    """Return the child of a node at an offset."""
    for field in CHILDREN[type(node)]:
        value = getattr(node, field)
        for child in value if type(value) is tuple else (value,):
            if child is not None and child.span.start <= offset < child.span.end:
                return cast(nodes.Node, child)
    return None


def _run(run: Pass) -> Index:
    return Index(run.library)


INDEX = Fact(_run)
"""All nodes of the library by type."""


Uses = Counter[tuple[Use, str]]
"""The number of uses of a name in one way, whether declared or not."""


def _count(run: Pass) -> Uses:
    return Counter([(one.use, one.name) for one in run.result(INDEX).uses()])


USES = Fact(_count)
"""The number of uses of each name."""


# --- how a name is used -----------------------------------------------------------


def _list_use(use: Use, found: Occurrence[P]) -> NameUse:
    node = found.node
    return NameUse(use, node.name, len(node.args), node, found.owner)


def _call_use(found: Occurrence[nodes.Call]) -> NameUse:
    call = found.node
    return NameUse("computed", call.function, len(call.args), call, found.owner)


def _signal_use(node: nodes.WaitFor | nodes.EventRule, owner: Form) -> NameUse:
    return NameUse("event", node.signal, len(node.args), node, owner)


def _goal_use(found: Occurrence[nodes.Goal]) -> NameUse:
    """Return the use of a RAP; a step takes every output, other goals need not."""
    goal, parent = found.node, found.parent
    outputs: int | None = len(goal.outputs)
    if type(parent) is nodes.Succeeds:
        outputs = len(parent.outputs) or None
    elif type(parent) is not nodes.Step:
        outputs = outputs or None
    return NameUse("goal", goal.name, len(goal.args), goal, found.owner, outputs)


def _row_uses(row: nodes.ScriptRow, owner: Form) -> Iterator[NameUse]:
    """Yield the facts of a row; only the row node knows which facts are erased."""
    for fact in row.asserts:
        yield NameUse("asserted", fact.name, len(fact.args), fact, owner)
    for fact in row.erases:
        yield NameUse("erased", fact.name, len(fact.args), fact, owner)


def _use(fact: nodes.Proposition, parent: nodes.Node) -> Use | None:
    """Return the use of a proposition; None if `parent` itself yields the use."""
    if type(parent) is nodes.Method:
        asked = any(fact is formula for _, formula in held(METHOD, parent))
        return "test" if asked else "asserted"
    if type(parent) is nodes.RuleAction:
        return "asserted" if parent.op == "mem-add" else "erased"
    return _USES.get(type(parent), "test")


_USES: Mapping[type, Use | None] = {
    nodes.Believe: "believed",
    nodes.DeclaredEffect: "asserted",
    nodes.Exclusion: "asserted",
    nodes.DefineTest: "asserted",
    nodes.ScriptRow: None,
    nodes.Asserts: "asserted",
    nodes.Erases: "erased",
}
"""The uses of propositions by type of parent; all other propositions are tests."""

_SENT: Mapping[type[nodes.Pattern], Use] = {
    nodes.Request: "primitive",
    nodes.Datum: "datum",
    nodes.Skill: "skill",
    nodes.Signal: "event",
}
"""The uses of names that are sent to a world or received from a world."""
