"""RAP100 to RAP104: constants and arguments at a wrong place.

A constant is compared with the constants at the same place elsewhere, and at places of
the same kind: the values that a closed kind lists, and the constants that the library
uses. A comparison belongs to the places of the compared variable.

Two arguments count as swapped if other forms link the places of the first term with the
second place and the places of the second term with the first place, and no form links
the terms with their actual places. A constant is linked with each place of its other
uses. An example is `(at ?room ?cart)`: elsewhere `?room` is an input of `enter`, and
all other forms that pass a variable to `enter` bind the variable at the second place of
`at`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import combinations, islice

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Form, NameUse
from rapc.analysis.facts.statistics import LIMITS, THRESHOLDS
from rapc.analysis.facts.usage import (
    CENSUS,
    SPACES,
    TRUTH,
    USAGE,
    Constant,
    Place,
    Usage,
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
    Subject,
)
from rapc.base.names import Close, is_row
from rapc.base.source import Span
from rapc.base.values import Text, format_atom
from rapc.ir import nodes
from rapc.ir.printer import format_term

MISSPELT = Rule(
    code="RAP100",
    name="misspelt-constant",
    severity=Severity.WARNING,
    summary="a constant is used once, and its argument has a similar constant",
    fix="unsafe: writes the similar constant, or the variable of the same name",
    ignore="where the value comes from outside of the library, and a "
    "similar value exists",
    source="T 4.1",
)

FOREIGN = Rule(
    code="RAP102",
    name="foreign-constant",
    severity=Severity.WARNING,
    summary="a constant has a different kind than the other values of its argument",
    ignore="where the word is a value of both kinds: declare the kind with `:is`",
    source="L 7",
)

MIXED = Rule(
    code="RAP103",
    name="mixed-values",
    severity=Severity.WARNING,
    summary="a number, word or truth value is used where all other values "
    "are of another type",
    ignore="where an argument takes values of several types on purpose, "
    "for example a label",
    source="L 2",
)


@check(MISSPELT, FOREIGN, MIXED)
def constants(run: Pass) -> Iterator[Diagnostic]:
    """Compare constants with the constants at the same places elsewhere."""
    known = _Known(run)
    usage = run.result(USAGE)
    for one in usage.constants:
        kinds = known.usage.kinds(one.places)
        fits = all(run.signatures.kinds.holds(k, one.const.value) for k in kinds)
        if fits and not isinstance(one.form, nodes.DefineTest):
            unmarked = usage.of(one.form, f"?{one.const.value}")
            found = known.finding(one, kinds, unmarked)
            if found is not None:
                yield found


class _Known:
    """The knowledge of the library about its constants."""

    def __init__(self, run: Pass) -> None:
        self.usage = run.result(CENSUS)
        self.kinds = run.signatures.kinds
        self._forms: dict[str, Counter[int]] = {}

    def finding(
        self, one: Constant, kinds: Sequence[str], unmarked: Collection[Place]
    ) -> Diagnostic | None:
        """Return the finding about a constant, or None.

        Args:
            one: the constant.
            kinds: the kinds of its places.
            unmarked: the places in its form of a variable of the same name.
        """
        sort = sort_of(one.written)
        found = None
        if sort == "word":
            found = self._misspelt(one, kinds, unmarked)
        if sort and found is None and len(one.places) == 1:
            found = self._mixed(one, one.places[0], sort)
            if found is None and sort == "word" and len(kinds) == 1:
                found = self._foreign(one, kinds[0])
        return found

    def _misspelt(
        self, one: Constant, kinds: Sequence[str], unmarked: Collection[Place]
    ) -> Diagnostic | None:
        word = one.written
        if unmarked and self._is_new(one, kinds):
            return _slip(one, f"?{word}", ())
        for other in self._close.all_to(word) if self.usage.count(word) == 1 else ():
            there = self.usage.counts(other)
            apart = not (there[0].keys() & one.places or there[1].keys() & kinds)
            alike = other[0] == word[0] and not is_row(word, other)
            if alike and not apart and self.usage.count(other) > 1:
                first = self.usage.standing(other)[:1]
                label = "a similar constant"
                return _slip(one, other, [Label(c.const.span, label) for c in first])
        return None

    def _is_new(self, one: Constant, kinds: Sequence[str]) -> bool:
        """Return whether a constant occurs once, or once in its form and its places."""
        if not one.places or self.usage.count(one.written) == 1:
            return self.usage.count(one.written) == 1
        places, of_kinds = self.usage.counts(one.written)
        if one.written not in self._forms:
            every = self.usage.standing(one.written)
            self._forms[one.written] = Counter([id(found.form) for found in every])
        return (
            self._forms[one.written][id(one.form)] == 1
            and all(places[place] == 1 for place in one.places)
            and all(of_kinds[kind] == 1 for kind in kinds)
        )

    @cached_property
    def _close(self) -> Close:
        only = [word for word in self.usage.words() if sort_of(word) == "word"]
        return Close(only, THRESHOLDS.close_word)

    def _mixed(self, one: Constant, place: Place, own: str) -> Diagnostic | None:
        """Find a number among words, or a word among numbers; also truth values.

        `false` among words is valid: the value means that there is no thing.
        """
        there = self.usage.sorts(place)
        others = {sort: n for sort, n in there.items() if sort and sort != own}
        if one.const.value == "false" or there[own] != 1 or len(others) != 1:
            return None
        ((sort, count),) = others.items()
        if count < self._enough(one, {own, sort}):
            return None
        return MIXED.at(
            one.const.span,
            f"`{format_atom(one.const.value)}` is used where all other "
            f"values are {sort}s",
            help=f"this argument of `{place.name}` has {count} of them",
            about=_unmarked(one),
        )

    def _enough(self, one: Constant, sorts: set[str]) -> int:
        """Return the required number of other constants; 1 if a text is also a word."""
        value = one.const.value
        word = value.value if isinstance(value, Text) else ""
        is_word = sort_of(word) not in _EXACT
        if is_word and self.usage.counts(word)[0][one.places[0]]:
            return 1
        if sorts & _EXACT:
            return THRESHOLDS.same_sort
        return THRESHOLDS.same_sort_of_words

    def _foreign(self, one: Constant, wanted: str) -> Diagnostic | None:
        _, there = self.usage.counts(one.written)
        if there[wanted] > 1 or self.kinds.values(wanted) is not None:
            return None
        homes = [kind for kind, n in there.items() if n > 1 and kind != wanted]
        if not homes or not all(self._strange(kind, wanted) for kind in homes):
            return None
        return FOREIGN.at(
            one.const.span,
            f"expected kind {wanted}, not `{one.written}` of kind {homes[0]}",
            help="the arguments may be in the wrong order",
            about=_unmarked(one),
        )

    def _strange(self, kind: str, wanted: str) -> bool:
        """Return whether two kinds are unrelated; a common word relates kinds."""
        if set(kind.split("-")) & set(wanted.split("-")):
            return False
        if wanted in ("item", "symbol"):
            above = self.kinds.above(kind)
            return self.kinds.values(kind) is not None and "item" not in above
        return self.kinds.apart(kind, wanted)


_EXACT = {"number", "text"}
"""The sorts that are not words."""


def _slip(one: Constant, meant: str, labels: Sequence[Label]) -> Diagnostic:
    edit = Edit(one.const.span, meant)
    return MISSPELT.at(
        one.const.span,
        f"`{one.const.value}` is used only here",
        labels=tuple(labels),
        help=f"did you mean `{meant}`?",
        fix=Fix(Applicability.UNSAFE, f"write `{meant}`", (edit,)),
        about=_unmarked(one),
    )


def _unmarked(one: Constant) -> tuple[Subject, ...]:
    """Return the variable whose name is a word with a question mark."""
    return (Subject(one.const.span, f"?{one.const.value}"),)


MARKED = Rule(
    code="RAP104",
    name="marked-constant",
    severity=Severity.WARNING,
    summary="a variable is used once, and its name is a constant of the same argument",
    fix="unsafe: removes the question mark",
    ignore="where any value matches and the name is only a comment: "
    "choose another name",
    source="T 4.1",
)


@check(MARKED, needs_whole="form")
def marked_constant(run: Pass) -> Iterator[Diagnostic]:
    """Find variables used once that have the name of a constant of their place."""
    usage = run.result(USAGE)
    census = run.result(CENSUS)
    for variable, _, owner in run.result(INDEX).used_once():
        there = usage.of(owner, variable.name)
        if not there:
            continue
        (place,) = there
        word = variable.name[1:]
        others = list(_others(census, word, place))
        if _are_sure(others, owner):
            yield _marked(variable, others[0].const.span)
        elif any(_lists(run, kind, word) for kind in census.kinds((place,))):
            yield _marked(variable, None)


def _others(census: Usage, word: str, place: Place) -> Iterator[Constant]:
    """Yield constants of a name at a place, and at places of its kinds."""
    every = census.standing(word) if sort_of(word) not in _EXACT else ()
    told = [c for c in every if c.count and type(c.form) is not nodes.DefineTest]
    most = LIMITS.constants_of_place
    yield from [one for one in told if place in one.places][:most]
    for kind in census.kinds((place,)):
        yield from [one for one in told if kind in census.kinds(one.places)][:most]


def _are_sure(constants: Sequence[Constant], owner: Form) -> bool:
    """Return whether constants are more than one word that may itself lack its mark."""
    elsewhere = any(one.form is not owner for one in constants)
    return elsewhere or len({one.const.span for one in constants}) > 1


def _lists(run: Pass, kind: str, word: str) -> bool:
    return word in (run.signatures.kinds.values(kind) or ())


def _marked(variable: nodes.Var, other: Span | None) -> Diagnostic:
    word = variable.name[1:]
    fix = Fix(Applicability.UNSAFE, f"write `{word}`", (Edit(variable.span, word),))
    return MARKED.at(
        variable.span,
        f"`{variable.name}` is used only here and matches any value",
        labels=(Label(other, "the constant is used here"),) if other else (),
        help=f"did you mean `{word}`? for any value, write `?`",
        fix=fix,
        about=(Subject(variable.span, variable.name),),
    )


SWAPPED = Rule(
    code="RAP101",
    name="swapped-arguments",
    severity=Severity.WARNING,
    summary="two arguments may be swapped",
    fix="unsafe: swaps the two arguments",
    ignore="where a relation is symmetric, so that the order does not matter",
    source="T 4.1",
)

_Pair = tuple[Place, Place]


class _Links:
    """The number of forms that link two places, or a constant and a place."""

    def __init__(self, usage: Usage, census: Usage) -> None:
        self._usage = usage
        self._census = census

    def row(self, used: NameUse) -> Sequence[Place]:
        """Return the places of the name of a use."""
        return self._usage.row(SPACES[used.use], used.name, used.count)

    def alike(self, one: Place, other: Place) -> bool:
        """Return whether some variable occurs at both places."""
        return self._census.together_elsewhere(one, other) > 0

    def elsewhere(
        self, form: Form, term: nodes.Term, pair: _Pair, place: Place
    ) -> Iterator[int]:
        """Yield, for each evidence of a term, the number of other forms with a place.

        The evidence of a constant is the constant itself. The evidence of a variable is
        each of its places in the form, except the pair under comparison.
        """
        if type(term) is nodes.Var:
            for point in islice(self._usage.of(form, term.name), LIMITS.places):
                if point not in pair:
                    yield self._census.together_elsewhere(point, place, form)
        elif type(term) is nodes.Const:
            word = term.value
            if isinstance(word, str) and word not in _ANYWHERE:
                yield self._census.beside_elsewhere(word, place, form)


@check(SWAPPED)
def swapped_arguments(run: Pass) -> Iterator[Diagnostic]:
    """Find arguments that stand in each other's places."""
    links = _Links(run.result(USAGE), run.result(CENSUS))
    best: dict[int, tuple[int, Diagnostic]] = {}
    for used in run.result(INDEX).uses():
        form = used.owner
        if used.count <= 1 or type(form) is nodes.DefineTest:
            continue
        for support, found in _swapped(links, used):
            if support > best.get(id(form), (0, found))[0]:
                best[id(form)] = (support, found)
    for _, found in best.values():
        yield found


