"""Queries of hosts and handlers: a formula compiled once for many evaluations.

A task's query is compiled with its RAP. A host's query belongs to no task: a formula
about the history of methods has no solution [L 2].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rapc.base.names import hint
from rapc.base.resources import Value
from rapc.base.values import Atom
from rapc.compiler.query.builtin import FUNCTIONS
from rapc.compiler.query.code import ResultMode
from rapc.compiler.query.query import Query
from rapc.errors import TextError
from rapc.ir import nodes
from rapc.ir.nodes import Formula
from rapc.ir.walk import subformulas, subterms, terms
from rapc.library.signatures import Fault, Signatures
from rapc.parser.parse import parse_formula
from rapc.runtime.query_context import QueryContext
from rapc.runtime.run import Run

Answer = dict[str, Value]
"""The bindings of a solution besides the given ones; a free variable is absent."""


class HostQuery:
    """A formula compiled for many evaluations; made by `Interpreter.question`.

    Each of the functions takes the values of the variables in `given`, in their order,
    and is the generated function itself: `first` returns the first solution or None,
    `all` the list of all solutions in the order of [L 2], `holds` whether there is a
    solution.

    Args:
        run: the run whose memory is queried.
        formula: the formula.
        given: the variables, with their question marks, that get values.
        context: the context of the query; by default one that does not change the run.

    Raises:
        TextError: for a name that the library does not declare, or not with this
            number of arguments; for a variable that is not in the formula, or is
            given twice; in a query of a host, for a constant of a wrong kind.
    """

    __slots__ = (
        "_context",
        "_formula",
        "_query",
        "_renamings",
        "_run",
        "all",
        "first",
        "given",
        "holds",
    )

    def __init__(
        self,
        run: Run,
        formula: Formula,
        given: Sequence[str] = (),
        context: QueryContext | None = None,
    ) -> None:
        self.given = tuple(given)
        self._run = run
        self._formula = formula
        signatures = run.library.signatures
        _check_names(formula, signatures)
        if context is None:
            _check_kinds(formula, signatures)
            context = run.new_context(quiet=True)
        self._context = context
        self._renamings = -1
        self._query = self._compiled()
        for name in self.given:
            _check(name, self._query.variables, self.given)
        self.first: Callable[..., Answer | None] = self._ready(ResultMode.FIRST)
        self.all: Callable[..., list[Answer]] = self._ready(ResultMode.ALL)
        self.holds: Callable[..., bool] = self._ready(ResultMode.ANY)

    def _ready(self, mode: ResultMode) -> Callable[..., Any]:
        """Return the function for a mode, until items get other names."""
        items = self._run.beliefs.items
        renamed: dict[Query, Callable[..., Any]] = {}

        def aliased(*values: Value) -> Any:
            """Evaluate the query with the current names."""
            known = [items.canonical(v) if isinstance(v, str) else v for v in values]
            query = self._compiled()
            if query not in renamed:
                variant = query.variant(self.given, mode, by_place=True)
                renamed.clear()
                renamed[query] = variant.bind(self._context)
            return renamed[query](*known)

        variant = self._query.variant(self.given, mode, by_place=True)
        return variant.bind(self._context, items.aliases, aliased)

    def _compiled(self) -> Query:
        """Return the query, compiled again after a renaming of its items."""
        items = self._run.beliefs.items
        if items.renamings != self._renamings:
            self._renamings = items.renamings
            formula = self._formula
            if items.aliases:
                formula = _with_names(formula, items.canonical)
            compiler = self._run.library.compiler
            self._query = compiler.query(formula, "question", formula.span)
        return self._query


class HandlerQuestions:
    """The queries of a run's handlers; each formula is compiled once.

    A handler's query is a part of the run: its faults are traced, as in a clause.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self._context = run.new_context()
        self._ready: dict[tuple[str | Formula, tuple[str, ...]], HostQuery] = {}

    def ask(
        self, formula: str | Formula, given: Mapping[str, Atom] | None = None
    ) -> list[Answer]:
        """Return all solutions of `formula`: see `rapc.world.HandlerMemory.ask`.

        Raises:
            TextError: as `HostQuery`, and for an invalid formula.
        """
        given = {} if given is None else given
        key = formula, tuple(given)
        ready = self._ready.get(key)
        if ready is None:
            read = parse_formula(formula) if isinstance(formula, str) else formula
            ready = HostQuery(self._run, read, tuple(given), self._context)
            self._ready[key] = ready
        return ready.all(*given.values())


def _with_names(node: Any, name_of: Callable[[Atom], Atom]) -> Any:
    """Return a formula with the current name of every constant.

    Formulas nest as deep as the reader allows, a hundred levels.
    """
    if isinstance(node, nodes.Const):
        return nodes.Const(name_of(node.value), span=node.span)
    if isinstance(node, tuple):
        return tuple([_with_names(part, name_of) for part in node])
    if isinstance(node, nodes.Node):
        fields = {name: getattr(node, name) for name in node.__struct_fields__}
        named = {key: _with_names(part, name_of) for key, part in fields.items()}
        return type(node)(**named)
    return node


def check_formula(formula: Formula, signatures: Signatures) -> None:
    """Refuse undeclared names, and constants of a wrong kind.

    Raises:
        TextError: for the first fault.
    """
    _check_names(formula, signatures)
    _check_kinds(formula, signatures)


def _check_names(formula: Formula, signatures: Signatures) -> None:
    for part in subformulas(formula):
        if isinstance(part, nodes.Proposition):
            _refuse(signatures.fault("test", part.name, len(part.args)))
    for term in (inner for outer in terms(formula) for inner in subterms(outer)):
        if isinstance(term, nodes.Call) and term.function not in FUNCTIONS:
            _refuse(signatures.fault("computed", term.function, len(term.args)))


def _check_kinds(formula: Formula, signatures: Signatures) -> None:
    """Refuse constants that are not of the declared kind: no fact can match."""
    for part in subformulas(formula):
        if isinstance(part, nodes.Proposition):
            values = [
                arg.value if isinstance(arg, nodes.Const) else None for arg in part.args
            ]
            wrong = signatures.wrong_kind("test", part.name, values)
            if wrong is not None:
                raise TextError(wrong)


def _refuse(fault: Fault | None) -> None:
    if fault is not None:
        raise TextError(str(fault))


def _check(name: str, known: Sequence[str], given: Sequence[str]) -> None:
    if name not in known:
        raise TextError(f"`{name}` is not in the query{hint(name, known)}")
    if given.count(name) > 1:
        raise TextError(f"duplicate variable `{name}`")
