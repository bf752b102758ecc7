"""PDDL domains as RAP libraries: declarations, and RAPs with `effects`.

Types become kinds, predicates become propositions, and actions become RAPs without
methods. A problem adds the values of the kinds, facts and a goal. The reader of RAP
files reads the lists, so sizes and depths are limited as in RAP files.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple, NoReturn

from rapc.base.names import plural
from rapc.base.source import SourceFile, place
from rapc.base.values import Number, format_atom
from rapc.errors import TextError
from rapc.library.kinds import KNOWN_KINDS
from rapc.library.library import BUILTIN_NAMES
from rapc.parser.formatter import formatted
from rapc.parser.parse import parse
from rapc.parser.reader import read
from rapc.parser.syntax import Datum, Keyword, List, Numeral, Symbol, Variable

_ROOT = "object"
"""The type of all objects, which has no kind."""

_PARTS = (":parameters", ":precondition", ":effect")
"""The parts of an action."""

_WORD = re.compile(r"[^()\s]+")

_NO_LOCAL: Mapping[str, str | None] = {}


class Converted(NamedTuple):
    """A domain, and a problem if there is one, as RAP text."""

    library: str
    #: The initial facts of the problem.
    facts: tuple[str, ...]
    #: The goal of the problem; None without a problem.
    goal: str | None
    #: The parts that the library does not have, with their positions.
    left_out: tuple[str, ...]


class _Part(NamedTuple):
    """A formula as RAP text."""

    text: str
    #: The variables to which each solution gives a value.
    bound: frozenset[str] = frozenset()


class _Typed(NamedTuple):
    """A name or a variable with its type, None for any type."""

    name: str
    kind: str | None
    datum: Datum


def converted(domain: SourceFile, problem: SourceFile | None = None) -> Converted:
    """Return a domain and a problem as RAP text.

    Raises:
        TextError: for a text that is not PDDL, and for parts that RAPs cannot express.
    """
    reader = _Domain(domain)
    facts: tuple[str, ...] = ()
    goal: str | None = None
    if problem is not None:
        facts, goal = reader.take_problem(problem)
    library = formatted(SourceFile(domain.name, reader.text())).text
    for found in parse(SourceFile(domain.name, library)).diagnostics:
        said = f"{domain.name}: cannot express the domain as RAPs: {found.message}"
        raise TextError(said)
    return Converted(library, facts, goal, tuple(reader.left_out))


class _Domain:
    """The parts of a domain; reads one file after the other."""

    def __init__(self, source: SourceFile) -> None:
        self._source = source
        self.left_out: list[str] = []
        #: The kinds with the kind above each, and the objects with their kinds.
        self._above: dict[str, str | None] = {}
        self._objects: dict[str, str | None] = {}
        #: The kinds of the arguments of each predicate.
        self._predicates: dict[str, tuple[_Typed, ...]] = {}
        self._actions: dict[str, str] = {}
        #: The variables of an action or a quantifier, with their types.
        self._types: dict[str, str | None] = {}
        #: The constant cost of an action.
        self._cost: Number | None = None
        self._closed = False
        sections = self._sections("domain")
        takes: Mapping[str, Callable[[List], None]] = {
            ":types": self._take_types,
            ":constants": self._take_objects,
            ":predicates": self._take_predicates,
            ":action": self._take_action,
        }
        ignored = (":requirements", ":functions")
        for head, _ in sections:
            if head.name not in (*takes, *ignored):
                self._fail(head, f"unsupported section `{head.name}`")
        for name, take in takes.items():
            for head, section in sections:
                if head.name == name:
                    take(section)

    def take_problem(self, source: SourceFile) -> tuple[tuple[str, ...], str]:
        """Take in the objects of a problem; return its facts and its goal."""
        self._source, self._closed, self._types = source, True, {}
        facts: list[str] = []
        goal = "true"
        ignored = (":domain", ":requirements", ":metric", ":objects")
        sections = self._sections("problem")
        for head, section in sections:
            if head.name == ":objects":
                self._take_objects(section)
        for head, section in sections:
            if head.name == ":init":
                facts += self._facts(section.items[1:])
            elif head.name == ":goal" and len(section.items) == 2:
                goal = self._formula(section.items[1]).text
            elif head.name not in ignored:
                self._fail(head, f"unsupported section `{head.name}`")
        return tuple(facts), goal

    def text(self) -> str:
        """Return the library as unformatted text."""
        forms, own = [], dict[str | None, list[str]]()
        for name, its_kind in self._objects.items():
            own.setdefault(its_kind, []).append(name)
        for kind, above in self._above.items():
            under = f" :is {above}" if above else ""
            values = f" ({' '.join(own.get(kind, ()))})" if self._closed else ""
            forms.append(f"(declare-kind {kind}{under}{values})")
        for name, args in self._predicates.items():
            told = " ".join([_declared(one) for one in args])
            forms.append(f"(declare-memory-proposition {name} ({told}))")
        return "\n".join([*forms, "", "\n\n".join(self._actions.values()), ""])

    # --- sections --------------------------------------------------------------------

    def _sections(self, what: str) -> list[tuple[Keyword, List]]:
        """Return the sections of `(define (domain name) section...)`."""
        reading = read(self._source)
        for found in reading.diagnostics:
            where = place(found.span, {self._source.name: self._source})
            raise TextError(f"{where}: {found.message}")
        data = [top.datum for top in reading.forms]
        form = data[0] if data else List((), 0, 0)
        items = form.items if isinstance(form, List) else ()
        head = items[1].items if len(items) > 1 and isinstance(items[1], List) else ()
        named = [one.name for one in (*items[:1], *head[:1]) if isinstance(one, Symbol)]
        if named != ["define", what] or len(head) != 2:
            self._fail(form, f"expected `(define ({what} NAME) ...)`")
        for more in data[1:]:
            self._fail(more, f"expected the end of the file after the {what}")
        sections: list[tuple[Keyword, List]] = []
        for one in items[2:]:
            first = one.items[0] if isinstance(one, List) and one.items else one
            if not (isinstance(first, Keyword) and isinstance(one, List)):
                self._fail(one, f"expected a section of the {what}: `(:NAME ...)`")
            sections.append((first, one))
        return sections

    def _take_types(self, section: List) -> None:
        for name, above, _ in self._typed(section.items[1:], Symbol):
            kind = self._kind(name)
            if kind is not None:
                self._above[kind] = above
            if above is not None:
                self._above.setdefault(above, None)
        parents = {kind: (above,) for kind, above in self._above.items() if above}
        try:
            TopologicalSorter(parents).prepare()
        except CycleError as error:
            names = ", ".join([f"`{one}`" for one in error.args[1][1:]])
            self._fail(section, f"a type is its own parent: {names}")

    def _take_objects(self, section: List) -> None:
        for name, kind, datum in self._typed(section.items[1:], Symbol):
            self._known_kind(kind, datum)
            self._objects[name] = kind

    def _take_predicates(self, section: List) -> None:
        for item in section.items[1:]:
            name, args = self._atom(item)
            if name in self._predicates:
                self._fail(item, f"duplicate predicate `{name}`")
            found = tuple(self._typed(args, Variable, either=True))
            for one in found:
                self._known_kind(one.kind, one.datum)
            self._predicates[name] = found

    def _typed(
        self,
        items: Sequence[Datum],
        wanted: type[Symbol] | type[Variable],
        either: bool = False,
    ) -> Iterator[_Typed]:
        """Yield the names of `a b - type c`.

        With `either`, a name may have several types; it has no kind then.
        """
        waiting: list[Symbol | Variable] = []
        at = 0
        while at < len(items):
            item = items[at]
            if isinstance(item, Symbol) and item.name == "-":
                kind = items[at + 1] if at + 1 < len(items) else item
                several = either and self._head(kind) == "either"
                name = kind.name if isinstance(kind, Symbol) else "-"
                if name == "-" and not several:
                    self._fail(kind, "expected the name of a type after `-`")
                for one in waiting:
                    yield _Typed(one.name, None if several else self._kind(name), one)
                waiting, at = [], at + 2
            elif isinstance(item, wanted):
                waiting.append(item)
                at += 1
            else:
                what = "a name" if wanted is Symbol else "a variable"
                self._fail(item, f"expected {what}")
        for one in waiting:
            yield _Typed(one.name, None, one)

    def _is_below(self, kind: str | None, above: str | None) -> bool:
        """Return whether all values of a kind are values of another kind."""
        seen = set[str]()
        while kind is not None and kind != above and kind not in seen:
            seen.add(kind)
            kind = self._above[kind]
        return above is None or kind == above

    def _known_kind(self, kind: str | None, datum: Datum) -> None:
        if kind is not None and kind not in self._above:
            self._fail(datum, f"unknown type `{kind}`")

    def _kind(self, name: str) -> str | None:
        """Return the name of the kind of a type; None for the type of all objects."""
        return None if name == _ROOT else _free(name, KNOWN_KINDS)

    def _facts(self, items: Iterable[Datum]) -> Iterator[str]:
        for item in items:
            if self._head(item) == "=":
                continue  # the value of a function
            yield self._fact(item).text

    # --- actions ---------------------------------------------------------------------

    def _take_action(self, section: List) -> None:
        items = section.items[1:]
        if not items or not isinstance(items[0], Symbol):
            self._fail(section, "expected the name of an action")
        name = _free(items[0].name, {*BUILTIN_NAMES, "index"})
        if name in self._actions:
            self._fail(items[0], f"duplicate action `{name}`")
        parts: dict[str, Datum] = {}
        for at in range(1, len(items), 2):
            key = items[at]
            if not isinstance(key, Keyword) or key.name not in _PARTS:
                self._fail(key, f"expected {', '.join(_PARTS)}")
            if at + 1 == len(items) or key.name in parts:
                self._fail(key, f"expected one list after `{key.name}`")
            parts[key.name] = items[at + 1]
        found = parts.get(":parameters", List((), 0, 0))
        inputs = tuple(self._typed(self._items(found), Variable))
        for one in inputs:
            self._known_kind(one.kind, one.datum)
        self._types = {one.name: one.kind for one in inputs}
        clauses = []
        condition = parts.get(":precondition")
        needed = None if condition is None else self._formula(condition).text
        if needed not in (None, "true"):
            clauses.append(f"(preconditions {needed})")
        effect = parts.get(":effect")
        self._cost = None
        told = () if effect is None else self._effects(effect, {}, "{}")
        effects = " ".join(dict.fromkeys(told))
        if effects:
            clauses.append(f"(effects {effects})")
        if self._cost is not None:
            clauses.append(f"(duration {format_atom(self._cost)})")
        text = " ".join(clauses)
        index, used = [name], set(_WORD.findall(text))
        for one in inputs:
            if one.name in used:
                index.append(_declared(one))
            else:
                said = f"the parameter `{one.name}`: no condition or effect has it"
                self.left_out.append(f"{self._place(one.datum)}: {said}")
        self._actions[name] = f"(define-rap ({' '.join(index)}) {text})"

    def _effects(
        self, effect: Datum, local: Mapping[str, str | None], form: str
    ) -> Iterator[str]:
        """Yield effects as text.

        Args:
            effect: the effect.
            local: the variables of quantifiers, with their types.
            form: the form of a fact: `{}` or `(may {})`.
        """
        head, items = self._head(effect), self._items(effect)
        if head == "and":
            for item in items[1:]:
                yield from self._effects(item, local, form)
        elif head == "forall" and len(items) == 3:
            own = {
                one.name: one.kind
                for one in self._typed(self._items(items[1]), Variable)
            }
            yield from self._effects(items[2], {**local, **own}, form)
        elif head == "when" and len(items) == 3:
            yield from self._effects(items[2], local, "(may {})")
        elif head == "increase" and len(items) == 3:
            self._take_cost(effect, items[1], items[2])
        elif head == "not" and len(items) == 2:
            fact = self._fact(items[1], local).text
            yield f"(not {fact})" if form == "{}" else form.format(fact)
        else:
            fact = self._fact(effect, local).text
            if form == "{}" and "?" in fact[1:-1].split():
                self._fail(effect, "unsupported: an effect that adds several facts")
            yield form.format(fact)

    def _take_cost(self, effect: Datum, function: Datum, value: Datum) -> None:
        if self._head(function) != "total-cost":
            self._fail(effect, "unsupported: a numeric effect")
        if isinstance(value, Numeral):
            self._cost = value.value
        else:
            self.left_out.append(f"{self._place(effect)}: a cost that is not constant")

    # --- formulas --------------------------------------------------------------------

    def _formula(self, datum: Datum, negated: bool = False) -> _Part:
        """Return a formula, or its negation."""
        items = self._items(datum)
        head, rest = self._head(datum) if items else "and", items[1:]
        if head in ("and", "or"):
            parts = [self._formula(one, negated) for one in rest]
            found = _and(parts) if (head == "and") != negated else _or(parts)
        elif head == "not" and len(rest) == 1:
            found = self._formula(rest[0], not negated)
        elif head == "imply" and len(rest) == 2:
            first = self._formula(rest[0], not negated)
            parts = [first, self._formula(rest[1], negated)]
            found = _and(parts) if negated else _or(parts)
        elif head in ("exists", "forall") and len(rest) == 2:
            found = self._quantifier(datum, head, negated)
        elif head == "=" and len(rest) == 2:
            left, right = [self._term(one, {}) for one in rest]
            found = _Part(f"({'n=' if negated else '='} {left} {right})")
        else:
            found = self._fact(datum)
            found = _Part(f"(not {found.text})") if negated else found
        return found

    def _quantifier(self, datum: Datum, head: str, negated: bool) -> _Part:
        """Return a quantified formula: `forall` is a negated `exists`."""
        _, variables, body = self._items(datum)
        own = tuple(self._typed(self._items(variables), Variable))
        before = dict(self._types)
        for one in own:
            self._known_kind(one.kind, one.datum)
            if one.name in before:
                self._fail(one.datum, f"unsupported: `{one.name}` has two meanings")
            self._types[one.name] = one.kind
        part = self._formula(body, negated=head == "forall")
        for one in own:
            if one.name not in part.bound:
                said = f"no fact in `{head}` gives `{one.name}` a value of its type"
                self._fail(one.datum, f"unsupported: {said}")
        uses = Counter(_WORD.findall(part.text))
        once = {one.name for one in own if uses[one.name] == 1}
        text = _WORD.sub(lambda word: "?" if word[0] in once else word[0], part.text)
        self._types = before
        positive = (head == "exists") != negated
        return _Part(text, part.bound) if positive else _Part(f"(not {text})")

    def _fact(self, datum: Datum, local: Mapping[str, str | None] = _NO_LOCAL) -> _Part:
        """Return a fact; variables of `local` become `?`."""
        name, args = self._atom(datum)
        declared = self._predicates.get(name)
        if declared is None:
            self._fail(datum, f"unknown predicate `{name}`")
        if len(declared) != len(args):
            wanted = plural(len(declared), "argument")
            said = f"`{name}` takes {wanted}, not {len(args)}"
            self._fail(datum, said)
        found, bound = [], set[str]()
        for arg, one in zip(args, declared, strict=True):
            found.append(self._term(arg, local))
            if isinstance(arg, Variable):
                kind = local.get(arg.name) or self._types.get(arg.name)
                if self._is_below(one.kind, kind):
                    bound.add(arg.name)
                elif arg.name in local:
                    said = f"an effect on `{name}` for the values of one type"
                    self._fail(arg, f"unsupported: {said}")
        named = [arg.name for arg in args if isinstance(arg, Variable)]
        for own in local:
            if named.count(own) > 1:
                self._fail(datum, f"unsupported: `{own}` twice in a fact")
        return _Part(f"({' '.join([name, *found])})", frozenset(bound))

    def _term(self, datum: Datum, local: Mapping[str, str | None]) -> str:
        if isinstance(datum, Variable):
            if datum.name in local:
                return "?"
            if datum.name in self._types:
                return datum.name
            self._fail(datum, f"unknown variable `{datum.name}`")
        if not isinstance(datum, Symbol):
            self._fail(datum, "expected a variable or an object")
        if datum.name not in self._objects:
            self._fail(datum, f"unknown object `{datum.name}`")
        return datum.name

    # --- data ------------------------------------------------------------------------

    def _atom(self, datum: Datum) -> tuple[str, Sequence[Datum]]:
        """Return the predicate of an atom, as RAP allows it, and the arguments."""
        head, items = self._head(datum), self._items(datum)
        if not head:
            self._fail(datum, "expected a predicate with its arguments")
        return _free(head, BUILTIN_NAMES), items[1:]

    def _items(self, datum: Datum) -> Sequence[Datum]:
        return (
            datum.items
            if isinstance(datum, List)
            else self._fail(datum, "expected a list")
        )

    def _head(self, datum: Datum) -> str:
        """Return the symbol at the beginning of a list; empty without one."""
        first = datum.items[0] if isinstance(datum, List) and datum.items else None
        return first.name if isinstance(first, Symbol) else ""

    def _place(self, datum: Datum) -> str:
        span = self._source.span(datum.start, datum.end)
        return place(span, {self._source.name: self._source})

    def _fail(self, datum: Datum, message: str) -> NoReturn:
        raise TextError(f"{self._place(datum)}: {message}")


def _and(parts: Sequence[_Part]) -> _Part:
    bound = frozenset[str]().union(*[one.bound for one in parts])
    return _Part(_list("and", parts, "true"), bound)


def _or(parts: Sequence[_Part]) -> _Part:
    every = [one.bound for one in parts]
    bound = every[0].intersection(*every[1:]) if every else frozenset[str]()
    return _Part(_list("or", parts, "false"), bound)


def _list(head: str, parts: Sequence[_Part], empty: str) -> str:
    if len(parts) < 2:
        return parts[0].text if parts else empty
    return f"({' '.join([head, *[one.text for one in parts]])})"


def _declared(one: _Typed) -> str:
    return one.name if one.kind is None else f"({one.name} {one.kind})"


def _free(name: str, taken: Container[str]) -> str:
    """Return a name, with an ending if RAP has another meaning for the name."""
    return f"{name}-1" if name in taken else name
