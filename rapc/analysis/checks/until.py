"""RAP074, RAP125, RAP127, RAP128, RAP148: `until` that ends nothing, or all at once.

`until` orders nothing [L 4.4]. What it means it means while both steps may be at work.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import endless, may_end
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.task_nets import Net, sure_nets
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import steps

_WORK = """\
(define-rap (watch))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    {}
    {})))
"""

ITSELF = Rule(
    code="RAP074",
    name="until-itself",
    severity=Severity.WARNING,
    summary="a step is to go on until it ends or starts itself",
    why="""`until-end` and `until-start` end a step for what another step does. With
its own tag such an annotation never does anything; another step is meant, or none.""",
    ignore="never: the annotation does nothing",
    source="T 4.5.2",
    example=_WORK.format("(t1 (watch) (until-end t1))", "(t2 (carry))"),
    better=_WORK.format("(t1 (watch) (until-end t2))", "(t2 (carry))"),
)

BOTH = Rule(
    code="RAP125",
    name="end-each-other",
    severity=Severity.WARNING,
    summary="two steps that can begin at once end each other by starting",
    why="""`until-start` takes a step away when the other one starts. Where each of two
steps does so to the other and neither waits for anything, the first to be chosen ends
the other before that has begun: one of the two is never carried out, and priority or
chance decides which. Steps that wait for something by monitors, signals or windows may
be alternatives of that form.""",
    ignore="where one of the two is to be dropped, whichever it is",
    source="T 4.5.2",
    example=_WORK.format(
        "(t1 (watch) (until-start t2))", "(t2 (carry) (until-start t1))"
    ),
    better=_WORK.format("(t1 (watch) (until-end t2))", "(t2 (carry))"),
)

IDLE = Rule(
    code="RAP127",
    name="idle-until",
    severity=Severity.WARNING,
    summary="a step is to be ended by one that is never under way at the same time",
    why="""`until-start` and `until-end` end a step that is at work beside another (T
4.5.2). Where `for` or a window puts one of the two before the other, the first has
ended when the second begins: the annotation does nothing, or takes away a step that has
not begun. Leave out the order, or the `until`.""",
    ignore="never: the annotation ends nothing that is under way",
    source="T 4.5.2",
    example=_WORK.format("(t1 (watch) (for t2) (until-end t2))", "(t2 (carry))"),
    better=_WORK.format("(t1 (watch) (until-end t2))", "(t2 (carry))"),
)

AT_ONCE = Rule(
    code="RAP128",
    name="ended-by-start",
    severity=Severity.WARNING,
    summary="a step is taken away when another one starts, which can start at once",
    why="""`until-start` takes a step away when the other one is first selected [L
4.28]. Where that waits for nothing, no other step, window, signal or monitor, and is no
less urgent, it may be selected first: the step is never carried out. Mostly `until-end`
was meant; else say what the other one waits for.""",
    ignore="where the other step waits for something that the library does not tell",
    source="T 4.5.2",
    example=_WORK.format("(t1 (watch) (until-start t2))", "(t2 (carry))"),
    better=_WORK.format("(t1 (watch) (until-end t2))", "(t2 (carry))"),
)

NEVER = Rule(
    code="RAP148",
    name="until-never",
    severity=Severity.WARNING,
    summary="a step is to go on until another one ends or starts, which never does",
    why="""`until-end` and `until-start` end a step when another one has ended or begins
(T 4.5.2). A step for a RAP that stands by for good, with `(succeed nil)`, never ends,
unless something takes it away; what `for` puts behind such a step never begins. The
step that waits for this goes on for good, and so does its method.""",
    ignore="where the step is to go on until its whole method is ended from above",
    source="T 4.5.2, 4.7.1",
    example="""\
(declare-memory-proposition smoke ())
(declare-primitive ring () (okay))
(declare-primitive drive () (okay))
(define-rap (watch)
  (succeed nil)
  (monitor-state (smoke))
  (method (primitive (ring))))
(define-rap (carry) (method (primitive (drive))))
(define-rap (deliver)
  (method (task-net
    (t1 (carry) (until-end t2))
    (t2 (watch)))))
""",
    better="""\
(declare-memory-proposition smoke ())
(declare-primitive ring () (okay))
(declare-primitive drive () (okay))
(define-rap (watch)
  (succeed nil)
  (monitor-state (smoke))
  (method (primitive (ring))))
(define-rap (carry) (method (primitive (drive))))
(define-rap (deliver)
  (method (task-net
    (t1 (carry))
    (t2 (watch) (until-end t1)))))
