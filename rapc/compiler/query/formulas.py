"""Formulas to generated Python: the properties of each kind, in `_KINDS`.

The form of the code is described in the head of `rapc.compiler.query.query`. A writer
appends to a `FunctionWriter` the code that finds the solutions of its formula; code
that is appended later runs once for each solution. `watches` returns the changes that a
monitor of a formula listens to. To add a kind of formula, add its rule and its words to
the grammar, its node to `ir/nodes.py`, and a row to `_KINDS`.

Not here: facts and properties (`facts`), terms (`term_code`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rapc.base.values import is_number
from rapc.compiler.query import facts, named
from rapc.compiler.query.code import ResultMode
from rapc.compiler.query.function import MAX_LOOPS, FunctionWriter
from rapc.compiler.query.plan_steps import AccessPath
from rapc.compiler.query.term_code import argument_code, attempt, known_value, match
from rapc.compiler.watches import Watch, of_age, of_call, of_proposition, of_resources
from rapc.ir import nodes
from rapc.ir.schema import CHILDREN, CONNECTIVES
from rapc.ir.walk import variable_names
from rapc.library.signatures import Signatures


def solve(
    fn: FunctionWriter,
    formula: nodes.Formula,
    answer: Callable[[FunctionWriter], str],
) -> None:
    """Write a formula with which a function ends, and close the function.

    `answer` is the expression for a solution. The branches of a final `or` become
    functions that end in the same way.
    """
    *before, last = [nodes.Truth(True), *conjuncts(formula)]
    write(fn, nodes.And(tuple(before)))
    if not isinstance(last, nodes.Or) or not last.parts:
        write(fn, last)
        fn.return_solution(answer(fn))
        fn.close()
        return
    fn.code.note(last, AccessPath.EITHER)
    fn.code.depth += 1
    for branch in last.parts:
        inner = fn.child("either", fn.known, fn.mode)
        solve(inner, branch, answer)
        fn.return_all_of(fn.call(inner))
    fn.code.depth -= 1
    if fn.is_deep:
        fn.step_back()
    fn.close()


def write(fn: FunctionWriter, formula: nodes.Formula) -> None:
    """Append the code of a formula; later code runs once for each solution."""
    query = named.query_of(fn.code.signatures, formula)
    if query is not None and isinstance(formula, nodes.Proposition):
        named.write_use(fn, formula, query, write)
        return
    if type(formula) in CONNECTIVES:
        _KINDS[type(formula)].write(fn, formula)
        return
    names = variable_names(formula)
    if fn.maybe.isdisjoint(names):
        _KINDS[type(formula)].write(fn, formula)
    else:
        _in_either_case(fn, formula)
    fn.given.update(names)


# --- connectives ---------------------------------------------------------------


def _truth(fn: FunctionWriter, formula: nodes.Truth) -> None:
    if not formula.value:
        fn.code.note(formula, AccessPath.NEVER)
        fn.line(fn.skip)


def _and(fn: FunctionWriter, formula: nodes.And) -> None:
    parts = list(conjuncts(formula))
    for at, part in enumerate(parts):
        if fn.loops >= MAX_LOOPS:
            _through(fn, "rest", [nodes.And(tuple(parts[at:]))])
            return
        write(fn, part)


def conjuncts(formula: nodes.Formula) -> Iterator[nodes.Formula]:
    """Iterate over the conjuncts of a formula."""
    stack: list[nodes.Formula] = [formula]
    while stack:
        top = stack.pop()
        if isinstance(top, nodes.And):
            stack.extend(reversed(top.parts))
        else:
            yield top


def _or(fn: FunctionWriter, formula: nodes.Or) -> None:
    fn.code.note(formula, AccessPath.EITHER)
    if formula.parts:
        _through(fn, "either", formula.parts)
    else:
        fn.search("for _ in ():")


def _through(
    fn: FunctionWriter, prefix: str, branches: Sequence[nodes.Formula]
) -> None:
    """Write branches as one generator, and a loop over its results."""
    needed = [name for branch in branches for name in variable_names(branch)]
    inner = fn.child(prefix, needed, ResultMode.EACH)
    writers = [inner.child(prefix, inner.parameters, ResultMode.EACH) for _ in branches]
    fn.code.depth += len(branches) > 1
    for writer, branch in zip(writers, branches, strict=True):
        write(writer, branch)
    fn.code.depth -= len(branches) > 1
    exports = _exports(fn, writers, needed)
    for writer in writers:
        _export(writer, exports)
        inner.line(f"yield from {inner.call(writer)}")
    inner.close()
    _loop(fn, fn.call(inner), exports, writers, prefix == "either")


def _in_either_case(fn: FunctionWriter, formula: nodes.Formula) -> None:
    """Leave a formula to a separate query, compiled for the bindings at run time.

    Code for each case would grow by two to the number of possibly bound variables.
    """
    names = variable_names(formula)
    fn.code.note(formula, AccessPath.LATER)
    known = fn.bound | fn.maybe
    values = [fn.local(name) if name in known else "UNBOUND" for name in names]
    later = fn.code.constant(fn.code.later(formula))
    listed = "".join(f"{value}, " for value in values)
    unsure = [name for name in names if name not in fn.bound]
    targets = dict.fromkeys(names, "_")
    for name in unsure:
        old = name in fn.maybe
        targets[name] = fn.rename(name) if old else fn.local(name)
    opened = fn.search if _searches(fn, formula) else fn.loop
    opened(
        f"for {''.join(f'{t}, ' for t in targets.values())} "
        f"in {later}.extended(ctx, {fn.where}, ({listed})):"
    )
    fn.bound.update(unsure)
    fn.maybe.difference_update(unsure)


def _exports(
    fn: FunctionWriter, writers: Sequence[FunctionWriter], names: Iterable[str]
) -> Sequence[str]:
    """Return the names that the generators of branches must export."""
    return [
        name
        for name in dict.fromkeys(names)
        if name not in fn.bound and any(name in w.bound | w.maybe for w in writers)
    ]


def _searches(fn: FunctionWriter, formula: nodes.Formula) -> bool:
    """Return whether a part may have several solutions, by preceding text [L 2.71]."""
    if isinstance(formula, nodes.SensorName):
        return fn.is_open(formula.item)
    pattern = formula.pattern if isinstance(formula, nodes.Believe) else formula
    if not isinstance(pattern, nodes.Proposition):
        return False
    relation = fn.code.signatures.relations.get(pattern.name)
    if relation is None:
        return False
    args = relation.full(pattern.args)
    index = args[:-1] if relation.is_property else args
    return any(fn.is_open(arg) for arg in index)


def _loop(
    fn: FunctionWriter,
    call: str,
    exports: Sequence[str],
    writers: Sequence[FunctionWriter],
    is_or: bool,
) -> None:
    """Write a loop over the results of generators, and record their bindings.

    The generators are the branches of an `or`, or the rest of an `and`.
    """
    targets = "".join(
        f"{fn.rename(n) if n in fn.maybe else fn.local(n)}, " for n in exports
    )
    head = f"for {f'({targets})' if targets else '_'} in {call}:"
    if is_or:
        fn.search(head)
    else:
        fn.loop(head)
        fn.searches += writers[0].searches
    fn.given |= set.intersection(*(writer.given for writer in writers))
    for name in exports:
        surely = all(name in writer.bound for writer in writers)
        (fn.bound if surely else fn.maybe).add(name)
        if surely:
            fn.maybe.discard(name)


def _export(writer: FunctionWriter, exports: Sequence[str]) -> None:
    for name in exports:
        if name not in writer.bound | writer.maybe:
            writer.line(f"{writer.local(name)} = UNBOUND")
    writer.return_solution(writer.values(exports))
    writer.close()


def _not(fn: FunctionWriter, formula: nodes.Not) -> None:
    fn.code.note(formula, AccessPath.NEITHER)
    inner = fn.child("no", variable_names(formula.part), ResultMode.ANY)
    fn.code.depth += 1
    solve(inner, formula.part, lambda _: "True")
    fn.code.depth -= 1
    fn.skip_if(fn.call(inner))


# --- tests -----------------------------------------------------------------------


def _compare(fn: FunctionWriter, formula: nodes.Compare) -> None:
    fn.code.note(formula, AccessPath.TEST)
    args = argument_code(fn, (formula.left, formula.right))
    if args is None:
        return
    left, right = args
    if formula.op == "=":
        fn.skip_if(f"{left} != {right}")
    elif formula.op == "n=":
        fn.skip_if(f"{left} == {right}")
    else:
        numbers = [
            f"type({known}) in NUMBERS"
            for known, term in zip(args, (formula.left, formula.right), strict=True)
            if not (isinstance(term, nodes.Const) and is_number(term.value))
        ]
        fn.skip_unless(" and ".join([*numbers, f"{left} {formula.op} {right}"]))


def _is(fn: FunctionWriter, formula: nodes.Is) -> None:
    fn.code.note(formula, AccessPath.TEST)
    args = argument_code(fn, (formula.value,))
    if args is not None:
        match(fn, formula.variable, args[0])


def _set_test(fn: FunctionWriter, formula: nodes.SetTest) -> None:
    fn.code.note(formula, AccessPath.TEST)
    args = argument_code(fn, formula.args)
    if args is None:
        return
    members = attempt(fn, f"set_members({args[0]})")
    if formula.test == "member":
        fn.skip_unless(f"{args[1]} in {members}")
    else:
        fn.skip_if(members)


def _history(fn: FunctionWriter, formula: nodes.HistoryTest) -> None:
    fn.code.note(formula, AccessPath.TEST)
    if formula.query == "method-tried":
        args = argument_code(fn, formula.args)
        if args is not None:
            fn.skip_unless(f"ctx.method_tried({args[0]})")
        return
    *key, wanted = formula.args
    known = argument_code(fn, key)
    if known is None:
        return
    asked = f"ctx.last_result({', '.join(known)})"
    result = fn.code.fresh("t")
    fn.line(f"{result} = {asked}")
    fn.skip_if(f"{result} is None")
    match(fn, wanted, result)


def _sensor_name(fn: FunctionWriter, formula: nodes.SensorName) -> None:
    item = known_value(fn, formula.item)
    if item is None:
        fn.code.note(formula, AccessPath.ITEMS)
        local = fn.code.fresh("t")
        fn.search(f"for {local} in ctx.accessible_items():")
        match(fn, formula.item, local)
        match(fn, formula.value, fn.code.constant("true"))
        return
    fn.code.note(formula, AccessPath.TEST)
    state = fn.code.fresh("t")
    fn.line(f"{state} = 'true' if ctx.is_accessible({item}) else 'false'")
    match(fn, formula.value, state)


def _count(fn: FunctionWriter, formula: nodes.Count) -> None:
    fn.code.note(formula, AccessPath.TEST)
    args = argument_code(fn, (formula.kind, formula.place))
    if args is None:
        return
    size = fn.code.fresh("t")
    fn.line(f"{size} = ctx.count({args[0]}, {args[1]})")
    match(fn, formula.number, size)


class _Kind(NamedTuple):
    """A kind of formula."""

    #: Append its code.
    write: Callable[[FunctionWriter, Any], None]
    #: The changes that can change its result, except changes that its operands list.
    heard: Callable[[Any, Signatures], Iterable[Watch]] | None = None


_KINDS: Mapping[type, _Kind] = {
    nodes.Truth: _Kind(_truth),
    nodes.And: _Kind(_and),
    nodes.Or: _Kind(_or),
    nodes.Not: _Kind(_not),
    nodes.Compare: _Kind(_compare),
    nodes.Is: _Kind(_is),
    nodes.SetTest: _Kind(_set_test, lambda test, _: of_resources(test.args[:1])),
    nodes.HistoryTest: _Kind(_history),
    nodes.SensorName: _Kind(_sensor_name, lambda *_: [Watch(("know-sensor-name",))]),
    nodes.Count: _Kind(
        _count,
        lambda *_: [Watch((word,)) for word in ("location", "class", "external")],
    ),
    nodes.Proposition: _Kind(facts.write_pattern, of_proposition),
    nodes.Believe: _Kind(facts.write_believe, lambda believe, _: of_age(believe.age)),
}


def watches(formula: nodes.Formula, signatures: Signatures) -> tuple[Watch, ...]:
    """Return all changes that can change the result of a formula, each once."""
    found: dict[Watch, None] = {}
    stack: list[nodes.Node] = [*named.spelled_out(formula, signatures)]
    stack.reverse()
    while stack:
        node = stack.pop()
        kind = _KINDS.get(type(node))
        if kind is not None and kind.heard is not None:
            found.update(dict.fromkeys(kind.heard(node, signatures)))
        elif isinstance(node, nodes.Call):
            found.update(dict.fromkeys(of_call(node, signatures)))
        for field in reversed(CHILDREN[type(node)]):
            part = getattr(node, field)
            stack.extend(reversed(part) if type(part) is tuple else (part,))
    return tuple(found)
