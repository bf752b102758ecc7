"""RAP100, RAP102 and RAP103: constants that do not belong where they stand.

A constant is held against what stands at the same place elsewhere, and at places of the
same kind: the values that a closed kind lists, and the constants that the library uses.
A comparison belongs to the places of the variable that is compared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.close_names import Close, is_row
from rapc.analysis.index import INDEX, Form, Index
from rapc.analysis.inferred_kinds import INFERRED
from rapc.analysis.passes.kinds import ANALYZER as KINDS
from rapc.analysis.place_kinds import PlaceKinds
from rapc.analysis.places import PLACES, Place, Places
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
from rapc.base.values import Atom, Text, format_atom, is_number
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

PLAIN = ("unknown", "true", "false", "nil", "t", "okay")
"""Constants that stand anywhere."""

_LEAST = 5
"""How long a word must be to be close to another."""


class _Standing(msgspec.Struct, frozen=True):
    """A constant where it stands."""

    const: nodes.Const
    form: Form
    #: The place that it is at, or those of the variable that it is held against.
    places: tuple[Place, ...]
    #: The kinds of these places.
    kinds: tuple[str, ...]


def _run(run: Pass) -> set[tuple[int, str]]:
    """Report, and return the variables for which a word stands, by the form's id."""
    places = run.result(PLACES)
    standing = list(_standing(run, run.result(INDEX), places))
    known = _Known(run, standing)
    told = run.result(KINDS)
    unmarked: set[tuple[int, str]] = set()
    for one in standing:
        if isinstance(one.form, nodes.DefineTest):
            continue
        if not known.fits(one):
            unmarked.add((id(one.form), f"?{one.const.value}"))
        if id(one.form) in told or not known.fits(one):
            continue
        found = _misspelt(run, known, one) or _mixed(known, one) or _foreign(known, one)
        if found is not None:
            unmarked.add((id(one.form), f"?{one.const.value}"))
            run.report(found)
    return unmarked


ANALYZER = Analyzer(
    name="constants",
    doc="Holds constants against those that stand at the same places elsewhere.",
    run=_run,
    needs=(INDEX, INFERRED, KINDS, PLACES),
    rules=(MISSPELT, FOREIGN, MIXED),
)


# --- what stands where ----------------------------------------------------------------


def _standing(run: Pass, index: Index, places: Places) -> Iterator[_Standing]:
    kinds = PlaceKinds(run.signatures, run.result(INFERRED))
    for one in places.filled:
        if isinstance(one.term, nodes.Const):
            yield _Standing(one.term, one.form, (one.place,), kinds.of((one.place,)))
    for test in index.of(nodes.Compare):
        left, right = test.node.left, test.node.right
        for const, other in ((left, right), (right, left)):
            if isinstance(const, nodes.Const) and isinstance(other, nodes.Var):
                there = tuple(dict.fromkeys(places.of(test.owner, other.name)))
                yield _Standing(const, test.owner, there, kinds.of(there))


class _Known:
    """What the library tells of its constants."""

    def __init__(self, run: Pass, standing: Iterable[_Standing]) -> None:
        self.kinds = run.signatures.kinds
        self.counts: Counter[object] = Counter()
        #: How many constants of each sort stand at a place.
        self.sorts: dict[Place, Counter[str]] = {}
        #: The places and kinds of each constant, with how often it stands there.
        self.at: dict[object, Counter[Place | str]] = {}
        self.first: dict[object, Span] = {}
        self.in_form: Counter[tuple[int, object]] = Counter()
        for one in standing:
            value = one.const.value
            self.counts[value] += 1
            self.in_form[id(one.form), value] += 1
            self.first.setdefault(value, one.const.span)
            keys: tuple[Place | str, ...] = (*one.places, *one.kinds)
            for key in keys:
                self.at.setdefault(value, Counter())[key] += 1
            for place in one.places:
                self.sorts.setdefault(place, Counter())[_sort(value)] += 1
        #: The closed kinds that list a symbol.
        self.listed: dict[object, list[str]] = {}
        for name in self.kinds:
            for value in self._own_values(run, name):
                self.listed.setdefault(value, []).append(name)
                self.counts[value] += 2
                self.at.setdefault(value, Counter())[name] += 2
        for value in _results(run):
            self.counts[value] += 2
        symbols = [v for v in self.counts if _is_word(v)]
        self.close = Close([str(v) for v in symbols], _LEAST)

    def fits(self, one: _Standing) -> bool:
        """Whether a constant is of the kinds of its places."""
        return all(self.kinds.holds(kind, one.const.value) for kind in one.kinds)

    def is_new(self, one: _Standing) -> bool:
        """Whether a constant stands nowhere else in its form, or where such do."""
        value = one.const.value
        keys: tuple[Place | str, ...] = (*one.places, *one.kinds)
        if not keys or self.counts[value] == 1:
            return self.counts[value] == 1
        alone = self.in_form[id(one.form), value] == 1
        return alone and all(self.at[value][key] == 1 for key in keys)

    def _own_values(self, run: Pass, name: str) -> Sequence[Atom]:
        form = run.library.kinds.get(name)
        return (form.values or ()) if form is not None else ()


