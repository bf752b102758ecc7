"""RAP134, RAP135, RAP138, RAP139: standing tasks given wrongly, idle, or unready."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.settled import Always
from rapc.analysis.facts.effects import below_agendas, endless
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.analysis.facts.logic import (
    asked_by,
    asked_through,
    fact_name,
    is_computed,
    is_never,
    literals,
)
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.walk import variable_names
from rapc.library.library import Library

_GARDEN = """\
(declare-memory-property soil (?plant ?state) unknown)
(declare-primitive pour (?plant) (okay) :on (okay (soil ?plant wet)))
(define-rap (water ?plant) (method (primitive (pour ?plant))))
(define-rap (keep-wet)
  (succeed nil)
  (monitor-state (soil ?plant dry))
  (repeat-while (soil ?plant dry))
  (method (task-net (t1 (water ?plant)))))
(define-agenda day (task (keep-wet){}) (task (water rose)))
"""

ENDLESS = Rule(
    code="RAP134",
    name="endless-task",
    severity=Severity.WARNING,
    summary="an agenda gives a task as work that is never done",
    why="""A run ends when all tasks have ended but those of the background. A task that
is never done, for its RAP has `(succeed nil)` or a step that has, keeps the run going
for good: nothing tells any more whether the work was done. Give it
`:background true`, beside a task that is done one day: a run for which tasks in the
background alone are given is over at once. Where the run is ended by a time, as in a
test or with `--until`, ignore the rule there.""",
    fix="unsafe: writes `:background true`",
    ignore="where the run is ended by a time, or from outside",
    source="T 5.4",
    example=_GARDEN.format(" :priority 4"),
    better=_GARDEN.format(" :priority 4 :background true"),
)

_CALL = """\
(declare-memory-property battery (?level) unknown)
(declare-memory-proposition called ())
(declare-primitive plug-in () (okay) :on (okay (battery 100)))
(declare-primitive look () (okay) :tells (gauge) :on (okay))
(declare-sensor-datum gauge (?level) :on ((battery ?level)))
(define-rap (watch-gauge) (succeed nil) (monitor-time now 5 9)
  (method (primitive (look))))
"""

UNHEARD = Rule(
    code="RAP135",
    name="unheard-monitor",
    severity=Severity.WARNING,
    summary="a monitor asks for what nothing in the library ever changes",
    why="""A monitor is passive: it notices what comes into memory while others act, and
senses nothing itself (T 4.7.1). Where no primitive, datum, rule or notation changes any
of the facts that it asks for, or only primitives that no RAP asks for, it never wakes,
or it always holds: another fact was meant, a RAP that looks is missing, or what a datum
does to memory is not declared. Told
where the library says of its primitives what they do; what comes from the host's own
program is not seen.""",
    ignore="where a host program asserts the fact",
    source="T 4.7.2",
    example=_CALL
    + """\
(define-rap (answer)
  (succeed nil)
  (monitor-state (called))
  (method (primitive (plug-in))))
""",
    better=_CALL
    + """\
(define-rap (answer)
  (succeed nil)
  (monitor-state (and (battery ?level) (< ?level 20)))
  (method (primitive (plug-in))))
""",
)

_UNREADY = """\
(declare-memory-property battery (?level) unknown)
(declare-memory-proposition at-dock ())
(declare-primitive plug-in () (okay) :on (okay (battery 100)))
(declare-primitive drive () (okay) :on (okay (at-dock)))
(define-rap (recharge)
  (succeed nil)
  (monitor-state (and (battery ?level) (< ?level 20)))
  (method (context (at-dock)) (primitive (plug-in))){})
"""

UNREADY = Rule(
    code="RAP138",
    name="unready-reaction",
    severity=Severity.WARNING,
    summary="a standing task has no method for some of the states that wake it",
    why="""A task that wakes and has no method that fits fails with `no-method`, and a