def _swapped(links: _Links, used: NameUse) -> Iterator[tuple[int, Diagnostic]]:
    """Yield two arguments that were swapped, with the weight of the evidence."""
    terms, row = used.node.args[: LIMITS.arguments], links.row(used)
    for one, other in combinations(range(len(terms)), 2):
        pair = (terms[one], terms[other])
        support = _support(links, used.owner, pair, (row[one], row[other]))
        if support:
            yield support, _swap(used, pair)


def _support(
    links: _Links, form: Form, terms: tuple[nodes.Term, nodes.Term], places: _Pair
) -> int:
    """Return the number of other places that indicate swapped arguments."""
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
    return (
        1
        if any(count >= THRESHOLDS.swapped_beside_any for count in turned[1 - lone[0]])
        else 0
    )


_ANYWHERE = ("unknown", *TRUTH)
"""Constants that may occur at any place."""


def _is_open(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Var) and term.anonymous


def _swap(used: NameUse, terms: tuple[nodes.Term, nodes.Term]) -> Diagnostic:
    one, other = (format_term(term) for term in terms)
    spans: Mapping[int, Span] = {0: terms[0].span, 1: terms[1].span}
    return SWAPPED.at(
        Span(used.span.file, spans[0].start, spans[1].end),
        f"`{one}` and `{other}` may be swapped",
        help=f"all other uses of `{used.name}` in the library have these "
        "arguments in the opposite order",
        fix=Fix(
            Applicability.UNSAFE,
            "swap the two arguments",
            (Edit(spans[0], other), Edit(spans[1], one)),
        ),
    )
