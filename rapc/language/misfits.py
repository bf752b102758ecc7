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
    #: Whether it is said of an operand of another kind, too.
    whole: bool = False


def _clause(message: str, help: str = "") -> Misfit:
    return Misfit("malformed-clause", message, help)


def _switch(word: str) -> Misfit:
    help = f"write `({word} (:skill argument...))`"
    return Misfit("malformed-clause", "one skill is wanted here", help, whole=True)


def _step(message: str, help: str = "") -> Misfit:
    return Misfit("malformed-step", message, help)


def _form(message: str, help: str = "") -> Misfit:
    return Misfit("malformed-form", message, help)


def _rule(message: str, help: str = "") -> Misfit:
    return Misfit("malformed-rule", message, help)


_DEFAULTS = "it is `unknown`, `true`, `false` or the name of a function"
_FIRST_VALUE = (
    "another first value is an initial fact, of the world, a test or `--fact`"
)
_ON_RESULT = "write `:on (okay (fact ...) (not (fact ...)) (may (fact ...)))`"

MISFITS: Mapping[str, Misfit] = {
    # declarations
    "arguments": _form("a list of variables is wanted here, not {kind}"),
    "argument": _form("an argument in parentheses is a variable and its kind"),
    "valued": _form(
        "the arguments of a property end with its value",
        "a property without arguments has only that: `(?value)`",
    ),
    "DEFAULT": _form("this is no default", f"{_DEFAULTS}; {_FIRST_VALUE}"),
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
    # RAPs
    "resource": _clause(
        "a resource is a set or a counter", "write `(set ?name)` or `(counter ?name 0)`"
    ),
    "step": _step(
        "a step begins with its tag, a symbol",
        "write `(tag (rap args...) annotation...)`",
    ),
    "_priority": _step("a priority is an integer"),
    "annotation": Misfit(
        "malformed-annotation", "{kind} stands where an annotation is wanted"
    ),
    # rules over memory
    "define_memory_rule": _rule(
        "a memory rule says when it runs, `:finish` or `:event`"
    ),
    "match_result": _rule(
        "behind its time a memory rule has one `match-result`",
        "write `(match-result (succeed (rule (query action...))))`",
    ),
    "case": _rule("a case is a result and the rules for it"),
    "rule": _rule("a `(rule ...)` is wanted here"),
    "alternative": _rule(
        "a query and its actions stand in parentheses together",
        "write `(rule (query (mem-add p) (mem-del p))...)`",
    ),
    "action": _rule("an action is `(mem-add fact)` or `(mem-del prefix)`"),
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
    "enabled": _switch("enable"),
    "disabled": _switch("disable"),
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
"""What is said by the rule that was wanted, or, behind `_`, a part of one."""


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
