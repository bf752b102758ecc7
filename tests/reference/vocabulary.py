"""What all random libraries share: declarations, and words to choose from."""

from __future__ import annotations

DECLARATIONS: tuple[tuple[object, ...], ...] = (
    ("declare-memory-property", "p", ("?a", "?value"), "unknown"),
    ("declare-memory-property", "b", ("?a", "?value"), "false"),
    ("declare-memory-property", "k", ("?a", "?b", "?value"), "true"),
    ("declare-memory-property", "g", ("?a", "?value"), "guess"),
    ("declare-memory-property", "mode", ("?value",), "1"),
    ("declare-memory-function", "guess", ("?index",)),
    ("declare-memory-property", "loose", "true"),
    ("declare-memory-proposition", "q", ("?a",)),
    ("declare-memory-proposition", "r", ("?a", "?b")),
    ("declare-memory-function", "twice", ("?a",), ":reads", ()),
    ("declare-memory-function", "odd", ("?a",), ":reads", ()),
    ("declare-memory-function", "look-up", ("?a",), ":reads", ("p",)),
    ("declare-memory-function", "peek", ("?a",)),
    ("declare-primitive", "act", ("?x",), ("okay", "bad", "worse"), ":atomic", "false"),
    ("declare-primitive", "pair", ("?x", "?y"), ("okay", "slip"), ":atomic", "false"),
    ("declare-primitive", "rest", (), ("okay",), ":atomic", "false"),
    ("declare-primitive", "slow", ("?x",), ("okay", "lost"), ":atomic", "false"),
    ("declare-sensor-datum", "seen", ("?x", "?y")),
    ("declare-event", ":go", ("?a",)),
    ("declare-event", ":stop", ()),
)

PROPERTIES = {"p": 1, "b": 1, "k": 2, "g": 1, "mode": 0, "loose": 1}
"""The properties, with the number of arguments before the value."""

PROPOSITIONS = {"q": 1, "r": 2}

PRIMITIVES = {
    "act": (1, ("okay", "bad", "worse")),
    "pair": (2, ("okay", "slip")),
    "rest": (0, ("okay",)),
    "slow": (1, ("okay", "lost")),
}

SIGNALS = {":go": 1, ":stop": 0}

SYMBOLS = ("a", "c", "d")

VALUES = ("a", "c", "1", "2", "3", "unknown", "true")

WILD = ("2.5", '"a"', "false", "-1", "0", "box")
"""Values that come up now and then."""

NUMBERS = ("0", "1", "2", "3", "4", "6", "9")

RESULTS = ("okay", "bad", "slip", "lost", "interference", "no-method", "futile-loop")

METHODS = ("one", "2")
"""Names of methods."""

FORMS = (
    "queries",
    "otherwise",
    "constraints",
    "claims",
    "skills",
    "refusals",
    "kinds",
    "agenda",
    "deep",
    "methods",
)
"""Kinds of forms that some programs use and others do not."""

UNBROKEN = tuple([form for form in FORMS if form != "kinds"])
"""Those with which no run breaks off: a world's values of a wrong kind end a run."""

QUERIES = {"near": 1, "wide": 2, "fit": 2, "calm": 0, "sound": 1}
"""Named queries, with the number of their arguments; each may use those behind it."""

KINDS: tuple[tuple[object, ...], ...] = (
    ("declare-kind", "letter", ("a", "c")),
    ("declare-kind", "late", ":is", "letter", ("d",)),
    ("declare-kind", "tool"),
    ("declare-kind", "amount", ":is", "number"),
    ("declare-kind", "few", ":is", "amount", ("1", "2")),
)
"""Kinds: closed, closed below that, open, and two of numbers."""

OF_KINDS = ("letter", "late", "tool", "amount", "few", "number", "symbol", "text")

THINGS = {"wheels": 0, "arm": 1, "way": 2}

USERS: tuple[tuple[object, ...], ...] = (
    (
        "declare-primitive",
        "hold",
        ("?x",),
        ("okay", "lost"),
        ":atomic",
        "false",
        ":uses",
        (("arm", "?x"),),
    ),
    (
        "declare-primitive",
        "go",
        ("?x", "?y"),
        ("okay", "slip"),
        ":atomic",
        "false",
        ":uses",
        ("wheels", ("way", "?x", "?y")),
    ),
    (
        "declare-primitive",
        "carry",
        ("?x",),
        ("okay", "lost"),
        ":atomic",
        "false",
        ":uses",
        (("arm", "?x"), "wheels"),
    ),
    ("declare-primitive", "tap", ("?x",), ("okay", "bad"), ":uses", (("arm", "?x"),)),
)
"""Primitives that use things."""

USING = {
    "hold": (1, ("okay", "lost")),
    "go": (2, ("okay", "slip")),
    "carry": (1, ("okay", "lost")),
    "tap": (1, ("okay", "bad")),
}

SKILLS = {":roll": 1, ":scan": 1, ":hum": 0, ":steer": 2}
"""The skills, with the number of their arguments."""

SKILLED: tuple[tuple[object, ...], ...] = (
    (
        "declare-skill",
        ":roll",
        ("?x",),
        ":events",
        (":go", ":stop"),
        ":uses",
        ("wheels",),
    ),
    ("declare-skill", ":scan", ("?x",), ":events", (":go",), ":uses", (("arm", "?x"),)),
    ("declare-skill", ":hum", (), ":events", (":stop",)),
    (
        "declare-skill",
        ":steer",
        ("?x", "?y"),
        ":uses",
        ("wheels", ("way", "?x", "?y")),
    ),
)
"""Skills, most of which use things."""
