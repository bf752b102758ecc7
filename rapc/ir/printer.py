"""IR to RAP text: terms, formulas, goals, with values put in for bound variables.

The text reads back as what was printed. Whole definitions are not printed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rapc.base.values import format_atom
from rapc.ir import nodes

Bindings = Mapping[str, object]
"""Values by variable name (with its question mark): atoms, or what `str` writes."""


def format_term(term: nodes.Term, bindings: Bindings | None = None) -> str:
    """A term; a variable that is bound is written as its value."""
    match term:
        case nodes.Const(value):
            return format_atom(value)
        case nodes.Var(name):
            if bindings and name in bindings:
                return format_atom(bindings[name])
            return name
        case nodes.Call(function, args):
            return _list(function, args, bindings)


def format_goal(goal: nodes.Goal, bindings: Bindings | None = None) -> str:
    """A goal: `(find box => ?place)`."""
    words = [goal.name, *(format_term(arg, bindings) for arg in goal.args)]
    if goal.outputs:
        words += ["=>", *(format_term(out, bindings) for out in goal.outputs)]
    return f"({' '.join(words)})"


def format_formula(
    formula: nodes.Formula | nodes.Pattern, bindings: Bindings | None = None
) -> str:
    """A formula on one line, or any name with its arguments.

    A formula that is a word alone is written as its node is called.
    """
    parts: Sequence[nodes.Formula] = ()
    args: Sequence[nodes.Term] = ()
    match formula:
        case nodes.Truth(value):
            return "true" if value else "false"
        case nodes.Thing(word, ()):
            return word
        case nodes.And(parts):
            word = "and"
        case nodes.Or(parts):
            word = "or"
        case nodes.Not(part):
            word, parts = "not", (part,)
        case nodes.Believe(pattern, age):
            word, parts, args = "believe", (pattern,), (age,)
        case nodes.Compare(word, left, right):
            args = (left, right)
        case nodes.SensorName(item, known):
            word, args = "know-sensor-name", (item, known)
        case nodes.Count(kind, place, number):
            word, args = "count", (kind, place, number)
        case nodes.Pattern(word, args) | nodes.SetTest(word, args):
            pass
        case nodes.HistoryTest(word, args):
            pass
        case _:
            return type(formula).__name__.lower()
    words = [word, *(format_formula(part, bindings) for part in parts)]
    return f"({' '.join((*words, *(format_term(arg, bindings) for arg in args)))})"


def _list(name: str, args: Iterable[nodes.Term], bindings: Bindings | None) -> str:
    return f"({' '.join((name, *(format_term(arg, bindings) for arg in args)))})"