standing task that has failed is gone for good. Here every method asks for a fact that
the monitor does not ask for, and that does change: give a method with `otherwise`, or
let the monitor ask for the fact as well.""",
    ignore="where the fact holds whenever the monitor does, as the world is made",
    source="T 4.7.1",
    example=_UNREADY.format(""),
    better=_UNREADY.format("\n  (method (context otherwise) (primitive (drive)))"),
)

_CONDITION = """\
(declare-memory-property battery (?level) unknown)
(declare-memory-proposition at-dock ())
(declare-primitive plug-in () (okay) :on (okay (battery 100)))
(declare-primitive drive () (okay) :on (okay (at-dock)))
(define-rap (dock) (method (primitive (drive))))
(define-rap (recharge)
  (succeed nil)
  (monitor-state (and (battery ?level) (< ?level 20){}))
  {}(method (primitive (plug-in))))
"""

FAILING = Rule(
    code="RAP139",
    name="failing-reaction",
    severity=Severity.WARNING,
    summary="a standing task fails for good where a condition of its RAP does not hold",
    why="""A condition is asked when the monitor has woken the task, and one that does
not hold is no reason to sleep on: the task fails, `interference` or, for
`repeat-while`, `no-method`, and a standing task that has failed is gone for good (T
4.4.2). Here the condition asks for a fact that changes, and that the monitor does not
ask for. Ask for it in the monitor, or in the contexts, with a method for the case that
it does not hold.""",
    ignore="where the task is to end for good then",
    source="T 4.4.2, 4.7.1",
    example=_CONDITION.format("", "(preconditions (at-dock))\n  "),
    better=_CONDITION.format(" (at-dock)", ""),
)


@check(ENDLESS, UNHEARD, UNREADY, FAILING)
def standing(run: Pass) -> Iterator[Diagnostic]:
    """Find tasks that never end where they should, and monitors of what never is."""
    library = run.library
    never_done = endless(below_agendas(library))
    for agenda in library.agendas.values():
        for task in agenda.tasks:
            cause = never_done.get(task.goal.name)
            if cause is not None and not task.background and task.deadline is None:
                work = any(
                    other.goal.name not in never_done and not other.background
                    for other in agenda.tasks
                )
                yield _endless(task, cause, work)
    if run.complete and is_described(library):
        changed = _Changed(library, run.result(INDEX))
        idle = _never_asked_for(library, run.result(INDEX))
        always = Always(run.signatures)
        for rap in library.raps.values():
            if rap.monitor_state is not None and rap.monitor_time is None:
                yield from _unheard(library, rap.monitor_state, changed, idle)
            yield from _unready(library, rap, changed, always)
            yield from _failing(library, rap, changed, always)


def _endless(task: nodes.GivenTask, cause: Span, work: bool) -> Diagnostic:
    """Return the finding about a task; `work` if its agenda gives others as work.

    A run is over at once for which tasks in the background alone are given: without
    other work nothing is mended by that.
    """
    end = task.span.end - 1
    help_ = "write `:background true`"
    if not work:
        help_ += ", and give a task that is done: a run lasts as long as that"
    edit = Edit(Span(task.span.file, end, end), " :background true")
    return ENDLESS.at(
        task.goal.span,
        f"`{task.goal.name}` is never done, so a run with this task never ends",
        labels=(Label(cause, "this never succeeds"),),
        help=help_,
        fix=Fix(Applicability.UNSAFE, "let it stand by", (edit,)),
    )


# --- what nothing changes -------------------------------------------------------------


def is_described(library: Library) -> bool:
    """Whether most of a library's primitives, or its rules, say what they do."""
    forms = library.primitives.values()
    told = sum(bool(form.on or form.tells) for form in forms)
    if not told and not library.memory_rules and not library.event_rules:
        return False
    silent = any(datum.on is None for datum in library.data.values())
    return not silent and told * _OF >= len(forms) * _MOST


_MOST, _OF = 3, 4
"""So many of so many primitives have to say what they do."""


class _Changed:
    """The names of all facts that anything in the library brings or takes away."""

    def __init__(self, library: Library, index: Index) -> None:
        self._names = {*library.functions, *(name for name, _ in _told(index))}

    def __contains__(self, name: str) -> bool:
        return name in self._names


def _told(index: Index) -> Iterator[tuple[str, Form]]:
    """Yield the facts that forms bring or take away."""
    for one in index.uses():
        if one.use in ("asserted", "erased"):
            yield one.name, one.owner


