"""The main loop: take in messages, test monitors, choose a task, process the task.

Where nothing is eligible, the clock goes on to the next time at which something can
happen; a run ends when there is none [T figure 3.3; L 4]. Monitors are tested only if
something that they ask about has changed. Not here: what a cycle does to its task
(`rapc.runtime.tasks.cycle`).
"""

from __future__ import annotations

import heapq

from rapc.base.values import number
from rapc.runtime.intake import take_in
from rapc.runtime.machine import Machine
from rapc.runtime.tasks.cycle import run_cycle
from rapc.runtime.tasks.hold_things import resume_skills
from rapc.runtime.tasks.start import create_top, release
from rapc.world import NOT_KNOWN, Time


class Loop:
    """The turns of one run, one after another.

    Two settings bound what a run may do in vain, so that a host always gets control
    back: `idle_cycles` cycles while the clock stands still, `idle_waits` waits without
    a cycle.
    """

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._cost = machine.settings.cycle_cost
        #: What stays the same object for the life of the machine; see where they are.
        self._parts = (
            machine.recorder,
            machine.agenda,
            machine.monitors,
            machine.monitors.to_test,
            machine.host_timers,
            machine.recognizer.unsettled,
            machine.things.changed,
        )

    def run(self, most: int | None, wait: bool, choose: bool = True) -> str | None:
        """Turn until the run is over, and return why, or `most` cycles are done.

        Without `wait` also until no task can go on now, without `choose` until one is
        about to be chosen. Each of these returns None.
        """
        machine = self._machine
        state, world = machine.state, machine.world
        patience = machine.settings.idle_cycles
        recorder, agenda, monitors, to_test, timers, unsettled, changed = self._parts
        gone, cycle, cost = state.activations.off, recorder.cycle, self._cost
        clock, receive = world.clock, world.receive
        # A world that may end the run by itself is asked in each turn.
        ended, may_end = world.ended, world.may_end
        last = -1 if most is None else cycle + most
        # The last cycle that the clock may stand still; it moved `patience` before.
        limit = cycle - state.idle + patience
        reason: str | None = None
        machine.turning = True
        while cycle != last and not state.over:
            now = clock()
            if now != recorder.time and machine.set_clock(now):
                reason = "until"
                break
            if timers or unsettled:
                machine.run_host_timers()
                machine.access.recognise()
            messages = receive()
            if messages or gone or messages is None:
                take_in(machine, world.listed(messages))
            look = monitors.next_look
            if to_test or changed or (look is not None and recorder.time >= look):
                self._wake()
            if (
                cycle > limit
                or not state.foreground
                or (may_end and ended() is not None)
            ):
                state.idle = cycle - limit + patience
                reason = self.reason()
                if reason is not None:
                    break
            task = agenda.choose() if choose else None
            if task is None:
                if not wait or len(agenda):
                    break
                state.idle = cycle - limit + patience
                reason = self._wait()
                limit = cycle - state.idle + patience
                if reason is not None:
                    break
                continue
            recorder.cycle = cycle = cycle + 1
            state.waits = 0
            run_cycle(machine, task)
            if cost:
                self._spend(cost)
            if recorder.time != now:
                limit = cycle + patience
        state.idle = cycle - limit + patience
        machine.turning = machine.broken = False
        return reason

    def reason(self) -> str | None:
        """Return why the run is over, or None if it is not."""
        machine, state = self._machine, self._machine.state
        if state.past_until:
            return "until"
        if machine.world.ended() is not None:
            return "world"
        if not (state.foreground or state.expected or machine.host_timers):
            return "done"
        return "runaway" if state.idle > machine.settings.idle_cycles else None

    def _wake(self) -> None:
        """Start what has waited for this time, and test what has changed."""
        machine = self._machine
        monitors, things = machine.monitors, machine.things
        look = monitors.next_look
        if look is not None and machine.recorder.time >= look:
            self._start_due()
        monitors.test_changed()
        while things.resumable:
            resume_skills(machine)
            monitors.test_changed()
        if machine.state.scheduled:
            monitors.look_by(machine.state.scheduled[0][0])

    def _start_due(self) -> None:
        """Create the tasks, and start the steps, that have waited for this time."""
        machine = self._machine
        scheduled = machine.state.scheduled
        while scheduled and scheduled[0][0] <= machine.recorder.time:
            submission = heapq.heappop(scheduled)[2]
            machine.state.expected -= not submission.background
            create_top(machine, submission)
        for task in machine.monitors.due():
            release(machine, task, again=True)

    def _spend(self, cost: Time) -> None:
        """Let a cycle take its time."""
        world = self._machine.world
        world.advance(number(world.now() + cost))
        self._machine.sync_clock()

    def _wait(self) -> str | None:
        """Move time on to what comes next, as nothing is eligible, or say what ends.

        Where the clock does not move, the turn counts as idle.
        """
        machine, until = self._machine, self._machine.state.until
        now = machine.recorder.time
        known = self._coming_times()
        if not known or machine.waited_in_vain():
            return "stuck"
        target = max(min(known), now)
        end = None
        if target == NOT_KNOWN:
            target = end = number(now + machine.settings.patience)
        if until is not None and target > until:
            if now == until:
                return "until"
            target = until
        for action in machine.when_waiting:
            action()
        machine.state.waits += 1
        machine.world.advance(target)
        moved = machine.world.now() != now
        machine.state.idle = 0 if moved else machine.state.idle + 1
        if target == end:
            return self._wait_is_over(end)
        if not moved:
            self._take_what_is_due(target)
        return None

    def _wait_is_over(self, end: Time) -> str | None:
        """Take in what has come of a wait until `end` at most; `stuck` if nothing has.

        Raises:
            PortError: for a world that has stopped before, and sent nothing.
        """
        machine, world = self._machine, self._machine.world
        machine.sync_clock()
        messages = world.messages()
        if messages:
            take_in(machine, messages)
        elif world.ended() is None:
            world.check_stop(machine.recorder.time, end)
            return "stuck"
        return None

    def _take_what_is_due(self, target: Time) -> None:
        """Take in what the world has sent where waiting has not moved its clock.

        Raises:
            PortError: for a world that should have moved it, or sent something.
        """
        machine, world = self._machine, self._machine.world
        messages = world.messages()
        if messages:
            take_in(machine, messages)
        else:
            world.check_wait(machine.recorder.time, target)

    def _coming_times(self) -> list[Time]:
        """Return the times at which something is known to come.

        Raises:
            PortError: for a world whose next time is no time, or has been.
        """
        machine = self._machine
        due = machine.world.next_time(machine.recorder.time)
        times = [machine.monitors.next_time(), due]
        if machine.state.scheduled:
            times.append(machine.state.scheduled[0][0])
        if machine.host_timers:
            times.append(machine.host_timers[0][0])
        return [time for time in times if time is not None]
