"""RAP100, RAP102 and RAP103: constants that do not belong where they stand.

A constant is held against what stands at the same place elsewhere, and at places of the
same kind: the values that a closed kind lists, and the constants that the library uses.
A comparison belongs to the places of the variable that is compared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence

import msgspec

from rapc.analysis.check import Fact, Pass, Reported, check
from rapc.analysis.checks.kinds import KINDS
from rapc.analysis.facts.index import Form
from rapc.analysis.facts.names import Close, is_row
from rapc.analysis.facts.usage import (
    CENSUS,
    PLACE_KINDS,
    PLACES,
    Place,
    PlaceKinds,
    place_parts,
    sort_of,
)
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.base.values import Atom, Text, format_atom
from rapc.ir import nodes

MISSPELT = Rule(
    code="RAP100",
    name="misspelt-constant",
    severity=Severity.WARNING,
    summary="a constant is used only once, and another one there is spelled almost so",
    why="""A constant that nobody else uses is a value that never comes up: a fact with
it is never found, a test of it never passes. Where a constant that differs by one slip
of the pen stands at the same place, or is a value of the same kind, that one was meant;
where the form has a variable of that name, the question mark is missing. A closed kind
(`declare-kind`) makes sure.""",
    fix="unsafe: writes the constant that is spelled almost so, or the variable",
    ignore="where the value comes from outside, and another one is spelled almost so",
    source="T 4.1",
    example="""\
(declare-memory-property door-state (?door ?state) unknown)
(declare-primitive push (?door) (okay))
(declare-primitive free (?door) (okay))
(define-rap (open ?door)
  (preconditions (not (door-state ?door locked)))
  (method (context (not (door-state ?door jammed))) (primitive (push ?door)))
  (method (context (door-state ?door jamed)) (primitive (free ?door)))
  (method (context (door-state ?door jammed)) (primitive (free ?door))))
""",
    better="""\
(declare-memory-property door-state (?door ?state) unknown)
(declare-primitive push (?door) (okay))
(declare-primitive free (?door) (okay))
(define-rap (open ?door)
  (preconditions (not (door-state ?door locked)))
  (method (context (not (door-state ?door jammed))) (primitive (push ?door)))
  (method (context (door-state ?door jammed)) (primitive (free ?door))))
""",
)

FOREIGN = Rule(
    code="RAP102",
    name="foreign-constant",
    severity=Severity.WARNING,
    summary="a constant of one kind stands where values of another are wanted",
    why="""A symbol that a closed kind lists, or that the library uses as a value of one
kind, is hardly one of another kind: an arm is no class of things. Mostly an argument
was left out, or stands in another's place. If the symbol is meant to be of both kinds,
say so with `:is`.""",
    ignore="where one word is a value of both kinds: say so with `:is`",
    source="L 7",
    example="""\
(declare-kind arm (left-arm right-arm))
(declare-kind class)
(declare-memory-property class-of (?thing (?class class)) unknown)
(declare-memory-proposition holding ((?arm arm) ?thing))
(define-rap (show ?thing)
  (preconditions (and (holding ? ?thing) (class-of ?thing left-arm))))
""",
    better="""\
(declare-kind arm (left-arm right-arm))
(declare-kind class)
(declare-memory-property class-of (?thing (?class class)) unknown)
(declare-memory-proposition holding ((?arm arm) ?thing))
(define-rap (show ?thing)
  (preconditions (and (holding left-arm ?thing) (class-of ?thing cup))))
""",
)

MIXED = Rule(
    code="RAP103",
    name="mixed-values",
    severity=Severity.WARNING,
    summary="a number, word or truth value stands where all others are of another sort",
    why="""No number equals a word. Where words stand everywhere else in the library, a
fact with a number, or with `true`, is never found; and the other way round. `unknown`
goes with all.""",
    ignore="where a place takes values of several sorts on purpose, as a label may",
    source="L 2",
    example="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (pass ?door)
  (preconditions (not (door-state ?door locked)))
  (constraints (not (door-state ?door shut)))
  (succeed (door-state ?door 1)))
""",
    better="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (pass ?door)
  (preconditions (not (door-state ?door locked)))
  (constraints (not (door-state ?door shut)))
  (succeed (door-state ?door open)))
