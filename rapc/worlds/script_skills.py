"""The skills of a scripted world: while they are on, they tell what their rows say."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from rapc.base.values import Fact, number
from rapc.world import Refused, Time
from rapc.worlds.script import FoundRow, Script
from rapc.worlds.script_state import Due, ScriptState, SkillOn


class ScriptedSkills:
    """The skills of a scripted world: each tells what its row says.

    Args:
        script: the rows.
    """

    def __init__(self, script: Script) -> None:
        self._script = script

    def switch_on(
        self, state: ScriptState, ticket: int, skills: Sequence[Fact]
    ) -> Refused | None:
        """Switch skills on; each does what the first row for it says that matches.

        Args:
            state: of the scripted world; the skills are on in it then.
            ticket: of the activation.
            skills: what comes on; one that is on already goes on as it is.

        Returns:
            In whose way they are, by the first row that refuses one; else None.
        """
        coming = [skill for skill in skills if state.found(skill) is None]
        found = {
            skill: self._script.find("enable", skill, state.used) for skill in coming
        }
        for row in found.values():
            if row is not None and self._script.rows[row[0]].refused:
                self._script.use(row, state.used)
                return Refused(state.under_way())
        for skill in dict.fromkeys(skills):
            on = state.found(skill)
            if on is None:
                on = SkillOn(skill, [])
                state.on.append(on)
                self._start(state, skill, found[skill])
            on.tickets.append(ticket)
        return None

    def switch_off(self, state: ScriptState, ticket: int) -> None:
        """Switch off the skills that only this activation has."""
        for on in [on for on in state.on if ticket in on.tickets]:
            on.tickets.remove(ticket)
            if on.tickets:
                continue
            state.on.remove(on)
            state.coming = [due for due in state.coming if due.skill != on.skill]
            found = self._script.find("disable", on.skill, state.used)
            if found is not None:
                row = self._script.use(found, state.used)
                state.change_memory(row)
                state.send(row.signals, (ticket,))

    def tell(self, state: ScriptState, due: Due) -> None:
        """Send the signal of a skill that is due, and plan the next one."""
        row, on = due.row, state.found(due.skill or ())
        if row is None or on is None:
            return
        if due.signal == 0:
            state.change_memory(row)
        state.send(row.signals[due.signal : due.signal + 1], tuple(on.tickets))
        if due.signal + 1 < len(row.signals):
            _tell_later(state, msgspec.structs.replace(due, signal=due.signal + 1), 0)
        elif row.every is not None:
            _tell_later(state, msgspec.structs.replace(due, signal=0), row.every)

    def _start(self, state: ScriptState, skill: Fact, found: FoundRow | None) -> None:
        """Let a skill have to tell, from now on, what its row says."""
        if found is None:
            return
        row = self._script.use(found, state.used)
        _tell_later(state, Due(0, row=row, skill=skill), row.after or 0)


def _tell_later(state: ScriptState, due: Due, wait: Time) -> None:
    """Let a skill tell a signal of its row after a wait, and its pause."""
    row = due.row
    assert row is not None
    pause = row.pause(due.signal) if row.signals else 0
    time = number(state.now + wait + pause)
    state.expect(msgspec.structs.replace(due, time=time))
