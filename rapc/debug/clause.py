"""A clause asked conjunct by conjunct: how far it holds, and what is missing where not.

Asking leaves no mark on the run: no event, no fault, no draw.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice

import msgspec

from rapc.base.resources import Value
from rapc.base.values import Fact, format_atom, format_list
from rapc.compiler.query.query import Query
from rapc.ir import nodes
from rapc.runtime.machine import Machine
from rapc.runtime.memory.memory import EXTERNAL
from rapc.runtime.memory.store import NEVER
from rapc.runtime.state.task import Env, Task
from rapc.world import Time

MOST = 100
"""How many solutions are counted."""

_NEAR = 3
"""How many facts are named that come near to what is missing."""


class Support(msgspec.Struct, frozen=True):
    """A fact that a clause rests on."""

    fact: Fact
    #: When it was last asserted; None if it never was, or is a default.
    since: Time | None


class ConjunctAsked(msgspec.Struct, frozen=True):
    """A conjunct, and how many solutions all up to it have."""

    text: str
    place: str
    #: At most `MOST`.
    solutions: int


class ClauseAsked(msgspec.Struct, frozen=True):
    """What comes of asking a clause."""

    #: The clause in words.
    clause: str
    #: The conjuncts, up to the first without a solution.
    parts: tuple[ConjunctAsked, ...]
    #: How many conjuncts there are.
    count: int
    #: What the first solution adds; where there is none, what the variables of the
    #: conjunct that fails were bound to.
    bindings: Mapping[str, Value] = {}
    #: What is wrong with the conjunct that fails, where there is more to say.
    note: str = ""
    #: Facts, each of which would let the conjunct that fails have a solution.
    missing: tuple[Fact, ...] = ()
    #: Facts that keep a negated conjunct from holding.
    unwanted: tuple[Fact, ...] = ()
    #: Facts that come near to what is missing.
    near: tuple[Fact, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the whole clause has a solution."""
        return len(self.parts) == self.count and all(
            one.solutions for one in self.parts
        )


def ask(
    machine: Machine, clause: str, query: Query, asker: Task | None, env: Env
) -> ClauseAsked:
    """Ask a clause as a task would, conjunct by conjunct.

    Args:
        machine: the run's.
        clause: the clause in words.
        query: what is asked.
        asker: the task whose clause it is; None for a question of the user.
        env: what is bound beforehand.
    """
    context = machine.noting
    context.begin(asker)
    parts: list[ConjunctAsked] = []
    solutions: list[dict[str, Value]] = [{}]
    beginnings = query.beginnings()
    for part, up_to_it, text in beginnings:
        context.go_on()
        found = list(islice(up_to_it.solutions(context, env), MOST))
        place = machine.library.compiler.row(part.span)
        parts.append(ConjunctAsked(text, place, len(found)))
        if not found:
            return _failing(
                machine, clause, part, parts, len(beginnings), env, solutions
            )
        solutions = found
    return ClauseAsked(clause, tuple(parts), len(beginnings), solutions[0])


def _failing(
    machine: Machine,
    clause: str,
    part: nodes.Formula,
    parts: list[ConjunctAsked],
    count: int,
    env: Env,
    solutions: list[dict[str, Value]],
) -> ClauseAsked:
    """Return an answer whose last conjunct fails, with the facts near to it."""
    known = [{**env, **found} for found in solutions]
    negated = isinstance(part, nodes.Not)
    inner = part.part if isinstance(part, nodes.Not) else part
    if isinstance(inner, nodes.Believe):
        inner = inner.pattern
    missing: tuple[Fact, ...] = ()
    unwanted: tuple[Fact, ...] = ()
    near: tuple[Fact, ...] = ()
    if isinstance(inner, nodes.Proposition) and _in_memory(machine, inner):
        patterns = [with_values(machine, inner, one) for one in known]
        if negated:
            unwanted = tuple(_matching(machine, patterns))
        else:
            ground = [_full(pattern) for pattern in patterns]
            missing = tuple(dict.fromkeys([fact for fact in ground if fact]))[:_NEAR]
            near = tuple(_nearest(machine, patterns))
    return ClauseAsked(
        clause=clause,
        parts=tuple(parts),
        count=count,
        bindings={n: v for n, v in known[0].items() if n in Query.names(part)},
        note=machine.noting.noted,
        missing=missing,
        unwanted=unwanted,
        near=near,
    )


def _in_memory(machine: Machine, part: nodes.Proposition) -> bool:
    return part.name in machine.library.signatures.relations


Pattern = tuple[object, ...]
"""A fact with None where nothing is known."""


def with_values(
    machine: Machine, part: nodes.Proposition, env: Mapping[str, Value]
) -> Pattern:
    """Return a proposition with the values that variables have, None for the others."""
    relation = machine.library.signatures.relations[part.name]
    values: list[object] = []
    for term in relation.full(part.args):
        if isinstance(term, nodes.Const):
            values.append(term.value)
        elif isinstance(term, nodes.Var):
            values.append(env.get(term.name))
        else:
            values.append(None)
    place = machine.memory.place
    if part.name == "location" and values[-1:] == [EXTERNAL] and place is not None:
        values[-1] = place
    known: tuple[object, ...] = machine.memory.canonical((part.name, *values))
    return known


