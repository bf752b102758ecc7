"""What is looked at before each choice: inputs, times, deadlines and monitors.

Everything is looked at anew, for every task, at every choice [L 3, 4, 5].
"""

from __future__ import annotations

from rapc import events
from rapc.base.resources import Counter, SetResource, Value, frozen
from rapc.base.values import format_atom, is_number, number
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import variable_names
from rapc.world import Time
from tests.reference.deadlocks import circle_through
from tests.reference.run import Run, unbound
from tests.reference.tasks import Place, Task
from tests.reference.things import Obstacle, obstacles

# --- inputs and what is evaluated with them ---------------------------------------


def read_inputs(run: Run, task: Task) -> None:
    """Read the inputs of a step from the bindings of its method."""
    if task.parent is not None and task.place is not None:
        task.args = run.inputs(task.parent, task.place.step.goal.args)
    settle(run, task)


def settle(run: Run, task: Task) -> None:
    """Keep what inputs are bound; evaluate the rest when it uses nothing unbound."""
    names = [variable.name for variable in task.rap.inputs]
    inputs = {n: v for n, v in zip(names, task.args, strict=True) if v is not None}
    if task.full and task.bound_as is None:
        task.bound_as = frozen([arg for arg in task.args if arg is not None])
    task.own = {**inputs, **task.resources}
    waiting = {n for n in names if n not in inputs}
    if not task.prepared and not any(uses(t, waiting) for t in evaluated(task.rap)):
        task.prepared = True
        make_resources(run, task)
        task.duration = duration(run, task)
        set_delay(run, task)


def evaluated(rap: nodes.DefineRap) -> list[nodes.Term | None]:
    """The terms of a RAP that are evaluated when a task is made, or bound."""
    found = [resource.initial for resource in rap.resources]
    if rap.monitor_time is not None:
        found += [rap.monitor_time.start, rap.monitor_time.stop]
    return [*found, rap.duration]


def uses(term: nodes.Term | None, names: set[str]) -> bool:
    """Whether a term uses one of some variables."""
    if isinstance(term, nodes.Var):
        return term.name in names
    if isinstance(term, nodes.Call):
        return any(uses(arg, names) for arg in term.args)
    return False


def duration(run: Run, task: Task) -> int | float:
    """The duration a task states; zero if it states none, or nothing usable."""
    term = task.rap.duration
    if term is None:
        return 0
    own, asked = task.own, task.rap.preconditions
    if asked is not None and uses(term, {*variable_names(term)} - own.keys()):
        found = run.holds(task, asked, own, "preconditions")
        if found is None:
            return 0
        own = {**own, **found}
    value, why = run.value(task, term, own)
    if not isinstance(value, int | float):
        why = why or f"`{format_atom(value)}` is not a number"
        run.fault(task, "duration", task.rap, why)
        return 0
    return value


def make_resources(run: Run, task: Task) -> None:
    """Make the sets and counters that a task declares; a clause copies."""
    held = sum(len(other.resources) for other in run.live())
    wanted = len(task.rap.resources)
    if wanted and held + wanted > run.limits.max_resources:
        task.broken = True
        return
    for resource in task.rap.resources:
        value, why = None, ""
        if resource.initial is not None:
            value, why = run.value(task, resource.initial, task.own)
        made = None if why else new_resource(resource, value)
        if made is None:
            why = why or f"`{format_atom(value)}` is not a {resource.kind}"
            run.fault(task, "resources", resource, why)
            task.broken = True
        else:
            task.resources[resource.variable.name] = made
            task.own[resource.variable.name] = made


def new_resource(
    resource: nodes.Resource, value: Value | None
) -> Counter | SetResource | None:
    """A new set or counter; None if its first value is of the wrong kind."""
    if resource.initial is None:
        return Counter() if resource.kind == "counter" else SetResource()
    if resource.kind == "set":
        return SetResource(value.members) if isinstance(value, SetResource) else None
    if isinstance(value, Counter):
        return Counter(value.value)
    return Counter(value) if isinstance(value, int | float) else None


