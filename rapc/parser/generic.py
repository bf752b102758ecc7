"""Readers made from the grammar: data to nodes, each reader made at its first use.

A reader takes a datum, reports faults in the author's words, and returns the node, or
None if a part was left out. For most rules the shape in `rapc.language.grammar` is
sufficient: the first words of the list, the number and the kinds of operands. `MAKERS`
of `rapc.parser.special.table` makes the nodes that have names different from their
rules. The grammar has the messages of findings. Special readers in
`rapc.parser.special` and other modules take precedence.

A list whose operands do not fit its shape is reported once, as a whole; operands that
are lists report their own faults.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import msgspec
from msgspec.structs import replace

from rapc.base.source import Span
from rapc.base.values import Number
from rapc.ir import schema
from rapc.language.grammar import GRAMMAR, RULES, TERMINALS
from rapc.language.heads import heads, rules_by_head, words_of_shape
from rapc.language.shapes import Shape, is_list, is_rule, is_terminal, is_word, leaves
from rapc.parser.context import Context, OptionReader, Read, head_of, kind_of
from rapc.parser.forms import clauses, filled, read_options, slots
from rapc.parser.syntax import Datum, Keyword, List, Numeral, String, Symbol, Variable
from rapc.parser.terms import NAMED, REFUSED, term, with_arguments


def _breaks(rule: str) -> str:
    """Return the checker's rule for a fault in data of a grammar rule or terminal."""
    return GRAMMAR[rule].breaks if rule in GRAMMAR else "malformed-clause"


Fits = Callable[[Datum], bool]
"""A predicate: whether a datum is of an expected kind, by its type and first word."""


class OperandWanted(msgspec.Struct, frozen=True):
    """The requirements of a single operand."""

    fits: Fits
    read: Read
    #: Whether `read` is only for data that fit; readers of lists report faults.
    strict: bool


def one_word(word: str) -> Fits:
    """Return the predicate that is true only for the symbol or keyword `word`."""

    def fits(datum: Datum) -> bool:
        return isinstance(datum, Symbol | Keyword) and datum.name == word

    return fits


def _is_name(datum: Datum) -> bool:
    return type(datum) is Symbol


def is_string(datum: Datum) -> bool:
    """Return whether a datum is a string."""
    return type(datum) is String


def terminal(name: str) -> OperandWanted:
    """Return the reader of a terminal: to nodes for constants and variables, or str."""
    if name in _NODES:
        return OperandWanted(_NODES[name], term, True)
    if name in _NUMBERS:
        return OperandWanted(_is_numeral, _number(name), False)
    if name == "FILE":
        return OperandWanted(_names_file, _file, True)
    if name == "STRING":
        return OperandWanted(is_string, _text, True)
    if TERMINALS[name] == TERMINALS["SYMBOL"]:
        return OperandWanted(_is_name, _named, True)
    if TERMINALS[name] == TERMINALS["KEYWORD"]:
        return OperandWanted(_NODES["KEYWORD"], _named, True)
    raise TypeError(f"no operand is a {name} alone")


def _named(ctx: Context, datum: Datum) -> str:
    assert isinstance(datum, Symbol | Keyword)
    return datum.name


def _text(ctx: Context, datum: Datum) -> str:
    assert isinstance(datum, String)
    return datum.value


def _names_file(datum: Datum) -> bool:
    return isinstance(datum, Symbol) or (isinstance(datum, String) and datum.value > "")


def _file(ctx: Context, datum: Datum) -> str:
    """Read the name of a file; a symbol is read as a string without quotes."""
    if isinstance(datum, String):
        return datum.value
    assert isinstance(datum, Symbol)
    fix = ctx.replace(datum, f'"{datum.name}"')
    ctx.report_fixable(
        "malformed-form",
        "expected a string after `require`, not a symbol",
        datum,
        fix=fix,
    )
    return datum.name


def _is_numeral(datum: Datum) -> bool:
    return type(datum) is Numeral


_NODES: Mapping[str, Fits] = {
    "SYMBOL": _is_name,
    "VARIABLE": lambda datum: type(datum) is Variable,
    "NUMBER": _is_numeral,
    "KEYWORD": lambda datum: type(datum) is Keyword,
}
_NUMBERS: Mapping[str, Callable[[Number], bool]] = {
    "INTEGER": lambda value: isinstance(value, int),
    "COUNT": lambda value: isinstance(value, int) and value >= 0,
    "POSITIVE": lambda value: isinstance(value, int) and value > 0,
    "TIME": lambda value: value >= 0,
    "PERIOD": lambda value: value > 0,
}
"""The predicate of each terminal of numbers."""