""",
)

_LEAST = 5
"""How long a word must be to be close to another."""


class _Standing(msgspec.Struct, frozen=True):
    """A constant where it stands."""

    const: nodes.Const
    #: As it is written.
    written: str
    form: Form
    #: The place that it is at, or those of the variable that it is held against.
    places: tuple[Place, ...]
    #: The kinds of these places.
    kinds: tuple[str, ...]
    #: Its sort by how it is written (`census.sort_of`): `word` is a symbol that means
    #: something of its own, nothing what goes with all.
    sort: str


def _run(run: Pass) -> Reported[Collection[tuple[int, str]]]:
    """Return the findings, and the variables for which words stand, by form."""
    known = _Known(run)
    told = run.result(KINDS).value
    every: list[Diagnostic] = []
    unmarked: dict[tuple[int, str], None] = {}
    for one in _standing(run, known.place_kinds):
        if isinstance(one.form, nodes.DefineTest):
            continue
        if not known.fits(one):
            unmarked[id(one.form), f"?{one.const.value}"] = None
            continue
        if id(one.form) in told or not one.sort:
            continue
        found = _misspelt(run, known, one) or _mixed(known, one) or _foreign(known, one)
        if found is not None:
            unmarked[id(one.form), f"?{one.const.value}"] = None
            every.append(found)
    return Reported(every, unmarked)


CONSTANTS = Fact(_run)


@check(MISSPELT, FOREIGN, MIXED)
def constants(run: Pass) -> Iterable[Diagnostic]:
    """Compare constants with those that stand at the same places elsewhere."""
    return run.result(CONSTANTS).findings


# --- what stands where ----------------------------------------------------------------


def _standing(run: Pass, kinds: PlaceKinds) -> Iterator[_Standing]:
    for one in run.result(PLACES).constants:
        sort = sort_of(one.written)
        wanted = kinds.of(one.places)
        yield _Standing(one.const, one.written, one.form, one.places, wanted, sort)


class _Stands(msgspec.Struct, frozen=True):
    """How often a constant stands where."""

    places: Counter[Place]
    kinds: Counter[str]


class _Known:
    """What the library tells of its constants, by how they are written."""

    def __init__(self, run: Pass) -> None:
        self.kinds = run.signatures.kinds
        self.place_kinds = run.result(PLACE_KINDS)
        self.census = run.result(CENSUS)
        #: How often a declaration lists a constant; such a one counts twice.
        self._listed: Counter[str] = Counter()
        self._listing: dict[str, list[str]] = {}
        for name in self.kinds:
            for value in self._own_values(run, name):
                self._listed[format_atom(value)] += 2
                self._listing.setdefault(format_atom(value), []).append(name)
        for value in _results(run):
            self._listed[value] += 2
        self._at: dict[str, _Stands] = {}
        self._sorts: dict[Place, Counter[str]] = {}
        self._forms: dict[str, Counter[int]] = {}
        self._close: Close | None = None

    def count(self, written: str) -> int:
        """Return how often a constant stands in the library."""
        return len(self.census.standing(written)) + self._listed[written]

    def at(self, written: str) -> _Stands:
        """Return the places and kinds of a constant, with how often it stands there."""
        found = self._at.get(written)
        if found is None:
            found = self._at[written] = _Stands(Counter(), Counter())
            for one in self.census.standing(written):
                found.places.update(one.places)
                found.kinds.update(self.place_kinds.of(one.places))
            for name in self._listing.get(written, ()):
                found.kinds[name] += 2
        return found

    def sorts(self, place: Place) -> Counter[str]:
        """Return how many constants of each sort stand at a place."""
        found = self._sorts.get(place)
        if found is None:
            every = [one.written for one in self.census.at(place)]
            found = self._sorts[place] = Counter(map(sort_of, every))
        return found

    def first(self, written: str) -> Iterator[Span]:
        """Yield where a constant stands first, if it does."""
        for one in self.census.standing(written)[:1]:
            yield one.const.span

    def close_to(self, written: str) -> Iterator[str]:
        """Yield the words that are spelled almost like another."""
        if self._close is None:
            words = dict.fromkeys((*self.census.written(), *self._listed))
            only = [word for word in words if sort_of(word) == "word"]
            self._close = Close(only, _LEAST)
        return self._close.all_to(written)

    def fits(self, one: _Standing) -> bool:
        """Whether a constant is of the kinds of its places."""
        return all(self.kinds.holds(kind, one.const.value) for kind in one.kinds)

    def is_new(self, one: _Standing) -> bool:
        """Whether a constant stands nowhere else in its form, or where such do."""
        if not one.places or self.count(one.written) == 1:
            return self.count(one.written) == 1
        there = self.at(one.written)
        return (
            self._in_form(one) == 1
            and all(there.places[place] == 1 for place in one.places)
            and all(there.kinds[kind] == 1 for kind in one.kinds)
        )

    def _in_form(self, one: _Standing) -> int:
        forms = self._forms.get(one.written)
        if forms is None:
            every = self.census.standing(one.written)
            forms = self._forms[one.written] = Counter(
                [id(found.form) for found in every]
            )
        return forms[id(one.form)]

    def _own_values(self, run: Pass, name: str) -> Sequence[Atom]:
        form = run.library.kinds.get(name)
        return (form.values or ()) if form is not None else ()


def _results(run: Pass) -> Iterator[str]:
    for primitive in run.library.primitives.values():
        yield from primitive.results


# --- what is wrong -------------------------------------------------------------------


def _misspelt(run: Pass, known: _Known, one: _Standing) -> Diagnostic | None:
    word = one.written
    if one.sort != "word":
        return None
    if known.is_new(one) and run.result(PLACES).of(one.form, f"?{word}"):
        return _slip(one, f"?{word}", ())
    if known.count(word) != 1:
        return None
    for other in known.close_to(word):
        there = known.at(other)
        together = not there.places.keys().isdisjoint(one.places)
        together = together or not there.kinds.keys().isdisjoint(one.kinds)
        alike = other[0] == word[0] and not is_row(word, other)
        if together and alike and known.count(other) > 1:
            labels = [
                Label(span, "a constant with a close name")
                for span in known.first(other)
            ]
            return _slip(one, other, labels)
    return None


def _slip(one: _Standing, meant: str, labels: Iterable[Label]) -> Diagnostic:
    edit = Edit(one.const.span, meant)
    return MISSPELT.at(
        one.const.span,
        f"`{one.const.value}` stands only here",
        labels=tuple(labels),
        help=f"did you mean `{meant}`?",
        fix=Fix(Applicability.UNSAFE, f"write `{meant}`", (edit,)),
    )


_ENOUGH = 2
"""So many others at a place make it one of their sort."""


def _mixed(known: _Known, one: _Standing) -> Diagnostic | None:
    """A number among words, or a word among numbers; likewise with truth values.

    `false` among words is none: it says that there is no such thing.
    """
    own = one.sort
    if len(one.places) != 1 or one.const.value == "false":
        return None
    there = known.sorts(one.places[0])
    others = {sort: n for sort, n in there.items() if sort and sort != own}
    if there[own] != 1 or len(others) != 1:
        return None
    ((sort, count),) = others.items()
    if count < _enough(known, one, own, sort):
        return None
    _, name, _ = place_parts(one.places[0])
    return MIXED.at(
        one.const.span,
        f"`{format_atom(one.const.value)}` stands where all others are {sort}s",
        help=f"there are {count} of them at this place of `{name}`",
    )


_SURE = 4
"""The same where a property may have a word or none."""


def _enough(known: _Known, one: _Standing, own: str, sort: str) -> int:
    """Return how many others make a sort; where a text is there as a word, one does."""
    value = one.const.value
    word = value.value if isinstance(value, Text) else ""
    if sort_of(word) not in ("number", "text") and known.at(word).places[one.places[0]]:
        return 1
    return _ENOUGH if {"number", "text"} & {own, sort} else _SURE


def _foreign(known: _Known, one: _Standing) -> Diagnostic | None:
    if one.sort != "word" or len(one.kinds) != 1 or len(one.places) != 1:
        return None
    (wanted,) = one.kinds
    there = known.at(one.written).kinds
    if there[wanted] > 1 or known.kinds.values(wanted) is not None:
        return None
    homes = [kind for kind, n in there.items() if n > 1 and kind != wanted]
    if not homes or not all(_strange(known, kind, wanted) for kind in homes):
        return None
    return FOREIGN.at(
        one.const.span,
        f"`{one.written}` is a {homes[0]}, and a {wanted} is wanted",
        help="is it the argument that was meant here?",
    )


def _strange(known: _Known, kind: str, wanted: str) -> bool:
    """Whether values of a kind are hardly of another; kinds named alike are related."""
    if set(kind.split("-")) & set(wanted.split("-")):
        return False
    if wanted in ("item", "symbol"):
        above = known.kinds.above(kind)
        return known.kinds.values(kind) is not None and "item" not in above
    return known.kinds.apart(kind, wanted)
