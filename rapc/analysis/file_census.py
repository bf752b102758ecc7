"""What one file tells of places, constants and names: of its text alone.

So it can be kept from one check to the next (`rapc.analysis.again`). What all files
tell is put together in `rapc.analysis.census`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import islice

import msgspec

from rapc.analysis.asking import Asking, asking
from rapc.analysis.index import Form, Index, use_key
from rapc.analysis.places import Place, Places
from rapc.ir import nodes
from rapc.ir.walk import formulas, subformulas
from rapc.library.library import Library

MOST_PLACES = 12
"""Of the places of a variable in a form only the first so many are told."""

FormKey = tuple[str, int]
"""A form by its file and by where it begins."""


class Standing(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A constant where it stands."""

    #: As it is written, so that a text has its quotes.
    written: str
    #: Where its form begins.
    form: int
    start: int
    end: int
    #: With how many arguments it stands at its place; 0 if it is compared with a
    #: variable.
    count: int
    #: The place that it is at, or those of the variable that it is compared with.
    places: tuple[Place, ...]


class FileCensus(msgspec.Struct, array_like=True):
    """What the forms of one file tell; their variables are numbered, as `groups`."""

    #: For each place the variables that stand at it.
    groups: dict[Place, list[int]] = {}
    #: For each variable where its form begins.
    owners: list[int] = []
    constants: list[Standing] = []
    #: The names of facts that RAPs bring about or take away.
    changed: list[str] = []
    #: What RAPs ask for.
    asking: list[Asking] = []
    #: The RAPs that agendas ask for.
    given: list[str] = []
    #: What RAPs ask for in conditions of work: facts, functions and queries by name.
    conditions: list[str] = []
    #: How often names are used, in which way.
    uses: dict[str, int] = {}
    #: Where its first form begins.
    first: int = 0
    #: Where the forms begin that are tests, and those that are neither that nor RAPs.
    tests: list[int] = []
    others: list[int] = []


def form_key(form: Form) -> FormKey:
    """Return what tells a form from all others of its library."""
    return form.span.file, form.span.start


def gather(library: Library, index: Index, places: Places) -> Mapping[str, FileCensus]:
    """Return what each file with forms or tests tells.

    Args:
        library: the files.
        index: their nodes.
        places: what stands at their places.
    """
    made = _begun(library)
    for form, names in places.forms():
        here, start = made[form.span.file], form.span.start
        for there in names.values():
            group = len(here.owners)
            here.owners.append(start)
            for place in islice(there, MOST_PLACES):
                here.groups.setdefault(place, []).append(group)
    for one in places.constants:
        at, span = one.form.span, one.const.span
        made[at.file].constants.append(
            Standing(one.written, at.start, span.start, span.end, one.count, one.places)
        )
    for file, name in dict.fromkeys(_changed(index)):
        made[file].changed.append(name)
    for file, name in dict.fromkeys(_conditions(library)):
        made[file].conditions.append(name)
    uses = Counter([(u.owner.span.file, u.use, u.name) for u in index.uses()])
    for (file, use, name), number in uses.items():
        made[file].uses[use_key(use, name)] = number
    return made


def _begun(library: Library) -> dict[str, FileCensus]:
    """Return what forms tell by themselves."""
    made: dict[str, FileCensus] = {}
    for form in (*library.forms, *library.tests):
        here = made.get(form.span.file)
        if here is None:
            here = made[form.span.file] = FileCensus(first=form.span.start)
        if isinstance(form, nodes.DefineTest):
            here.tests.append(form.span.start)
        elif isinstance(form, nodes.DefineRap):
            here.asking.append(asking(form))
        else:
            here.others.append(form.span.start)
        if isinstance(form, nodes.DefineAgenda):
            here.given += [task.goal.name for task in form.tasks]
    return made


def _conditions(library: Library) -> Iterator[tuple[str, str]]:
    for form in library.forms:
        if isinstance(form, nodes.DefineRap):
            for whole in formulas(form):
                if whole.clause.is_condition:
                    for part in subformulas(whole.formula):
                        if isinstance(part, nodes.Proposition):
                            yield form.span.file, part.name


def _changed(index: Index) -> Iterator[tuple[str, str]]:
    for one in index.uses():
        if one.use in ("asserted", "erased") and type(one.owner) is nodes.DefineRap:
            yield one.owner.span.file, one.name