def _results(run: Pass) -> Iterator[str]:
    for primitive in run.library.primitives.values():
        yield from primitive.results


def _is_word(value: object) -> bool:
    return isinstance(value, str) and not isinstance(value, Text) and value not in PLAIN


# --- what is wrong -------------------------------------------------------------------


def _misspelt(run: Pass, known: _Known, one: _Standing) -> Diagnostic | None:
    value = one.const.value
    if not _is_word(value):
        return None
    if known.is_new(one) and run.result(PLACES).of(one.form, f"?{value}"):
        return _slip(one, f"?{value}", ())
    if known.counts[value] != 1:
        return None
    for other in known.close.all_to(str(value)):
        keys: tuple[Place | str, ...] = (*one.places, *one.kinds)
        together = any(key in known.at[other] for key in keys if other in known.at)
        alike = other[0] == str(value)[0] and not is_row(str(value), other)
        if together and alike and known.counts[other] > 1:
            there = [known.first[other]] if other in known.first else []
            labels = [Label(span, "a constant with a close name") for span in there]
            return _slip(one, other, labels)
    return None


def _slip(one: _Standing, meant: str, labels: Iterable[Label]) -> Diagnostic:
    edit = Edit(one.const.span, meant)
    return Diagnostic(
        rule=MISSPELT.name,
        message=f"`{one.const.value}` stands only here",
        span=one.const.span,
        labels=tuple(labels),
        help=f"did you mean `{meant}`?",
        fix=Fix(Applicability.UNSAFE, f"write `{meant}`", (edit,)),
    )


_ENOUGH = 2
"""So many others at a place make it one of their sort."""

_TRUTH = ("true", "false", "t", "nil")


def _sort(value: object) -> str:
    if is_number(value):
        return "number"
    if value in _TRUTH:
        return "truth value"
    if isinstance(value, Text):
        return "text"
    return "word" if _is_word(value) else ""


def _mixed(known: _Known, one: _Standing) -> Diagnostic | None:
    """A number among words, or a word among numbers; likewise with truth values.

    `false` among words is none: it says that there is no such thing.
    """
    own = _sort(one.const.value)
    if not own or len(one.places) != 1 or one.const.value == "false":
        return None
    there = known.sorts[one.places[0]]
    others = {sort: n for sort, n in there.items() if sort and sort != own}
    if there[own] != 1 or len(others) != 1:
        return None
    ((sort, count),) = others.items()
    if count < _enough(known, one, own, sort):
        return None
    return Diagnostic(
        rule=MIXED.name,
        message=f"`{format_atom(one.const.value)}` stands where all others are {sort}s",
        span=one.const.span,
        help=f"there are {count} of them at this place of `{one.places[0].name}`",
    )


_SURE = 4
"""The same where a property may have a word or none."""


def _enough(known: _Known, one: _Standing, own: str, sort: str) -> int:
    """Return how many others make a sort; where a text is there as a word, one does."""
    value = one.const.value
    words = known.at.get(value.value) if isinstance(value, Text) else None
    if words and words[one.places[0]]:
        return 1
    return _ENOUGH if {"number", "text"} & {own, sort} else _SURE


def _foreign(known: _Known, one: _Standing) -> Diagnostic | None:
    value = one.const.value
    if not _is_word(value) or len(one.kinds) != 1 or len(one.places) != 1:
        return None
    (wanted,) = one.kinds
    if known.at[value][wanted] > 1 or known.kinds.values(wanted) is not None:
        return None
    homes = [k for k, n in known.at[value].items() if isinstance(k, str) and n > 1]
    homes = [kind for kind in homes if kind != wanted]
    if not homes or not all(_strange(known, kind, wanted) for kind in homes):
        return None
    return Diagnostic(
        rule=FOREIGN.name,
        message=f"`{value}` is a {homes[0]}, and a {wanted} is wanted",
        span=one.const.span,
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
