"""The order of every task-net: tags, and the steps before each step.

Order comes from `for` annotations and from windows that name a step; `until` does not
delay a step [L 4.1, 4.2]. `rapc.analysis.facts.variables` determines the variables that
the order binds.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.ir import nodes

CLOCKS = ("now", "absolute")
"""The names in a window that are not steps."""


class StepOrder(msgspec.Struct, frozen=True):
    """An order of two steps, by positions in the text, and the reason for the order."""

    before: int
    after: int
    annotation: nodes.For | nodes.Window


class Net(msgspec.Struct, frozen=True):
    """The order of a task-net, by positions in the text.

    `order` lists the steps, each after the steps that it waits for; `order` is None if
    steps wait for each other in a cycle. `edges` holds, for each step, the reasons to
    be after other steps, in the order of the text. `early` are the steps that another
    step or a signal may end early. `by_until` are the steps of `early` that another
    step may end, even before the preceding steps have ended [L 4.33].
    """

    order: tuple[int, ...] | None
    edges: tuple[tuple[StepOrder, ...], ...]
    early: frozenset[int]
    by_until: frozenset[int]
    #: The first step of each tag.
    tags: Mapping[str, int]
    #: Annotations with the tag of no step.
    unknown: tuple[nodes.Annotation, ...] = ()
    #: Steps that wait for each other in a cycle, if there is no order.
    circle: tuple[int, ...] = ()

    @property
    def has_doubles(self) -> bool:
        """Return whether two steps have the same tag."""
        return len(self.tags) < len(self.edges)

    @property
    def is_broken(self) -> bool:
        """Return whether a tag names no step or two steps; the order is uncertain."""
        return bool(self.unknown) or self.has_doubles

    def is_before(self, one: int, other: int) -> bool:
        """Return whether a step is before another step, directly or indirectly."""
        return _is_before(self.edges, one, other, frozenset())

    def has_ended(self, one: int, other: int) -> bool:
        """Return whether a step has surely ended when another step begins.

        If `until` may end a step on the path early, the steps before that step may
        still run.
        """
        return _is_before(self.edges, one, other, self.by_until)

    def reach(self) -> tuple[list[int], list[int]]:
        """Return for each step the steps before and the steps after, as bit sets.

        All sets are empty if steps wait for each other in a cycle.
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
    """Return whether the order leads from a step to another, around some steps."""
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
"""The order of each task-net, by the `id` of the node."""


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
    """Return the order of the steps of a method, if the order is certain."""
    net = run.result(TASK_NETS).get(id(method.body))
    return None if net is None or net.is_broken or net.order is None else net


def sure_nets(run: Pass) -> Iterator[tuple[nodes.DefineRap, nodes.Method, Net]]:
    """Yield the methods whose steps have a certain order, with the order."""
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
    """Return the steps that an `until` may end early.

    An `until` cannot end a step that has ended before the named step begins.
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
    """Return whether a signal may end a step well."""
    return any(
        isinstance(note, nodes.WaitFor) and note.mode == "succeed"
        for note in step.annotations
    )


def tag_of(annotation: nodes.Annotation) -> str | None:
    """Return the tag that an annotation names, or None."""
    if type(annotation) is nodes.For:
        return annotation.tag
    if type(annotation) is nodes.UntilStart or type(annotation) is nodes.UntilEnd:
        return annotation.tag
    if type(annotation) is nodes.Window and annotation.reference not in CLOCKS:
        return annotation.reference
    return None


def _order(edges: Edges) -> tuple[tuple[int, ...] | None, tuple[int, ...]]:
    """Return the steps in order, or None and a cycle of steps."""
    if all(edge.before < at for at, into in enumerate(edges) for edge in into):
        return tuple(range(len(edges))), ()
    graph = {at: [edge.before for edge in into] for at, into in enumerate(edges)}
    try:
        return tuple(TopologicalSorter(graph).static_order()), ()
    except CycleError as error:
        return None, tuple(error.args[1])
