"""Which parts of a question search, by the text that stands before them [L 2.71]."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import msgspec

from rapc.ir import nodes
from rapc.ir.walk import variables
from rapc.library.library import Library
from tests.reference.memory import is_short

FREE = 2
"""A step back is one that a part takes before which so many searching parts stand."""


class GivenUp(Exception):  # the end of a question, not an error
    """A question has gone back too often in vain."""


class Before(NamedTuple):
    """What stands before a part: variables with a value, and how many parts search."""

    given: frozenset[str]
    searches: int

    def behind(self, library: Library, formula: nodes.Formula) -> Before:
        """What stands before the part that follows a formula."""
        match formula:
            case nodes.And(parts):
                found = self
                for part in parts:
                    found = found.behind(library, part)
                return found
            case nodes.Or(parts):
                each = [self.behind(library, part).given for part in parts]
                common = frozenset.intersection(*each) if each else self.given
                return Before(common, self.searches + 1)
            case nodes.Not():
                return self
            case nodes.Proposition(name, args) if name in library.queries:
                put = spelled_out(library.queries[name], args, f"~{name}")
                inner = self.behind(library, put)
                given = frozenset([n for n in inner.given if not is_own(n, f"~{name}")])
                return Before(given, inner.searches)
        named = [v.name for v in variables(formula) if not v.anonymous]
        searches = self.searches + self.search(library, formula)
        return Before(self.given.union(named), searches)

    def search(self, library: Library, formula: nodes.Formula) -> bool:
        """Whether a part that is no `and` and no query searches here."""
        match formula:
            case nodes.Or():
                return True
            case nodes.SensorName(item):
                return self.is_open(item)
            case nodes.Believe(pattern):
                return self.search(library, pattern)
            case nodes.Proposition(name, args):
                known = {*library.functions, *library.queries}
                short = is_short(library, name, len(args))
                index = args[:-1] if name in library.properties and not short else args
                return name not in known and any(self.is_open(arg) for arg in index)
        return False

    def is_open(self, term: nodes.Term) -> bool:
        """Whether a term is a variable that need not have a value here."""
        return isinstance(term, nodes.Var) and (
            term.anonymous or term.name not in self.given
        )


def spelled_out(query: nodes.DefineQuery, args: Any, mark: str) -> nodes.Formula:
    """The formula of a query with terms put in; its own variables are marked."""
    put: dict[str, nodes.Term] = {}
    for argument, term in zip(query.args, args, strict=True):
        bare = isinstance(term, nodes.Var) and term.anonymous
        name = argument.variable.name
        put[name] = nodes.Var(name + mark) if bare else term
    formula: nodes.Formula = put_in(query.formula, put, mark)
    return formula


def put_in(part: Any, put: Mapping[str, nodes.Term], mark: str) -> Any:
    """A part of a query with terms put in for its arguments, all else marked as own."""
    if isinstance(part, tuple):
        return tuple(put_in(each, put, mark) for each in part)
    if not isinstance(part, nodes.Node) or (
        isinstance(part, nodes.Var) and part.anonymous
    ):
        return part
    if isinstance(part, nodes.Var):
        return put.get(part.name, nodes.Var(part.name + mark))
    names = part.__struct_fields__
    made = {name: put_in(getattr(part, name), put, mark) for name in names}
    return msgspec.structs.replace(part, **made)


def is_own(name: str, mark: str) -> bool:
    """Whether a variable is one that an expansion has made."""
    return name.endswith(mark)
