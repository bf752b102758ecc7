"""What facts a formula asks for, through the queries that it names."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.ir import nodes
from rapc.ir.walk import subformulas
from rapc.library.library import Library


def is_computed(library: Library, name: str) -> bool:
    """Whether a name is that of a function or a query, not of facts."""
    return name in library.functions or name in library.queries


_PLAIN = (
    nodes.Truth,
    nodes.Proposition,
    nodes.And,
    nodes.Or,
    nodes.Not,
    nodes.Compare,
    nodes.Believe,
)


def is_known(library: Library, formula: nodes.Formula) -> bool:
    """Whether a formula asks about facts alone, through queries too."""
    return all(
        isinstance(one, _PLAIN)
        and not (isinstance(one, nodes.Proposition) and one.name in library.functions)
        for one in through(library, formula)
    )


def asked_through(library: Library, formula: nodes.Formula) -> set[str] | None:
    """Return the names that a formula asks for; None if it asks not facts alone."""
    return asked_by(library, formula) if is_known(library, formula) else None


def asked_by(library: Library, formula: nodes.Formula) -> set[str]:
    """The names of the facts that a formula asks, through queries too."""
    return {
        one.name
        for one in through(library, formula)
        if isinstance(one, nodes.Proposition)
    }


def through(library: Library, formula: nodes.Formula) -> Iterator[nodes.Formula]:
    """Yield the parts of a formula, and those of the queries that it names."""
    waiting, seen = [formula], set[str]()
    while waiting:
        for one in subformulas(waiting.pop()):
            yield one
            name = one.name if isinstance(one, nodes.Proposition) else ""
            query = library.queries.get(name)
            if query is not None and name not in seen:
                seen.add(name)
                waiting.append(query.formula)
