"""RAP101: arguments that stand in each other's places.

Every use of a name gives its places terms, and each term stands at other places as
well. Where other forms of the library link the first term's places with the second
place, and the second term's with the first, and none links them as they stand, the two
were swapped. A constant is linked with each place at which it stands elsewhere.

An example: `(at ?room ?cart)`. Elsewhere `?room` is an input of `enter`, and all other
forms that hand a variable to `enter` have it from the second place of `at`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.census import CENSUS, Census
from rapc.analysis.file_census import MOST_PLACES, form_key
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

_MOST_ARGUMENTS = 6
"""Of a name with more arguments only the first so many are held against each other."""

_PLAIN = ("unknown", "true", "false", "nil", "t")
"""Constants that stand anywhere."""

_Point = Place | str
"""A place, or a constant as it is written."""


_NO_FORM = ("", 0)
"""The key of no form at all."""


class _Links:
    """In how many forms two places, or a constant and a place, go together."""

    def __init__(self, places: Places, census: Census) -> None:
        self._places = places
        self._census = census
        self._rows: dict[tuple[int, str], tuple[Place, ...]] = {}

    def points(
        self, form: Form, term: nodes.Term, places: Sequence[Place]
    ) -> list[_Point]:
        """Return what speaks for a term of a form: its other places, or itself."""
        if isinstance(term, nodes.Const):
            word = term.value
            return [word] if isinstance(word, str) and word not in _PLAIN else []
        if not isinstance(term, nodes.Var):
            return []
        return [one for one in self._row(form, term.name) if one not in places]

    def alike(self, one: Place, other: Place) -> bool:
        """Whether one variable stands at both places: what fits one fits the other."""
        return self._census.together_elsewhere(one, other, _NO_FORM) > 0

    def elsewhere(self, form: Form, points: Sequence[_Point], place: Place) -> int:
        """Return in how many other forms one of the points goes with a place.

        More than `_OFTEN` are not counted.
        """
        most, key = 0, form_key(form)
        for point in points:
            if isinstance(point, str):
                count = self._census.beside_elsewhere(point, place, key)
            else:
                count = self._census.together_elsewhere(point, place, key)
            most = max(most, count)
            if most >= _OFTEN:
                break
        return most

    def _row(self, form: Form, name: str) -> tuple[Place, ...]:
        """Return the places of a variable, each once."""
        row = self._rows.get((id(form), name))
        if row is None:
            every = dict.fromkeys(self._places.of(form, name))
            row = self._rows[id(form), name] = tuple(every)[:MOST_PLACES]
        return row


def _run(run: Pass) -> None:
    links = _Links(run.result(PLACES), run.result(CENSUS))
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
    needs=(CENSUS, INDEX, KINDS, PLACES),
    rules=(SWAPPED,),
)


def _swapped(links: _Links, used: NameUse) -> Iterator[tuple[int, Diagnostic]]:
    """Yield two arguments that were swapped, with how much speaks for that."""
    terms = used.node.args[:_MOST_ARGUMENTS]
    space = SPACES[used.use]
    places = [Place(space, used.name, at) for at in range(len(terms))]
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
    places: tuple[Place, Place],
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