def _number(name: str) -> Read:
    def read(ctx: Context, datum: Datum) -> Number | None:
        if isinstance(datum, Numeral) and _NUMBERS[name](datum.value):
            return datum.value
        ctx.report("malformed-clause", f"expected {GRAMMAR[name].wanted}", datum)
        return None

    return read


class Operand(msgspec.Struct, frozen=True):
    """A sequence of operands of the same kind; `most` is None for any number."""

    least: int
    most: int | None
    part: OperandWanted


Maker = Callable[[Any, Sequence[Any], Span], Any]
"""A function that returns the node of a list, from its head, operands and span."""


Mend = Callable[[Context, List], List | None]
"""A function that reports a slip and returns the corrected list, or None."""


class GrammarReaders(dict[str, Read]):
    """The readers by the name of their rule; most are made from the grammar.

    Args:
        special: the special readers.
        makers: the functions that make nodes from the operands of a rule. Without a
            function, the result is the node of the same name, with the operands as
            fields, or the first operand if there is no node of that name.
        mends: the corrections of lists with published variants in their spelling.
    """

    def __init__(
        self,
        special: Mapping[str, Read],
        makers: Mapping[str, Maker],
        mends: Mapping[str, Mend],
    ):
        super().__init__(special)
        self.makers = makers
        self.mends = mends
        self._groups: dict[str, dict[str, Read]] = {}

    def __missing__(self, rule: str) -> Read:
        """Make the reader of a rule, or of a terminal alone."""
        made = self._plain(rule)
        if rule in self.mends:
            made = _mended(self.mends[rule], made)
        self[rule] = made
        return made

    def _plain(self, rule: str) -> Read:
        """Return the reader of a rule made only from the grammar."""
        shape = RULES.get(rule, rule)
        if is_terminal(shape):
            return _wanted(rule, shape, terminal(rule))
        if is_word(shape):
            return _alone(self.makers.get(rule) or _named_like(rule))
        if shape[0] == "seq":
            return self._option(rule, shape)
        if is_list(shape):
            return self._named(shape) or self._list(rule, shape)
        return self._choice(rule)

    @cached_property
    def formulas(self) -> dict[str, Read]:
        """Return the readers of formulas by first word."""
        return self.group("formula")

    def group(self, rule: str) -> dict[str, Read]:
        """Return the readers of the lists in a group by first word."""
        found = self._groups.get(rule)
        if found is None:
            heads = rules_by_head(rule).items()
            found = {head: self[one] for head, one in heads if is_list(RULES[one])}
            self._groups[rule] = found
        return found

    def part(self, shape: Shape) -> OperandWanted:
        """Return the reader of a single operand of a shape."""
        if isinstance(shape, str):
            if is_word(shape):
                word = shape[1:-1]
                return OperandWanted(
                    one_word(word), lambda _, d: word.removeprefix(":"), True
                )
            if shape in _PLAIN:
                return self.part(RULES[shape])
            if is_rule(shape):
                return self._rule_part(shape)
            return terminal(shape)
        if shape[0] != "or":
            raise TypeError(f"no single operand has the shape {shape}")
        parts = [self.part(one) for one in shape[1:]]
        if "SYMBOL" in shape and "STRING" in shape:
            parts[shape.index("STRING") - 1] = OperandWanted(is_string, term, True)

        def read(ctx: Context, datum: Datum) -> Any:
            fitting = next((one for one in parts if one.fits(datum)), parts[-1])
            return fitting.read(ctx, datum)

        return OperandWanted(lambda d: any(one.fits(d) for one in parts), read, True)

    def _rule_part(self, rule: str) -> OperandWanted:
        known = frozenset(heads(rule))

        def late(ctx: Context, datum: Datum) -> Any:
            return self[rule](ctx, datum)  # made when needed: rules hold each other

        alone = is_list(RULES[rule]) and self._named(RULES[rule]) is not None
        read = self[rule] if alone else self.get(rule, late)
        if known and RULES[rule][0] == "list":
            return OperandWanted(lambda d: head_of(d) in known, read, True)
        return OperandWanted(lambda d: type(d) is List, read, False)

    def option(self, rule: str) -> OptionReader:
        """Return the reader of an option, with the number of its values."""
        shape = RULES[rule]
        if is_word(shape):
            return OptionReader(0, lambda ctx, datum: True)
        return OptionReader(len(shape) - 2, self[rule])

    def _option(self, rule: str, shape: Shape) -> Read:
        """Return the reader of an option with one value."""
        read = self._value(rule, shape[2])
        return lambda ctx, datum: read(ctx, datum.items[1])

    def _value(self, rule: str, shape: Shape) -> Read:
        """Return the reader of data at the position of a value of a shape."""
        if shape[0] == "list":
            return self._inner(rule, shape)
        if words_of_shape(shape) == _TRUTHS:
            return _truth(rule)
        return _wanted(rule, shape, self.part(shape))

    def _inner(self, rule: str, shape: Shape) -> Read:
        """Return the reader of a list of items of the same kind, without a head."""
        inner = shape[1][1]
        part = self.part(inner)
        one = _wanted(rule, inner, part)
        nested = is_list(RULES.get(next(leaves(inner)), ""))
        what = "a list of lists" if nested else GRAMMAR[rule].wanted or "a list"

        def read(ctx: Context, datum: Datum) -> tuple[Any, ...]:
            items = datum.items if isinstance(datum, List) else ()
            flat = nested and not any(
                isinstance(d, List) or part.fits(d) for d in items
            )
            flat = flat and bool(items)
            if flat or not isinstance(datum, List):
                found = "one list" if flat else kind_of(datum)
                message = f"expected {what} after `{heads(rule)[0]}`, not {found}"
                fix = ctx.wrap(datum, datum, "(", sure=False)
                ctx.report(_breaks(rule), message, datum, fix=fix)
                return ()
            return made(one(ctx, item) for item in items)

        return read

    def _choice(self, rule: str) -> Read:
        """Return the reader of a group of lists, selected by first word."""
        readers = self.group(rule)
        what = GRAMMAR[rule].wanted

        def read(ctx: Context, datum: Datum) -> Any:
            name = head_of(datum)
            if name is None or not isinstance(datum, List):
                message = f"expected {what}, not {kind_of(datum)}"
                plural = what.split(" ", 1)[1] + "s"
                help = f"{plural} begin with " + ", ".join(f"`{n}`" for n in readers)
                ctx.report(_breaks(rule), message, datum, help=help)
                return None
            if name in readers:
                return readers[name](ctx, datum)
            word = datum.items[0]
            assert isinstance(word, Symbol)
            ctx.unknown("unknown-clause", what.split(" ", 1)[1], word, readers)
            return None

        return read

    def _named(self, shape: Shape) -> Read | None:
        """Return the reader of a name with arguments, or None for other rules."""
        name, args = (shape[1], shape[2]) if len(shape) == 3 else ("", "")
        if name in NAMED and args[0] == "*" and args[1] in REFUSED:
            return with_arguments(str(name), str(args[1]))
        return None

    def _list(self, rule: str, shape: Shape) -> Read:
        """Return the reader of a list with a head, a choice of heads, or none."""
        told, inner = bool(GRAMMAR[rule].whole), shape[1 + bool(heads(rule)) :]
        if inner[-1][0] == "*" and str(inner[-1][1]).startswith("_"):
            return self._with_parts(rule, inner[:-1], str(inner[-1][1]))
        operands = [self._operand(one, told) for one in inner]
        return _varied(rule, operands, self.makers.get(rule) or _named_like(rule))

    def _with_parts(self, rule: str, operands: Sequence[Shape], group: str) -> Read:
        """Return the reader of a list with operands, then options or lists of a group.

        Options fill the fields of their names, lists the field after the operands.
        """
        kind: Any = schema.kind_of_rule(rule)
        reads = [self.part(one).read for one in operands]
        own, words = heads(rule)[0], tuple(rules_by_head(group))
        wanted = GRAMMAR[next(leaves(operands[0]))].wanted.partition(" ")[2]

        def rest(ctx: Context, data: Sequence[Datum]) -> dict[str, Any]:
            if words[0].startswith(":"):
                options = read_options(ctx, data, f"`{own}`", group)
                return filled(slots(str(schema.rule_of_kind(kind)), kind), options)
            known, found = self.group(group), clauses(ctx, data, own, words)
            field = kind.__struct_fields__[len(reads)]
            return {field: made(known[word](ctx, one) for word, one in found)}

        def read(ctx: Context, datum: List) -> Any:
            data = datum.items[1:]
            if len(data) < len(reads):
                ctx.report(_breaks(rule), f"`{own}` requires a {wanted}", datum)
                return None
            values = [one(ctx, item) for one, item in zip(reads, data, strict=False)]
            if any(value is None for value in values):
                return None
            fields = rest(ctx, data[len(reads) :])
            return kind(*values, span=ctx.span(datum), **fields)

        return read

    def _operand(self, shape: Shape, told: bool) -> Operand:
        """Return the reader of operands; `told` if their list reports their faults."""
        least, most = _COUNTS.get(str(shape[0]), (1, 1))
        part = self.part(shape if least == most else shape[1])
        return Operand(least, most, replace(part, strict=part.strict or told))


