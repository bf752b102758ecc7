"""Named queries: the meaning of `(name term...)`, and its code.

A use of a query means its formula with the terms inserted [T 5.4]; the other variables
of the formula are local. A short formula is written in place. A long formula becomes a
function, one for each pattern of known arguments. So the code of a chain of queries,
each of which uses the preceding query twice, grows with the text and not with the
number of expanded parts.

Not here: errors of queries (the checker), and the table of queries
(`rapc.library.signatures`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import msgspec

from rapc.compiler.query.code import ResultMode
from rapc.compiler.query.function import FREE_SEARCHES, MAX_LOOPS, FunctionWriter
from rapc.compiler.query.plan_steps import AccessPath
from rapc.ir import nodes
from rapc.ir.walk import subformulas, substitute, variable_names
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures

MOST_INLINE = 24
"""The highest number of parts of a query's formula that is written in place."""

Write = Callable[[FunctionWriter, nodes.Formula], None]
"""The type of `rapc.compiler.query.formulas.write`."""


def query_of(signatures: Signatures, formula: nodes.Formula) -> Signature | None:
    """Return the query that a formula uses by name, or None."""
    if type(formula) is not nodes.Proposition:
        return None
    found = signatures.predicates.get(formula.name)
    return found if found is not None and found.formula is not None else None


def write_use(
    fn: FunctionWriter, use: nodes.Proposition, query: Signature, write: Write
) -> None:
    """Append the code of a use of a query; later code runs once per solution."""
    fn.code.note(use, AccessPath.NAMED)
    fn.code.depth += 1
    if _fits(fn, query):
        before, fn.within = fn.within, f"`{query.name}` in {fn.within}"
        write(fn, _put_in(use, query, str(fn.code.serial())))
        fn.within = before
    else:
        _call(fn, use, query, write)
    fn.code.depth -= 1


def parts_of(formula: nodes.Formula, signatures: Signatures) -> Iterator[nodes.Formula]:
    """Iterate over the parts of a formula and of all queries that it uses."""
    for whole in spelled_out(formula, signatures):
        yield from subformulas(whole)


def spelled_out(
    formula: nodes.Formula, signatures: Signatures
) -> Iterator[nodes.Formula]:
    """Iterate over a formula and the formulas of its queries, each use once."""
    yield formula
    seen: set[nodes.Formula] = set()
    stack = [formula]
    while stack:
        for part in subformulas(stack.pop()):
            query = query_of(signatures, part)
            if query is None or part in seen:
                continue
            seen.add(part)
            assert isinstance(part, nodes.Proposition)
            put = _put_in(part, query, query.name)
            yield put
            stack.append(put)


class _Shape(msgspec.Struct, frozen=True):
    """The known arguments of a query: all uses of a shape share one function."""

    name: str
    #: The terms for the arguments within the function.
    args: tuple[nodes.Term, ...]
    #: The passed variables: those with a value, and those that may have a value.
    handed: tuple[str, ...]
    #: The passed variables that may have no value.
    maybe: tuple[str, ...]
    #: The passed variables that have a value by the text [L 2.71].
    given: tuple[str, ...]
    #: The number of searching parts before the call, at most the number of free parts.
    outer: int


class _Made(msgspec.Struct, frozen=True):
    """A function that yields the solutions of a query."""

    call: str
    #: The variables whose values it yields, and whether each is certainly bound.
    exports: tuple[tuple[str, bool], ...]
    #: The variables that have a value after the call, by the text.
    given: frozenset[str]
    #: The number of its searching parts.
    searches: int


