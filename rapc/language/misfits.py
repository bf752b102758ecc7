"""What is said of data that do not fit a rule, where its shape does not say enough."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec


class Misfit(msgspec.Struct, frozen=True):
    """A row: what is reported of whatever stands where a rule is wanted."""

    #: The rule of the checker that is broken.
    finding: str
    #: The message; `{kind}` stands for what was found, with its article.
    message: str
    help: str = ""


def _clause(message: str, help: str = "") -> Misfit:
    return Misfit("malformed-clause", message, help)


_SKILL = "write `({} (:skill argument...))`"


def _form(message: str, help: str = "") -> Misfit:
    return Misfit("malformed-form", message, help)


_DEFAULTS = "it is `unknown`, `true`, `false` or the name of a function"
_ON_RESULT = "write `:on (okay (fact ...) (not (fact ...)) (may (fact ...)))`"

MISFITS: Mapping[str, Misfit] = {
    # declarations
    "arguments": _form("a list of variables is wanted here, not {kind}"),
    "argument": _form("an argument in parentheses is a variable and its kind"),
    "valued": _form(
        "the arguments of a property end with its value",
        "a property without arguments has only that: `(?value)`",
    ),
    "DEFAULT": _form("this is no default", _DEFAULTS),
    "results": _form("a list of results is wanted here, not {kind}"),
    "kind_values": _form("a list of values is wanted here, not {kind}"),
    "datum_effects": _form("a list of effects is wanted here, not {kind}"),
    "_result_effects": _form(
        "a result and its effects are wanted here, not {kind}", _ON_RESULT
    ),
    "result_effects": _form(
        "a list of effects begins with the result they come with", _ON_RESULT
    ),
    "declare_class_comparator": _form(
        "a comparator is a name or rows, behind a class and perhaps a place",
        "rows are `(veto property)`, `(ignore property)` and `(score property weight)`",
    ),
    "row": _form(
        "a row of a comparator vetoes, ignores or scores a property",
        "write `(veto p)`, `(ignore p)` or `(score p 20)`",
    ),
    "define_query": _form(
        "`define-query` begins with a name and its arguments in parentheses",
        "write `(define-query (name ?argument...) formula)`",
    ),
    # tests
    "answer": _clause(
        "an answer is a question to a function, and a value",
        "write `((function argument...) value)`",
    ),
    "world_option": _clause(
        "an option of the world is its name and a value", "write `(name value)`"
    ),
    "script_row": _clause(
        "a row of the script is wanted here, not {kind}", "write `((request) result)`"
    ),
    "enabled": _clause("one skill is wanted here", _SKILL.format("enable")),
    "disabled": _clause("one skill is wanted here", _SKILL.format("disable")),
    **dict.fromkeys(
        ("moved", "placed"),
        _clause(
            "an item and its place are wanted here, not {kind}", "write `(item place)`"
        ),
    ),
    "event_pattern": _clause(
        "an event pattern is wanted here, not {kind}",
        "write `(task-failed :reason no-method)`",
    ),
}
"""What is said by the rule that was wanted."""


class MissingOperand(msgspec.Struct, frozen=True):
    """A row: what is reported of an operand that is missing, and assumed of it."""

    #: The message; `{name}` stands for the name of what is declared.
    message: str
    help: str
    #: What is offered to be written there.
    written: str
    assumed: Any


MISSING: Mapping[str, MissingOperand] = {
    "arguments": MissingOperand(
        "the arguments of `{name}` are missing", "without any, write `()`", "()", ()
    ),
    "results": MissingOperand(
        "the results of `{name}` are missing",
        "list `okay` and what else the world may answer: `(okay blocked)`",
        "",
        ("okay",),
    ),
    "DEFAULT": MissingOperand(
        "the property `{name}` has no default", _DEFAULTS, "unknown", "unknown"
    ),
}
"""The operands of declarations that may not be left out, by rule or terminal."""
