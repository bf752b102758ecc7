"""The loop of a run: messages, monitors, the selection of a task, and its cycle.

If no task is eligible, the clock moves to the next time with an event. A run ends when
there is no such time [T figure 3.3; L 4]. Not here: the cycle of a task
(`rapc.runtime.tasks.cycle`).
"""

from __future__ import annotations

import heapq
import sys

from rapc.base.values import number
from rapc.runtime.pictures import tell_picture
from rapc.runtime.run import Run
from rapc.runtime.tasks.cycle import run_cycle
from rapc.runtime.tasks.hold_things import resume_skills
from rapc.runtime.tasks.messages import take_in
from rapc.runtime.tasks.start import create_top, release
from rapc.world import NOT_KNOWN, Drawable, Time


def run_loop(  # noqa: PLR0912, PLR0915  # calls in each pass cost time
    run: Run, most: int | None, wait: bool, choose: bool = True, arrive: bool = False
) -> str | None:
    """Run the loop until the run is over; return the reason.

    The loop may stop before the run is over; then the result is None.

    Args:
        run: a run that has started.
        most: the number of cycles after which the loop stops; None: no limit.
        wait: whether the loop may wait; if not, the loop stops when no task is
            eligible.
        choose: whether the loop may choose a task; if not, the loop stops before the
            choice.
        arrive: whether the loop stops between two cycles, as soon as the clock has
            moved or messages have arrived, or else before the next choice. The next
            loop continues this pass: it does not ask the world the same again.

    Returns:
        `until`, `world`, `done` or `runaway` (see `why_over`), `stuck` if the run
        waits for nothing known or has waited in vain (see `_wait`), or None.

    Raises:
        PortError: if the world breaks.
    """
    state, port, cost = run.state, run.port, run.settings.cycle_cost
    (
        recorder,
        eligible,
        monitors,
        to_test,
        things_to_test,
        timers,
        unsettled,
    ) = run.read_by_loop
    off, cycle = state.activations.off, recorder.cycle
    clock, receive = port.clock, port.receive
    pictures = run.settings.pictures and recorder.on
    drawn = port if pictures and isinstance(port, Drawable) else None
    # In each pass, the loop queries a world that may end the run by itself.
    may_end = port.may_end
    last = -1 if most is None else cycle + most
    # The last cycle in which the run is not yet idle for too long, as far as the loop
    # knows: `why_over` looks at the present state. A loop that stops at arrivals looks
    # in each pass.
    idle_cycles = run.settings.idle_cycles if not arrive else -sys.maxsize
    idle_limit = state.moved_at + idle_cycles
    reason: str | None = None
    received = state.received
    run.in_loop = True
    try:
        while cycle != last and not state.stops:
            if received:
                received = state.received = False
            else:
                now = clock()
                if now != recorder.time:
                    run.arrived = True
                    if run.set_clock(now):
                        reason = "until"
                        break
                if timers or unsettled:
                    run.run_host_timers()
                    run.access.recognise()
                messages = receive()
                # None, an error of the world, is refused by `listed` like other types.
                if messages or off or messages is None:
                    run.arrived |= bool(messages)
                    take_in(run, port.listed(messages))
            if drawn is not None:
                tell_picture(run, drawn)
            look = monitors.next_look
            if (
                to_test
                or things_to_test
                or (look is not None and recorder.time >= look)
            ):
                _wake(run)
            if (
                cycle > idle_limit
                or not state.foreground
                or (may_end and port.ended() is not None)
            ):
                if arrive and (run.arrived or len(eligible)):
                    state.received = True
                    break
                reason = why_over(run)
                if reason is not None:
                    break
                idle_limit = state.moved_at + idle_cycles
            task = eligible.choose() if choose else None
            if task is None:
                if not wait or len(eligible):
                    break
                reason = _wait(run)
                idle_limit = state.moved_at + idle_cycles
                if reason is not None:
                    break
                run.arrived = True
                continue
            recorder.cycle = cycle = cycle + 1
            state.idle_waits = 0
            run_cycle(run, task)
            if cost:
                _spend(run, cost)
    finally:
        run.in_loop = False
    run.broken = False
    return reason