def _full(pattern: Pattern) -> Fact | None:
    """Return a pattern as a fact if nothing in it is left open."""
    return None if None in pattern else pattern  # type: ignore[return-value]  # atoms


def _matching(machine: Machine, patterns: list[Pattern]) -> Iterator[Fact]:
    """Iterate over the facts that some patterns match, each once."""
    seen: dict[Fact, None] = {}
    for pattern in patterns[:_NEAR]:
        for fact in machine.memory.facts.matching(pattern):  # type: ignore[arg-type]
            seen.setdefault(fact)
    return islice(iter(seen), _NEAR)


def _nearest(machine: Machine, patterns: list[Pattern]) -> Iterator[Fact]:
    """Iterate over the facts that agree with the first pattern in most arguments."""
    pattern = patterns[0]
    facts = list(machine.memory.facts.table(str(pattern[0])).stamps)
    agreeing = [(_agreement(pattern, fact), -at, fact) for at, fact in enumerate(facts)]
    agreeing = [one for one in agreeing if one[0] > 0]
    agreeing.sort(key=lambda one: one[:2], reverse=True)
    return (fact for _, _, fact in agreeing[:_NEAR])


def _agreement(pattern: Pattern, fact: Fact) -> int:
    given = zip(pattern[1:], fact[1:], strict=False)
    return sum(1 for want, value in given if want is not None and want == value)


def supports(
    machine: Machine, formula: nodes.Formula, env: Mapping[str, Value]
) -> list[Support]:
    """Return the facts that make a formula hold, with these bindings, in its order."""
    found: dict[Fact, None] = {}
    stack = [formula]
    while stack:
        part = stack.pop()
        if isinstance(part, nodes.And | nodes.Or):
            stack.extend(reversed(part.parts))
        elif isinstance(part, nodes.Believe):
            stack.append(part.pattern)
        elif isinstance(part, nodes.Proposition):
            for fact in _rests_on(machine, part, env):
                found.setdefault(fact)
    return [support(machine, fact) for fact in found]


def _rests_on(
    machine: Machine, part: nodes.Proposition, env: Mapping[str, Value]
) -> list[Fact]:
    """Return the first fact that a proposition matches; those of a named query."""
    query = machine.library.library.queries.get(part.name)
    if query is not None:
        given = zip(query.args, part.args, strict=False)
        inner: dict[str, Value] = {}
        for parameter, term in given:
            value = term.value if isinstance(term, nodes.Const) else None
            if isinstance(term, nodes.Var):
                value = env.get(term.name)  # type: ignore[assignment]
            if value is not None:
                inner[parameter.variable.name] = value
        return [one.fact for one in supports(machine, query.formula, inner)]
    if not _in_memory(machine, part):
        return []
    facts = machine.memory.facts.matching(with_values(machine, part, env))  # type: ignore[arg-type]
    return facts[:1]


def support(machine: Machine, fact: Fact) -> Support:
    """Return a fact with the time of its last assertion."""
    stamp = machine.memory.facts.stamp(fact)
    return Support(fact, None if stamp is None or stamp == NEVER else stamp)


def clause_in_lines(asked: ClauseAsked, indent: str = "  ") -> Iterator[str]:
    """Say in lines how far a clause holds, and what is missing."""
    yield f"{asked.clause}: {'holds' if asked.holds else 'does not hold'}"
    for part in asked.parts:
        told = str(part.solutions) if part.solutions < MOST else f"{MOST} or more"
        mark = " " if part.solutions else ">"
        yield f"{indent}{mark} {part.text}: {told}"
    left = asked.count - len(asked.parts)
    if left:
        yield f"{indent}  and {left} more, not asked"
    pairs = " ".join(f"{n} {format_atom(v)}" for n, v in asked.bindings.items())
    if pairs:
        yield f"{indent}with {pairs}"
    if asked.note:
        yield f"{indent}{asked.note}"
    for fact in asked.missing:
        yield f"{indent}would hold with {format_list(fact)}"
    for fact in asked.unwanted:
        yield f"{indent}is kept from holding by {format_list(fact)}"
    for fact in asked.near:
        yield f"{indent}near to it: {format_list(fact)}"


def in_a_line(asked: ClauseAsked) -> str:
    """Say in one line whether a clause holds, else at which conjunct it fails."""
    if asked.holds:
        pairs = " ".join(f"{n} {format_atom(v)}" for n, v in asked.bindings.items())
        return f"holds with {pairs}" if pairs else "holds"
    last = asked.parts[-1]
    told = f"{last.text} fails, conjunct {len(asked.parts)} of {asked.count}"
    pairs = " ".join(f"{n} {format_atom(v)}" for n, v in asked.bindings.items())
    told += f", with {pairs}" if pairs else ""
    return f"{told} ({asked.note})" if asked.note else told
