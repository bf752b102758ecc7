"""Inferred kinds of variables and of RAP inputs without a declared kind.

A variable at an argument with a declared kind has a value of that kind. The kinds
inferred for the inputs of a RAP apply to the steps that call the RAP, and from these
steps to the variables of the calling RAPs. The inference runs for three rounds.

Only formulas that hold together are combined: the conjuncts of one clause, or the
conjuncts of `repeat-while` and a context with the steps or the request of the method. A
branch of an `or` is left out, because an input may have a different kind in each
branch. Kinds that two methods infer differently for an input are left out, too.

`item` is any name. The values of a closed kind may be items, too. If all uses in the
library but one distinguish the closed kind from `item`, that use counts as a fault.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import Literal

import msgspec

from rapc.analysis.check import Fact, Pass, RapFact
from rapc.analysis.facts.logic import literals
from rapc.analysis.facts.statistics import LIMITS
from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.walk import steps
from rapc.library.kinds import Kinds
from rapc.library.signatures import Signatures


class Learned(msgspec.Struct, frozen=True, gc=False):
    """A kind, and the place that implies the kind."""

    kind: str
    span: Span


class KindClash(msgspec.Struct, frozen=True):
    """A variable of one kind at a place that requires another kind."""

    variable: nodes.Var
    #: The kind that the place requires.
    wanted: str
    #: The kind of the variable, with the other place that implies the kind.
    known: Learned
    #: The list that contains the variable.
    use: nodes.Pattern | nodes.Goal
    #: The top-level form.
    form: nodes.TopForm
    #: The closed kind whose values seem not to be items; None if the kinds differ.
    no_items: str | None = None


class InferredKinds(msgspec.Struct, frozen=True):
    """The inferred kinds of a library."""

    #: By RAP: for each input the inferred kind, or None.
    inputs: Mapping[str, Sequence[Learned | None]]
    clashes: Sequence[KindClash]


_Node = nodes.Pattern | nodes.Goal

_Told = Sequence[tuple[nodes.Var, Learned]]
"""Variables with the kinds that a use requires."""


class _Use(msgspec.Struct, frozen=True, gc=False):
    """A list with variables."""

    node: _Node
    #: What the declarations require; None if inferred kinds of inputs may add to it.
    told: _Told | None


_Scope = list[_Use]


def _run(run: Pass) -> InferredKinds:
    if not run.library.kinds:
        return InferredKinds({}, ())
    learning = _Learning(run.signatures)
    raps = [form for form in run.library.forms if isinstance(form, nodes.DefineRap)]
    scopes = [(rap, run.of(_SCOPES, rap)) for rap in raps]
    for _ in range(LIMITS.kind_rounds):
        if not learning.learn(scopes):
            break
    clashes = [one for rap, there in scopes for one in learning.clashes(rap, there)]
    often = Counter(one.no_items for one in clashes)
    return InferredKinds(
        learning.inputs,
        tuple([c for c in clashes if c.no_items is None or often[c.no_items] == 1]),
    )


INFERRED = Fact(_run)
"""The kinds of variables and inputs without a declared kind."""


def _scopes_of(run: Pass, rap: nodes.DefineRap) -> list[_Scope]:
    uses = _Learning(run.signatures).uses
    return [uses(one) for one in _scopes(rap)]


_SCOPES = RapFact(_scopes_of)
"""The uses of variables in the clauses and methods of a RAP."""


# --- formulas that hold together ------------------------------------------------------


def _scopes(rap: nodes.DefineRap) -> Iterator[list[_Node]]:
    handed: list[_Node] = []
    for clause, formula in clauses.held(clauses.RAP, rap):
        if clause.hands_on:
            handed += _facts(formula)
        else:
            yield _facts(formula)
    for method in rap.methods:
        scope: list[_Node] = [*handed, *method.notations]
        scope += (*method.claims, *method.skills)
        for _, formula in clauses.held(clauses.METHOD, method):
            scope += _facts(formula)
        if isinstance(method.body, nodes.Primitive):
            scope.append(method.body.request)
        for step in steps(method):
            scope.append(step.goal)
            for note in step.annotations:
                if isinstance(note, nodes.For) and note.formula is not None:
                    scope += _facts(note.formula)
        yield scope


def _facts(formula: nodes.Formula) -> list[_Node]:
    """Return the facts of a formula outside the branches of an `or`."""
    found: list[_Node] = []
    waiting = [formula]
    while waiting:
        for literal in literals(waiting.pop()):
            here = literal.formula
            if isinstance(here, nodes.Believe):
                found.append(here.pattern)
            elif isinstance(here, nodes.Proposition):
                found.append(here)
            elif isinstance(here, nodes.And | nodes.Not):
                waiting.append(here)
    return found


# --- inference ------------------------------------------------------------------------


class _Learning:
    """The kinds of the inputs of RAPs inferred so far."""

    def __init__(self, signatures: Signatures) -> None:
        self.inputs: dict[str, Sequence[Learned | None]] = {}
        #: The RAPs with new kinds in the last round; None before the first round.
        self._new: set[str] | None = None
        self._signatures = signatures
        self._kinds: Kinds = signatures.kinds

    def uses(self, scope: Iterable[_Node]) -> _Scope:
        """Return the uses of a scope that require, or may require, kinds."""
        found: _Scope = []
        for node in scope:
            if isinstance(node, nodes.Goal):
                found.append(_Use(node, None))
            elif told := self._told(node):
                found.append(_Use(node, told))
        return found

    def learn(self, scopes: Sequence[tuple[nodes.DefineRap, Sequence[_Scope]]]) -> bool:
        """Infer the kinds of inputs from uses; return whether a kind is new."""
        before, self._new = self._new, set()
        for rap, there in scopes:
            if before is not None and not self._calls(there, before | self._new):
                continue
            told: dict[str, list[Learned]] = {}
            for scope in there:
                for use in scope:
                    for variable, learned in self._required(use):
                        _add(told.setdefault(variable.name, []), learned)
            declared = {one.variable for one in rap.kinds}
            found = [
                None if v.name in declared else self._most_general(told.get(v.name, ()))
                for v in rap.inputs
            ]
            if found != self.inputs.get(rap.name, [None] * len(found)):
                self._new.add(rap.name)
            self.inputs[rap.name] = found
        return bool(self._new)

    def _calls(self, scopes: Iterable[_Scope], names: Container[str]) -> bool:
        """Return whether a goal in some scopes names one of some RAPs."""
        return any(
            use.told is None and use.node.name in names
            for scope in scopes
            for use in scope
        )

    def clashes(
        self, rap: nodes.DefineRap, scopes: Sequence[_Scope]
    ) -> Iterator[KindClash]:
        """Yield the variables with two kinds, at most one for each scope.

        The kinds that the clauses of a RAP imply for its inputs also apply in its
        methods.
        """
        inputs = {v.name for v in rap.inputs}
        declared = {one.variable: Learned(one.kind, one.span) for one in rap.kinds}
        base: dict[str, list[Learned]] = {}
        for at, scope in enumerate(scopes):
            known = {name: list(told) for name, told in base.items()}
            clash = self._clash(rap, scope, known, declared)
            if clash is not None:
                yield clash
            elif at < len(scopes) - len(rap.methods):
                base = {name: told for name, told in known.items() if name in inputs}

    def _clash(
        self,
        rap: nodes.DefineRap,
        scope: _Scope,
        known: dict[str, list[Learned]],
        declared: Mapping[str, Learned],
    ) -> KindClash | None:
        for use in scope:
            for variable, learned in self._required(use):
                own = declared.get(variable.name)
                earlier = [own] if own else known.setdefault(variable.name, [])
                if _has(earlier, learned.kind):
                    continue  # compared before
                for other in earlier:
                    no_items = self._no_items(other.kind, learned.kind)
                    apart = self._kinds.apart(other.kind, learned.kind)
                    told = own is not None and self._is_declared(use.node)
                    if no_items or (apart and not told):
                        return KindClash(
                            variable, learned.kind, other, use.node, rap, no_items
                        )
                earlier.append(learned)
        return None

    def _no_items(self, one: str, other: str) -> str | None:
        """Return the kind of two with values that are no items; the other is `item`."""
        if one == other or "item" not in (one, other):
            return None
        kind = other if one == "item" else one
        closed = self._kinds.values(kind) is not None
        return kind if closed and "item" not in self._kinds.above(kind) else None

    def _is_declared(self, use: _Node) -> bool:
        """Return whether the checks of kinds compare a declared variable with a use."""
        return not isinstance(use, nodes.Goal) or use.name not in self.inputs

    def _required(self, use: _Use) -> _Told:
        """Return the variables of a use with the kinds required so far."""
        return self._told(use.node) if use.told is None else use.told

    def _told(self, use: _Node) -> _Told:
        kinds = self._wanted(use)
        return [
            (term, Learned(kind, term.span))
            for term, kind in zip(use.args, kinds, strict=False)
            if kind is not None and isinstance(term, nodes.Var) and not term.anonymous
        ]

    def _wanted(self, use: _Node) -> Sequence[str | None]:
        """Return the required kinds of the arguments of a use; None where unknown."""
        table = self._signatures.table(_TABLES.get(type(use), "test"))
        declared = table.get(use.name)
        if declared is None or declared.args is None:
            return ()
        if declared.miscount(len(use.args)):
            return ()
        own = [arg.kind for arg in declared.args]
        if isinstance(use, nodes.Goal):
            # If a name has two definitions, the last counts here; `declared` is the
            # first.
            learned = self.inputs.get(use.name, ())
            for at, one in enumerate(learned[: len(own)]):
                if own[at] is None and one is not None:
                    own[at] = one.kind
        return own

    def _most_general(self, told: Sequence[Learned]) -> Learned | None:
        """Return the kind that includes all other kinds; None without that kind."""
        for one in told:
            if all(
                one.kind in (other.kind, *self._kinds.above(other.kind))
                for other in told
            ):
                return one
        return None


def _has(told: Iterable[Learned], kind: str) -> bool:
    for one in told:  # noqa: SIM110  # faster than `any`
        if one.kind == kind:
            return True
    return False


def _add(told: list[Learned], new: Learned) -> None:
    """Add a kind, unless the kind is known from an earlier place."""
    if not _has(told, new.kind):
        told.append(new)


_TABLES: Mapping[type, Literal["goal", "primitive", "skill"]] = {
    nodes.Goal: "goal",
    nodes.Request: "primitive",
    nodes.Skill: "skill",
}
"""The types of uses whose names are not predicates."""
