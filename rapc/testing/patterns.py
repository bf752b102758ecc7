"""Match the patterns of a test with events.

Events hold values, except for texts for people: a monitor's formula (`on`), tasks and
faults as the user wrote them. Patterns match these texts as terms, too, so the texts
are parsed.

The meaning of an event for an expectation is in `rapc.testing.judge`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import msgspec

from rapc import events
from rapc.base import values
from rapc.base.values import Atom, Fact, Text, number
from rapc.ir import nodes
from rapc.runtime.events.trace import record

Value = Atom | tuple[Any, ...]
"""A term of a trace: an atom, or a list as a tuple; `#counter(3)` is one symbol."""

_STRING = r'"(?:[^"\\]|\\.)*"'
_RESOURCE = rf'#(?:counter|set)\((?:[^()"]|{_STRING})*\)'
_WORD = re.compile(rf'[()]|{_STRING}|{_RESOURCE}|[^\s()"]+')
_NUMBER = re.compile(r"[-+]?[0-9]+(?:\.[0-9]+)?")
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)


def read_value(text: str) -> Value:
    """Return a term from the text of a trace; a string if the text is not a term."""
    stack: list[list[Value]] = [[]]
    for word in _WORD.findall(text):
        if word == "(":
            stack.append([])
        elif word != ")":
            stack[-1].append(_atom(word))
        elif len(stack) > 1:
            done = tuple(stack.pop())
            stack[-1].append(done)
        else:
            return Text(text)
    whole = stack[0]
    return whole[0] if len(stack) == 1 and len(whole) == 1 else Text(text)


def end_of_list(text: str) -> int:
    """Return the offset after the first list of a text, or the whole length."""
    depth = 0
    for word in _WORD.finditer(text):
        depth += {"(": 1, ")": -1}.get(word[0], 0)
        if depth <= 0:
            return word.end()
    return len(text)


def _atom(word: str) -> Atom:
    if word.startswith('"'):
        return Text(_ESCAPE.sub(r"\1", word[1:-1]))
    if not _NUMBER.fullmatch(word):
        return word
    return number(float(word)) if "." in word else int(word)


def flat(node: nodes.Pattern | nodes.Goal) -> Fact:
    """Return a goal or request as a flat pattern, with variables by name."""
    return (node.name, *[atom(arg) for arg in node.args])


def atom(term: nodes.Term) -> Atom:
    """Return a constant's value or a variable's name; computed terms do not occur."""
    assert not isinstance(term, nodes.Call)
    return term.value if isinstance(term, nodes.Const) else term.name


def goal_matches(goal: nodes.Goal, inputs: Fact) -> bool:
    """Return whether the RAP and its inputs match; variables match any value."""
    return values.match_pattern(flat(goal), inputs) is not None


# --- events ------------------------------------------------------------------------


def event_matches(pattern: nodes.EventPattern, event: events.Event) -> bool:
    """Return whether an event matches a pattern, whose keys are those of the trace."""
    kind = type(event)
    if kind.__struct_config__.tag != pattern.event:
        return False
    found = dict(
        zip(kind.__struct_encode_fields__, msgspec.structs.astuple(event), strict=True)
    )
    bound: dict[str, Value] = {}
    for key, wanted in pattern.keys:
        value = found.get(key)
        if value is None:
            return False
        if isinstance(wanted, nodes.Const) and wanted.value == Text(_text(event, key)):
            continue
        outputs = not isinstance(value, events.Goal) or _names_outputs(wanted)
        if not _unify(wanted, _term(value, outputs), bound):
            return False
    return True


def _names_outputs(pattern: nodes.TracePattern) -> bool:
    if not isinstance(pattern, nodes.ListPattern):
        return True
    return any(i.value == "=>" for i in pattern.items if isinstance(i, nodes.Const))


def _text(event: events.Event, key: str) -> str:
    """Return the text of a trace under a key."""
    return str(record(event)[key])


def _term(value: object, outputs: bool = True) -> Value:
    """Return a value of an event as a term.

    Objects are lists of pairs, text is parsed, and a missing value inside an object is
    the symbol `null`.
    """
    match value:
        case None:
            value = "null"
        case events.Goal():
            return value.parts if outputs else (value.name, *value.inputs)
        case events.ResourceChange():
            value = Text(str(value))
        case events.TaskResult() | events.PlanStep() | events.PlanLink():
            value = _term(msgspec.structs.asdict(value))
        case Mapping():
            value = tuple([(str(name), _term(one)) for name, one in value.items()])
        case tuple():
            value = tuple([_term(one) for one in value])
        case str():
            value = read_value(value)
    assert isinstance(value, int | float | str | Text | tuple)
    return value


def _unify(pattern: nodes.TracePattern, value: Value, bound: dict[str, Value]) -> bool:
    """Return whether a value matches; data are nested within the reader's limit."""
    if isinstance(pattern, nodes.Var):
        return pattern.anonymous or bound.setdefault(pattern.name, value) == value
    if isinstance(pattern, nodes.Const):
        return pattern.value == value
    return (
        isinstance(value, tuple)
        and len(value) == len(pattern.items)
        and all(map(lambda p, v: _unify(p, v, bound), pattern.items, value))
    )
