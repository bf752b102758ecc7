"""Asking memory: n items with four facts each, half of them in one place.

The other half is spread over sites, 20 items at an average one. With the site bound an
indexed memory is as fast at 100,000 items as at 1000; the first answer for the place
where half of them are is found without the others. Facts come and go as a host asserts
and erases them, `color` being asked by nobody and `location` by its place.
"""

from __future__ import annotations

from collections.abc import Iterator

from bench.common import Figure, compiled, seconds
from rapc.library import loader
from rapc.runtime.host_query import HostQuery
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """\
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property class (?item ?class ?value) unknown)
(declare-memory-property color (?item ?color) unknown)
(declare-memory-property size (?item ?size) unknown)
"""
QUERY = "(and (location ?x ?p) (class ?x rock true) (size ?x ?k) (> ?k 3))"
CROWDED = "yard"
SITES = 64
"""How many sites are asked about in turn."""


def _setup(items: int) -> tuple[HostQuery, Interpreter]:
    """The query, made ready, and a run whose memory holds so many items."""
    library = compiled(loader.load_text(LIBRARY))
    run = Interpreter(library, ScriptedWorld([], declared=library.library))
    sites = max(items // 40, 1)
    for n in range(items):
        place = CROWDED if n % 2 else f"site-{n // 2 * 7919 % sites}"
        kind = "rock" if n // 2 % 4 == 0 else "drum"
        run.assert_fact("location", f"item-{n}", place)
        run.assert_fact("class", f"item-{n}", kind, "true")
        run.assert_fact("color", f"item-{n}", ("red", "blue", "yellow")[n % 3])
        run.assert_fact("size", f"item-{n}", n // 8 % 10)
    return run.question(QUERY, "?p"), run


def figures(quick: bool = False) -> Iterator[Figure]:
    """Answers for a bound site and for the crowded place; facts that come and go."""
    for items in (100,) if quick else (1_000, 10_000, 100_000):
        ask, run = _setup(items)
        size = f"{items:,} items"
        for what, taken in (*_asked(ask, items), *_told(run)):
            yield Figure("queries", what, size, taken * 1e6, "us")


def _asked(ask: HostQuery, items: int) -> Iterator[tuple[str, float]]:
    sites = max(items // 40, 1)
    places = [f"site-{n * sites // SITES}" for n in range(SITES)]

    def first() -> None:
        for place in places:
            ask.first(place)

    def every() -> None:
        for place in places:
            ask.all(place)

    answers = sum(len(ask.all(place)) for place in places) / SITES
    yield "first answer, site bound", seconds(first) / SITES
    yield f"all of {answers:.1f} answers, site bound", seconds(every) / SITES
    yield "first answer, crowded place", seconds(lambda: ask.first(CROWDED))
    crowd = len(ask.all(CROWDED))
    yield "an answer of all, crowded place", seconds(lambda: ask.all(CROWDED)) / crowd


def _told(run: Interpreter) -> Iterator[tuple[str, float]]:
    names = [f"more-{n}" for n in range(SITES)]
    for name, value in (("color", "red"), ("location", "site-0")):

        def come_and_go(name: str = name, value: str = value) -> None:
            for item in names:
                run.assert_fact(name, item, value)
            for item in names:
                run.erase(name, item)

        what = f"assert and erase, `{name}` of a new item"
        yield what, seconds(come_and_go) / SITES
