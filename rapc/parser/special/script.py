"""The script of a test: its rows, and what is written like them elsewhere in a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from rapc.base.values import Number
from rapc.ir import nodes
from rapc.language.grammar import RULES
from rapc.language.heads import rules_by_head
from rapc.language.shapes import is_word
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.elaborate import made
from rapc.parser.syntax import Datum, Keyword, List, Numeral, Symbol
from rapc.parser.terms import colon, goal, pattern

D = TypeVar("D", nodes.Proposition, nodes.Datum)


def option_counts(group: str) -> dict[str, int]:
    """The options in a group of the grammar, with the number of their values."""
    return {
        word: 0 if is_word(RULES[rule]) else len(RULES[rule]) - 2
        for word, rule in rules_by_head(group).items()
    }


OPTIONS = option_counts("_once_row_option")
"""The options of a row, with the number of their values."""


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
    given = options(ctx, rest, "a row", OPTIONS)
    if asked is None:
        return None
    times, takes, after = (given.get(f":{n}") for n in ("times", "takes", "after"))
    taken = None if takes is None else number(ctx, takes, "a duration")
    told_signals, pauses = _with_pauses(ctx, given.get(":signals"))
    every = given.get(":every")
    return nodes.ScriptRow(
        kind=kind,
        request=asked,
        result=result,
        times=None if times is None else whole(ctx, times, "a number", least=1),
        takes=taken or 0,
        after=None if after is None else number(ctx, after, "a duration"),
        asserts=told(ctx, _listed(ctx, given, ":asserts"), nodes.Proposition),
        erases=told(ctx, _listed(ctx, given, ":erases"), nodes.Proposition),
        data=told(ctx, _listed(ctx, given, ":data"), nodes.Datum),
        signals=told_signals,
        refused=":refused" in given,
        pauses=pauses,
        every=None if every is None else _period(ctx, every),
        span=ctx.span(datum),
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
    return "request", request(ctx, datum)


def _listed(ctx: Context, given: Mapping[str, Datum], name: str) -> Sequence[Datum]:
    datum = given.get(name)
    if datum is None:
        return ()
    if isinstance(datum, List) and all(isinstance(i, List) for i in datum.items):
        return datum.items
    message = f"`{name}` takes a list of lists"
    fix = ctx.wrap(datum, datum, "(", sure=False) if isinstance(datum, List) else None
    ctx.report("malformed-clause", message, datum, fix=fix)
    return ()


def _with_pauses(
    ctx: Context, datum: Datum | None
) -> tuple[tuple[nodes.Signal, ...], tuple[Number, ...]]:
    """Return the signals of a row, and how long each waits for the one before it."""
    if datum is None:
        return (), ()
    if not isinstance(datum, List) or not all(
        isinstance(item, List | Numeral) for item in datum.items
    ):
        _listed(ctx, {":signals": datum}, ":signals")
        return (), ()
    found: list[nodes.Signal] = []
    pauses: list[Number] = []
    pause: Number = 0
    for item in datum.items:
        if not isinstance(item, List):
            pause += number(ctx, item, "a wait before a signal") or 0
            continue
        one = plain(ctx, colon(ctx, item, nodes.Signal))
        if one is not None:
            found.append(one)
            pauses.append(pause)
        pause = 0
    return tuple(found), tuple(pauses) if any(pauses) else ()


def _period(ctx: Context, datum: Datum) -> Number | None:
    """Return the time between two tellings of a skill, which is more than none."""
    found = number(ctx, datum, "a duration")
    if found == 0:
        ctx.report("malformed-clause", "`:every` takes a time above 0", datum)
        return None
    return found


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
    if found is not None and found.outputs:
        help = "in `succeeds` they stand behind it: `(succeeds (find box) kitchen)`"
        ctx.report("malformed-goal", "no outputs can stand here", datum, help=help)
        return None
    return _ground(ctx, found) if ground else plain(ctx, found)


def told(ctx: Context, data: Sequence[Datum], kind: type[D]) -> tuple[D, ...]:
    """What is told in a script: propositions or data of constants and variables."""
    return made(plain(ctx, pattern(ctx, datum, kind)) for datum in data)


def fact(ctx: Context, datum: Datum) -> nodes.Proposition | None:
    """A proposition without variables."""
    return _ground(ctx, pattern(ctx, datum, nodes.Proposition))


def arriving(ctx: Context, datum: Datum) -> nodes.Signal | None:
    """A signal without variables."""
    return _ground(ctx, colon(ctx, datum, nodes.Signal))


P = TypeVar("P", bound=nodes.Pattern | nodes.Goal)


def plain(ctx: Context, node: P | None) -> P | None:
    """What holds no computed terms: a pattern is compared with values."""
    for arg in node.args if node is not None else ():
        if isinstance(arg, nodes.Call):
            _no_place(ctx, arg, "a computed term")
            return None
    return node


def _ground(ctx: Context, node: P | None) -> P | None:
    """What holds neither computed terms nor variables."""
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


def options(
    ctx: Context, data: Sequence[Datum], owner: str, known: Mapping[str, int]
) -> Mapping[str, Datum]:
    """Options with their values by name; the word itself for those without one."""
    found: dict[str, Datum] = {}
    rest = list(data)
    while rest:
        word = rest.pop(0)
        if not isinstance(word, Keyword):
            message = f"{kind_of(word)} stands where an option of {owner} is wanted"
            ctx.report("malformed-clause", message, word)
            continue
        value: Datum | None = None
        if known.get(word.name, 1) == 0:
            value = word
        elif rest and not isinstance(rest[0], Keyword):
            value = rest.pop(0)
        if word.name not in known:
            ctx.unknown("unknown-clause", f"option of {owner}", word, known)
        elif value is None:
            ctx.report("malformed-clause", f"`{word.name}` lacks its value", word)
        elif word.name in found:
            ctx.report("duplicate-clause", f"there is a second `{word.name}`", word)
        else:
            found[word.name] = value
    return found