def set_delay(run: Run, task: Task) -> None:
    """When the delay of a `monitor-time` ends, and its deadline."""
    monitor = task.rap.monitor_time
    if monitor is None:
        return
    if task.delay is not None:
        note_missed(run, task)
    found = times(run, task, "monitor-time", task.own, monitor)
    if found is None:
        task.broken = True
        return
    base = task.delay_from if monitor.reference == "now" else 0
    task.delay = (number(base + found[0]), number(base + found[1]))


def times(
    run: Run,
    task: Task,
    clause: str,
    env: object,
    node: nodes.MonitorTime | nodes.Window,
) -> tuple[Time, Time] | None:
    """The two times of a delay or window; None if one is no number."""
    found = []
    for term in (node.start, node.stop):
        value, why = run.value(task, term, env)  # type: ignore[arg-type]
        if not is_number(value):
            why = why or f"`{format_atom(value)}` is not a number"
            run.fault(task, clause, node, why)
            return None
        found.append(value)
    return found[0], found[1]  # type: ignore[return-value]


# --- order, windows, deadlines ----------------------------------------------------


def order_allows(task: Task) -> bool:
    """Whether all that a task was ordered after has ended."""
    if task.parent is None or task.place is None:
        return True
    before = task.parent.followed(task.place)
    return all(place.ended is not None for place in before)


def read_windows(run: Run, task: Task) -> None:
    """Fix the windows of a step: when their reference has come and they are bound.

    What is unbound when the order lets the step run is a fault.
    """
    running, place = task.parent, task.place
    if running is None or place is None:
        return
    for index, note in enumerate(place.step.annotations):
        if not isinstance(note, nodes.Window) or index in task.windows:
            continue
        base: Time | None = 0
        if note.reference == "now":
            base = running.made
        elif note.reference != "absolute":
            base = running.place(note.reference).ended
        open_ = unbound(note.start, running.env) or unbound(note.stop, running.env)
        if base is None or (open_ and not order_allows(task)):
            continue
        found = times(run, running.task, "window", running.env, note)
        if found is None:
            task.broken = True
            task.windows[index] = None
        else:
            task.windows[index] = (number(base + found[0]), number(base + found[1]))


def starts(task: Task) -> list[Time]:
    """The start times of a step's windows that are known."""
    return [window[0] for window in task.windows.values() if window is not None]


def starts_allow(run: Run, task: Task) -> bool:
    """Whether all start times of a step have come."""
    return all(start <= run.time for start in starts(task))


def stated_deadline(task: Task) -> Time | None:
    """The nearest deadline that a task states itself."""
    found = [window[1] for window in task.windows.values() if window is not None]
    if task.delay is not None:
        found.append(task.delay[1])
    if task.given_deadline is not None:
        found.append(task.given_deadline)
    return min(found, default=None)


def deadline(task: Task) -> Time | None:
    """The nearest of a task's own deadlines and its ancestors'."""
    stated = [stated_deadline(each) for each in task.line()]
    return min((d for d in stated if d is not None), default=None)


def look_at_deadline(run: Run, task: Task) -> None:
    """A deadline that the clock has passed is traced once."""
    note_missed(run, task)
    for missed in task.to_tell:
        run.tell(events.DeadlineMissed, task=task.number, deadline=missed)
    task.to_tell = []


def note_missed(run: Run, task: Task) -> None:
    """Note that the clock has passed a task's nearest deadline: once for each."""
    stated = stated_deadline(task)
    if stated is not None and run.time > stated and stated != task.missed:
        task.missed = stated
        task.to_tell.append(stated)


# --- monitors ---------------------------------------------------------------------


def delay_over(run: Run, task: Task) -> bool:
    """Whether the time of a `monitor-time` has come."""
    return task.delay is None or task.delay[0] <= run.time


def monitors_hold(run: Run, task: Task) -> bool:
    """Whether all monitors of a task hold now; notes when that may change."""
    task.timers = []
    if not delay_over(run, task):
        return False
    formula = task.rap.monitor_state
    if formula is None:
        return True
    asker = run.asker(task)
    found = asker.first(formula, task.own)
    for within, message in asker.faults:
        run.fault(task, f"{within}monitor-state", formula, message)
    task.timers = asker.timers
    return found is not None


