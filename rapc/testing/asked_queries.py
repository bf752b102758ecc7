"""Which named queries are asked with a clause, through other queries too."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rapc.ir import nodes, walk
from rapc.library.library import Library

Asker = tuple[str, str, str]
"""A RAP, a method (nothing for the RAP itself), and `context` or nothing."""


def asked_with(library: Library) -> Mapping[Asker, frozenset[str]]:
    """Return the queries that are asked when a clause is, by whose clause it is.

    The clauses of a RAP are asked when its task is selected, a context when a method
    is to be chosen, the others of a method once it has been.
    """
    found: dict[Asker, set[str]] = {}
    for rap in library.raps.values():
        for at in walk.formulas(rap):
            method = "" if at.method is None else traced_name(at.method)
            clause = "context" if at.clause.word == "context" else ""
            named = found.setdefault((rap.name, method, clause), set())
            named.update(_within(library, at.formula))
    return {asker: frozenset(named) for asker, named in found.items() if named}


def traced_name(method: nodes.Method) -> str:
    """Return the name of a method as a trace writes it."""
    return f"#{method.position}" if method.name is None else str(method.name)


def _within(library: Library, formula: nodes.Formula) -> Iterable[str]:
    """Return the queries that a formula names, and those that these name."""
    seen: dict[str, None] = {}
    stack = [formula]
    while stack:
        for part in walk.subformulas(stack.pop()):
            if isinstance(part, nodes.Proposition) and part.name in library.queries:
                if part.name not in seen:
                    stack.append(library.queries[part.name].formula)
                seen[part.name] = None
    return seen