def _call(
    fn: FunctionWriter, use: nodes.Proposition, query: Signature, write: Write
) -> None:
    """Write a loop over the results of the function of a query."""
    inner: dict[str, str] = {}
    handed: dict[str, str] = {}
    args: list[nodes.Term] = []
    for parameter, arg in zip(_parameters(query), use.args, strict=True):
        if isinstance(arg, nodes.Const):
            handed[parameter] = fn.code.constant(arg.value)
            args.append(nodes.Var(parameter))
        elif isinstance(arg, nodes.Var):
            own = parameter if arg.name in fn.bound else _shown(arg.name, len(inner))
            known = parameter if arg.anonymous else inner.setdefault(arg.name, own)
            args.append(nodes.Var(known))
        else:
            for name in variable_names(arg):
                inner.setdefault(name, _shown(name, len(inner)))
            args.append(substitute(arg, {v: nodes.Var(n) for v, n in inner.items()}))
    valued = fn.bound | fn.maybe
    handed.update((inner[n], fn.local(n)) for n in inner if n in valued)
    outer = {name: variable for variable, name in inner.items()}
    shape = _Shape(
        query.name,
        tuple(args),
        tuple(handed),
        tuple([n for n in handed if outer.get(n) in fn.maybe]),
        tuple([n for n in handed if n not in outer or outer[n] in fn.given]),
        min(fn.outer + fn.searches, FREE_SEARCHES),
    )
    free = [n for n in outer if n not in handed or n in shape.maybe]
    made = _made(fn, shape, query, free, write)
    taken = ", ".join([_place(fn, query), *handed.values()])
    targets = "".join(f"{_target(fn, outer[name])}, " for name, _ in made.exports)
    fn.loop(f"for {f'({targets})' if targets else '_'} in {made.call}({taken}):")
    fn.searches += made.searches
    fn.given.update(outer[one] for one in made.given if one in outer)
    for name, surely in made.exports:
        fn.maybe.discard(outer[name])
        (fn.bound if surely else fn.maybe).add(outer[name])


def _shown(variable: str, number: int) -> str:
    """Return a unique name, shown as `variable` if it has no value."""
    return f"{variable.partition(' ')[0]}  {number}"


def _target(fn: FunctionWriter, variable: str) -> str:
    """Return the local that receives a value; a new local if it may be bound."""
    return fn.rename(variable) if variable in fn.maybe else fn.local(variable)


def _made(
    fn: FunctionWriter, shape: _Shape, query: Signature, free: list[str], write: Write
) -> _Made:
    """Return the function for a shape, written at the first use of the shape."""
    made: _Made | None = fn.code.shared.get(shape)
    if made is not None:
        return made
    name = fn.code.fresh("ask")
    writer = FunctionWriter(fn.code, name, shape.handed, ResultMode.EACH)
    writer.bound.difference_update(shape.maybe)
    writer.maybe.update(shape.maybe)
    writer.given = set(shape.given)
    writer.outer = shape.outer
    writer.is_shared = True
    use = nodes.Proposition(query.name, shape.args)
    write(writer, _put_in(use, query, query.name))
    known = writer.bound | writer.maybe
    exports = tuple([(one, one in writer.bound) for one in free if one in known])
    writer.return_solution(writer.values([one for one, _ in exports]))
    writer.close()
    made = fn.code.shared[shape] = _Made(
        name, exports, frozenset(writer.given), writer.searches
    )
    return made


def _place(fn: FunctionWriter, query: Signature) -> str:
    """Return the expression for the clause's name, after the name of its query."""
    before, fn.within = fn.within, f"`{query.name}` in {fn.within}"
    place = fn.where
    fn.within = before
    return place


def _parameters(query: Signature) -> list[str]:
    return [argument.variable.name for argument in query.args or ()]


def _put_in(use: nodes.Proposition, query: Signature, mark: str) -> nodes.Formula:
    """Return the formula of a query with terms inserted and variables renamed.

    No variable of a program has a name with a space, so the renamed variables are
    unique.
    """
    assert query.formula is not None
    put: dict[str, nodes.Term] = {}
    for parameter, arg in zip(_parameters(query), use.args, strict=True):
        anonymous = isinstance(arg, nodes.Var) and arg.anonymous
        put[parameter] = nodes.Var(f"{parameter} {mark}") if anonymous else arg
    for name in variable_names(query.formula):
        put.setdefault(name, nodes.Var(f"{name} {mark}"))
    return substitute(query.formula, put)


def _fits(fn: FunctionWriter, query: Signature) -> bool:
    """Return whether a query is written in place: short, with few loops in all."""
    if _size(query.name, fn.code.signatures, ()) > MOST_INLINE:
        return False
    loops = fn.loops
    stack = [query.formula]
    while stack:
        part = stack.pop()
        inner = None if part is None else query_of(fn.code.signatures, part)
        if isinstance(part, nodes.And):
            stack.extend(part.parts)
        elif inner is not None:
            stack.append(inner.formula)
        else:
            loops += not isinstance(part, nodes.Not | nodes.Truth)
    return loops <= MAX_LOOPS


def _size(name: str, signatures: Signatures, above: tuple[str, ...]) -> int:
    """Return the number of parts of the formula of a query, or a number too large."""
    formula = signatures.predicates[name].formula
    if formula is None or name in above:
        return MOST_INLINE + 1
    size = 0
    for part in subformulas(formula):
        query = query_of(signatures, part)
        size += 1 if query is None else _size(query.name, signatures, (*above, name))
        if size > MOST_INLINE:
            break
    return size
