"""`define-test`: its clauses, what is given, and what is done at a time.

The rows of a script are read by `rapc.parser.special.script`, expectations by
`rapc.parser.special.expectations`. What a test means is in docs/testing.md.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from rapc.ir import nodes
from rapc.language.heads import TEST_CLAUSES, heads
from rapc.parser.context import Context, head_of
from rapc.parser.elaborate import made
from rapc.parser.fields import filled, slots
from rapc.parser.special.clauses import clauses, read_clauses, single
from rapc.parser.special.script import number, plain
from rapc.parser.syntax import Datum, List, String, Symbol
from rapc.parser.terms import constant, pattern

_ONCE = heads("_once_test_clause")


def define_test(ctx: Context, datum: Datum) -> nodes.DefineTest | None:
    """`(define-test name ["doc"] clause...)`."""
    assert isinstance(datum, List)
    items = datum.items[1:]
    name = items[0] if items else datum
    if not isinstance(name, Symbol):
        ctx.report("malformed-form", "`define-test` wants a symbol for its name", name)
        return None
    doc = ""
    first = items[1] if len(items) > 1 else None
    if isinstance(first, String):
        doc, items = first.value, items[1:]
    return _test(ctx, datum, name, doc, items[1:])


def define_test_defaults(ctx: Context, form: Datum) -> nodes.DefineTest:
    """`(define-test-defaults clause...)`: what is said of all tests, as one of them."""
    assert isinstance(form, List)
    return _test(ctx, form, None, "", form.items[1:])


def with_defaults(test: nodes.DefineTest, given: nodes.DefineTest) -> nodes.DefineTest:
    """Return a test with what its file says of all tests.

    What may stand once is the test's own if it says it; all else comes before.
    """
    merged = {
        name: getattr(given, name) + getattr(test, name)
        if isinstance(getattr(test, name), tuple)
        else getattr(given, name)
        if getattr(test, name) is None
        else getattr(test, name)
        for name in test.__struct_fields__
        if name not in ("name", "doc", "name_span", "span")
    }
    return msgspec.structs.replace(test, **merged)


def _test(
    ctx: Context, form: List, name: Symbol | None, doc: str, data: Sequence[Datum]
) -> nodes.DefineTest:
    """A test, or what is said of all of a file, of the data behind its name."""
    owner = head_of(form) or ""
    found = clauses(ctx, data, owner, TEST_CLAUSES)
    kept = single(ctx, found, set(TEST_CLAUSES) - set(_ONCE))
    read = read_clauses(ctx, kept, "_test_clause")
    fields = filled(_SLOTS, read)
    fields["until"] = _until(made((*read.get("until", ()), *read.get("cycles", ()))))
    return nodes.DefineTest(
        name="" if name is None else name.name,
        doc=doc,
        name_span=ctx.span(name or form.items[0]),
        span=ctx.span(form),
        **fields,
    )


_SLOTS = slots("define_test", nodes.DefineTest)


def _until(found: Sequence[nodes.Until]) -> nodes.Until | None:
    """`(until t)`, `(until (cycles n))` and `cycles` as a clause of its own, as one."""
    if not found:
        return None
    times = [one.time for one in found if one.time is not None]
    cycles = [one.cycles for one in found if one.cycles is not None]
    time, count = next(iter(times), None), next(iter(cycles), None)
    return nodes.Until(time, count, found[-1].span)


# --- what is given ------------------------------------------------------------------


def answer(ctx: Context, datum: Datum) -> nodes.Answer | None:
    """`((function arg...) value)`."""
    items = datum.items if isinstance(datum, List) else ()
    asked = pattern(ctx, items[0], nodes.Request) if len(items) == 2 else None
    value = constant(items[1]) if len(items) == 2 else None
    if asked is None or value is None:
        if len(items) != 2 or asked is not None:
            message = "an answer is a question to a function, and a value"
            help = "write `((function argument...) value)`"
            ctx.report("malformed-clause", message, datum, help=help)
        return None
    asked = plain(ctx, asked)
    if asked is None:
        return None
    call = nodes.Call(asked.name, asked.args, asked.span)
    return nodes.Answer(call, nodes.Const(value, ctx.span(items[1])), ctx.span(datum))


def world_option(ctx: Context, datum: Datum) -> nodes.WorldOption | None:
    """`(name value)`."""
    items = datum.items if isinstance(datum, List) else ()
    name = items[0] if len(items) == 2 else None
    value = constant(items[1]) if len(items) == 2 else None
    if not isinstance(name, Symbol) or value is None:
        message = "an option of the world is its name and a value"
        help = "write `(name value)`"
        ctx.report("malformed-clause", message, datum, help=help)
        return None
    return nodes.WorldOption(name.name, value, ctx.span(datum))


def at(ctx: Context, datum: Datum) -> nodes.At | None:
    """`(at time action...)`."""
    assert isinstance(datum, List)
    time = number(ctx, datum.items[1], "a time") if len(datum.items) > 1 else None
    if time is None:
        if len(datum.items) == 1:
            ctx.report("malformed-clause", "`at` lacks its time", datum)
        return None
    found = clauses(ctx, datum.items[2:], "at", ACTIONS)
    readers = ctx.readers.group("_action")
    actions: tuple[nodes.Action, ...] = made(readers[n](ctx, one) for n, one in found)
    return nodes.At(time, actions, ctx.span(datum))


ACTIONS = heads("_action")
"""What may be done at a time."""
