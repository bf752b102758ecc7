"""Faults in the order of steps, and `until`, which does not order steps [L 4.4].

Order comes from `for` annotations and from windows that name a step (the fact
`TASK_NETS`). An `until` has an effect only while both steps may be active.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import endless, may_end
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.names import renaming
from rapc.analysis.facts.task_nets import TASK_NETS, Net, StepOrder, sure_nets, tag_of
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Suggestions
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import word_span

UNKNOWN_TAG = Rule(
    code="RAP026",
    name="unknown-tag",
    severity=Severity.ERROR,
    summary="an annotation names an unknown step of its task-net",
    fix="unsafe: writes the similar name, if there is one",
    source="T 4.5.2",
)

DUPLICATE_TAG = Rule(
    code="RAP027",
    name="duplicate-tag",
    severity=Severity.ERROR,
    summary="duplicate tag in a task-net",
    source="T 4.5.2",
)

CYCLIC_TASK_NET = Rule(
    code="RAP025",
    name="cyclic-task-net",
    severity=Severity.ERROR,
    summary="the order of the steps of a task-net is cyclic",
    source="T 4.5.2",
)

_SHOWN = 8
"""The maximum number of steps of a cycle to show."""


@check(UNKNOWN_TAG, DUPLICATE_TAG, CYCLIC_TASK_NET, needs_whole="method")
def task_nets(run: Pass) -> Iterator[Diagnostic]:
    """Find unknown and duplicate tags, and steps that wait for each other."""
    nets = run.result(TASK_NETS)
    for form in run.library.forms:
        for method in form.methods if isinstance(form, nodes.DefineRap) else ():
            if isinstance(method.body, nodes.TaskNet):
                net = nets[id(method.body)]
                yield from _duplicates(run, method.body, net.tags)
                if not net.has_doubles:
                    yield from _unknown_tags(run, net)
                    if net.circle:
                        yield _cycle(method.body, net)


def _duplicates(
    run: Pass, net: nodes.TaskNet, tags: Mapping[str, int]
) -> Iterator[Diagnostic]:
    for at, step in enumerate(net.steps):
        first = tags[step.tag]
        if first != at:
            yield DUPLICATE_TAG.at(
                _tag_span(run, step),
                f"duplicate tag `{step.tag}`",
                labels=(Label(_tag_span(run, net.steps[first]), "the first step"),),
                help="give each step a unique tag",
            )


def _tag_span(run: Pass, step: nodes.Step) -> Span:
    return word_span(run.library.files, step.span, 0)


def _place(run: Pass, annotation: nodes.Annotation, tag: str) -> Span:
    """Return the span of a tag in an annotation: after the keyword, or at the end."""
    span = annotation.span
    if type(annotation) is not nodes.For or annotation.formula is None:
        return word_span(run.library.files, span, 1)
    source = run.library.files.get(span.file)
    if source is None:
        return span
    end = span.start + len(source.text[span.start : span.end].rstrip(") \t\n"))
    named = source.text[end - len(tag) : end].lower() == tag
    return source.span(end - len(tag), end) if named else span


def _unknown_tags(run: Pass, net: Net) -> Iterator[Diagnostic]:
    unknown: dict[str, list[Span]] = {}
    for annotation in net.unknown:
        tag = tag_of(annotation) or ""
        unknown.setdefault(tag, []).append(_place(run, annotation, tag))
    if not unknown:
        return
    names = Suggestions(net.tags)
    for tag, places in unknown.items():
        yield UNKNOWN_TAG.at(
            places[0],
            f"unknown step `{tag}` in this task-net",
            labels=tuple([Label(other, "named here, too") for other in places[1:]]),
            help=names.did_you_mean(tag),
            fix=renaming(run.library.files, tag, names.near(tag), places),
        )


def _cycle(net: nodes.TaskNet, found: Net) -> Diagnostic:
    links = sorted(_links(found), key=lambda edge: edge.annotation.span.start)
    tags = [f"`{net.steps[edge.before].tag}`" for edge in links]
    if len(tags) == 1:
        message = f"step {tags[0]} waits for itself"
    elif len(tags) <= _SHOWN:
        message = f"steps {', '.join(tags[:-1])} and {tags[-1]} wait for each other"
    else:
        message = f"{len(tags)} steps wait for each other, {tags[0]} among them"
    return CYCLIC_TASK_NET.at(
        links[-1].annotation.span,
        message,
        label=_says(net, links[-1]),
        labels=tuple(
            Label(e.annotation.span, _says(net, e)) for e in links[:-1][:_SHOWN]
        ),
        help="remove one of these annotations",
    )


def _links(net: Net) -> Iterator[StepOrder]:
    for before, after in pairwise(net.circle):
        yield next(edge for edge in net.edges[after] if edge.before == before)


def _says(net: nodes.TaskNet, edge: StepOrder) -> str:
    return (
        f"this orders `{net.steps[edge.before].tag}` before "
        f"`{net.steps[edge.after].tag}`"
    )


UNTIL_ITSELF = Rule(
    code="RAP074",
    name="until-itself",
    severity=Severity.WARNING,
    summary="a step must run until its own end or start",
    ignore="never: the annotation does nothing",
    source="T 4.5.2",
)

END_EACH_OTHER = Rule(
    code="RAP125",
    name="end-each-other",
    severity=Severity.WARNING,
    summary="two concurrent steps end each other when they start",
    ignore="where only one of the two steps must finish, no matter which",
    source="T 4.5.2",
)

IDLE_UNTIL = Rule(
    code="RAP127",
    name="idle-until",
    severity=Severity.WARNING,
    summary="`until` names a step that never runs at the same time",
    ignore="never: the annotation ends no running step",
    source="T 4.5.2",
)

ENDED_BY_START = Rule(
    code="RAP128",
    name="ended-by-start",
    severity=Severity.WARNING,
    summary="a step is ended by the start of another step that can start at once",
    ignore="where the other step waits for something that the library does not declare",
    source="T 4.5.2",
)

UNTIL_NEVER = Rule(
    code="RAP148",
    name="until-never",
    severity=Severity.WARNING,
    summary="a step must run until another step ends or starts, which never happens",
    ignore="where the step must run until its method ends",
    source="T 4.5.2, 4.7.1",
)

_Until = nodes.UntilStart | nodes.UntilEnd


class _Mark(msgspec.Struct, frozen=True):
    """An `until` of a step, with the positions of both steps."""

    note: _Until
    #: The step to end.
    at: int
    #: The step that ends the first step.
    by: int


@check(
    UNTIL_ITSELF,
    END_EACH_OTHER,
    IDLE_UNTIL,
    ENDED_BY_START,
    UNTIL_NEVER,
    needs_whole="method",
)
def until(run: Pass) -> Iterator[Diagnostic]:
    """Find `until` annotations that never end a step."""
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
    """Yield at most one fault for each `until` of a task-net."""
    starts = {(m.at, m.by): m for m in marks if isinstance(m.note, nodes.UntilStart)}
    for mark in marks:
        one, by = every[mark.at], every[mark.by]
        if mark.at == mark.by:
            continue
        if net.is_before(mark.at, mark.by):
            why = f"`{by.tag}` begins only after the end of `{one.tag}`"
            yield _idle(mark, by, why)
        elif net.is_before(mark.by, mark.at):
            why = f"`{by.tag}` ends before `{one.tag}` can begin"
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
                    does = "end" if type(note) is nodes.UntilEnd else "start"
                    yield UNTIL_ITSELF.at(
                        note.span,
                        f"step `{step.tag}` must run until its own {does}",
                        help="name another step, or remove the annotation",
                    )


def _each_other(
    run: Pass, every: Sequence[nodes.Step], net: Net, mark: _Mark, back: _Mark
) -> Iterator[Diagnostic]:
    one, other = every[mark.at], every[mark.by]
    if any(net.edges[at] for at in (mark.at, mark.by)):
        return
    if not may_wait(run, one) and not may_wait(run, other):
        yield END_EACH_OTHER.at(
            mark.note.span,
            f"steps `{other.tag}` and `{one.tag}` end each other when they "
            "start, so only one of them finishes",
            labels=(Label(back.note.span, "the opposite annotation"),),
            help="remove one of the two annotations, or write `until-end`",
        )


def may_wait(run: Pass, step: nodes.Step) -> bool:
    """Return whether a step may wait for more than other steps; True if unknown."""
    rap = run.library.raps.get(step.goal.name)
    if rap is None or rap.monitor_state is not None or rap.monitor_time is not None:
        return True
    return any(
        isinstance(note, nodes.WaitFor | nodes.Window) for note in step.annotations
    )


def _idle(mark: _Mark, by: nodes.Step, why: str) -> Diagnostic:
    return IDLE_UNTIL.at(
        mark.note.span,
        f"this annotation never ends a running step: {why}",
        labels=(Label(by.span, "the other step"),),
        help="remove this annotation, or the annotation that orders the two steps",
    )


def _begins_together(
    run: Pass, step: nodes.Step, other: nodes.Step, mark: _Mark, net: Net
) -> Iterator[Diagnostic]:
    late = other.priority < step.priority
    if net.edges[mark.by] or may_wait(run, other) or late:
        return
    yield ENDED_BY_START.at(
        mark.note.span,
        f"`{other.tag}` can start at once, and then ends `{step.tag}`",
        labels=(Label(other.span, "nothing delays this step"),),
        help=f"write `(until-end {other.tag})`, or let step `{other.tag}` wait",
    )


def _never_comes(
    every: Sequence[nodes.Step],
    net: Net,
    mark: _Mark,
    never_done: Mapping[str, Span],
) -> Span | None:
    """Return the reason why the other step never ends or never begins, or None."""
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
    return UNTIL_NEVER.at(
        mark.note.span,
        f"`{by.tag}` never {does}, so this step runs without end",
        labels=(Label(cause, "this formula never holds"),),
        help="name a step that ends, or exchange the steps of the `until`",
    )
