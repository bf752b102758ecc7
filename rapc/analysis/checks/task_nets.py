"""The order of every task-net: tags, what comes before what, cycles.

Order comes from `for` annotations and from windows that name a step; `until` delays
nothing [L 4.1, 4.2]. Which variables that order binds is for `bindings` to say.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

import msgspec

from rapc.analysis.check import Fact, Pass, check
from rapc.analysis.facts.names import renaming
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Suggestions
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import word_span

_IN_ORDER = """\
(define-rap (lift))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (lift) (for t2))
    (t2 (carry)))))
"""

UNKNOWN_TAG = Rule(
    code="RAP026",
    name="unknown-tag",
    severity=Severity.ERROR,
    summary="an annotation names a step that its task-net does not have",
    why="""`for`, `until-start`, `until-end` and `window` speak of a step of the same
task-net by its tag. One that no step carries orders nothing and protects nothing, and
a formula meant for it is never checked.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="T 4.5.2",
    example="""\
(define-rap (lift))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (lift) (for t3))
    (t2 (carry)))))
""",
    better=_IN_ORDER,
)

DUPLICATE_TAG = Rule(
    code="RAP027",
    name="duplicate-tag",
    severity=Severity.ERROR,
    summary="two steps of a task-net have one tag",
    why="""A tag names one step: an annotation that speaks of a tag carried twice
would mean either of them.""",
    source="T 4.5.2",
    example="""\
(define-rap (lift))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (lift))
    (t1 (carry)))))
""",
    better=_IN_ORDER,
)

CYCLE = Rule(
    code="RAP025",
    name="cyclic-task-net",
    severity=Severity.ERROR,
    summary="steps of a task-net wait for each other in a circle",
    why="""`for` and a window that names a step put steps in order. In a circle no step
may begin before another of them has ended, so none ever begins, and the method never
ends.""",
    source="T 4.5.2",
    example="""\
(define-rap (lift))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (lift) (for t2))
    (t2 (carry) (for t1)))))
""",
    better=_IN_ORDER,
)

CLOCKS = ("now", "absolute")
"""What a window may refer to besides a step."""

_MOST = 8
"""How many steps of a circle are shown."""


class StepOrder(msgspec.Struct, frozen=True):
    """One step before another, by positions in the text, and what says so."""

    before: int
    after: int
    annotation: nodes.For | nodes.Window


class Net(msgspec.Struct, frozen=True):
    """A task-net's order, by positions in the text.

    `order` lists the steps so that each follows what it waits for; it is None if they
    wait in a circle. `edges` holds, for each step, what puts others before it, in the
    order of the text. `early` are the steps that another one or a signal may end
    before they have done their work; `by_until` are those of them that another step
    may end, even before the steps that they follow have ended [L 4.33].
    """

    order: tuple[int, ...] | None
    edges: tuple[tuple[StepOrder, ...], ...]
    early: frozenset[int]
    by_until: frozenset[int]
    #: Whether a tag names no step, or two: what is said of the order is not sure.
    broken: bool = False
    faults: tuple[Diagnostic, ...] = ()

    def is_before(self, one: int, other: int) -> bool:
        """Whether a step is ordered before another, directly or not."""
        return _is_before(self.edges, one, other, frozenset())

    def has_ended(self, one: int, other: int) -> bool:
        """Whether a step has surely ended when another begins.

        A step between them that `until` ends early says nothing of those before it.
        """
        return _is_before(self.edges, one, other, self.by_until)

    def reach(self) -> tuple[list[int], list[int]]:
        """Return for each step those before it and those after it, as sets of bits.

        All of these are empty where steps wait for each other in a circle.
        """
        before = [0] * len(self.edges)
        after = [0] * len(self.edges)
        order = self.order or ()
        for at in order:
            for edge in self.edges[at]:
                before[at] |= before[edge.before] | 1 << edge.before
        for at in reversed(order):
            for edge in self.edges[at]:
                after[edge.before] |= after[at] | 1 << at
        return before, after


