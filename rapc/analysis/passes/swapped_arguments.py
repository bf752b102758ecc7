"""RAP101: arguments that stand in each other's places.

Every use of a name gives its places terms, and each term stands at other places as
well. Where other forms of the library link the first term's places with the second
place, and the second term's with the first, and none links them as they stand, the two
were swapped. A constant is linked with each place at which it stands elsewhere.

An example: `(at ?room ?cart)`. Elsewhere `?room` is an input of `enter`, and all other
forms that hand a variable to `enter` have it from the second place of `at`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import permutations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX, Form, NameUse
from rapc.analysis.passes.kinds import ANALYZER as KINDS
from rapc.analysis.places import PLACES, SPACES, Place, Places
from rapc.base.diagnostics import Applicability, Diagnostic, Edit, Fix, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_term

_BOXES = """\
(declare-memory-proposition inside (?thing ?box))
(declare-primitive open (?box) (okay))
(declare-primitive lift (?thing) (okay))
(define-rap (unpack ?thing)
  (method (context (inside ?thing ?box)) (primitive (open ?box))))
(define-rap (take ?thing)
  (preconditions (inside ?thing ?))
  (method (primitive (lift ?thing))))
(define-rap (free ?thing)
  (method (context (inside ?thing ?box)) (primitive (open ?box))))
(define-rap (empty-out ?box)
  (method one
    (context (inside {}))
    (task-net (t1 (unpack ?thing) (for t2)) (t2 (take ?thing))))
  (method shake (primitive (open ?box))))
"""
"""Things in boxes; what one method asks is left open."""

SWAPPED = Rule(
    code="RAP101",
    name="swapped-arguments",
    severity=Severity.WARNING,
    summary="two arguments seem to stand in each other's places",
    why="""Nothing tells a fact with its arguments swapped from another fact: it is
