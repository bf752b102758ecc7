"""The script of a test: its rows, and what is written like them elsewhere in a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from rapc.base.values import Number
from rapc.ir import nodes
from rapc.language.heads import rules_by_head
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.fields import filled, slots
from rapc.parser.syntax import Arrow, Datum, Keyword, List, Numeral, Symbol
from rapc.parser.terms import colon, goal, pattern, term


def row(ctx: Context, datum: Datum) -> nodes.ScriptRow | None:
    """`((request) [result] option...)`."""
    if not isinstance(datum, List) or not datum.items:
        message = f"a row of the script is wanted here, not {kind_of(datum)}"
        help = "write `((request) result)`"
        ctx.report("malformed-clause", message, datum, help=help)
        return None
    first, *rest = datum.items
    kind, asked = _request(ctx, first)
    result = None
    if rest and isinstance(rest[0], Symbol):
        result, rest = rest[0].name, rest[1:]
    read = read_options(ctx, rest, "a row", "_once_row_option")
    if asked is None:
        return None
    fields = filled(slots("script_row", nodes.ScriptRow), read)
    fields["signals"], fields["pauses"] = _with_pauses(fields["signals"])
    return nodes.ScriptRow(
        kind=kind, request=asked, result=result, span=ctx.span(datum), **fields
    )


def _request(
    ctx: Context, datum: Datum
) -> tuple[nodes.RowKind, nodes.Request | nodes.Skill | None]:
    """A request, or a skill that is enabled or disabled."""
    name = head_of(datum)
    inner = datum.items[1] if isinstance(datum, List) and len(datum.items) == 2 else 0
    if name == "enable" and isinstance(inner, List):
        return "enable", plain(ctx, colon(ctx, inner, nodes.Skill))
    if name == "disable" and isinstance(inner, List):
        return "disable", plain(ctx, colon(ctx, inner, nodes.Skill))
    if name in ("enable", "disable"):
        help = f"write `({name} (:skill argument...))`"
        ctx.report("malformed-clause", "one skill is wanted here", datum, help=help)
        return "request", None
    return "request", request(ctx, datum)


def _with_pauses(
    told: Sequence[nodes.Signal | Number],
) -> tuple[tuple[nodes.Signal, ...], tuple[Number, ...]]:
    """Return the signals of a row, and how long each waits for the one before it."""
    found: list[nodes.Signal] = []
    pauses: list[Number] = []
    pause: Number = 0
    for one in told:
        if isinstance(one, nodes.Signal):
            found.append(one)
            pauses.append(pause)
            pause = 0
        else:
            pause += one
    return tuple(found), tuple(pauses) if any(pauses) else ()


# --- shared by the clauses of a test -------------------------------------------------


def request(ctx: Context, datum: Datum) -> nodes.Request | None:
    """A request of constants and variables."""
    return plain(ctx, pattern(ctx, datum, nodes.Request))


def enabled(ctx: Context, datum: Datum) -> nodes.Skill | None:
    """`(enable (:skill argument...))`, one skill of constants and variables."""
    kind, asked = _request(ctx, datum)
    return asked if kind == "enable" and isinstance(asked, nodes.Skill) else None


def asked_goal(
    ctx: Context, datum: Datum, *, ground: bool = False
) -> nodes.Goal | None:
    """A goal without outputs, of constants and, unless `ground`, variables."""
    found = goal(ctx, datum)
    arrow = isinstance(datum, List) and any(type(d) is Arrow for d in datum.items)
    if found is not None and arrow:
        help = "in `succeeds` they stand behind it: `(succeeds (find box) kitchen)`"
        ctx.report("malformed-goal", "no outputs can stand here", datum, help=help)
        return None
    return _ground(ctx, found) if ground else plain(ctx, found)


def told(ctx: Context, datum: Datum) -> nodes.Proposition | None:
    """A proposition of constants and variables."""
    return plain(ctx, pattern(ctx, datum, nodes.Proposition))


def moved(ctx: Context, datum: Datum) -> nodes.Moved | None:
    """`(item place)`, constants or variables."""
    return _moved(ctx, datum, (nodes.Const, nodes.Var), "a value or a variable")


def placed(ctx: Context, datum: Datum) -> nodes.Moved | None:
    """`(item place)` without variables."""
    return _moved(ctx, datum, (nodes.Const,), "a value")


def _moved(
    ctx: Context, datum: Datum, kinds: tuple[type[nodes.Term], ...], wanted: str
) -> nodes.Moved | None:
    if not isinstance(datum, List) or len(datum.items) != 2:
        help = "write `(item place)`"
        message = f"an item and its place are wanted here, not {kind_of(datum)}"
        ctx.report("malformed-clause", message, datum, help=help)
        return None
    item, place = (term(ctx, part) for part in datum.items)
    if item is None or place is None:
        return None
    for one in (item, place):
        if not isinstance(one, kinds):
            spot = Symbol("", one.span.start, one.span.end)
            ctx.report("malformed-clause", f"{wanted} is wanted here", spot)
            return None
    return nodes.Moved(item, place, ctx.span(datum))


def told_datum(ctx: Context, datum: Datum) -> nodes.Datum | None:
    """A sensor datum of constants and variables."""
    return plain(ctx, pattern(ctx, datum, nodes.Datum))


def told_signal(ctx: Context, datum: Datum) -> nodes.Signal | None:
    """A signal of constants and variables."""
    return plain(ctx, colon(ctx, datum, nodes.Signal))


def fact(ctx: Context, datum: Datum) -> nodes.Proposition | None:
    """A proposition without variables."""
    return _ground(ctx, pattern(ctx, datum, nodes.Proposition))


def arriving(ctx: Context, datum: Datum) -> nodes.Signal | None:
    """A signal without variables."""
    return _ground(ctx, colon(ctx, datum, nodes.Signal))


P = TypeVar("P", bound=nodes.Pattern | nodes.Goal)


def plain(ctx: Context, node: P | None) -> P | None:
    """Return what holds no computed terms: a pattern is compared with values."""
    for arg in node.args if node is not None else ():
        if isinstance(arg, nodes.Call):
            _no_place(ctx, arg, "a computed term")
            return None
    return node


def _ground(ctx: Context, node: P | None) -> P | None:
    """Return what holds neither computed terms nor variables."""
    for arg in node.args if node is not None else ():
        if not isinstance(arg, nodes.Const):
            is_variable = isinstance(arg, nodes.Var)
            _no_place(ctx, arg, "a variable" if is_variable else "a computed term")
            return None
    return node


def _no_place(ctx: Context, arg: nodes.Term, what: str) -> None:
    place = Symbol("", arg.span.start, arg.span.end)
    ctx.report("malformed-proposition", f"{what} cannot stand here", place)


def number(ctx: Context, datum: Datum, what: str) -> Number | None:
    """A number that is not negative."""
    if isinstance(datum, Numeral) and datum.value >= 0:
        return datum.value
    ctx.report("malformed-clause", f"{what} is wanted here", datum)
    return None


def whole(ctx: Context, datum: Datum, what: str, least: int | None = None) -> int:
    """A whole number; `least`, or 0, stands in for what is none."""
    value = datum.value if isinstance(datum, Numeral) else None
    if isinstance(value, int) and (least is None or value >= least):
        return value
    ctx.report("malformed-clause", f"{what} is wanted here, a whole one", datum)
    return least or 0


def read_options(
    ctx: Context, data: Sequence[Datum], owner: str, group: str
) -> Mapping[str, list[Any]]:
    """Return what was read of each option of a group by its word."""
    rules = rules_by_head(group)
    known = {word: ctx.readers.option(rule) for word, rule in rules.items()}
    counts = {word: option.values for word, option in known.items()}
    found = options(ctx, data, owner, counts)
    return {word: [known[word].read(ctx, one)] for word, one in found.items()}


def options(
    ctx: Context, data: Sequence[Datum], owner: str, known: Mapping[str, int]
) -> Mapping[str, List]:
    """Options by their words, each as a list of its word and, if it has one, its value.

    `known` gives the number of values of each, at most one.
    """
    found: dict[str, List] = {}
    at = 0
    while at < len(data):
        word = data[at]
        at += 1
        if not isinstance(word, Keyword):
            message = f"{kind_of(word)} stands where an option of {owner} is wanted"
            ctx.report("malformed-clause", message, word)
            continue
        wanted = known.get(word.name, 1)
        values = [d for d in data[at : at + wanted] if not isinstance(d, Keyword)]
        at += len(values)
        if word.name not in known:
            ctx.unknown("unknown-clause", f"option of {owner}", word, known)
        elif len(values) < wanted:
            ctx.report("malformed-clause", f"`{word.name}` lacks its value", word)
        elif word.name in found:
            ctx.report("duplicate-clause", f"there is a second `{word.name}`", word)
        else:
            end = values[-1].end if values else word.end
            found[word.name] = List((word, *values), word.start, end)
    return found
