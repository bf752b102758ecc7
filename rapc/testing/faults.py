"""Syntax of faults on the command line: `--fault`.

The effect of a fault on a world is in `rapc.worlds.faults`.
"""

from __future__ import annotations

import math
from typing import Any

from rapc.base.names import did_you_mean
from rapc.base.values import Number, number
from rapc.errors import TextError
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.parser.parse import parse_pattern
from rapc.testing.patterns import end_of_list, flat
from rapc.worlds.faults import InjectedFault

_OPTIONS = {"p": "p", "from": "start", "until": "stop", "by": "by"}


def told_for_skills(library: Library) -> frozenset[str]:
    """Return the events that skills may emit: declared for the skills, or awaited.

    A spurious signal is one of these events that none of the skills has emitted.
    """
    told = {event for form in library.skills.values() for event in form.events or ()}
    bodies = (m.body for rap in library.raps.values() for m in rap.methods)
    for body in bodies:
        if isinstance(body, nodes.Skills):
            told.update(wait.signal for wait in body.waits)
    return frozenset(told)


def read_fault(text: str) -> InjectedFault:
    """Return a fault from `(request) result p=0.3 from=100 until=200`.

    Return a fault of a signal from `(:signal) lost`, `late by=5`, `doubled` or
    `spurious by=5`.

    Raises:
        TextError: if the text is invalid; the message has one line.
    """
    end = end_of_list(text)
    of_signal = text.lstrip().startswith("(:")
    if text.split()[:1] in (["(enable"], ["(disable"]):
        raise TextError(
            "a skill cannot fail; for a fault of its signals write `(:signal) lost`"
        )
    request = parse_pattern(text[:end].replace("(:", "(", 1))
    if any(isinstance(arg, nodes.Call) for arg in request.args):
        raise TextError(
            f"a request must not contain computed terms: {text[:end].strip()}"
        )
    result, *options = text[end:].split() or [""]
    if not result or "=" in result:
        missing = "kind of signal fault" if of_signal else "result"
        raise TextError(f"missing {missing} after {text[:end].strip()}")
    given: dict[str, Any] = {}
    for option in options:
        name, equals, value = option.partition("=")
        if name not in _OPTIONS or not equals:
            known = "expected p, from, until or by"
            said = did_you_mean(name, _OPTIONS, known, "`{}=`")
            raise TextError(f"unknown option `{option}` of a fault; {said}")
        if _OPTIONS[name] in given:
            raise TextError(f"duplicate option `{name}`")
        given[_OPTIONS[name]] = _number(name, value)
    if given.get("start", 0) > given.get("stop", math.inf):
        raise TextError("`from` is later than `until`")
    if not 0 <= given.get("p", 1) <= 1:
        raise TextError("`p` is a chance, from 0 to 1")
    pattern = flat(request)
    if of_signal:
        pattern = (f":{pattern[0]}", *pattern[1:])
    return InjectedFault(pattern, result.lower(), **given)


def _number(name: str, text: str) -> Number:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0):
        raise TextError(f"`{name}` takes a number, not `{text}`")
    return number(value)
