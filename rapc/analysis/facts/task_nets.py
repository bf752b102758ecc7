"""The order of every task-net: tags, and what comes before what.

Order comes from `for` annotations and from windows that name a step; `until` delays
nothing [L 4.1, 4.2]. Which variables that order binds is in
`rapc.analysis.facts.variables`.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.ir import nodes

CLOCKS = ("now", "absolute")
"""What a window may refer to besides a step."""


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
    #: The first step of each tag.
    tags: Mapping[str, int]
    #: Annotations whose tag names no step.
    unknown: tuple[nodes.Annotation, ...] = ()
    #: Steps that wait for each other, if there is no order.
    circle: tuple[int, ...] = ()

    @property
    def has_doubles(self) -> bool:
        """Whether two steps have one tag."""
        return len(self.tags) < len(self.edges)

    @property
    def is_broken(self) -> bool:
        """Whether a tag names no step, or two: the order is not sure."""
        return bool(self.unknown) or self.has_doubles

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
                    nets[id(method.body)] = _net(method.body)
    return nets


TASK_NETS = Fact(_run)


def sure_net(run: Pass, method: nodes.Method) -> Net | None:
    """Return the order of the steps of a method, if it has one that is sure."""
    net = run.result(TASK_NETS).get(id(method.body))
    return None if net is None or net.is_broken or net.order is None else net


def sure_nets(run: Pass) -> Iterator[tuple[nodes.DefineRap, nodes.Method, Net]]:
    """Yield the methods whose steps have an order that is sure, with it."""
    for rap in run.library.raps.values():
        for method in rap.methods:
            net = sure_net(run, method)
            if net is not None:
                yield rap, method, net


def _net(net: nodes.TaskNet) -> Net:
    tags = {step.tag: at for at, step in reversed(list(enumerate(net.steps)))}
    edges: list[list[StepOrder]] = [[] for _ in net.steps]
    unknown: list[nodes.Annotation] = []
    for at, step in enumerate(net.steps):
        for annotation in step.annotations:
            tag = tag_of(annotation)
            if tag is None:
                continue
            if tag not in tags:
                unknown.append(annotation)
            elif type(annotation) is nodes.For:
                edges[tags[tag]].append(StepOrder(at, tags[tag], annotation))
            elif type(annotation) is nodes.Window:
                edges[at].append(StepOrder(tags[tag], at, annotation))
    by_until = _ended_by_until(net, tags, edges)
    by_signal = {at for at, step in enumerate(net.steps) if _ended_by_signal(step)}
    order, circle = _order(edges)
    return Net(
        order,
        tuple(map(tuple, edges)),
        by_until | by_signal,
        by_until,
        tags,
        tuple(unknown),
        circle,
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


def tag_of(annotation: nodes.Annotation) -> str | None:
    """The tag an annotation speaks of, if it speaks of one."""
    if type(annotation) is nodes.For:
        return annotation.tag
    if type(annotation) is nodes.UntilStart or type(annotation) is nodes.UntilEnd:
        return annotation.tag
    if type(annotation) is nodes.Window and annotation.reference not in CLOCKS:
        return annotation.reference
    return None


def _order(edges: Edges) -> tuple[tuple[int, ...] | None, tuple[int, ...]]:
    """Return the steps in order, or None and a circle of steps."""
    if all(edge.before < at for at, into in enumerate(edges) for edge in into):
        return tuple(range(len(edges))), ()
    graph = {at: [edge.before for edge in into] for at, into in enumerate(edges)}
    try:
        return tuple(TopologicalSorter(graph).static_order()), ()
    except CycleError as error:
        return None, tuple(error.args[1])
