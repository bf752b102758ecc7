"""IR to RAP text: terms, formulas, goals, with values put in for bound variables.

The text reads back as what was printed. Whole definitions are not printed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rapc.base.values import format_atom
from rapc.ir import nodes
from rapc.ir.fields import CHILDREN, declared
from rapc.language.heads import ALONE, heads, rule_named

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
    """A formula on one line, or any name with its arguments."""
    if isinstance(formula, nodes.Truth):
        return "true" if formula.value else "false"
    if isinstance(formula, nodes.Thing) and not formula.args:
        return formula.name
    if isinstance(formula, nodes.Pattern):
        return _list(formula.name, formula.args, bindings)
    word, field = _WORDS[type(formula)]
    if type(formula) in _ALONE:
        return word
    words = [getattr(formula, field) if field else word]
    for field in CHILDREN[type(formula)]:
        value = getattr(formula, field)
        for part in value if type(value) is tuple else (value,):
            is_term = isinstance(part, nodes.Term)
            words.append((format_term if is_term else format_formula)(part, bindings))
    return f"({' '.join(words)})"


def _list(name: str, args: Iterable[nodes.Term], bindings: Bindings | None) -> str:
    return f"({' '.join((name, *(format_term(arg, bindings) for arg in args)))})"


def _word(kind: type[nodes.Node]) -> tuple[str, str]:
    """The word that heads a kind of formula, or else the field that holds the word."""
    for field in kind.__struct_fields__:
        if declared(kind, field).startswith("Literal["):
            return "", field
    return heads(rule_named(kind.__name__))[0], ""


_SAID: frozenset[type] = frozenset((nodes.Truth, nodes.Proposition))
"""Kinds of formulas whose nodes say what they begin with."""

_KINDS = [kind for kind in nodes.Formula.__args__ if kind not in _SAID]

_WORDS = {kind: _word(kind) for kind in _KINDS}

_ALONE = frozenset(
    kind for kind in _KINDS if rule_named(kind.__name__) in ALONE.values()
)
"""Kinds of formulas that are a word without parentheses."""
