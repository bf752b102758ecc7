"""Named queries: what `(name term...)` stands for, and how it becomes code.

A use of a query means its formula with the terms put in [T 5.4]; the other variables of
the formula are its own. A short formula is written where it is used, as if it stood
there. A long one becomes a function of its own, once for each way in which its
arguments are known: so a chain of queries, each of which uses the one before it twice,
grows with its text and not with all that it comes to.

Not here: what is wrong with a query (the checker says), and which queries there are
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
"""The most parts that the formula of a query written where it is used may come to."""

Write = Callable[[FunctionWriter, nodes.Formula], None]
"""What writes a formula: `rapc.compiler.query.formulas.write`."""


def query_of(signatures: Signatures, formula: nodes.Formula) -> Signature | None:
    """Return the query that a formula uses by name, or None."""
    if type(formula) is not nodes.Proposition:
        return None
    found = signatures.predicates.get(formula.name)
    return found if found is not None and found.formula is not None else None


def write_use(
    fn: FunctionWriter, use: nodes.Proposition, query: Signature, write: Write
) -> None:
    """Append the code of a use of a query; what follows runs once per solution."""
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
    """Iterate over a formula and what the queries in it stand for, each use once."""
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
    """How the arguments of a query are known: one function serves all uses of it."""

    name: str
    #: What stands for each argument within the function.
    args: tuple[nodes.Term, ...]
    #: The variables that have or may have a value, which the function is handed.
    handed: tuple[str, ...]
    #: Those of them that may have none.
    maybe: tuple[str, ...]
    #: Those of them that have a value by the text [L 2.71].
    given: tuple[str, ...]
    #: How many searching parts stand before it, up to those that are free.
    outer: int


class _Made(msgspec.Struct, frozen=True):
    """A function that yields the solutions of a query."""

    call: str
    #: The variables it yields values of, and whether each surely has one.
    exports: tuple[tuple[str, bool], ...]
    #: The variables that have a value behind it, by the text.
    given: frozenset[str]
    #: How many searching parts it has.
    searches: int


def _call(
    fn: FunctionWriter, use: nodes.Proposition, query: Signature, write: Write
) -> None:
    """Loop over what the function of a query yields."""
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
    """Return a name that is nobody else's, told as `variable` where it has no value."""
    return f"{variable.partition(' ')[0]}  {number}"


def _target(fn: FunctionWriter, variable: str) -> str:
    """Return the local that takes a value; a new one if there may be one before."""
    return fn.rename(variable) if variable in fn.maybe else fn.local(variable)


def _made(
    fn: FunctionWriter, shape: _Shape, query: Signature, free: list[str], write: Write
) -> _Made:
    """Return the function for a shape, written when the shape is first met."""
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
    """Return the expression for the clause's name, with that of the query before."""
    before, fn.within = fn.within, f"`{query.name}` in {fn.within}"
    place = fn.where
    fn.within = before
    return place


def _parameters(query: Signature) -> list[str]:
    return [argument.variable.name for argument in query.args or ()]


def _put_in(use: nodes.Proposition, query: Signature, mark: str) -> nodes.Formula:
    """Return the formula of a query with terms put in and its own variables marked.

    No variable of a program has a name with a space in it, as the marked ones have.
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
    """Whether a query is written where it is used: short, with few loops in all."""
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
    """Return how many parts the formula of a query comes to, or a number too many."""
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
