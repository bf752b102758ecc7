"""Readers of terms, propositions and goals: data with arguments [L 2.37]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from rapc.base.source import Span
from rapc.base.values import Atom, Text
from rapc.ir import nodes
from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import ARROW, CALLS, QUERIES, rules_by_head
from rapc.parser.context import Context, Read, head_of
from rapc.parser.syntax import (
    Arrow,
    Datum,
    Keyword,
    List,
    Numeral,
    String,
    Symbol,
    Variable,
)

_CALLS = rules_by_head("call")
_LEAST = {
    word: sum(part[0] != "*" for part in RULES[rule][2:])
    for word, rule in _CALLS.items()
}
_REPEATS = frozenset(
    word for word, rule in _CALLS.items() if RULES[rule][-1][0] in ("*", "+")
)
"""Calls with a repeatable last argument; `_LEAST` has the least number."""


def term(ctx: Context, datum: Datum) -> nodes.Term | None:
    """Read a constant, a variable or a computed term."""
    if type(datum) is Variable:
        return nodes.Var(datum.name, span=Span(ctx.file, datum.start, datum.end))
    if type(datum) is List:
        return _call(ctx, datum)
    span = Span(ctx.file, datum.start, datum.end)
    if type(datum) is Symbol or type(datum) is Keyword:
        return nodes.Const(datum.name, span=span)
    if type(datum) is Numeral:
        return nodes.Const(datum.value, span=span)
    if type(datum) is Arrow:
        _stray_arrow(ctx, datum)
        return None
    assert type(datum) is String
    return nodes.Const(Text(datum.value), span=span)


def constant(datum: Datum) -> Atom | None:
    """Return the value of a constant; None for any other datum."""
    match datum:
        case Symbol(name) | Keyword(name):
            return name
        case Numeral(number):
            return number
        case String(text):
            return Text(text)
        case List() | Variable() | Arrow():
            return None


def _stray_arrow(ctx: Context, datum: Datum) -> None:
    ctx.report(
        "malformed-term",
        f"expected a value, not `{ARROW}`",
        datum,
        help=f"`{ARROW}` separates the inputs of an index or a goal from the outputs",
    )


def terms(ctx: Context, data: Sequence[Datum]) -> tuple[nodes.Term, ...]:
    """Read a sequence of terms; invalid data are reported and left out."""
    return tuple(filter(None, [term(ctx, datum) for datum in data]))


def _call(ctx: Context, datum: List) -> nodes.Call | None:
    name = head_of(datum)
    if name is None:
        help = "a term in parentheses begins with the name of a function"
        ctx.report("malformed-term", "expected a term, not this list", datum, help=help)
        return None
    if name in QUERIES:
        help = "only functions such as `+` are valid inside of arguments"
        ctx.report(
            "malformed-term",
            f"`{name}` is a test and has no value",
            datum,
            help=help,
        )
        return None
    args = terms(ctx, datum.items[1:])
    if len(args) < len(datum.items) - 1:
        return None
    rule = _CALLS.get(name)
    if rule is not None:
        count, least = len(args), _LEAST[name]
        if count < least or (count > least and name not in _REPEATS):
            message = f"`{name}` takes {GRAMMAR[rule].takes}, not {count}"
            ctx.report("malformed-term", message, datum)
            return None
    return nodes.Call(name, args, span=ctx.span(datum))


P = TypeVar("P", nodes.Proposition, nodes.Request, nodes.Datum, nodes.Call)
S = TypeVar("S", nodes.Signal, nodes.Skill)


def pattern(ctx: Context, datum: Datum, kind: type[P]) -> P | None:
    """Read a plain proposition: a name and its arguments."""
    name = head_of(datum)
    if name is None or type(datum) is not List:
        ctx.wrong("proposition", datum)
        return None
    if name in _NO_PROPOSITIONS:
        ctx.report(
            "malformed-proposition",
            f"`{name}` cannot be the name of a proposition",
            datum,
            help="expected a plain proposition",
        )
        return None
    place = Span(ctx.file, datum.start, datum.end)
    return kind(name, terms(ctx, datum.items[1:]), span=place)


_NO_PROPOSITIONS = frozenset((*QUERIES, *CALLS))


def proposition(ctx: Context, datum: Datum) -> nodes.Proposition | None:
    """Read a proposition with any kinds of terms."""
    return pattern(ctx, datum, nodes.Proposition)


def thing(ctx: Context, datum: Datum) -> nodes.Thing | None:
    """Read a thing: a symbol, or a name with its arguments."""
    if type(datum) is Symbol:
        return nodes.Thing(datum.name, (), span=ctx.span(datum))
    name = head_of(datum)
    if type(datum) is List and name is not None:
        return nodes.Thing(name, terms(ctx, datum.items[1:]), span=ctx.span(datum))
    ctx.wrong("thing", datum)
    return None


def signal(ctx: Context, datum: Datum) -> nodes.Signal | None:
    """Read an event or signal with its arguments: `(:name args...)`."""
    return colon(ctx, datum, nodes.Signal)


def colon(ctx: Context, datum: Datum, kind: type[S]) -> S | None:
    """Read a skill, event or signal with its arguments: `(:name args...)`."""
    if isinstance(datum, List) and datum.items:
        first = datum.items[0]
        if isinstance(first, Symbol):
            ctx.report_fixable(
                "malformed-proposition",
                "expected a name with a colon for a signal or skill, not "
                f"`{first.name}`",
                first,
                fix=ctx.replace(first, f":{first.name}"),
            )
        if isinstance(first, Symbol | Keyword):
            name = first.name if first.name.startswith(":") else f":{first.name}"
            return kind(name, terms(ctx, datum.items[1:]), span=ctx.span(datum))
    ctx.wrong("signal", datum)
    return None


def goal(ctx: Context, datum: Datum) -> nodes.Goal | None:
    """Read a goal: `(rap args... [=> outs...])`."""
    name = head_of(datum)
    if name is None or type(datum) is not List:
        ctx.wrong("goal", datum)
        return None
    inputs, outputs = split_arrow(ctx, datum)
    made = terms(ctx, inputs)
    outs: tuple[nodes.Term, ...] = ()
    if outputs:
        outs = tuple(out for out in terms(ctx, outputs) if _plain(ctx, out, datum))
    return nodes.Goal(name, made, outs, span=Span(ctx.file, datum.start, datum.end))


def split_arrow(
    ctx: Context, datum: List
) -> tuple[tuple[Datum, ...], tuple[Datum, ...]]:
    """Return the data before and after the `=>` of an index or a goal."""
    items = datum.items[1:]
    if Arrow not in map(type, items):
        return items, ()
    places = [i for i, d in enumerate(items) if type(d) is Arrow]
    first = places[0]
    for place in places[1:]:
        ctx.report(
            "malformed-goal",
            f"duplicate `{ARROW}`",
            items[place],
            labels=[(items[first], "the first is here")],
        )
    rest = tuple(d for i, d in enumerate(items) if i > first and i not in places)
    return items[:first], rest


def _plain(ctx: Context, out: nodes.Term, datum: Datum) -> bool:
    if not isinstance(out, nodes.Call):
        return True
    ctx.report(
        "malformed-goal", "expected a variable or a constant as an output", datum
    )
    return False


def _asked(ctx: Context, datum: Datum) -> nodes.Goal | None:
    """Read a goal without outputs."""
    found = goal(ctx, datum)
    if found is None or not isinstance(datum, List):
        return None
    if Arrow in map(type, datum.items):
        help = (
            "in `succeeds`, write the outputs after the goal: `(succeeds "
            "(find box) kitchen)`"
        )
        ctx.report("malformed-goal", "unexpected outputs", datum, help=help)
        return None
    return found


NAMED: Mapping[str, Read] = {
    "PREDICATE": proposition,
    "PRIMITIVE": lambda ctx, datum: pattern(ctx, datum, nodes.Request),
    "DATUM": lambda ctx, datum: pattern(ctx, datum, nodes.Datum),
    "FUNCTION": lambda ctx, datum: pattern(ctx, datum, nodes.Call),
    "SIGNAL": signal,
    "SKILL": lambda ctx, datum: colon(ctx, datum, nodes.Skill),
    "RAP": _asked,
}
"""The readers of a name with its arguments, by the kind of name."""

REFUSED: Mapping[str, Mapping[type[nodes.Term], str]] = {
    "term": {},
    "plain": {nodes.Call: "a computed term"},
    "value": {nodes.Call: "a computed term", nodes.Var: "a variable"},
}
"""The invalid terms in arguments of a kind: some arguments are compared with values."""


def with_arguments(name: str, args: str) -> Read:
    """Return the reader of a name of a kind with arguments of a kind, as one node."""
    read, refused = NAMED[name], REFUSED[args]
    if not refused:
        return read

    def checked(ctx: Context, datum: Datum) -> Any:
        node = read(ctx, datum)
        for arg in node.args if node is not None else ():
            if type(arg) in refused:
                place = Symbol("", arg.span.start, arg.span.end)
                message = f"{refused[type(arg)]} is not allowed here"
                ctx.report("malformed-proposition", message, place)
                return None
        return node

    return checked