def _unready(
    library: Library, rap: nodes.DefineRap, changed: _Changed, always: Always
) -> Iterator[Diagnostic]:
    """Yield a fact that all methods ask for, though the monitor does not."""
    if rap.monitor_state is None or rap.succeed is None or not is_never(rap.succeed):
        return
    waking = [rap.monitor_state, rap.repeat_while]
    asked = {n for one in waking if one is not None for n in asked_by(library, one)}
    every = [list(literals(method.context)) for method in rap.methods]
    given = {variable.name for variable in rap.inputs}
    if rap.repeat_while is not None:
        given.update(variable_names(rap.repeat_while))
    for one in every[0] if every else ():
        if not all(one in there for there in every):
            continue
        if one.holds and always.holds(one.formula, given):
            continue
        name = fact_name(one)
        if name in changed and name not in asked and not is_computed(library, name):
            yield UNREADY.at(
                one.span,
                f"`{rap.name}` has no method where this does not hold, and "
                "fails for good",
                labels=(Label(rap.monitor_state.span, "it wakes by this alone"),),
                help="add a method with `otherwise`, or ask for this in the monitor",
            )
            return


def _failing(
    library: Library, rap: nodes.DefineRap, changed: _Changed, always: Always
) -> Iterator[Diagnostic]:
    """Yield a condition of a standing task that its monitor does not ask for."""
    monitor = rap.monitor_state
    if monitor is None or rap.succeed is None or not is_never(rap.succeed):
        return
    heard = asked_by(library, monitor)
    given = {variable.name for variable in rap.inputs}
    conditions = [f for c, f in clauses.held(clauses.RAP, rap) if c.is_condition]
    for one in (one for formula in conditions for one in literals(formula)):
        asked = asked_through(library, one.formula)
        facts = set() if asked is None else asked - library.queries.keys()
        if not any(name in changed for name in facts) or facts & heard:
            continue
        if one.holds and always.holds(one.formula, given):
            continue
        yield FAILING.at(
            one.span,
            f"`{rap.name}` fails for good if it wakes where this does not hold",
            labels=(Label(monitor.span, "it wakes by this alone"),),
            help="ask for this in the monitor, or in the contexts of its methods",
        )
        return


def _never_asked_for(library: Library, index: Index) -> Mapping[str, str]:
    """Return what only primitives do that no RAP asks for: by fact, the primitive."""
    primitives = library.primitives
    raps = (form for form in library.forms if isinstance(form, nodes.DefineRap))
    bodies = (method.body for rap in raps for method in rap.methods)
    requested = {b.request.name for b in bodies if isinstance(b, nodes.Primitive)}
    wanted = requested & primitives.keys()
    idle = [form for name, form in primitives.items() if name not in wanted]
    found: dict[str, str] = {}
    for form in idle:
        data = [library.data[name] for name in form.tells if name in library.data]
        effects = [*(on.effects for on in form.on), *(one.on or () for one in data)]
        for effect in (one for there in effects for one in there):
            found.setdefault(effect.pattern.name, form.name)
    told = {name for one in wanted for name in primitives[one].tells}
    own = {id(form) for form in idle} | {
        id(library.data[name])
        for form in idle
        for name in form.tells
        if name in library.data and name not in told
    }
    for name, owner in _told(index) if found else ():
        if id(owner) not in own:
            found.pop(name, None)
    return found


def _unheard(
    library: Library,
    monitor: nodes.Formula,
    changed: _Changed,
    idle: Mapping[str, str],
) -> Iterator[Diagnostic]:
    asked = asked_through(library, monitor)
    if asked is None:
        return
    facts = sorted(asked - library.queries.keys())
    known = library.properties.keys() | library.propositions.keys()
    if not facts or not known.issuperset(facts):
        return
    names = ", ".join(f"`{name}`" for name in facts)
    if not any(name in changed for name in facts):
        yield UNHEARD.at(
            monitor.span,
            f"nothing in the library ever changes {names}",
            help="ask for what a primitive, a datum or a rule changes, or declare that",
        )
    elif all(name in idle for name in facts if name in changed):
        first = next(name for name in facts if name in idle)
        yield UNHEARD.at(
            monitor.span,
            f"no RAP ever asks for what changes {names}",
            help=f"`{idle[first]}` does: let a RAP ask for it, now and then",
        )
