"""What tasks of a RAP may fail with, and which events skills below them may tell.

Both are summed up along the calls, as `rapc.analysis.effects` sums up facts. A RAP
whose failures cannot be known has a method that is still to be written, asks for a
primitive or a RAP that nobody declares, or leaves its methods to a problem solver. What
the interpreter itself fails a task with is not told here
(`rapc.analysis.checks.unknown_result`).
"""

from __future__ import annotations

from collections.abc import Container, Iterable

from rapc.analysis.effects import does_nothing
from rapc.base.graph import reachable_bits
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import Library

_ANY_FAILURE = 1
"""The bit of what may fail with anything."""

_ANY_EVENT = 2
"""The bit of what may tell any event."""


class Outcomes:
    """The failures and events of the RAPs of a library.

    Args:
        library: the library.
        unread: the RAPs of which not all is known what they do.
    """

    def __init__(self, library: Library, unread: Container[str] = ()) -> None:
        self._library = library
        self._bits: dict[str, int] = {}
        own = {
            rap.name: self._of(rap, rap.name in unread) for rap in library.raps.values()
        }
        calls = {
            rap.name: tuple(
                step.goal.name for method in rap.methods for step in steps(method)
            )
            for rap in library.raps.values()
        }
        self._sums = reachable_bits(own, calls)

    def fails_with(self, name: str, failure: str) -> bool:
        """Whether a task of the RAP `name` may fail with `failure`, a symbol."""
        return self._has(name, _ANY_FAILURE, failure)

    def tells(self, name: str, event: str) -> bool:
        """Whether skills of the RAP `name`, or below it, may tell `event`."""
        return self._has(name, _ANY_EVENT, event)

    def _has(self, name: str, anything: int, told: str) -> bool:
        bits = self._sums.get(name, anything)
        return bool(bits & (anything | self._bits.get(told, 0)))

    def _of(self, rap: nodes.DefineRap, unread: bool) -> int:
        """Return what a RAP does by itself, its steps aside."""
        found = _ANY_FAILURE | _ANY_EVENT if unread or not rap.methods else 0
        for method in rap.methods:
            if does_nothing(method):
                found |= _ANY_FAILURE | _ANY_EVENT
            found |= self._of_skills(method.skills)
            if isinstance(method.body, nodes.Primitive):
                found |= self._of_primitive(method.body.request.name)
            elif isinstance(method.body, nodes.Skills):
                found |= self._of_skills(method.body.enable)
                found |= self._of_waits(method.body.waits)
            for step in steps(method):
                notes = step.annotations
                waits = [note for note in notes if isinstance(note, nodes.WaitFor)]
                found |= self._of_waits(waits)
                if step.goal.name not in self._library.raps:
                    found |= _ANY_FAILURE | _ANY_EVENT
        return found

    def _of_primitive(self, name: str) -> int:
        form = self._library.primitives.get(name)
        if form is None:
            return _ANY_FAILURE | _ANY_EVENT
        found = 0 if form.atomic else _ANY_EVENT
        for result in form.results:
            found |= self._bit(result)
        return found

    def _of_skills(self, skills: Iterable[nodes.Skill]) -> int:
        found = 0
        for skill in skills:
            form = self._library.skills.get(skill.name)
            if form is None or form.events is None:
                found |= _ANY_EVENT
            else:
                for event in form.events:
                    found |= self._bit(event)
        return found

    def _of_waits(self, waits: Iterable[nodes.WaitFor]) -> int:
        """Return the bits of events that are awaited, and of failures by them."""
        found = 0
        for wait in waits:
            found |= self._bit(wait.signal)
            if wait.mode == "fail":
                found |= self._bit(wait.signal.removeprefix(":"))
        return found

    def _bit(self, name: str) -> int:
        """Return the bit of a failure, or of an event by its name with the colon."""
        return self._bits.setdefault(name, 4 << len(self._bits))