asked and asserted, and never means what was meant. Two arguments are told of if in all
of the library the first is otherwise used like the second, and the second like the
first. Say the kinds of arguments in their declarations (`(?room room)`), and no guess
is needed.""",
    fix="unsafe: swaps the two",
    ignore="where a relation holds both ways, so that either order is meant",
    source="T 4.1",
    example=_BOXES.format("?box ?thing"),
    better=_BOXES.format("?thing ?box"),
)

_MOST_PLACES = 12
"""A variable with more places in a form is held against the first so many."""

_MOST_ARGUMENTS = 6
"""Of a name with more arguments only the first so many are held against each other."""

_Point = Place | tuple[str, object]
"""A place, or a constant."""

_PLAIN = ("unknown", "true", "false", "nil", "t")
"""Constants that stand anywhere."""


class _Links:
    """In how many forms two places, or a constant and a place, go together.

    A declaration counts as two RAPs do. Places and constants are told by numbers, and
    what goes together by a pair of these.
    """

    def __init__(self, places: Places) -> None:
        self._numbers: dict[_Point, int] = {}
        self._forms: dict[tuple[int, int], int] = {}
        self._rows: dict[int, dict[str, tuple[int, ...]]] = {}
        self._own: dict[int, list[set[int]]] = {}
        self._places: dict[tuple[str, str], list[int]] = {}
        for form, variables in places.forms():
            rows = self._rows[id(form)] = {
                name: tuple(dict.fromkeys(map(self._number, found)))[:_MOST_PLACES]
                for name, found in variables.items()
            }
            self._own[id(form)] = [set(row) for row in rows.values()]
            weight = 1 if isinstance(form, nodes.DefineRap | nodes.DefineTest) else 2
            pairs = {pair for row in rows.values() for pair in permutations(row, 2)}
            self._add(pairs, weight)
        for form, constants in _constants(places):
            pairs = set()
            for value, found in constants.items():
                own = self._number(("constant", value))
                there = {self._number(place) for place in found}
                pairs.update((own, place) for place in there)
                self._own.setdefault(id(form), []).append({own, *there})
            self._add(pairs, 1)

    def _number(self, point: _Point) -> int:
        return self._numbers.setdefault(point, len(self._numbers))

    def _add(self, pairs: Iterable[tuple[int, int]], weight: int) -> None:
        for pair in pairs:
            self._forms[pair] = self._forms.get(pair, 0) + weight

    def places(self, space: str, name: str) -> Sequence[int]:
        """Return the numbers of the first places of a name."""
        found = self._places.get((space, name))
        if found is None:
            places = (Place(space, name, at) for at in range(_MOST_ARGUMENTS))
            found = self._places[space, name] = [self._number(at) for at in places]
        return found

    def points(self, form: Form, term: nodes.Term, places: Sequence[int]) -> list[int]:
        """Return what speaks for a term of a form: its other places, or itself."""
        if isinstance(term, nodes.Const):
            plain = term.value in _PLAIN or not isinstance(term.value, str)
            return [] if plain else [self._number(("constant", term.value))]
        if not isinstance(term, nodes.Var):
            return []
        row = self._rows.get(id(form), {}).get(term.name, ())
        return [place for place in row if place not in places]

    def alike(self, one: int, other: int) -> bool:
        """Whether one variable stands at both places: what fits one fits the other."""
        return (one, other) in self._forms

    def elsewhere(self, form: Form, points: Sequence[int], place: int) -> int:
        """Return in how many other forms one of the points goes with a place."""
        most = 0
        for point in points:
            count = self._forms.get((point, place), 0)
            if count > most:
                own = any(
                    point in there and place in there
                    for there in self._own.get(id(form), ())
                )
                most = max(most, count - own)
        return most


def _constants(
    places: Places,
) -> Iterator[tuple[Form, Mapping[object, Sequence[Place]]]]:
    """Yield the forms that have constants, with the places of each."""
    found: dict[int, tuple[Form, dict[object, list[Place]]]] = {}
    for one in places.filled:
        if isinstance(one.term, nodes.Const):
            _, there = found.setdefault(id(one.form), (one.form, {}))
            there.setdefault(one.term.value, []).append(one.place)
    return iter(found.values())


def _run(run: Pass) -> None:
    links = _Links(run.result(PLACES))
    told = run.result(KINDS)
    best: dict[int, tuple[int, Diagnostic]] = {}
    for used in run.result(INDEX).uses():
        form = used.owner
        if isinstance(form, nodes.DefineTest) or id(form) in told:
            continue
        for support, found in _swapped(links, used) if used.count > 1 else ():
            if support > best.get(id(form), (0, found))[0]:
                best[id(form)] = (support, found)
    for _, found in best.values():
        run.report(found)


ANALYZER = Analyzer(
    name="swapped-arguments",
    doc="Finds arguments that stand in each other's places.",
    run=_run,
    needs=(INDEX, KINDS, PLACES),
    rules=(SWAPPED,),
)


def _swapped(links: _Links, used: NameUse) -> Iterator[tuple[int, Diagnostic]]:
    """Yield two arguments that were swapped, with how much speaks for that."""
    terms = used.node.args[:_MOST_ARGUMENTS]
    places = links.places(SPACES[used.use], used.name)
    for one in range(len(terms)):
        for other in range(one + 1, len(terms)):
            pair = (terms[one], terms[other])
            if pair[0] != pair[1]:
                support = _support(links, used, pair, (places[one], places[other]))
                if support:
                    yield support, _finding(used, pair)


def _support(
    links: _Links,
    used: NameUse,
    terms: tuple[nodes.Term, nodes.Term],
    places: tuple[int, int],
) -> int:
    """Return how many other places say that two arguments were swapped."""
    form = used.owner
    if links.alike(*places):
        return 0
    points = [links.points(form, term, places) for term in terms]
    if any(map(links.elsewhere, (form, form), points, places)):
        return 0
    turned = [
        [links.elsewhere(form, [point], place) for point in there]
        for there, place in zip(points, reversed(places), strict=True)
    ]
    if all(any(there) for there in turned):
        counts = [count for there in turned for count in there if count]
        return len(counts) if max(counts) > 1 else 0
    lone = [at for at, term in enumerate(terms) if _is_open(term)]
    if len(lone) != 1 or not isinstance(terms[1 - lone[0]], nodes.Const):
        return 0
    often = links.elsewhere(form, points[1 - lone[0]], places[lone[0]])
    return 1 if often >= _OFTEN else 0


_OFTEN = 3
"""In so many forms a constant beside a bare `?` stands in the place of that."""


def _is_open(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Var) and term.anonymous


def _finding(used: NameUse, terms: tuple[nodes.Term, nodes.Term]) -> Diagnostic:
    one, other = (format_term(term) for term in terms)
    spans: Mapping[int, Span] = {0: terms[0].span, 1: terms[1].span}
    return Diagnostic(
        rule=SWAPPED.name,
        message=f"`{one}` and `{other}` seem to be swapped",
        span=Span(used.span.file, spans[0].start, spans[1].end),
        help=f"everywhere else in the library the arguments of `{used.name}` are used "
        "the other way round",
        fix=Fix(
            Applicability.UNSAFE,
            "swap the two",
            (Edit(spans[0], other), Edit(spans[1], one)),
        ),
    )