def awaited(run: Run, task: Task) -> str:
    """What a task blocked by a monitor waits for."""
    if task.delay is not None and not delay_over(run, task):
        return f"time {format_atom(task.delay[0])}"
    assert task.rap.monitor_state is not None
    return format_formula(task.rap.monitor_state, task.own)


def block(run: Run, task: Task) -> None:
    """A monitor blocks a task: its futile-loop history starts afresh."""
    task.blocked = True
    task.once = False
    task.chosen, task.times = {}, {}
    task.wanted = []
    task.blocked_on = awaited(run, task)
    run.tell(events.TaskBlocked, task=task.number, on=task.blocked_on)


def may_run(run: Run, task: Task) -> bool:
    """Whether order, start times and waits let a task run; its inputs are read then."""
    if task.running is not None or not order_allows(task):
        return False
    read_windows(run, task)
    if not starts_allow(run, task):
        return False
    if task.place is not None and not task.place.goes:
        return False
    if not task.allowed:
        task.allowed = True
        read_inputs(run, task)
    return True


def look(run: Run, task: Task) -> None:
    """Look at one task before a choice: things, monitors, then deadline."""
    if may_run(run, task):
        if task.wanted:
            look_at_things(run, task)
        whole = task.full and not task.broken and not task.held_up
        if task.monitored and whole and not task.once:
            look_at_monitors(run, task)
    look_at_deadline(run, task)


def look_at_monitors(run: Run, task: Task) -> None:
    """Wake a task whose monitors have come to hold; block one whose do not."""
    if monitors_hold(run, task):
        if task.blocked:
            task.blocked = False
            run.tell(events.TaskWoken, task=task.number, on=task.blocked_on)
    elif not task.blocked:
        block(run, task)


def look_at_things(run: Run, task: Task) -> None:
    """Wake a task when nothing is in the way; hold it up again when something is."""
    blocking = [obstacles(run, task, wanted) for wanted in task.wanted]
    if task.held_up and not all(blocking):
        task.held_up = False
        on, holder = task.held_up_by
        run.tell(events.TaskWoken, task=task.number, on=on, holder=holder)
    elif not task.held_up and all(blocking):
        hold_up(run, task, blocking[0][0])


def hold_up(run: Run, task: Task, obstacle: Obstacle) -> None:
    """A task waits until nothing is in the way of what it wants."""
    task.held_up = True
    task.held_up_by = (obstacle.words, obstacle.holder.number)
    on, holder = task.held_up_by
    run.tell(events.TaskBlocked, task=task.number, on=on, holder=holder)
    circle = tuple(each.number for each in circle_through(run, task))
    if circle:
        run.tell(events.Deadlock, tasks=circle, waiting=())


def next_time(run: Run) -> Time | None:
    """The next time at which a start comes or a belief goes stale."""
    found: list[Time] = []
    for task in run.live():
        if task.running is not None or not order_allows(task):
            continue
        if task.place is not None and not task.place.goes:
            continue
        last = max(starts(task), default=run.time)
        found += [last] if last > run.time else []
        if task.blocked:
            if task.delay is not None and not delay_over(run, task):
                found.append(task.delay[0])
            found += [timer for timer in task.timers if timer > run.time]
    return min(found, default=None)


# --- beginning to listen ----------------------------------------------------------


def listen(run: Run, place: Place) -> None:
    """A step whose order allows it begins to listen for what it waits for."""
    task = place.task
    if task is None or place.listens or not task.live or not order_allows(task):
        return
    waits = [n for n in place.step.annotations if isinstance(n, nodes.WaitFor)]
    if not waits:
        return
    place.listens = True
    read_windows(run, task)
    proceed = [wait for wait in waits if wait.mode == "proceed"]
    if proceed:
        place.goes = False
        on = format_signal(proceed[0], task)
        run.tell(events.TaskBlocked, task=task.number, on=on)


def let_go(run: Run, place: Place) -> None:
    """A step whose order allows it listens, and reads its inputs if it may run."""
    if place.task is not None and place.task.live:
        listen(run, place)
        may_run(run, place.task)


def format_signal(wait: nodes.WaitFor, task: Task) -> str:
    """A signal as the trace prints it, with what is bound put in."""
    assert task.parent is not None
    pattern = nodes.Signal(wait.signal, wait.args)
    return format_formula(pattern, task.parent.env)
