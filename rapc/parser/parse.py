"""Parsing of files and of small texts to IR: the reader, then the form functions.

Not here: linking the definitions of several files (`rapc.library.library`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import msgspec

from rapc.base.limits import MAX_FINDINGS, MAX_QUOTED
from rapc.base.names import nearest
from rapc.base.source import SourceFile
from rapc.base.values import Atom, Fact
from rapc.errors import TextError
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.ir.walk import subformulas
from rapc.parser import reader
from rapc.parser.context import Context, Read, head_of, kind_of
from rapc.parser.special.formulas import formula
from rapc.parser.special.table import readers
from rapc.parser.syntax import Comment, Datum, Keyword, List, Numeral, Symbol
from rapc.parser.terms import goal, proposition, signal
from rapc.parser.unit import PartialForm, SourceUnit, with_defaults

__all__ = (
    "Comment",
    "SourceUnit",
    "parse",
    "parse_fact",
    "parse_formula",
    "parse_goal_options",
    "parse_pattern",
    "parse_signal",
)

GOAL_OPTIONS = (":priority", ":deadline", ":at", ":background")
"""The options of a top-level task after its goal."""


def parse(source: SourceFile) -> SourceUnit:
    """Return the IR of a file with its findings; never raises."""
    reading = reader.read(source)
    known = readers()
    known_forms = known.group("_form")
    forms: list[nodes.TopForm] = []
    tests: list[DefineTest] = []
    defaults: DefineTest | None = None
    found = list(reading.diagnostics)
    partial: list[PartialForm] = []
    for top in reading.forms:
        room = MAX_FINDINGS - len(found)
        ctx = Context(source, room, known)
        ctx.damaged, ctx.surplus = top.damaged, top.surplus
        form = _form(ctx, top.datum, known_forms)
        if isinstance(form, DefineTest):
            if form.name:
                form = form if defaults is None else with_defaults(form, defaults)
                tests.append(form)
            else:
                if tests or defaults is not None:
                    _misplaced_defaults(ctx, top.datum)
                defaults = defaults or form
        elif form is not None:
            forms.append(form)
        found.extend(ctx.diagnostics)
        if form is not None and (top.damaged or ctx.incomplete):
            partial.append(PartialForm(form, top.damaged))
    found.sort(key=lambda d: d.span.start)
    if len(found) >= MAX_FINDINGS:
        note = f"only the first {MAX_FINDINGS} findings of this file are reported"
        found[-1] = msgspec.structs.replace(found[-1], notes=(note,))
    return SourceUnit(
        file=source,
        forms=tuple(forms),
        tests=tuple(tests),
        data=tuple([top.datum for top in reading.forms]),
        comments=reading.comments,
        diagnostics=tuple(found),
        partial=tuple(partial),
    )


def _form(
    ctx: Context, datum: Datum, forms: Mapping[str, Read]
) -> nodes.TopForm | DefineTest | None:
    name = head_of(datum)
    if not isinstance(datum, List) or name is None:
        ctx.report(
            "unknown-form",
            f"expected a form, not {kind_of(datum)}",
            datum,
            help=(
                "a form is a list that begins with a word such as `define-rap`; "
                "a comment begins with `;`"
            ),
        )
        return None
    if name not in forms:
        word = cast(Symbol, datum.items[0])
        meant = ctx.unknown("unknown-form", "top-level form", word, forms)
        if meant is None:
            return None
        name = meant
    made: nodes.TopForm | DefineTest | None = forms[name](ctx, datum)
    return made


def _misplaced_defaults(ctx: Context, datum: Datum) -> None:
    ctx.report(
        "malformed-form",
        "`define-test-defaults` must be unique and precede the tests of its file",
        datum,
    )


def parse_fact(text: str) -> Fact:
    """Return the fact in a text, for example `(location box-1 depot)`.

    Raises:
        TextError: if the text is not a ground proposition.
    """
    return _ground(parse_pattern(text), "a fact", text)


def _ground(made: nodes.Pattern, called: str, text: str) -> Fact:
    values: list[Atom] = []
    for arg in made.args:
        if not isinstance(arg, nodes.Const):
            what = "a variable" if isinstance(arg, nodes.Var) else "a computed term"
            raise TextError(
                f"expected only values in {called}, not {what}: {_quoted(text)}"
            )
        values.append(arg.value)
    return (made.name, *values)


def parse_pattern(text: str) -> nodes.Proposition:
    """Return the proposition in a text, for example `(location ?x depot)`.

    Raises:
        TextError: if the text is not a proposition.
    """
    return cast(nodes.Proposition, _only(text, proposition, "proposition"))


def parse_signal(text: str) -> Fact:
    """Return the signal with values in a text, for example `(:door-open hall)`.

    Raises:
        TextError: if the text is not a signal with values.
    """
    return _ground(_only(text, signal, "signal"), "a signal", text)


def parse_formula(text: str) -> nodes.Formula:
    """Return the formula in a text, for example `(and (location ?x depot) (red ?x))`.

    Raises:
        TextError: if the text is not a formula, or has `otherwise`.
    """
    made: nodes.Formula = _only(text, formula, "formula")
    if any(isinstance(part, nodes.Otherwise) for part in subformulas(made)):
        raise TextError(
            f"`otherwise` is valid only in the context of a method: {_quoted(text)}"
        )
    return made


def _only(text: str, read: Read, what: str) -> Any:
    """Return the value of a text with exactly one datum; raise TextError otherwise."""
    ctx, data = _small(text)
    made = read(ctx, data[0])
    _complain(ctx)
    if made is None or len(data) > 1:
        raise TextError(f"expected one {what}: {_quoted(text)}")
    return made


def parse_goal_options(text: str) -> tuple[nodes.Goal, Mapping[str, Atom]]:
    """Return a goal and its options, for example `(fetch box) :priority 4 :at 120`.

    The options are by name without the colon: `priority` (an integer), `deadline`
    and `at` (absolute times), `background` (`true` or `false`).

    Raises:
        TextError: if the text is not a goal with valid options.
    """
    ctx, data = _small(text)
    made = goal(ctx, data[0])
    _complain(ctx)
    options: dict[str, Atom] = {}
    rest = list(data[1:])
    while rest:
        word = rest.pop(0)
        if not isinstance(word, Keyword):
            raise TextError(
                f"expected an option that begins with a colon, not {ctx.text(word)}"
            )
        if word.name not in GOAL_OPTIONS:
            near = nearest(word.name, GOAL_OPTIONS)
            hint = f"; did you mean {near}?" if near else ""
            raise TextError(f"unknown option {word.name}{hint}")
        if word.name[1:] in options:
            raise TextError(f"duplicate option {word.name}")
        options[word.name[1:]] = _option(word.name, rest.pop(0) if rest else None)
    if made is None:
        raise TextError(f"expected a goal such as (rap args), not {_quoted(text)}")
    return made, options


def _option(name: str, value: Datum | None) -> Atom:
    if name == ":background":
        if isinstance(value, Symbol) and value.name in ("true", "false"):
            return value.name
        raise TextError(f"expected true or false after {name}")
    if not isinstance(value, Numeral):
        raise TextError(f"expected a number after {name}")
    if name == ":priority" and not isinstance(value.value, int):
        raise TextError(f"expected an integer after {name}")
    return value.value


def _quoted(text: str) -> str:
    """Return a text for a message, with `...` for the characters over a limit."""
    text = text.strip()
    return text if len(text) <= MAX_QUOTED else f"{text[:MAX_QUOTED]}..."


def _small(text: str) -> tuple[Context, tuple[Datum, ...]]:
    """Return the data of a small text, at least one; raise TextError otherwise."""
    source = SourceFile("", text)
    reading = reader.read(source)
    for found in reading.diagnostics:
        raise TextError(f"{found.message}: {_quoted(text)}")
    if not reading.forms:
        raise TextError("the text is empty")
    return Context(source, 1, readers()), tuple(top.datum for top in reading.forms)


def _complain(ctx: Context) -> None:
    for found in ctx.diagnostics:
        raise TextError(f"{found.message}: {_quoted(ctx.source.text)}")