Edges = Sequence[Sequence[StepOrder]]


def _is_before(edges: Edges, one: int, other: int, avoid: Container[int]) -> bool:
    """Whether a path of order leads from one step to another, not through some."""
    seen: set[int] = set()
    waiting = [other]
    while waiting:
        for edge in edges[waiting.pop()]:
            if edge.before == one:
                return True
            if edge.before not in seen and edge.before not in avoid:
                seen.add(edge.before)
                waiting.append(edge.before)
    return False


Nets = Mapping[int, Net]
"""The net of each task-net node, by the node's `id`."""


def _run(run: Pass) -> Nets:
    nets = {}
    for rap in run.library.forms:
        if type(rap) is nodes.DefineRap:
            for method in rap.methods:
                if type(method.body) is nodes.TaskNet:
                    nets[id(method.body)] = _net(run, method.body)
    return nets


TASK_NETS = Fact(_run)


@check(UNKNOWN_TAG, DUPLICATE_TAG, CYCLE, needs_whole="method")
def task_nets(run: Pass) -> Iterator[Diagnostic]:
    """Find unknown and duplicate tags, and steps that wait for each other."""
    for net in run.result(TASK_NETS).values():
        yield from net.faults


def sure_net(run: Pass, method: nodes.Method) -> Net | None:
    """Return the order of the steps of a method, if it has one that is sure."""
    net = run.result(TASK_NETS).get(id(method.body))
    return None if net is None or net.broken or net.order is None else net


def sure_nets(run: Pass) -> Iterator[tuple[nodes.DefineRap, nodes.Method, Net]]:
    """Yield the methods whose steps have an order that is sure, with it."""
    for rap in run.library.raps.values():
        for method in rap.methods:
            net = sure_net(run, method)
            if net is not None:
                yield rap, method, net


def _net(run: Pass, net: nodes.TaskNet) -> Net:
    tags = {step.tag: at for at, step in reversed(list(enumerate(net.steps)))}
    found = list(_duplicates(run, net, tags))
    doubled = broken = len(tags) < len(net.steps)
    edges: list[list[StepOrder]] = [[] for _ in net.steps]
    unknown: dict[str, list[Span]] = {}
    for at, step in enumerate(net.steps):
        for annotation in step.annotations:
            tag = _tag(annotation)
            if tag is None:
                continue
            if tag not in tags:
                broken = True
                unknown.setdefault(tag, []).append(_place(run, annotation, tag))
            elif type(annotation) is nodes.For:
                edges[tags[tag]].append(StepOrder(at, tags[tag], annotation))
            elif type(annotation) is nodes.Window:
                edges[at].append(StepOrder(tags[tag], at, annotation))
    names = Suggestions(tags) if unknown else None
    for tag, places in unknown.items() if names and not doubled else ():
        assert names is not None
        found.append(_unknown_tag(run, places, tag, names))
    by_until = _ended_by_until(net, tags, edges)
    by_signal = {at for at, step in enumerate(net.steps) if _ended_by_signal(step)}
    order, circle = _order(edges)
    if circle and not doubled:
        found.append(_cycle(net, edges, circle))
    return Net(
        order,
        tuple(map(tuple, edges)),
        by_until | by_signal,
        by_until,
        broken,
        tuple(found),
    )


def _ended_by_until(
    net: nodes.TaskNet, tags: Mapping[str, int], edges: Edges
) -> frozenset[int]:
    """The steps that an `until` may end early.

    It cannot end a step that has ended when the step it speaks of begins.
    """
    marked = {at: named for at, step in enumerate(net.steps) if (named := _ends(step))}
    return frozenset(
        at
        for at, named in marked.items()
        for tag in named
        if tag in tags and not _is_before(edges, at, tags[tag], marked)
    )


def _ends(step: nodes.Step) -> list[str]:
    """Return the tags of the steps that end a step by `until`."""
    return [
        note.tag
        for note in step.annotations
        if isinstance(note, nodes.UntilStart | nodes.UntilEnd)
    ]