def why_over(run: Run) -> str | None:
    """Return the reason for the end of the run, or None before the end."""
    state = run.state
    if state.past_until:
        return "until"
    if run.port.ended() is not None:
        return "world"
    going = state.foreground or state.expected or run.host_timers
    if not (going or (state.until is not None and _only_background(run))):
        return "done"
    idle = run.recorder.cycle - state.moved_at
    return "runaway" if idle > run.settings.idle_cycles else None


def _only_background(run: Run) -> bool:
    """Whether the run has tasks left, and never had one that is not in the background.

    Such a run goes on until its time limit.
    """
    state = run.state
    left = bool(state.live_top or state.scheduled)
    return left and all(given.background for given in state.top_level)


def _wake(run: Run) -> None:
    """Start all work that is due, and test the marked monitors."""
    monitors, things = run.monitors, run.things
    look = monitors.next_look
    if look is not None and run.recorder.time >= look:
        _start_due(run)
    monitors.test_marked()
    while things.resumable:
        resume_skills(run)
        monitors.test_marked()
    if run.state.scheduled:
        monitors.look_by(run.state.scheduled[0][0])


def _start_due(run: Run) -> None:
    """Create the scheduled tasks, and start the steps, that are due."""
    scheduled = run.state.scheduled
    while scheduled and scheduled[0][0] <= run.recorder.time:
        submission = heapq.heappop(scheduled)[2]
        run.state.expected -= not submission.background
        create_top(run, submission)
    for task in run.monitors.due():
        release(run, task, again=True)


def _spend(run: Run, cost: Time) -> None:
    """Advance the clock by the cost of a cycle."""
    port = run.port
    port.advance(number(port.now() + cost))
    run.sync_clock()


def _wait(run: Run) -> str | None:
    """Advance to the next known time; return the reason if the run is over.

    If the world cannot state its next time, the wait ends after `Settings.patience`.
    A wait in which the clock does not move counts like a cycle for
    `Settings.idle_cycles`.
    """
    state, port = run.state, run.port
    until, now = state.until, run.recorder.time
    known = _coming_times(run)
    if not known or run.waited_in_vain():
        return "stuck"
    target = max(min(known), now)
    end = None
    if target == NOT_KNOWN:
        target = end = number(now + run.settings.patience)
    if until is not None and target > until:
        if now == until:
            return "until"
        target = until
    run.in_wait = True
    if state.stops:  # interrupted just before
        run.in_wait = False
        return None
    for action in run.when_waiting:
        action()
    state.idle_waits += 1
    port.advance(target)
    run.in_wait = False
    moved = port.now() != now
    if not moved:
        state.moved_at -= 1  # the wait counts as one more idle cycle
    if target == end:
        return _wait_is_over(run, end)
    if not moved:
        _take_what_is_due(run, target)
    return None


def _wait_is_over(run: Run, end: Time) -> str | None:
    """Take in the messages of a wait until `end`; return `stuck` without any.

    Raises:
        PortError: for a world that has stopped before `end`, and sent nothing.
    """
    port = run.port
    run.sync_clock()
    messages = port.messages()
    if messages:
        take_in(run, messages)
    elif port.ended() is None:
        port.check_stop(run.recorder.time, end)
        return "stuck"
    return None


def _take_what_is_due(run: Run, target: Time) -> None:
    """Take in the messages of a world whose clock has not moved.

    Raises:
        PortError: for a world that should have moved its clock, or sent a message.
    """
    port = run.port
    messages = port.messages()
    if messages:
        take_in(run, messages)
    else:
        port.check_wait(run.recorder.time, target)


def _coming_times(run: Run) -> list[Time]:
    """Return the known times of future events.

    Raises:
        PortError: for a world whose next time is invalid, or past.
    """
    due = run.port.next_time(run.recorder.time)
    times = [run.monitors.next_time(), due]
    if run.state.scheduled:
        times.append(run.state.scheduled[0][0])
    if run.host_timers:
        times.append(run.host_timers[0][0])
    return [time for time in times if time is not None]
