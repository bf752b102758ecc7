"""Formulas to generated Python: one function per kind of formula.

A formula becomes a function that finds its solutions in the order semantics 2
promises: `and` is nested loops, left to right; `or` and long conjunctions become
generators of their own, or, where nothing follows, functions that end as theirs does;
`not` becomes one that stops at a first solution. The result
depends on which variables are bound beforehand, so a formula is compiled once for
each such set that occurs (`rapc.compiler.query.query`), and one that uses a variable
which only some branch of an `or` before it binds is written once for either case.

Terms and facts have modules of their own. Generated code is handed a context `ctx`
(see `rapc.compiler.query.context.Context`) when a query meets its memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from rapc.base.values import is_number
from rapc.compiler.query import facts
from rapc.compiler.query.code import MAX_LOOPS, Ending, Scope
from rapc.compiler.query.plan_steps import Way
from rapc.compiler.query.term_code import Clause, arguments, attempt, known_value, match
from rapc.ir import nodes
from rapc.ir.walk import CHILDREN


def solve(
    clause: Clause,
    scope: Scope,
    formula: nodes.Formula,
    answer: Callable[[Scope], str],
) -> None:
    """Write a formula with which a function ends, and close the function.

    `answer` is the expression for a solution. The branches of an `or` that nothing
    follows become functions that end in the same way.
    """
    *before, last = [nodes.Truth(True), *_conjuncts(formula)]
    write(clause, scope, nodes.And(tuple(before)))
    if not isinstance(last, nodes.Or) or not last.parts:
        write(clause, scope, last)
        scope.finish(answer(scope))
        scope.close()
        return
    clause.note(last, Way.EITHER)
    clause.emitter.depth += 1
    for branch in last.parts:
        inner = scope.child("either", scope.known, scope.ending)
        solve(clause, inner, branch, answer)
        scope.hand_on(scope.call(inner))
    clause.emitter.depth -= 1
    scope.close()


def write(clause: Clause, scope: Scope, formula: nodes.Formula) -> None:
    """Append the code of a formula; what follows runs once for each solution."""
    unsure = scope.maybe and type(formula) not in _CONNECTIVES
    if unsure and not scope.maybe.isdisjoint(variables(formula)):
        _in_either_case(clause, scope, formula)
        return
    _WRITERS[type(formula)](clause, scope, formula)


def variables(formula: nodes.Formula) -> tuple[str, ...]:
    """The named variables a formula could bind or uses, in the order of the text."""
    found: dict[str, None] = {}
    _gather(formula, found)
    return tuple(found)


def _gather(node: nodes.Node, found: dict[str, None]) -> None:
    """Add the named variables in a node."""
    if type(node) is nodes.Var:
        if node.name != "?":
            found[node.name] = None
        return
    for field in CHILDREN[type(node)]:
        part = getattr(node, field)
        for child in part if type(part) is tuple else (part,):
            _gather(child, found)


# --- connectives ---------------------------------------------------------------


def _truth(clause: Clause, scope: Scope, formula: nodes.Truth) -> None:
    if not formula.value:
        clause.note(formula, Way.NEVER)
        scope.line(scope.skip)


def _and(clause: Clause, scope: Scope, formula: nodes.And) -> None:
    parts = list(_conjuncts(formula))
    for at, part in enumerate(parts):
        if scope.loops >= MAX_LOOPS:
            _through(clause, scope, "rest", [nodes.And(tuple(parts[at:]))])
            return
        write(clause, scope, part)


def _conjuncts(formula: nodes.Formula) -> Iterator[nodes.Formula]:
    stack: list[nodes.Formula] = [formula]
    while stack:
        top = stack.pop()
        if isinstance(top, nodes.And):
            stack.extend(reversed(top.parts))
        else:
            yield top


def _or(clause: Clause, scope: Scope, formula: nodes.Or) -> None:
    clause.note(formula, Way.EITHER)
    _through(clause, scope, "either", formula.parts)


def _through(
    clause: Clause, scope: Scope, prefix: str, branches: Sequence[nodes.Formula]
) -> None:
    """Write branches as one generator and loop over what it yields."""
    if not branches:
        scope.line(scope.skip)
        return
    needed = [name for branch in branches for name in variables(branch)]
    inner = scope.child(prefix, needed, Ending.EACH)
    writers = [inner.child(prefix, inner.parameters, Ending.EACH) for _ in branches]
    clause.emitter.depth += len(branches) > 1
    for writer, branch in zip(writers, branches, strict=True):
        write(clause, writer, branch)
    clause.emitter.depth -= len(branches) > 1
    exports = _exports(scope, writers, needed)
    for writer in writers:
        _export(writer, exports)
        inner.line(f"yield from {inner.call(writer)}")
    inner.close()
    _loop(scope, scope.call(inner), exports, writers)


def _in_either_case(clause: Clause, scope: Scope, formula: nodes.Formula) -> None:
    """Leave a formula to a query of its own, compiled for what turns out to be bound.

    Writing it here for each case would take two to the number of such variables.
    """
    names = variables(formula)
    clause.note(formula, Way.LATER)
    known = scope.bound | scope.maybe
    values = [scope.local(name) if name in known else "UNBOUND" for name in names]
    later = clause.emitter.constant(clause.later(formula))
    listed = "".join(f"{value}, " for value in values)
    unsure = [name for name in names if name not in scope.bound]
    targets = dict.fromkeys(names, "_")
    for name in unsure:
        old = name in scope.maybe
        targets[name] = scope.rename(name) if old else scope.local(name)
    scope.loop(
        f"for {''.join(f'{t}, ' for t in targets.values())} "
        f"in {later}.extended(ctx, ({listed})):"
    )
    scope.bound.update(unsure)
    scope.maybe.difference_update(unsure)


def _exports(
    scope: Scope, writers: Sequence[Scope], names: Iterable[str]
) -> Sequence[str]:
    """The names that generators have to hand out, as some of them may bind them."""
    return [
        name
        for name in dict.fromkeys(names)
        if name not in scope.bound and any(name in w.bound | w.maybe for w in writers)
    ]


def _loop(
    scope: Scope, call: str, exports: Sequence[str], writers: Sequence[Scope]
) -> None:
    """Loop over what generators yield, and take note of what they have bound."""
    targets = "".join(
        f"{scope.rename(n) if n in scope.maybe else scope.local(n)}, " for n in exports
    )
    scope.loop(f"for {f'({targets})' if targets else '_'} in {call}:")
    for name in exports:
        surely = all(name in writer.bound for writer in writers)
        (scope.bound if surely else scope.maybe).add(name)
        if surely:
            scope.maybe.discard(name)


def _export(writer: Scope, exports: Sequence[str]) -> None:
    for name in exports:
        if name not in writer.bound | writer.maybe:
            writer.line(f"{writer.local(name)} = UNBOUND")
    writer.finish(writer.values(exports))
    writer.close()


def _not(clause: Clause, scope: Scope, formula: nodes.Not) -> None:
    clause.note(formula, Way.NEITHER)
    inner = scope.child("no", variables(formula.part), Ending.ANY)
    clause.emitter.depth += 1
    solve(clause, inner, formula.part, lambda _: "True")
    clause.emitter.depth -= 1
    scope.refuse(scope.call(inner))


# --- tests -----------------------------------------------------------------------


def _compare(clause: Clause, scope: Scope, formula: nodes.Compare) -> None:
    clause.note(formula, Way.TEST)
    args = arguments(clause, scope, (formula.left, formula.right))
    if args is None:
        return
    left, right = args
    if formula.op == "=":
        scope.refuse(f"{left} != {right}")
    elif formula.op == "n=":
        scope.refuse(f"{left} == {right}")
    else:
        numbers = [
            f"type({known}) in NUMBERS"
            for known, term in zip(args, (formula.left, formula.right), strict=True)
            if not (isinstance(term, nodes.Const) and is_number(term.value))
        ]
        scope.require(" and ".join([*numbers, f"{left} {formula.op} {right}"]))


def _set_test(clause: Clause, scope: Scope, formula: nodes.SetTest) -> None:
    clause.note(formula, Way.TEST)
    args = arguments(clause, scope, formula.args)
    if args is None:
        return
    members = attempt(clause, scope, f"set_members({args[0]})")
    if formula.test == "member":
        scope.require(f"{args[1]} in {members}")
    else:
        scope.refuse(members)


def _history(clause: Clause, scope: Scope, formula: nodes.HistoryTest) -> None:
    clause.note(formula, Way.TEST)
    if formula.query == "method-tried":
        args = arguments(clause, scope, formula.args)
        if args is not None:
            scope.require(f"ctx.method_tried({args[0]})")
        return
    *key, wanted = formula.args
    known = arguments(clause, scope, key)
    if known is None:
        return
    asked = f"ctx.last_result({', '.join(known)})"
    result = clause.emitter.fresh("t")
    scope.line(f"{result} = {asked}")
    scope.refuse(f"{result} is None")
    match(clause, scope, wanted, result)


def _sensor_name(clause: Clause, scope: Scope, formula: nodes.SensorName) -> None:
    item = known_value(clause, scope, formula.item)
    if item is None:
        clause.note(formula, Way.ITEMS)
        local = clause.emitter.fresh("t")
        scope.loop(f"for {local} in ctx.accessible_items():")
        match(clause, scope, formula.item, local)
        match(clause, scope, formula.value, clause.emitter.constant("true"))
        return
    clause.note(formula, Way.TEST)
    state = clause.emitter.fresh("t")
    scope.line(f"{state} = 'true' if ctx.is_accessible({item}) else 'false'")
    match(clause, scope, formula.value, state)


def _count(clause: Clause, scope: Scope, formula: nodes.Count) -> None:
    clause.note(formula, Way.TEST)
    args = arguments(clause, scope, (formula.kind, formula.place))
    if args is None:
        return
    size = clause.emitter.fresh("t")
    scope.line(f"{size} = ctx.count({args[0]}, {args[1]})")
    match(clause, scope, formula.number, size)


_CONNECTIVES = (nodes.And, nodes.Or, nodes.Not, nodes.Truth)

_WRITERS: dict[type, Callable[..., None]] = {
    nodes.Truth: _truth,
    nodes.And: _and,
    nodes.Or: _or,
    nodes.Not: _not,
    nodes.Compare: _compare,
    nodes.SetTest: _set_test,
    nodes.HistoryTest: _history,
    nodes.SensorName: _sensor_name,
    nodes.Count: _count,
    nodes.Proposition: facts.pattern,
    nodes.Believe: facts.believe,
}
