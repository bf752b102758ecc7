"""The names in a form, found in its data: each with its name space and span.

Nodes have no spans for many names: tags, results, methods, data in `:tells`. This
module walks the data of a form along the shapes of the grammar, whose terminals state
the kind of each name. Data that fit no shape are skipped: a form with faults gives the
names of its valid parts. The check does not use this module.

Not here: the definition and all occurrences of a name (`rapc.analysis.naming`).
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from functools import cache
from typing import Literal

import msgspec

from rapc.base.source import Span
from rapc.language.grammar import RULES
from rapc.language.heads import SLIPS
from rapc.language.shapes import Shape, is_rule, is_terminal, is_word
from rapc.parser.context import head_of
from rapc.parser.syntax import (
    Arrow,
    Datum,
    Keyword,
    List,
    Numeral,
    String,
    Symbol,
    Variable,
)

Space = Literal[
    "RAP",
    "method",
    "tag",
    "predicate",
    "primitive",
    "result",
    "datum",
    "skill",
    "event",
    "kind",
    "agenda",
    "class",
    "thing",
    "variable",
]
"""The name space of a name."""


class Named(msgspec.Struct, frozen=True, gc=False):
    """A name at a position of a text."""

    space: Space
    #: The name in lower case; a variable with its question mark, a skill or an event
    #: with its colon.
    name: str
    #: The name in the text; an event in a `match-result` may have no colon there.
    span: Span
    #: The top-level form around the name.
    form: Span
    #: Whether the name is defined or declared here.
    defines: bool = False
    #: The RAP of a method, a tag or a variable; empty if there is none or if the text
    #: does not state the RAP.
    rap: str = ""
    #: The form or method to which a tag or a variable belongs; None for a variable of a
    #: whole RAP, and for other names.
    scope: Span | None = None
    #: Whether the name may also be a value, as the default of a property.
    may_be_value: bool = False


SPACE_OF: Mapping[str, Space] = {
    "RAP": "RAP",
    "METHOD": "method",
    "TAG": "tag",
    "PREDICATE": "predicate",
    "FUNCTION": "predicate",
    "QUERY": "predicate",
    "PRIMITIVE": "primitive",
    "RESULT": "result",
    "DATUM": "datum",
    "SKILL": "skill",
    "SIGNAL": "event",
    "BARE_SIGNAL": "event",
    "KIND": "kind",
    "AGENDA": "agenda",
    "CLASS": "class",
    "THING": "thing",
    "VARIABLE": "variable",
    "PARAMETER": "variable",
}
"""The name spaces of the terminals of the grammar."""

_DEFINING = frozenset(
    (
        *(("index", "RAP"), ("index_clause", "RAP"), ("query_head", "QUERY")),
        *(("method", "METHOD"), ("define_method", "METHOD"), ("step", "TAG")),
        *(("argument", "PARAMETER"), ("resource", "PARAMETER")),
        *(("results", "RESULT"), ("define_agenda", "AGENDA")),
    )
)
"""The rules and terminals that define a name; so do the rules of declarations."""

_DECLARATIONS = frozenset(
    rule
    for rule in RULES
    if rule.startswith("declare_") and rule != "declare_class_comparator"
)
"""The rules of declarations, whose names are in lists of other rules, but for one."""

_OF_TESTS = ("method_chosen", "event_pattern")
"""The rules in which a RAP precedes the name of its method."""

_EVENT_KEYS: Mapping[str, Shape] = {
    ":goal": "goal",
    ":rap": "RAP",
    ":method": "METHOD",
    ":result": "RESULT",
    ":reason": "RESULT",
    ":class": "CLASS",
    ":fact": "told",
    ":request": "required",
    ":sent": "required",
    ":data": ("or", "told_datum", ("list", ("*", "told_datum"))),
    ":what": ("or", "signal", "RESULT"),
}
"""The shapes of values in event patterns, by key; other values have no names."""

_SHAPES: Mapping[str, Shape] = {
    **RULES,
    "index_clause": ("list", '"index"', ("or", "index", ("seq", *RULES["index"][1:]))),
    "method_tried": ("list", '"method-tried"', ("or", "METHOD", "term")),
    "last_result": ("list", '"last-result"', ("or", "RESULT", "term")),
    "result_with_method": (
        *("list", '"result-with-method"'),
        *(("or", "METHOD", "term"), ("or", "RESULT", "term")),
    ),
    "fails": ("list", '"fails"', "asked", ("?", ("or", "RESULT", "VARIABLE"))),
    "count": ("list", '"count"', ("or", "CLASS", "term"), "term", "term"),
    "default": ("or", "FUNCTION", "NUMBER"),
    "bare_signal": ("list", "BARE_SIGNAL", ("*", "term")),
    "event_pattern": (
        *("list", "EVENT"),
        (
            "*",
            (
                "or",
                *(("seq", f'"{key}"', value) for key, value in _EVENT_KEYS.items()),
                "event_key",
            ),
        ),
    ),
}
"""The shapes of the rules, with more exact terminals where a term is a name."""


_TYPES: Mapping[str, tuple[type, ...]] = {
    **dict.fromkeys(("KEYWORD", "SKILL", "SIGNAL"), (Keyword,)),
    **dict.fromkeys(("VARIABLE", "PARAMETER"), (Variable,)),
    **dict.fromkeys(("STRING", "FILE"), (String,)),
    **dict.fromkeys(("NUMBER", "INTEGER", "TIME"), (Numeral,)),
    **dict.fromkeys(("PERIOD", "COUNT", "POSITIVE"), (Numeral,)),
    "METHOD": (Symbol, Numeral),
}
"""The types of data that fit a terminal; symbols fit all terminals not listed."""


def names_in(file: str, form: Datum) -> list[Named]:
    """Return the names in a top-level form, in the order of the text.

    Args:
        file: the name of the file.
        form: the data of the form.
    """
    walk = _Walk(file, form)
    walk.take("_form", (form,), 0, "")
    wide = {one.name for one in walk.found if one.scope == walk.form}
    if head_of(form) == "define-method":
        wide = set()
    return [walk.finished(one, wide) for one in walk.found]


class _Walk:
    """A walk over the data of a form."""

    def __init__(self, file: str, form: Datum) -> None:
        self.found: list[Named] = []
        self.file = file
        self.form = Span(file, form.start, form.end)
        #: The method or form that is being walked.
        self.scope = self.form
        #: The RAP that the form defines or extends.
        self.owner = ""
        #: The RAP last named in a `method-chosen` or a clause `method` of a test.
        self.named = ""

    def finished(self, one: Named, wide: Container[str]) -> Named:
        """Return a name with its RAP, and no scope for a variable of a whole RAP."""
        if one.space not in ("variable", "tag", "method"):
            return one
        of_rap = one.space == "variable" and self.owner and one.name in wide
        scope = None if of_rap else one.scope
        return msgspec.structs.replace(one, scope=scope, rap=one.rap or self.owner)

    def take(self, shape: Shape, items: Sequence[Datum], at: int, rule: str) -> int:
        """Walk the data that fit a shape; return the position after the data.

        Args:
            shape: the shape.
            items: the data of a list.
            at: the position of the first datum.
            rule: the rule of the shape.
        """
        if not _rank(shape, items, at):
            return at
        if is_rule(shape):
            name = str(shape)
            return self.take(_SHAPES[name], items, at, rule if name[0] == "_" else name)
        if isinstance(shape, tuple) and shape[0] != "list":
            return self._several(shape, items, at, rule)
        datum = items[at]
        if isinstance(shape, tuple):
            assert isinstance(datum, List)
            self._list(shape[1:], datum, rule)
        elif is_terminal(shape):
            self._name(shape, datum, rule)
        return at + 1

    def _several(
        self, shape: tuple[Shape, ...], items: Sequence[Datum], at: int, rule: str
    ) -> int:
        """Walk the data that fit a shape with an operator other than `list`."""
        operator, *parts = shape
        if operator == "or":
            parts = [max(parts, key=lambda part: _rank(part, items, at))]
        repeats = operator in ("*", "+")
        before = -1
        while before < at:
            before = at if repeats else len(items)
            for part in parts:
                at = self.take(part, items, at, rule)
        return at

    def _list(self, parts: Sequence[Shape], datum: List, rule: str) -> None:
        """Walk a list; data that fit no part are skipped."""
        outer = self.scope
        if rule in ("method", "define_method"):
            self.scope = Span(self.file, datum.start, datum.end)
        at, items = 0, datum.items
        for part in parts:
            at = self.take(part, items, at, rule)
        first = next((n for n, one in enumerate(parts) if _may_repeat(one)), len(parts))
        while at < len(items):
            before = at
            for part in parts[first:]:
                at = self.take(part, items, at, rule)
            at += at == before
        self.scope = outer

    def _name(self, terminal: str, datum: Datum, rule: str) -> None:
        space = SPACE_OF.get(terminal)
        if space is None or isinstance(datum, List | String):
            return
        name = str(datum.value) if isinstance(datum, Numeral) else datum.name
        if name == "?":
            return
        if terminal == "BARE_SIGNAL":
            name = f":{name}"
        if terminal == "RAP":
            if rule in ("index", "index_clause", "define_method"):
                self.owner = name
            self.named = name
        defines = (rule, terminal) in _DEFINING or rule in _DECLARATIONS
        scope = self.scope if space in ("variable", "tag") else None
        rap = self.named if space == "method" and rule in _OF_TESTS else ""
        span = Span(self.file, datum.start, datum.end)
        found = Named(space, name, span, self.form, defines, rap, scope)
        if rule == "default":
            found = msgspec.structs.replace(found, may_be_value=True)
        self.found.append(found)


def _rank(shape: Shape, items: Sequence[Datum], at: int) -> int:
    """Return how well data fit the start of a shape: 2 for a word, 1, or 0."""
    if at >= len(items):
        return 0
    if isinstance(shape, str):
        return _rank_of_name(shape, items, at)
    if shape[0] == "or":
        return max(_rank(part, items, at) for part in shape[1:])
    if shape[0] == "list":
        datum = items[at]
        return _rank_of_parts(shape[1:], datum.items, 0) if type(datum) is List else 0
    return _rank_of_parts(shape[1:], items, at)


def _rank_of_name(shape: str, items: Sequence[Datum], at: int) -> int:
    datum = items[at]
    if is_word(shape):
        name = datum.name if isinstance(datum, Symbol | Keyword | Arrow) else ""
        return 2 if shape[1:-1] in (name, SLIPS.get(name)) else 0
    if is_rule(shape):
        return _rank(_SHAPES[shape], items, at)
    return 1 if type(datum) in _TYPES.get(shape, (Symbol,)) else 0


def _rank_of_parts(parts: Sequence[Shape], items: Sequence[Datum], at: int) -> int:
    """Return the rank of a sequence: that of the first part that fits.

    Optional parts may be missing. A word after the first part must follow, too: a
    formula begins many lists, but only `for` makes it a condition of a step.
    """
    for number, part in enumerate(parts):
        found = _rank(part, items, at)
        if _may_be_missing(part):
            if found:
                return found
        elif found and number + 1 < len(parts) and is_word(parts[number + 1]):
            return min(found, _rank(parts[number + 1], items, at + 1))
        else:
            return found
    return 1 if at >= len(items) else 0


@cache
def _may_be_missing(shape: Shape) -> bool:
    return isinstance(shape, tuple) and shape[0] in ("*", "?")


def _may_repeat(shape: Shape) -> bool:
    return isinstance(shape, tuple) and shape[0] in ("*", "+", "?", "or")
