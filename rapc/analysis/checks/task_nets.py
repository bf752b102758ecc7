"""Faults of task-nets: unknown and duplicate tags, and steps that wait in a circle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.names import renaming
from rapc.analysis.facts.task_nets import TASK_NETS, Net, StepOrder, tag_of
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

_SHOWN = 8
"""How many steps of a circle are shown."""


@check(UNKNOWN_TAG, DUPLICATE_TAG, CYCLE, needs_whole="method")
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
                f"tag `{step.tag}` names another step already",
                labels=(Label(_tag_span(run, net.steps[first]), "this one"),),
                help="give each step a tag of its own",
            )


def _tag_span(run: Pass, step: nodes.Step) -> Span:
    return word_span(run.library.files, step.span, 0)


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
            f"no step of this task-net has the tag `{tag}`",
            labels=tuple([Label(other, "named here too") for other in places[1:]]),
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
    return CYCLE.at(
        links[-1].annotation.span,
        message,
        label=_says(net, links[-1]),
        labels=tuple(
            Label(e.annotation.span, _says(net, e)) for e in links[:-1][:_SHOWN]
        ),
        help="take one of these annotations away",
    )


def _links(net: Net) -> Iterator[StepOrder]:
    for before, after in pairwise(net.circle):
        yield next(edge for edge in net.edges[after] if edge.before == before)


def _says(net: nodes.TaskNet, edge: StepOrder) -> str:
    return f"puts `{net.steps[edge.before].tag}` before `{net.steps[edge.after].tag}`"