def _ended_by_signal(step: nodes.Step) -> bool:
    """Whether a signal may end a step well."""
    return any(
        isinstance(note, nodes.WaitFor) and note.mode == "succeed"
        for note in step.annotations
    )


def _duplicates(
    run: Pass, net: nodes.TaskNet, tags: Mapping[str, int]
) -> Iterator[Diagnostic]:
    for at, step in enumerate(net.steps):
        first = tags[step.tag]
        if first != at:
            yield DUPLICATE_TAG.at(
                _tag_span(run, step),
                f"tag `{step.tag}` names another step already",
                labels=(Label(_tag_span(run, net.steps[first]), "this one"),),
                help="give each step a tag of its own",
            )


def _tag_span(run: Pass, step: nodes.Step) -> Span:
    return word_span(run.library.files, step.span, 0)


def _tag(annotation: nodes.Annotation) -> str | None:
    """The tag an annotation speaks of, if it speaks of one."""
    if type(annotation) is nodes.For:
        return annotation.tag
    if type(annotation) is nodes.UntilStart or type(annotation) is nodes.UntilEnd:
        return annotation.tag
    if type(annotation) is nodes.Window and annotation.reference not in CLOCKS:
        return annotation.reference
    return None


def _place(run: Pass, annotation: nodes.Annotation, tag: str) -> Span:
    """Return where an annotation names its tag: behind its word, or at the end."""
    span = annotation.span
    if type(annotation) is not nodes.For or annotation.formula is None:
        return word_span(run.library.files, span, 1)
    source = run.library.files.get(span.file)
    if source is None:
        return span
    end = span.start + len(source.text[span.start : span.end].rstrip(") \t\n"))
    named = source.text[end - len(tag) : end].lower() == tag
    return source.span(end - len(tag), end) if named else span


def _unknown_tag(
    run: Pass, places: Sequence[Span], tag: str, names: Suggestions
) -> Diagnostic:
    return UNKNOWN_TAG.at(
        places[0],
        f"no step of this task-net has the tag `{tag}`",
        labels=tuple([Label(other, "named here too") for other in places[1:]]),
        help=names.did_you_mean(tag),
        fix=renaming(run.library.files, tag, names.near(tag), places),
    )


def _order(edges: Edges) -> tuple[tuple[int, ...] | None, Sequence[int]]:
    """Return the steps in order, or None and a circle of steps."""
    if all(edge.before < at for at, into in enumerate(edges) for edge in into):
        return tuple(range(len(edges))), ()
    graph = {at: [edge.before for edge in into] for at, into in enumerate(edges)}
    try:
        return tuple(TopologicalSorter(graph).static_order()), ()
    except CycleError as error:
        return None, error.args[1]


def _cycle(net: nodes.TaskNet, edges: Edges, circle: Sequence[int]) -> Diagnostic:
    links = sorted(_links(edges, circle), key=lambda edge: edge.annotation.span.start)
    tags = [f"`{net.steps[edge.before].tag}`" for edge in links]
    if len(tags) == 1:
        message = f"step {tags[0]} waits for itself"
    elif len(tags) <= _MOST:
        message = f"steps {', '.join(tags[:-1])} and {tags[-1]} wait for each other"
    else:
        message = f"{len(tags)} steps wait for each other, {tags[0]} among them"
    return CYCLE.at(
        links[-1].annotation.span,
        message,
        label=_says(net, links[-1]),
        labels=tuple(
            Label(e.annotation.span, _says(net, e)) for e in links[:-1][:_MOST]
        ),
        help="take one of these annotations away",
    )


def _links(edges: Edges, circle: Sequence[int]) -> Iterator[StepOrder]:
    for before, after in pairwise(circle):
        yield next(edge for edge in edges[after] if edge.before == before)


def _says(net: nodes.TaskNet, edge: StepOrder) -> str:
    return f"puts `{net.steps[edge.before].tag}` before `{net.steps[edge.after].tag}`"
