"""The index of a library: each node by its type, each name with its uses.

The index holds the nodes of all forms, in the order of the text, each
with its parent, which tells what part it plays, and with the top-level form that it
stands in. What a name means is for `rapc.library.signatures` to say.
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
    """A node where it stands."""

    node: N
    #: The node that holds it.
    parent: nodes.Node
    #: The top-level form that it stands in.
    owner: Form


VariableAt = tuple[nodes.Var, nodes.Node, Form]
"""A variable where it stands: what holds it, and the top-level form."""


_FactAt = tuple[nodes.Proposition, nodes.Node, Form]


class NameUse(msgspec.Struct, frozen=True, gc=False):
    """A place where a name is used that somebody has to declare."""

    use: Use
    name: str
    #: How many arguments (inputs of a RAP) stand behind the name.
    count: int
    #: What the name stands in.
    node: nodes.Pattern | nodes.Goal | nodes.Call | nodes.WaitFor | nodes.EventRule
    #: The top-level form that it stands in.
    owner: Form
    #: How many outputs of a RAP are taken; None where none are named.
    outputs: int | None = None

    @property
    def span(self) -> Span:
        """The list that the name heads, or what else holds the name."""
        return self.node.span

    def place(self, files: Mapping[str, SourceFile]) -> Span:
        """Return where the name stands, or what holds it if it heads no list."""
        heads = not isinstance(self.node, nodes.WaitFor | nodes.EventRule)
        return word_span(files, self.span, 0) if heads else self.span


class NamedKind(msgspec.Struct, frozen=True, gc=False):
    """A place where a kind is named."""

    kind: str
    #: What names it.
    span: Span
    #: The top-level form that it stands in.
    owner: Form


_BODIES = (nodes.DefineRap, nodes.DefineQuery, nodes.MemoryRule, nodes.EventRule)
"""The forms with variables of their own."""


class Index:
    """The nodes of a library by type; constants are left out.

    Args:
        library: the library; its tests are part of it.
    """

    def __init__(self, library: Library) -> None:
        #: For each type of node: the node, its parent, its form; `of` makes more of it.
        self._rows: dict[type, list[tuple[nodes.Node, nodes.Node, Form]]] = {
            kind: [] for kind in CHILDREN
        }
        self._made: dict[type, Sequence[Occurrence[nodes.Node]]] = {}
        self._forms: dict[str, list[Form]] = {}
        self._uses: tuple[NameUse, ...] | None = None
        self._variables: list[tuple[Form, dict[str, list[VariableAt]]]] | None = None
        self._kinds: tuple[NamedKind, ...] | None = None
        self._by_name: dict[tuple[Use, str], list[NameUse]] | None = None
        for form in (*library.forms, *library.tests):
            self._forms.setdefault(form.span.file, []).append(form)
            self._add(form, form, form)
        for forms in self._forms.values():
            forms.sort(key=lambda form: form.span.start)

    def of(self, kind: type[N]) -> Sequence[Occurrence[N]]:
        """Return all nodes of one type, in the order of the text."""
        made = self._made.get(kind)
        if made is None:
            made = [Occurrence(*row) for row in self._rows.get(kind, ())]
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
        """Return the places where a name is used in one way, in the order of uses."""
        if self._by_name is None:
            self._by_name = {}
            for one in self.uses():
                self._by_name.setdefault((one.use, one.name), []).append(one)
        return self._by_name.get((use, name), ())

    def uses(self) -> Sequence[NameUse]:
        """Return each place where a declared name is used; gathered once."""
        if self._uses is None:
            self._uses = tuple(self._gathered())
        return self._uses

    def variables(self) -> Sequence[tuple[Form, Mapping[str, Sequence[VariableAt]]]]:
        """Return the forms that have variables, with these by name; gathered once."""
        if self._variables is None:
            names: dict[str, list[VariableAt]] = {}
            self._variables = []
            last: Form | None = None
            for row in cast(list[VariableAt], self._rows[nodes.Var]):
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
        """Return each place where a kind is named; gathered once."""
        if self._kinds is None:
            self._kinds = tuple(_named_kinds(self))
        return self._kinds

    def _gathered(self) -> Iterator[NameUse]:
        facts = cast(list[_FactAt], self._rows[nodes.Proposition])
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
    """The part of a node that an offset lies in."""
    for field in CHILDREN[type(node)]:
        value = getattr(node, field)
        for child in value if type(value) is tuple else (value,):
            if child is not None and child.span.start <= offset < child.span.end:
                return cast(nodes.Node, child)
    return None


def _run(run: Pass) -> Index:
    return Index(run.library)


INDEX = Fact(_run)
"""Gathers every node of the library by its type."""


Uses = Counter[tuple[Use, str]]
"""How often a name is used in one way, be it declared or not."""


def _count(run: Pass) -> Uses:
    return Counter([(one.use, one.name) for one in run.result(INDEX).uses()])


USES = Fact(_count)
"""Counts how often each name is used."""


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
    """A step takes every output; a rule and a test need not name any."""
    goal, parent = found.node, found.parent
    outputs: int | None = len(goal.outputs)
    if type(parent) is nodes.Succeeds:
        outputs = len(parent.outputs) or None
    elif type(parent) is not nodes.Step:
        outputs = outputs or None
    return NameUse("goal", goal.name, len(goal.args), goal, found.owner, outputs)


def _row_uses(row: nodes.ScriptRow, owner: Form) -> Iterator[NameUse]:
    """The facts of a row, of which its node alone tells which are erased."""
    for fact in row.asserts:
        yield NameUse("asserted", fact.name, len(fact.args), fact, owner)
    for fact in row.erases:
        yield NameUse("erased", fact.name, len(fact.args), fact, owner)


def _use(fact: nodes.Proposition, parent: nodes.Node) -> Use | None:
    """Say how a proposition in `parent` is used; None where `parent` tells better."""
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
"""The uses of propositions that their parents alone tell; all others are tests."""

_SENT: Mapping[type[nodes.Pattern], Use] = {
    nodes.Request: "primitive",
    nodes.Datum: "datum",
    nodes.Skill: "skill",
    nodes.Signal: "event",
}
"""The uses of what is sent to a world or comes from it."""
