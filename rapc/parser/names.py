"""The names in a form, found in its data: each with its name space and span.

Nodes have no spans for many names: tags, results, methods, data in `:tells`. This
module walks the data of a form along the shapes of the grammar, whose terminals state
the kind of each name. Data that fit no shape are skipped: a form with faults gives the
names of its valid parts. The check does not use this module.

Not here: the definition and all occurrences of a name (`rapc.analysis.naming`).
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from functools import cache, cached_property
from typing import Literal

import msgspec

from rapc.base.source import Span
from rapc.language.grammar import RULES
from rapc.language.heads import SLIPS
from rapc.language.shapes import Shape, is_rule, is_word
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
    "listed": ("list",),
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
    walk.take(_part("_form"), (form,), 0, "")
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

    def take(self, part: _Part, items: Sequence[Datum], at: int, rule: str) -> int:
        """Walk the data that fit a part of a rule; return the position after the data.

        Args:
            part: the part.
            items: the data of a list.
            at: the position of the first datum.
            rule: the rule of the part.
        """
        if at >= len(items) or not part.rank(items[at]):
            return at
        match part.operator:
            case "rule":
                return self.take(part.parts[0], items, at, part.name or rule)
            case "list":
                self._list(part, items[at], rule)
            case "or":
                best = max(part.parts, key=lambda one: one.rank(items[at]))
                return self.take(best, items, at, rule)
            case "seq" | "?":
                for one in part.parts:
                    at = self.take(one, items, at, rule)
                return at
            case "*" | "+":
                (one,) = part.parts
                while (after := self.take(one, items, at, rule)) > at:
                    at = after
                return at
            case "terminal":
                self._name(part.name, items[at], rule)
        return at + 1

    def _list(self, part: _Part, datum: Datum, rule: str) -> None:
        """Walk a list; data that fit no part are skipped."""
        assert isinstance(datum, List)
        outer = self.scope
        if rule in ("method", "define_method"):
            self.scope = Span(self.file, datum.start, datum.end)
        elif rule == "event_pattern":
            self.named = ""  # the RAP of the preceding pattern
        at, items = 0, datum.items
        for one in part.parts:
            at = self.take(one, items, at, rule)
        while at < len(items):
            before = at
            for one in part.loose:
                at = self.take(one, items, at, rule)
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


class _Begin(msgspec.Struct, frozen=True):
    """The data with which a part of a rule may begin."""

    #: The words and the types of atoms.
    words: frozenset[str] = frozenset()
    types: frozenset[type] = frozenset()
    #: The first words of lists, and the types of their first items.
    heads: frozenset[str] = frozenset()
    firsts: frozenset[type] = frozenset()

    @classmethod
    def of_any(cls, parts: Iterable[_Part]) -> _Begin:
        """Return the data with which any of some parts may begin."""
        rows = [msgspec.structs.astuple(part.begin) for part in parts]
        return cls(*[frozenset().union(*column) for column in zip(*rows, strict=True)])


class _Part:
    """A part of a rule; rules contain each other, so its parts are made when needed.

    Args:
        shape: the shape of the part.
    """

    def __init__(self, shape: Shape) -> None:
        self._shape = shape
        self.operator = "terminal"
        #: The name of a rule or terminal; none for a group of rules.
        self.name = ""
        if not isinstance(shape, str):
            self.operator = str(shape[0])
        elif is_word(shape):
            self.operator = "word"
        elif is_rule(shape):
            self.operator = "rule"
            self.name = "" if shape[0] == "_" else shape
        else:
            self.name = shape

    @cached_property
    def parts(self) -> tuple[_Part, ...]:
        """The parts of a list, choice or sequence, or of a rule its only part."""
        shape = self._shape
        if isinstance(shape, str):
            return (_part(_SHAPES[shape]),)
        return tuple(map(_part, shape[1:]))

    @cached_property
    def begin(self) -> _Begin:
        """The data with which the part may begin."""
        if self.operator == "word":
            return _Begin(words=frozenset((str(self._shape)[1:-1],)))
        if self.operator == "terminal":
            return _Begin(types=frozenset(_TYPES.get(self.name, (Symbol,))))
        if self.operator not in ("list", "seq"):
            return _Begin.of_any(self.parts)
        needed = [n for n, one in enumerate(self.parts) if not one.is_optional]
        found = _Begin.of_any(self.parts[: needed[0] + 1] if needed else self.parts)
        if self.operator == "seq":
            return found
        lists = {List} if found.heads or found.firsts else set()
        return _Begin(heads=found.words, firsts=found.types | lists)

    @property
    def is_optional(self) -> bool:
        """Whether the part may be missing."""
        return self.operator in ("?", "*")

    @cached_property
    def loose(self) -> tuple[_Part, ...]:
        """The parts of a list from the first one that may be missing or repeated."""
        at = [n for n, one in enumerate(self.parts) if one.operator in _LOOSE]
        return self.parts[at[0] :] if at else ()

    def rank(self, datum: Datum) -> int:
        """Return how well a datum fits the start: 2 for a word, 1 for a type, or 0."""
        begin, first = self.begin, datum
        words, types = begin.words, begin.types
        if isinstance(datum, List):
            words, types = begin.heads, begin.firsts
            if not datum.items:
                return bool(words or types)
            first = datum.items[0]
        name = first.name if isinstance(first, Symbol | Keyword | Arrow) else ""
        if name in words or SLIPS.get(name) in words:
            return 2
        return type(first) in types


_LOOSE = ("*", "+", "?", "or")

_part = cache(_Part)
"""The part of a shape."""
