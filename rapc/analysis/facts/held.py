"""What holds when a method is chosen, and when each of its steps begins.

When a method is chosen, its context holds, the clauses that every method requires hold,
and the contexts before `otherwise` have no solution. A step that begins later finds
these facts as far as no other step of the method may change them. It also finds what
the steps before it guarantee, and what other steps protect for it.

The world may change a fact meanwhile, and another task may. A finding that rests on
these facts is therefore about the plan of the author, not about every run.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Iterator, Sequence, Set
from functools import cached_property

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.facts.effects import EFFECTS, GUARANTEED
from rapc.analysis.facts.logic import (
    Literal,
    apart,
    asked_by,
    fact_name,
    is_never,
    literals,
)
from rapc.analysis.facts.statistics import LIMITS
from rapc.analysis.facts.task_nets import Net
from rapc.ir import nodes
from rapc.ir.walk import steps, subformulas, substitute
from rapc.library.library import Library


def of_memory(found: Iterable[Literal]) -> list[Literal]:
    """Return the literals that do not depend on the task that evaluates them."""
    return [
        one
        for one in found
        if type(one.formula) is nodes.Proposition
        or not any(isinstance(part, _OF_TASK) for part in subformulas(one.formula))
    ]


_OF_TASK = nodes.HistoryTest | nodes.SetTest | nodes.Otherwise


def at_choice(
    run: Pass, rap: nodes.DefineRap, method: nodes.Method, given: Container[str]
) -> list[Literal]:
    """Return the facts that hold when a method is chosen.

    Variables of clauses without bindings, and of other methods, have new names.
    """
    found: list[Literal] = []
    waits = rap.monitor_state if is_never(rap.succeed) else None
    for word, formula in (("monitor", waits), ("required", rap.preconditions)):
        if formula is not None:
            found += literals(apart(formula, given, f"@{word}"))
    found += literals(rap.repeat_while)
    found += _context(rap, method, given)
    return with_queries(run.library, of_memory(found))


def _context(
    rap: nodes.DefineRap, method: nodes.Method, given: Container[str]
) -> Iterator[Literal]:
    """Yield the literals of a context; `otherwise` denies the contexts before."""
    own = literals(method.context)
    yield from own
    if not any(isinstance(one.formula, nodes.Otherwise) and one.holds for one in own):
        return
    for at, other in enumerate(rap.methods):
        if other is method or other.context is None:
            return
        parts = other.context.parts if isinstance(other.context, nodes.And) else ()
        asked = [p for p in parts if not isinstance(p, nodes.Otherwise)]
        whole = other.context
        if len(asked) < len(parts):
            whole = nodes.And(tuple(asked), span=whole.span)
        elif isinstance(whole, nodes.Otherwise):
            return
        for one in literals(nodes.Not(apart(whole, given, f"@{at}"), span=whole.span)):
            yield _simple(one)


def _simple(one: Literal) -> Literal:
    """Return a denied conjunction of one part, or a denied denial, more simply."""
    formula = one.formula
    if not one.holds and isinstance(formula, nodes.And) and len(formula.parts) == 1:
        return _simple(Literal(formula.parts[0], False))
    if not one.holds and isinstance(formula, nodes.Not):
        return Literal(formula.part, True)
    return one


def with_queries(library: Library, found: Iterable[Literal]) -> list[Literal]:
    """Return literals, and after each query that they use the formula of the query."""
    found = list(found)
    if not any(fact_name(one) in library.queries for one in found):
        return found
    every: list[Literal] = []
    waiting = [(one, 0) for one in reversed(found)]
    while waiting:
        one, depth = waiting.pop()
        every.append(one)
        fact = one.formula
        if not isinstance(fact, nodes.Proposition) or depth > LIMITS.query_depth:
            continue
        query = library.queries.get(fact.name)
        if query is None or len(query.args) != len(fact.args):
            continue
        names = {arg.variable.name for arg in query.args}
        terms = {
            arg.variable.name: term
            for arg, term in zip(query.args, fact.args, strict=True)
        }
        inner = substitute(apart(query.formula, names, f"@{len(every)}"), terms)
        inside = literals(inner) if one.holds else [_simple(Literal(inner, False))]
        waiting += [(part, depth + 1) for part in reversed(inside)]
    return every


class Beginnings:
    """The facts that hold when the steps of a method begin.

    Args:
        run: the pass.
        rap: the RAP of the method.
        method: the method, with a task-net.
        net: the order of the steps.
        chosen: the facts that hold when the method is chosen.
        given: the inputs and resources of the RAP.
    """

    def __init__(
        self,
        run: Pass,
        rap: nodes.DefineRap,
        method: nodes.Method,
        net: Net,
        chosen: Sequence[Literal],
        given: Container[str],
    ) -> None:
        self._library = run.library
        self._asked = run.result(ASKED)
        self._effects = run.result(EFFECTS)
        self._guaranteed = run.result(GUARANTEED)
        self._steps = steps(method)
        self._net = net
        self._before, self._after = net.reach()
        self._chosen = [one for one in chosen if not _computes(one.formula)]
        always = [
            one
            for formula in (rap.constraints, method.constraints)
            if formula is not None
            for one in literals(apart(formula, given, "@always"))
        ]
        self._always = with_queries(run.library, of_memory(always))

    def about(self, at: int, names: Collection[str]) -> list[Literal]:
        """Return what holds of the facts of some names when a step begins."""
        found = self.surviving(self._of(names, self._chosen), at)
        found += self._of(names, self._always)
        found += self._of(names, self.protected(at))
        others = self._others(at)
        for name in sorted(names) if self._before[at] else ():
            there = self._brought.get(name, ())
            for by, one in there if len(there) <= LIMITS.steps_of_fact else ():
                if self._before[at] >> by & 1 and by not in self._net.early:
                    later = others & ~self._before[by] & ~(1 << by)
                    if not self._may_change(one, later):
                        found.append(one)
        return found

    def _of(self, names: Collection[str], facts: Iterable[Literal]) -> list[Literal]:
        """Return the facts that query a fact of some names."""
        return [one for one in facts if not self._names(one).isdisjoint(names)]

    def surviving(self, facts: Iterable[Literal], at: int) -> list[Literal]:
        """Return the facts that no other step may change before a step begins."""
        others = self._others(at)
        return [one for one in facts if not self._may_change(one, others)]

    def protected(self, at: int) -> list[Literal]:
        """Return the facts that other steps protect until a step begins."""
        return self._protected.get(at, [])

    def _others(self, at: int) -> int:
        """Return the steps that may run before a step begins, as bits."""
        return ((1 << len(self._steps)) - 1) & ~self._after[at] & ~(1 << at)

    @cached_property
    def _protected(self) -> dict[int, list[Literal]]:
        found: dict[int, list[Literal]] = {}
        for note in (note for step in self._steps for note in step.annotations):
            if isinstance(note, nodes.For) and note.formula is not None:
                facts = with_queries(self._library, of_memory(literals(note.formula)))
                found.setdefault(self._net.tags[note.tag], []).extend(facts)
        return found

    @cached_property
    def _brought(self) -> dict[str, list[tuple[int, Literal]]]:
        """By the name of a fact: the steps that guarantee such facts, and the facts."""
        found: dict[str, list[tuple[int, Literal]]] = {}
        for by, step in enumerate(self._steps):
            for one in with_queries(self._library, self._guaranteed.of(step.goal)):
                for name in self._names(one):
                    found.setdefault(name, []).append((by, one))
        return found

    @cached_property
    def _changing(self) -> tuple[dict[str, int], int]:
        """By the name of a fact, the steps that may change it; the unknown steps."""
        found: dict[str, int] = {}
        unknown = 0
        for by, step in enumerate(self._steps):
            changes = self._effects.changes(step.goal.name)
            if changes is None:
                unknown |= 1 << by
            for name in changes or ():
                found[name] = found.get(name, 0) | 1 << by
        return found, unknown

    def _names(self, one: Literal) -> Set[str]:
        return self._asked.names(one.formula)

    def _may_change(self, one: Literal, by: int) -> bool:
        """Return whether some of the steps, as bits, may change a literal."""
        if not by:
            return False
        changing, unknown = self._changing
        return bool(unknown & by) or any(
            changing.get(name, 0) & by for name in self._names(one)
        )


class Wanted(msgspec.Struct, frozen=True):
    """The literals of a clause that depend only on memory, with those of queries."""

    literals: Sequence[Literal]
    #: The names of the queried facts.
    names: Set[str]


class Asked:
    """What formulas query; each formula is looked at once.

    The formulas are kept, so that the `id` of each stays its own.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._names: dict[int, tuple[nodes.Formula, Set[str]]] = {}
        self._wanted: dict[int, tuple[nodes.Formula, Wanted]] = {}

    def names(self, formula: nodes.Formula) -> Set[str]:
        """Return the names of the facts that a formula queries, also by queries."""
        made = self._names.get(id(formula))
        if made is None:
            made = self._names[id(formula)] = (
                formula,
                asked_by(self._library, formula),
            )
        return made[1]

    def wanted(self, clause: nodes.Formula) -> Wanted:
        """Return the literals of a clause of the library."""
        made = self._wanted.get(id(clause))
        if made is None:
            found = with_queries(self._library, of_memory(literals(clause)))
            names = set[str]().union(*(self.names(one.formula) for one in found))
            made = self._wanted[id(clause)] = clause, Wanted(found, names)
        return made[1]


ASKED = Fact(lambda run: Asked(run.library))
"""What the formulas of the library query."""


def _computes(formula: nodes.Formula) -> bool:
    """Return whether a formula computes with the values of counters or sets."""
    return any(
        isinstance(term, nodes.Call)
        for part in subformulas(formula)
        if isinstance(part, nodes.Compare)
        for term in (part.left, part.right)
    )
