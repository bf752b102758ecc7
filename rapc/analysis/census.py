"""What all forms of a library tell of places and constants.

Some passes hold a form against all others: where else a constant stands, which places
go together. They ask the census, and never walk over other forms themselves.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import islice

from rapc.analysis.check import Fact, Pass
from rapc.analysis.index import INDEX, Form
from rapc.analysis.named import MISUSES
from rapc.analysis.places import PLACES, Constant, Place, Places
from rapc.ir import nodes

MOST_PLACES = 12
"""Of the places of a variable in a form only the first so many are told."""

PLAIN = ("unknown", "true", "false", "nil", "t", "okay")
"""Constants that stand anywhere."""

TRUTH = ("true", "false", "t", "nil")
"""Constants that answer a question."""

_Weights = Mapping[int, int]
"""How much each form counts, by the id of the form."""


class Census:
    """Where constants stand, and which places go together.

    Args:
        places: the places of the library.
        forms: its forms, in the order of files and text.
    """

    def __init__(self, places: Places, forms: Iterable[Form]) -> None:
        self._by_word: dict[str, list[Constant]] = {}
        self._by_place: dict[Place, list[Constant]] = {}
        for one in _in_order(places.constants, forms):
            self._by_word.setdefault(one.written, []).append(one)
            for place in one.places:
                self._by_place.setdefault(place, []).append(one)
        #: For each variable of a form that form; `_at` has the variables at a place.
        self._owners: list[Form] = []
        self._at: dict[Place, set[int]] = {}
        for form, names in places.forms():
            for there in names.values():
                for place in islice(there, MOST_PLACES):
                    self._at.setdefault(place, set()).add(len(self._owners))
                self._owners.append(form)
        self._together: dict[tuple[Place, Place], tuple[int, _Weights]] = {}
        self._beside: dict[tuple[str, Place], frozenset[int]] = {}

    def together_elsewhere(
        self, one: Place, other: Place, form: Form | None = None
    ) -> int:
        """Return in how many forms but one a variable stands at both places.

        A declaration counts as two RAPs do.
        """
        pair = (one, other)
        found = self._together.get(pair)
        if found is None:
            forms = self._forms_with_both(one, other)
            found = self._together[pair] = sum(forms.values()), forms
        count, forms = found
        return count - forms.get(id(form), 0)

    def beside_elsewhere(self, written: str, place: Place, form: Form) -> int:
        """Return in how many forms but one a constant itself stands at a place."""
        pair = (written, place)
        forms = self._beside.get(pair)
        if forms is None:
            there = [one for one in self.standing(written) if one.count]
            forms = frozenset([id(one.form) for one in there if place in one.places])
            self._beside[pair] = forms
        return len(forms) - (id(form) in forms)

    def written(self) -> Iterable[str]:
        """Return the constants of the library as they are written, each once."""
        return self._by_word

    def standing(self, written: str) -> Sequence[Constant]:
        """Return where a constant stands, in the order of files."""
        return self._by_word.get(written, ())

    def at(self, place: Place) -> Sequence[Constant]:
        """Return the constants at a place."""
        return self._by_place.get(place, ())

    def _forms_with_both(self, one: Place, other: Place) -> _Weights:
        """Return the forms in which one variable stands at both places."""
        if one == other:
            return {}
        small, large = sorted((self._at.get(p, set()) for p in (one, other)), key=len)
        forms = [self._owners[variable] for variable in small if variable in large]
        return {id(form): 1 if isinstance(form, _SINGLE) else 2 for form in forms}


_SINGLE = (nodes.DefineRap, nodes.DefineTest)
"""The forms that count once."""


def _in_order(constants: Iterable[Constant], forms: Iterable[Form]) -> list[Constant]:
    """Return constants file by file."""
    order: dict[str, int] = {}
    for form in forms:
        order.setdefault(form.span.file, len(order))
    return sorted(constants, key=lambda one: order[one.form.span.file])


def _run(run: Pass) -> Census:
    places = run.result(PLACES)
    if run.result(MISUSES).found:
        # Where a name does not meet its declaration, its arguments count all the same.
        places = Places(run.result(INDEX), ())
    return Census(places, (*run.library.forms, *run.library.tests))


CENSUS = Fact(_run)
"""Gathers what forms tell of places and constants."""


def sort_of(written: str) -> str:
    """Return the sort of a constant by how it is written; nothing for `unknown`.

    A number is one, a text has quotes, and `true` or `nil` are truth values.
    """
    if written[:1] == '"':
        return "text"
    if written in TRUTH:
        return "truth value"
    if _NUMERAL.fullmatch(written):
        return "number"
    return "" if written in PLAIN else "word"


_NUMERAL = re.compile(r"-?[0-9]+(\.[0-9]+)?")