_PLAIN = [rule for rule in RULES if all(map(is_terminal, leaves(RULES[rule])))]
"""The rules with only terminals, which are used like a terminal."""

_COUNTS = {"?": (0, 1), "*": (0, None), "+": (1, None)}


def _named_like(rule: str) -> Maker:
    """Return the function that makes the node of a rule, with operands as fields.

    The head is the first field if it distinguishes nodes of the kind. If the rule has
    no node, the result is the first operand.
    """
    kind: Any = schema.kind_of_rule(rule)
    if kind is None:
        return lambda head, values, span: values[0]
    if kind in schema.NAMED_BY and "args" in kind.__struct_fields__:
        return lambda head, values, span: kind(head, tuple(values), span=span)
    if kind in schema.NAMED_BY or len(heads(rule)) > 1:
        return lambda head, values, span: kind(head, *values, span=span)
    return lambda head, values, span: kind(*values, span=span)


def _alone(make: Maker) -> Read:
    """Return the reader of a word that is a complete form."""
    return lambda ctx, datum: make(ctx.text(datum).lower(), (), ctx.span(datum))


def _own_word(rule: str) -> str:
    """Return the first word of a rule, independent of the text; empty if several."""
    known = heads(rule)
    return known[0] if len(known) == 1 else ""


def _mended(mend: Mend, read: Read) -> Read:
    """Return the reader of a list that is corrected before it is read."""

    def mended(ctx: Context, datum: List) -> Any:
        meant = mend(ctx, datum)
        return None if meant is None else read(ctx, meant)

    return mended


