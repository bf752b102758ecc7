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
from itertools import combinations, islice

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.kinds import KINDS
from rapc.analysis.facts.index import INDEX, Form, NameUse
from rapc.analysis.facts.usage import (
    CENSUS,
    MOST_PLACES,
    PLACES,
    SPACES,
    Census,
    Place,
    Places,
)
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

_Pair = tuple[Place, Place]


class _Links:
    """In how many forms two places, or a constant and a place, go together."""

    def __init__(self, places: Places, census: Census) -> None:
        self._places = places
        self._census = census

    def row(self, used: NameUse) -> Sequence[Place]:
        """Return the places of a name that is used."""
        return self._places.row(SPACES[used.use], used.name, used.count)

    def alike(self, one: Place, other: Place) -> bool:
        """Whether one variable stands at both places: what fits one fits the other."""
        return self._census.together_elsewhere(one, other) > 0

    def elsewhere(
        self, form: Form, term: nodes.Term, pair: _Pair, place: Place
    ) -> Iterator[int]:
        """Yield in how many other forms what speaks for a term goes with a place.

        That is the term itself, if it is a constant; of a variable, each of its places
        in the form but the pair that is held against each other.
        """
        if type(term) is nodes.Var:
            for point in islice(self._places.of(form, term.name), MOST_PLACES):
                if point not in pair:
                    yield self._census.together_elsewhere(point, place, form)
        elif type(term) is nodes.Const:
            word = term.value
            if isinstance(word, str) and word not in _PLAIN:
                yield self._census.beside_elsewhere(word, place, form)


@check(SWAPPED)
def swapped_arguments(run: Pass) -> Iterator[Diagnostic]:
    """Find arguments that stand in each other's places."""
    links = _Links(run.result(PLACES), run.result(CENSUS))
    told = run.result(KINDS).value
    best: dict[int, tuple[int, Diagnostic]] = {}
    for used in run.result(INDEX).uses():
        form = used.owner
        if used.count <= 1 or type(form) is nodes.DefineTest or id(form) in told:
            continue
        for support, found in _swapped(links, used):
            if support > best.get(id(form), (0, found))[0]:
                best[id(form)] = (support, found)
    for _, found in best.values():
        yield found


def _swapped(links: _Links, used: NameUse) -> Iterator[tuple[int, Diagnostic]]:
    """Yield two arguments that were swapped, with how much speaks for that."""
    terms, row = used.node.args[:_MOST_ARGUMENTS], links.row(used)
    for one, other in combinations(range(len(terms)), 2):
        pair = (terms[one], terms[other])
        support = _support(links, used.owner, pair, (row[one], row[other]))
        if support:
            yield support, _finding(used, pair)


def _support(
    links: _Links, form: Form, terms: tuple[nodes.Term, nodes.Term], places: _Pair
) -> int:
    """Return how many other places say that two arguments were swapped."""
    for term, place in zip(terms, places, strict=True):
        if any(links.elsewhere(form, term, places, place)):
            return 0
    if terms[0] == terms[1] or links.alike(*places):
        return 0
    turned = [
        list(links.elsewhere(form, term, places, place))
        for term, place in zip(terms, reversed(places), strict=True)
    ]
    if all(any(there) for there in turned):
        counts = [count for there in turned for count in there if count]
        return len(counts) if max(counts) > 1 else 0
    lone = [at for at, term in enumerate(terms) if _is_open(term)]
    if len(lone) != 1 or not isinstance(terms[1 - lone[0]], nodes.Const):
        return 0
    return 1 if any(count >= _OFTEN for count in turned[1 - lone[0]]) else 0


_OFTEN = 3
"""In so many forms a constant beside a bare `?` stands in the place of that."""


def _is_open(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Var) and term.anonymous


def _finding(used: NameUse, terms: tuple[nodes.Term, nodes.Term]) -> Diagnostic:
    one, other = (format_term(term) for term in terms)
    spans: Mapping[int, Span] = {0: terms[0].span, 1: terms[1].span}
    return SWAPPED.at(
        Span(used.span.file, spans[0].start, spans[1].end),
        f"`{one}` and `{other}` seem to be swapped",
        help=f"everywhere else in the library the arguments of `{used.name}` are used "
        "the other way round",
        fix=Fix(
            Applicability.UNSAFE,
            "swap the two",
            (Edit(spans[0], other), Edit(spans[1], one)),
        ),
    )
