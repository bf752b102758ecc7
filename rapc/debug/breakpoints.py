"""Breakpoints: kinds, conditions and counts of the events that stop a run.

A cycle cannot be interrupted. Therefore a run stops after the cycle that meets a
breakpoint. A breakpoint with `before` then goes back to the preceding cycle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import msgspec

from rapc import events
from rapc.base.names import hint
from rapc.base.values import (
    Fact,
    format_atom,
    format_list,
    is_variable,
    match_pattern,
    readable,
)
from rapc.debug.arguments import read_pattern
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.errors import ArgumentError, TextError
from rapc.events import Event
from rapc.library.signatures import Use
from rapc.world import Time

KINDS: Mapping[str, str] = {
    "rap": "a task of a RAP is selected: NAME, or a goal with variables",
    "task": "a task is selected or ends: its number",
    "method": "a method is chosen: NAME, or NAME of RAP",
    "failure": "a task fails: a reason or result; by default any",
    "primitive": "a request is sent: a request with variables",
    "fact": "a fact is asserted or erased: a fact with variables",
    "untrue": "a belief is found to be wrong: a fact with variables",
    "true": "a query becomes true",
    "false": "a query becomes false",
    "deadline": "a deadline is missed",
    "time": "the clock reaches a time",
}
"""The kinds of breakpoints, each with its help."""


class Breakpoint(msgspec.Struct, omit_defaults=True):
    """A breakpoint."""

    kind: str
    #: The argument of the kind: a name, a number or a list; see `KINDS`.
    what: str = ""
    #: A formula that must hold at the end of the cycle; empty for none.
    condition: str = ""
    #: The number of times that the run passes the breakpoint before it stops.
    passes: int = 0
    #: Whether the breakpoint only logs and does not stop the run.
    logs: bool = False
    #: Whether the run stops before the cycle.
    before: bool = False
    #: The number of times that the breakpoint was met.
    met: int = 0

    def __str__(self) -> str:
        words = [self.kind, self.what]
        words += ["if", self.condition] if self.condition else []
        words += ["after", str(self.passes)] if self.passes else []
        words += ["log"] * self.logs + ["before"] * self.before
        return " ".join(word for word in words if word)


Meets = Callable[[ToldEvent], bool]

_OF_TASKS = (events.TaskSelected, events.TaskSucceeded, events.TaskFailed)


class Breakpoints:
    """The breakpoints of a history.

    Args:
        history: the history of the run to stop.
    """

    def __init__(self, history: History) -> None:
        self._history = history
        self._next = 1
        #: The breakpoints by number.
        self.all: dict[int, Breakpoint] = {}
        #: The texts that logging breakpoints have produced.
        self.logged: list[str] = []
        #: The matchers of the breakpoints that wait for an event, by number.
        self._meets: dict[int, Meets] = {}
        #: The patterns of the facts of breakpoints on wrong beliefs, by number.
        self._beliefs: dict[int, Fact] = {}
        #: The last state of breakpoints on a time or a query: has come, or holds.
        self._held: dict[int, bool] = {}
        self._stopped_before: int | None = None

    # --- setting ------------------------------------------------------------------

    def add(self, point: Breakpoint) -> int:
        """Set a breakpoint and return its number.

        Raises:
            TextError: if the breakpoint is invalid.
            ValueError: for names that the library does not declare.
        """
        number, history = self._next, self._history
        if point.kind not in KINDS:
            raise TextError(
                f"unknown kind of breakpoint `{point.kind}`; expected one of "
                f"{', '.join(KINDS)}"
            )
        if not point.what and point.kind not in ("failure", "deadline"):
            raise TextError(
                f"breakpoint `{point.kind}` requires an argument: {KINDS[point.kind]}"
            )
        if point.condition:
            history.question(point.condition)  # validates the names
        if point.kind in ("true", "false"):
            self._held[number] = bool(history.question(point.what).holds())
        elif point.kind == "time":
            _number(point.what)  # validates the time
            self._held[number] = False
        elif point.kind == "untrue":
            history.check_knows_truth()
            self._beliefs[number] = self._pattern("asserted", point.what)
        else:
            self._meets[number] = self._matcher(point)
        self.all[number] = point
        self._next += 1
        self._install()
        return number

    def remove(self, number: int) -> None:
        """Remove a breakpoint.

        Raises:
            ArgumentError: if no breakpoint has that number.
        """
        if self.all.pop(number, None) is None:
            raise ArgumentError(f"unknown breakpoint {number}")
        self._meets.pop(number, None)
        self._held.pop(number, None)
        self._beliefs.pop(number, None)
        self._install()

    def _install(self) -> None:
        if self.all:
            self._history.checks["breakpoints"] = self._check
        else:
            self._history.checks.pop("breakpoints", None)

    def _matcher(self, point: Breakpoint) -> Meets:
        """Return the function that decides whether an event meets a breakpoint."""
        kind, what = point.kind, point.what
        if kind == "rap":
            return self._of_goal(what)
        if kind in ("primitive", "fact"):
            return self._of_list(kind, what)
        if kind == "method":
            return self._of_method(what)
        if kind == "task":
            number = _number(what)
            return _of(lambda keys: keys["task"] == number, *_OF_TASKS)
        if kind == "failure":
            return _of(
                lambda keys: what in ("", keys["reason"], keys["result"]),
                events.TaskFailed,
            )
        return _of(lambda keys: True, events.DeadlineMissed)

    def _of_method(self, what: str) -> Meets:
        """Return the matcher for the choice of a method."""
        name, _, rap = what.lower().partition(" of ")
        raps = self.raps_with(name)
        if rap:
            self._see_rap(rap)
        # Methods of solvers have numbers, those of the planner are called `plan-N`.
        if not raps and not name.startswith(("#", "plan-")):
            known = self._methods()
            raise ArgumentError(f"unknown method `{name}`{hint(name, known)}")
        if rap and raps and rap not in raps:
            listed = ", ".join(f"`{one}`" for one in raps)
            raise ArgumentError(
                f"`{rap}` has no method `{name}`; expected one of {listed}"
            )
        return _of(
            lambda keys: keys["method"] == name and rap in ("", keys["rap"]),
            events.MethodChosen,
        )

    def raps_with(self, method: str) -> list[str]:
        """Return the RAPs that have a method with a given name."""
        return self._methods().get(method, [])

    def _methods(self) -> Mapping[str, list[str]]:
        """Return the RAPs of each method, by the name of the method in traces."""
        found: dict[str, list[str]] = {}
        for rap in self._history.library.program.library.raps.values():
            for method in rap.methods:
                found.setdefault(method.traced_name, []).append(rap.name)
        return found

    def _see_rap(self, name: str) -> None:
        """Raise ArgumentError if the library has no RAP with a given name."""
        known = self._history.library.program
        if name not in known.library.raps:
            raise ArgumentError(str(known.signatures.unknown("goal", name)))

    def _of_list(self, kind: str, what: str) -> Meets:
        """Return the matcher for events about a request or a fact."""
        pattern = self._pattern(
            "primitive" if kind == "primitive" else "asserted", what
        )
        size, of_facts = len(pattern), (events.FactAsserted, events.FactErased)
        key = "request" if kind == "primitive" else "fact"
        return _of(
            lambda keys: match_pattern(pattern, keys[key][:size]) is not None,
            *((events.PrimitiveRequested,) if kind == "primitive" else of_facts),
        )

    def _pattern(self, use: Use, what: str) -> Fact:
        """Return the pattern of a request or a fact. Raises ArgumentError."""
        pattern = read_pattern(what if what.startswith("(") else f"({what})")
        name, known = str(pattern[0]), self._history.library.program.signatures
        if name not in known.table(use) and not is_variable(name):
            raise ArgumentError(str(known.unknown(use, name)))
        return pattern

    def _of_goal(self, what: str) -> Meets:
        """Return the matcher for the selection of a task, by its goal."""
        size = None if what.startswith("(") else 1  # name only: ignore the inputs
        pattern = read_pattern(what) if size is None else (what.lower(),)
        if size is not None:
            self._see_rap(str(pattern[0]))

        def wanted(keys: Mapping[str, Any]) -> bool:
            goal = (keys["goal"].name, *keys["goal"].inputs)
            return match_pattern(pattern, goal[:size]) is not None

        return _of(wanted, events.TaskSelected)

    # --- while the run goes on ------------------------------------------------------

    def _check(self) -> str | None:
        """Return the text of the breakpoint that stops the last cycle, or None."""
        fresh = self._history.fresh
        met = [
            (number, _words(told))
            for told in (self._history.log.since(fresh) if self._meets else ())
            for number, meets in self._meets.items()
            if meets(told)
        ]
        met += self._turned()
        met += self._untrue() if self._beliefs else ()
        stops = None
        for number, words in met:
            point = self.all[number]
            if not self._counts(point):
                continue
            said = f"breakpoint {number} ({point}): {words}"
            if point.logs:
                self.logged.append(f"{readable(self._history.now):>7} {said}")
            elif stops is None and not (
                point.before and self._history.cycle == self._stopped_before
            ):
                stops = said
                if point.before:
                    self._stopped_before = self._history.cycle
        if stops is not None and self._stopped_before == self._history.cycle:
            here = self._history
            here.goto(here.cycle if here.between else here.cycle - 1)
        return stops

    def _counts(self, point: Breakpoint) -> bool:
        """Count a hit; return whether the breakpoint takes effect."""
        if point.condition and not self._holds(point.condition):
            return False
        point.met += 1
        return point.met > point.passes

    def _turned(self) -> list[tuple[int, str]]:
        """Return the breakpoints whose query changed or whose time came, with text."""
        found = []
        for number, held in list(self._held.items()):
            point, holds = self.all[number], self._is_so(self.all[number])
            self._held[number] = holds
            if holds != held and holds == (point.kind != "false"):
                words = f"{point.what} {'became true' if holds else 'became false'}"
                time = f"time {readable(self._history.now)}"
                found.append((number, time if point.kind == "time" else words))
        return found

    def _untrue(self) -> Iterator[tuple[int, str]]:
        """Yield the breakpoints on beliefs that were found wrong, with texts."""
        for one in self._history.branch.discrepancies.all:
            if not self._history.fresh <= one.first_serial < self._history.serial:
                continue
            fact, _, truth = one.belief
            words = f"{format_list(fact)} is untrue"
            if truth:
                words += f", the truth is {' or '.join(map(format_list, truth))}"
            for number, pattern in self._beliefs.items():
                if match_pattern(pattern, fact[: len(pattern)]) is not None:
                    yield number, words

    def _is_so(self, point: Breakpoint) -> bool:
        """Return whether the query holds or the time has come."""
        if point.kind == "time":
            return self._history.now >= _number(point.what)
        return self._holds(point.what)

    def _holds(self, formula: str) -> bool:
        """Return whether a formula holds.

        A formula with names that a reload has removed does not hold.
        """
        try:
            return bool(self._history.question(formula).holds())
        except ValueError:
            return False

    def look_again(self) -> None:
        """Update the state of queries and times after a move to another moment.

        A breakpoint on a time that has come since, and was not met before, is still
        met after the next cycle.
        """
        for number, held in self._held.items():
            point = self.all[number]
            self._held[number] = self._is_so(point) and (held or point.kind != "time")


def _of(wanted: Callable[[Mapping[str, Any]], bool], *kinds: type[Event]) -> Meets:
    return lambda told: told.kind in kinds and wanted(told.keys)


def _words(told: ToldEvent) -> str:
    """Return a short text for an event."""
    keys = told.keys
    tag = told.kind.__struct_config__.tag
    about = next(
        (keys[key] for key in ("goal", "request", "fact", "method") if key in keys), ""
    )
    if isinstance(about, tuple):
        about = f"({' '.join(map(format_atom, about))})"
    if told.kind is events.MethodChosen:
        about = f"{about} of {keys['rap']}"
    task = keys.get("task")
    return " ".join(
        str(word) for word in (tag, about, "" if task is None else f"[{task}]") if word
    )


def _number(text: str) -> Time:
    try:
        return float(text.removeprefix("[").removesuffix("]"))
    except ValueError:
        raise TextError(f"expected a number, not `{text}`") from None
