"""Asking memory: n items with four facts each, half of them in one place.

The other half is spread over sites, 20 items at an average one. With the site bound an
indexed memory is as fast at 100,000 items as at 1000; the first answer for the place
where half of them are is found without the others.
"""

from __future__ import annotations

from collections.abc import Iterator

from bench.common import Figure, compiled, seconds
from rapc import loader
from rapc.compiler.query import Query
from rapc.runtime.context import QueryContext
from rapc.runtime.memory.memory import Memory
from rapc.runtime.recorder import Recorder

LIBRARY = """\
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property class (?item ?class ?value) unknown)
(declare-memory-property color (?item ?color) unknown)
(declare-memory-property size (?item ?size) unknown)
(define-rap (ask ?p)
  (preconditions (and (location ?x ?p) (class ?x rock true) (size ?x ?k) (> ?k 3)))
  (method (task-net)))
"""
CROWDED = "yard"
SITES = 64
"""How many sites are asked about in turn."""


def _setup(items: int) -> tuple[Query, QueryContext]:
    """The query, compiled, and a memory of so many items."""
    library = compiled(loader.load_text(LIBRARY))
    recorder = Recorder()
    memory = Memory(library.vocabulary, recorder, lambda: 0)
    sites = max(items // 40, 1)
    for n in range(items):
        place = CROWDED if n % 2 else f"site-{n // 2 * 7919 % sites}"
        kind = "rock" if n // 2 % 4 == 0 else "drum"
        for fact in (
            ("location", f"item-{n}", place),
            ("class", f"item-{n}", kind, "true"),
            ("color", f"item-{n}", ("red", "blue", "yellow")[n % 3]),
            ("size", f"item-{n}", n // 8 % 10),
        ):
            memory.assert_fact(memory.checked(fact), "user")
    plan = library.rap("ask")
    assert plan is not None
    assert plan.preconditions is not None
    return plan.preconditions, QueryContext(memory, recorder, {})


def figures(quick: bool = False) -> Iterator[Figure]:
    """First answer and all answers for a bound site, and for the crowded place."""
    for items in (100,) if quick else (1_000, 10_000, 100_000):
        yield from _figures(items)


def _figures(items: int) -> Iterator[Figure]:
    query, ctx = _setup(items)
    sites = max(items // 40, 1)
    asked = [{"?p": f"site-{n * sites // SITES}"} for n in range(SITES)]
    crowded = {"?p": CROWDED}

    def first() -> None:
        for env in asked:
            query.first(ctx, env)

    def every() -> int:
        return sum(1 for env in asked for _ in query.solutions(ctx, env))

    def crowd() -> int:
        return sum(1 for _ in query.solutions(ctx, crowded))

    answers = every() / SITES
    for what, work, parts in (
        ("first answer, site bound", first, SITES),
        (f"all of {answers:.1f} answers, site bound", every, SITES),
        ("first answer, crowded place", lambda: query.first(ctx, crowded), 1),
        ("an answer of all, crowded place", crowd, crowd()),
    ):
        yield Figure(
            "queries", what, f"{items:,} items", seconds(work) / parts * 1e6, "us"
        )
