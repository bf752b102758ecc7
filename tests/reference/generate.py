"""Random libraries with scripts and tasks, one for each seed.

They keep to what the checker's errors ask for (declared names, right numbers of
arguments, tags that exist, orders without cycles) and are wild otherwise, some more
than others.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Sequence

from rapc.runtime.settings import Settings
from tests.reference.case import Case
from tests.reference.formulas import query
from tests.reference.nets import Sketch
from tests.reference.raps import rap, rules
from tests.reference.scripts import at, common, fact, host, rows, solvers, task, text
from tests.reference.vocabulary import (
    DECLARATIONS,
    FORMS,
    KINDS,
    OF_KINDS,
    QUERIES,
    SKILLED,
    USERS,
)
from tests.reference.words import Datum


def generate(seed: int, kinds: Collection[str] = FORMS) -> Case:
    """The case of a seed, always the same; `kinds` of forms may come up in it."""
    some = random.Random(f"{seed}:forms")
    forms = [kind for kind in FORMS if some.random() < 0.7 and kind in kinds]
    rng = random.Random(f"{seed}:case")
    wild = rng.choice((0.05, 0.2, 0.5, 1))
    sketches = [_sketch(rng, n) for n in range(rng.randrange(3, 8))]
    many = [text(common(rng)) for _ in range(14 if "deep" in forms else 0)]
    tasks = rng.choice((3, 4, 5) if "claims" in forms else (1, 2, 2, 3, 4))
    made = [rap(rng, wild, sketches, n, forms) for n in range(len(sketches))]
    whole = (
        *DECLARATIONS,
        *_named(rng, wild, forms),
        *made,
        *(rules(rng, wild, sketches) if "skills" in forms else ()),
    )
    if "kinds" in forms:
        whole = (*KINDS, *of_kinds(rng, whole))
    if "methods" in forms:
        whole = apart(random.Random(f"{seed}:methods"), whole)
    day = agenda(rng, sketches, forms) if "agenda" in forms else ()
    return Case(
        seed=seed,
        forms=(*whole, *day),
        agenda="day" if day else "",
        rows=rows(rng, wild, forms),
        at=tuple(at(rng) for _ in range(rng.randrange(9))),
        facts=(*many, *(text(fact(rng)) for _ in range(rng.randrange(2, 9)))),
        tasks=tuple(task(rng, sketches, forms) for _ in range(tasks)),
        solvers=solvers(rng, wild, sketches, forms),
        host=tuple(host(rng, sketches) for _ in range(rng.choice((0, 0, 0, 1, 2)))),
        until=rng.choice((20, 60, 60, 100)),
        cycles=rng.choice((40, 120, 120)),
        settings=Settings(
            futile_limit=rng.choice((1, 2, 2, 2, 3)),
            idle_cycles=rng.choice((15, 40, 40)),
            max_choices=random.Random(f"choices:{seed}").choice((1, 2, 3, 1000)),
            max_resources=random.Random(f"resources:{seed}").choice(RESOURCES),
            idle_waits=random.Random(f"waits:{seed}").choice((1, 3, 8, 100)),
            cycle_cost=rng.choice((0, 0, 0, 0, 1, 0.5)),
            query_steps=rng.choice(STEPS if "deep" in forms else (1_000_000,)),
        ),
    )


STEPS = (1, 1, 2, 2, 3, 4, 5, 7, 9, 14, 20, 35, 60, 100, 200, 400)
"""How often a question may go back in vain in programs whose questions may: a million
steps, each with a fault to tell of, would take minutes."""


RESOURCES = (1, 2, 3, 5, *[1_000_000] * 8)
"""How many sets and counters tasks may have."""


def _named(rng: random.Random, wild: float, forms: Collection[str]) -> list[Datum]:
    """The queries of a program, and primitives that use things."""
    made: list[Datum] = list(USERS) if "claims" in forms else []
    made += SKILLED if "skills" in forms else []
    if "queries" in forms:
        names = tuple(QUERIES)
        rest = [names[place + 1 :] for place in range(len(names))]
        made += [
            query(rng, wild, *each, forms) for each in zip(names, rest, strict=True)
        ]
    return made


def apart(rng: random.Random, forms: Sequence[Datum]) -> tuple[Datum, ...]:
    """The same forms with some methods outside of their RAPs, anywhere."""
    made: list[Datum] = []
    moved: list[Datum] = []
    for form in forms:
        own = []
        for part in form:
            is_method = form[0] == "define-rap" and part[:1] == ("method",)
            if is_method and rng.random() < 0.4:
                moved.append(("define-method", form[1][1][0], *part[1:]))
            else:
                own.append(part)
        made.append(tuple(own))
    for form in moved:
        made.insert(rng.randrange(len(made) + 1), form)
    return tuple(made)


def of_kinds(rng: random.Random, forms: Collection[Datum]) -> Iterator[Datum]:
    """Forms with kinds for some of the arguments that they declare.

    They are sparse, and mostly wide: what is of none breaks a run off.
    """
    share = rng.choice((0.02, 0.05, 0.15))
    for form in forms:
        place = 2 if str(form[0]).startswith(_WITH_ARGUMENTS) else None
        if form[0] == "define-rap":
            place = 1
        if place is None or not isinstance(form[place], tuple):
            yield form
            continue
        args = tuple(_of_kind(rng, part, share) for part in form[place])
        if form[0] == "define-rap":
            args = ("index", tuple(_of_kind(rng, p, share) for p in form[1][1]))
        yield (*form[:place], args, *form[place + 1 :])


_WITH_ARGUMENTS = ("declare-memory-pro", "declare-sensor-datum", "declare-event")
"""How the heads begin of declarations of what comes in from outside."""


def _of_kind(rng: random.Random, word: Datum, share: float) -> Datum:
    if isinstance(word, str) and word.startswith("?") and rng.random() < share:
        return (word, rng.choice(("letter", *OF_KINDS)))
    return word


def agenda(
    rng: random.Random, sketches: Sequence[Sketch], forms: Collection[str]
) -> tuple[Datum, ...]:
    """The agenda `day`: standing tasks in the background, and orders."""
    lines = [task(rng, sketches, forms) for _ in range(rng.choice((1, 2, 2, 3)))]
    if rng.random() < 0.6:
        standing = task(rng, sketches, ()).split(" :")[0]
        lines.append(f"{standing} :priority {rng.randrange(4)} :background true")
    return (("define-agenda", "day", *(("task", line) for line in lines)),)


def _sketch(rng: random.Random, number: int) -> Sketch:
    """A RAP to be; its input `?k`, if it has one, is meant for a counter."""
    inputs = ["?i", "?j"][: rng.choice((0, 1, 1, 2))]
    if number and rng.random() < 0.25:
        inputs.append("?k")
    return Sketch(f"r{number}", inputs, ["?o", "?n"][: rng.choice((0, 0, 1, 1, 2))])