""",
)

_Until = nodes.UntilStart | nodes.UntilEnd


class _Mark(msgspec.Struct, frozen=True):
    """An `until` of a step, with the positions of both steps."""

    note: _Until
    #: The step that is to be ended.
    at: int
    #: The step that ends it.
    by: int


@check(ITSELF, BOTH, IDLE, AT_ONCE, NEVER, needs_whole="method")
def until(run: Pass) -> Iterator[Diagnostic]:
    """Find steps that are to go on until something that never ends one of them."""
    index = run.result(INDEX)
    if not index.of(nodes.UntilStart) and not index.of(nodes.UntilEnd):
        return
    never_done = endless(run.library.raps)
    for _, method, net in sure_nets(run):
        every = steps(method)
        places = {step.tag: at for at, step in enumerate(every)}
        marks = [
            _Mark(note, at, places[note.tag])
            for at, step in enumerate(every)
            for note in step.annotations
            if isinstance(note, _Until)
        ]
        yield from _of_net(run, every, net, marks, never_done) if marks else ()
    for rap in run.library.forms:
        if type(rap) is nodes.DefineRap:
            yield from _by_themselves(rap)


def _of_net(
    run: Pass,
    every: Sequence[nodes.Step],
    net: Net,
    marks: Sequence[_Mark],
    never_done: Mapping[str, Span],
) -> Iterator[Diagnostic]:
    """Yield what is wrong with the `until` of one task-net, one finding for each."""
    starts = {(m.at, m.by): m for m in marks if isinstance(m.note, nodes.UntilStart)}
    for mark in marks:
        one, by = every[mark.at], every[mark.by]
        if mark.at == mark.by:
            continue
        if net.is_before(mark.at, mark.by):
            why = f"`{by.tag}` begins only when `{one.tag}` has ended"
            yield _idle(mark, by, why)
        elif net.is_before(mark.by, mark.at):
            why = f"`{by.tag}` has ended when `{one.tag}` could begin"
            yield _idle(mark, by, why)
        elif (cause := _never_comes(every, net, mark, never_done)) is not None:
            yield _never(mark, by, cause)
        elif isinstance(mark.note, nodes.UntilStart):
            back = starts.get((mark.by, mark.at))
            if back is None:
                yield from _begins_together(run, one, by, mark, net)
            elif mark.note.span.start > back.note.span.start:
                yield from _each_other(run, every, net, mark, back)


def _by_themselves(rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    for method in rap.methods:
        often = Counter(step.tag for step in steps(method))
        for step in steps(method):
            for note in step.annotations if often[step.tag] == 1 else ():
                if isinstance(note, _Until) and note.tag == step.tag:
                    does = "ends" if type(note) is nodes.UntilEnd else "starts"
                    yield ITSELF.at(
                        note.span,
                        f"step `{step.tag}` is to go on until it {does} itself",
                        help="name another step, or take the annotation away",
                    )


def _each_other(
    run: Pass, every: Sequence[nodes.Step], net: Net, mark: _Mark, back: _Mark
) -> Iterator[Diagnostic]:
    one, other = every[mark.at], every[mark.by]
    if any(net.edges[at] for at in (mark.at, mark.by)):
        return
    if not may_wait(run, one) and not may_wait(run, other):
        yield BOTH.at(
            mark.note.span,
            f"steps `{other.tag}` and `{one.tag}` end each other by starting, "
            "so only one of them is ever carried out",
            labels=(Label(back.note.span, "and the other way round here"),),
            help="leave one of the two out, or write `until-end`",
        )


def may_wait(run: Pass, step: nodes.Step) -> bool:
    """Whether a step may wait for more than the end of other steps, or nobody knows."""
    rap = run.library.raps.get(step.goal.name)
    if rap is None or rap.monitor_state is not None or rap.monitor_time is not None:
        return True
    return any(
        isinstance(note, nodes.WaitFor | nodes.Window) for note in step.annotations
    )


def _idle(mark: _Mark, by: nodes.Step, why: str) -> Diagnostic:
    return IDLE.at(
        mark.note.span,
        f"this never ends a step at work: {why}",
        labels=(Label(by.span, "the other step"),),
        help="leave this out, or what puts the two steps in order",
    )


def _begins_together(
    run: Pass, step: nodes.Step, other: nodes.Step, mark: _Mark, net: Net
) -> Iterator[Diagnostic]:
    late = other.priority < step.priority
    if net.edges[mark.by] or may_wait(run, other) or late:
        return
    yield AT_ONCE.at(
        mark.note.span,
        f"`{other.tag}` can start at once, and takes `{step.tag}` away then",
        labels=(Label(other.span, "nothing keeps this one back"),),
        help=f"write `(until-end {other.tag})`, or let that step wait",
    )


def _never_comes(
    every: Sequence[nodes.Step],
    net: Net,
    mark: _Mark,
    never_done: Mapping[str, Span],
) -> Span | None:
    """Return what says that the other step never ends, or never begins, if it does."""
    before = [at for at in range(len(every)) if net.is_before(at, mark.by)]
    if isinstance(mark.note, nodes.UntilEnd):
        before.append(mark.by)
    for at in before:
        cause = never_done.get(every[at].goal.name)
        if cause is not None and not any(map(may_end, every[at].annotations)):
            return cause
    return None


def _never(mark: _Mark, by: nodes.Step, cause: Span) -> Diagnostic:
    does = "ends" if isinstance(mark.note, nodes.UntilEnd) else "starts"
    return NEVER.at(
        mark.note.span,
        f"`{by.tag}` never {does}, so this step goes on for good",
        labels=(Label(cause, "this never succeeds"),),
        help="name a step that is done some time, or turn the `until` round",
    )