def _varied(rule: str, operands: Sequence[Operand], make: Maker) -> Read:
    """Return the reader of a list with optional and repeated operands."""
    own, headed = _own_word(rule), bool(heads(rule))

    def read(ctx: Context, datum: Datum) -> Any:
        rows = None
        if type(datum) is List:
            rows = _shared_out(datum.items[headed:], operands)
        if rows is None:
            ctx.wrong(rule, datum)
            return None
        values: list[Any] = []
        for one, row in zip(operands, rows, strict=True):
            found = [one.part.read(ctx, item) for item in row]
            if one.most is None:
                values.append(made(found))
            elif any(value is None for value in found):
                return None
            else:
                values.append(found[0] if found else None)
        return make(own or head_of(datum) or "", values, ctx.span(datum))

    return read


def _shared_out(
    items: Sequence[Datum], operands: Sequence[Operand]
) -> list[Sequence[Datum]] | None:
    """Return the items of a list for each of its operands; None if items do not fit.

    Each operand takes all fitting items, except the items that later operands need.
    """
    rows: list[Sequence[Datum]] = []
    at, needed = 0, sum(one.least for one in operands)
    for one in operands:
        needed -= one.least
        begun, end = at, len(items) - needed
        while at < end and (one.most is None or at - begun < one.most):
            if one.part.strict and not one.part.fits(items[at]):
                break
            at += 1
        if at - begun < one.least:
            return None
        rows.append(items[begun:at])
    return rows if at == len(items) else None


def _truth(rule: str) -> Read:
    """Return the reader of `true` or `false`."""

    def read(ctx: Context, datum: Datum) -> bool | None:
        if isinstance(datum, Symbol) and datum.name in _TRUTHS:
            return datum.name == "true"
        ctx.report(_breaks(rule), "expected `true` or `false`", datum)
        return None

    return read


_TRUTHS = ("true", "false")


def _wanted(rule: str, shape: Shape, part: OperandWanted) -> Read:
    """Return the reader of a datum as an operand; it reports data that do not fit."""
    if not part.strict:
        return part.read
    leaf = next(leaves(shape))
    what = (leaf in GRAMMAR and GRAMMAR[leaf].wanted) or "a name"

    def read(ctx: Context, datum: Datum) -> Any:
        if part.fits(datum):
            return part.read(ctx, datum)
        if rule in GRAMMAR and GRAMMAR[rule].wrong:
            ctx.wrong(rule, datum)
            return None
        message = f"expected {what}, not {kind_of(datum)}"
        ctx.report(_breaks(rule), message, datum)
        return None

    return read


def made(found: Iterable[Any]) -> tuple[Any, ...]:
    """Return the nodes in `found` that could be read, dropping None."""
    return tuple([one for one in found if one is not None])
