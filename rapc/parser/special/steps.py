"""Readers of task-nets: steps with goals and annotations (T 4.5.2, 4.8; S 3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from rapc.base.names import nearest
from rapc.ir import nodes
from rapc.language.heads import ANNOTATIONS, CALLS, METHOD_CLAUSES, SLIPS
from rapc.parser.context import Context, head_of
from rapc.parser.special.formulas import formula
from rapc.parser.syntax import Datum, List, Numeral, Symbol, Variable
from rapc.parser.terms import goal

GROUPS = ("sequence", "parallel")
"""Words that group steps in other languages."""

ELSEWHERE = {
    "priority": "write a priority as a number after the tag: `(t1 2 (rap args...))`",
    "after": "write the order in the earlier step: `(for t1)`",
    "timeout": "write the end time as a second step with `(window now 30 30)` "
    "and `until-end`",
}
"""The help for words of other languages in the position of an annotation."""


def task_net(ctx: Context, datum: Datum) -> nodes.TaskNet:
    """Read `(task-net step...)`."""
    assert type(datum) is List
    rows = datum.items[1:]
    if rows and type(rows[0]) is Symbol and rows[0].name in GROUPS:
        _grouped(ctx, rows[0])
        return nodes.TaskNet((), span=ctx.span(datum))
    steps = tuple(filter(None, [_step(ctx, row) for row in rows]))
    return nodes.TaskNet(steps, span=ctx.span(datum))


def _grouped(ctx: Context, word: Datum) -> None:
    ctx.report(
        "grouped-steps",
        f"`{ctx.text(word)}` cannot group steps",
        word,
        help="write all steps side by side; `(for t2)` in a step orders the "
        "step before step t2",
    )


def _holds_steps(items: Sequence[Datum]) -> bool:
    """Return whether a word such as `sequence` groups steps or goals and is not a tag.

    A single goal follows a tag, and annotations follow the goal.
    """
    first = items[0] if items else None
    if not isinstance(first, List):
        return False
    asked = first.items[1] if len(first.items) > 1 else None
    if type(asked) is List and head_of(asked) not in CALLS:
        return True
    return len(items) > 1 and all(map(_is_goal, items))


def _is_goal(datum: Datum) -> bool:
    """Return whether a list may be a goal and is unlikely to be an annotation."""
    name = head_of(datum)
    if name is None or name in ELSEWHERE or _is_like_annotation(name):
        return False
    return not any(_is_for(item) for item in cast(List, datum).items)


def _is_like_annotation(name: str) -> bool:
    return (
        name in ANNOTATIONS
        or SLIPS.get(name) in ANNOTATIONS
        or nearest(name, ANNOTATIONS) is not None
    )


def _step(ctx: Context, datum: Datum) -> nodes.Step | None:
    """Read `(tag [priority] goal annotation...)`."""
    tag = head_of(datum)
    if tag is None or type(datum) is not List:
        ctx.wrong("step", datum)
        return None
    items = datum.items[1:]
    if tag in GROUPS and _holds_steps(items):
        _grouped(ctx, datum.items[0])
        return None
    priority = 0
    if items and type(items[0]) is Numeral:
        if isinstance(items[0].value, int):
            priority = items[0].value
        else:
            ctx.report(
                "malformed-step", "expected an integer as the priority", items[0]
            )
        items = items[1:]
    if not items:
        ctx.report("malformed-step", f"step `{tag}` requires a goal", datum)
        return None
    if type(items[0]) is Variable:
        ctx.report(
            "malformed-step",
            f"expected the tag of the step, not `{tag}`",
            datum,
            help=f"begin the step with a unique tag: `(t1 {ctx.text(datum)})`",
        )
        return None
    asked = goal(ctx, items[0])
    annotations = _annotations(ctx, items[1:]) if len(items) > 1 else ()
    if asked is None:
        return None
    return nodes.Step(tag, priority, asked, annotations, span=ctx.span(datum))


def _annotations(ctx: Context, data: Sequence[Datum]) -> tuple[nodes.Annotation, ...]:
    made: list[nodes.Annotation] = []
    at = 0
    while at < len(data):
        bare = _bare_for(ctx, data, at)
        if bare is not None:
            node, at = bare
        else:
            node, at = _annotation(ctx, data[at]), at + 1
        made.extend([node] if node else [])
    return tuple(made)


def _bare_for(
    ctx: Context, data: Sequence[Datum], at: int
) -> tuple[nodes.Annotation | None, int] | None:
    """Read `for tag`, alone or after a formula, without the required parentheses."""
    formed = type(data[at]) is List and head_of(data[at]) not in ANNOTATIONS
    start = at + 1 if formed else at
    if len(data) < start + 2 or not _is_for(data[start]):
        return None
    tag = data[start + 1]
    if not isinstance(tag, Symbol):
        return None
    ctx.report_fixable(
        "bare-for",
        "`for` and its tag require parentheses",
        data[start],
        fix=ctx.wrap(data[at], tag, "("),
    )
    asked = formula(ctx, data[at]) if formed else None
    span = ctx.span(data[at]).to(ctx.span(tag))
    lost = formed and asked is None
    return None if lost else nodes.For(asked, tag.name, span=span), start + 2


def _is_for(datum: Datum) -> bool:
    return type(datum) is Symbol and datum.name == "for"


def _annotation(ctx: Context, datum: Datum) -> nodes.Annotation | None:
    if type(datum) is not List or not datum.items:
        ctx.wrong("annotation", datum)
        return None
    read = ctx.readers.group("annotation").get(head_of(datum) or "")
    if read is not None:
        made: nodes.Annotation | None = read(ctx, datum)
        return made
    second = datum.items[1] if len(datum.items) > 1 else None
    if second is not None and _is_for(second):
        return _formula_for(ctx, datum)
    if second is not None and head_of(second) == "for" and len(datum.items) == 2:
        return _parenthesised_for(ctx, datum, second)
    return _unknown(ctx, datum)


def _formula_for(ctx: Context, datum: List) -> nodes.For | None:
    """Read `(formula for tag)`."""
    tag = datum.items[2] if len(datum.items) == 3 else None
    asked = formula(ctx, datum.items[0])
    if not isinstance(tag, Symbol):
        message = "`for` requires the tag of one step"
        ctx.report("malformed-annotation", message, datum.items[-1])
        return None
    return nodes.For(asked, tag.name, span=ctx.span(datum)) if asked else None


def _parenthesised_for(ctx: Context, datum: List, second: Datum) -> nodes.For | None:
    inner = cast(List, second)
    ctx.report_fixable(
        "parenthesised-for",
        "`for` after a formula must not have its own parentheses",
        inner,
        fix=ctx.replace(inner, ctx.text(inner)[1:-1].strip()),
    )
    whole = List((datum.items[0], *inner.items), datum.start, datum.end)
    return _formula_for(ctx, whole)


def _unknown(ctx: Context, datum: List) -> nodes.Annotation | None:
    first = datum.items[0]
    listed = ", ".join(f"`{word}`" for word in sorted(ANNOTATIONS))
    help = f"an annotation is `(formula for tag)`, or begins with {listed}"
    if not isinstance(first, Symbol):
        ctx.report("malformed-annotation", "expected an annotation", datum, help=help)
        return None
    if _is_like_annotation(first.name):
        meant = ctx.unknown("unknown-annotation", "annotation", first, ANNOTATIONS)
        known = ctx.readers.group("annotation")
        return known[meant](ctx, datum) if meant else None
    if first.name in ELSEWHERE:
        help = ELSEWHERE[first.name]
    elif first.name in METHOD_CLAUSES or isinstance(datum.items[-1], List):
        help = "each step requires its own parentheses; a parenthesis may be missing"
    ctx.report(
        "unknown-annotation",
        f"expected an annotation, not `{first.name}`",
        first,
        help=help,
    )
    return None
