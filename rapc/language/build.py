"""Generator of `grammar.py` from `rap.lark`, and the lark parser of `rap.lark`.

`python -m rapc.language.build` writes `grammar.py`; a test compares both files. Only
this module and `rapc.language.complete` use lark. The parser of files imports neither.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark, Token, Tree
from lark.lexer import PatternRE, PatternStr, TerminalDef
from lark.load_grammar import load_grammar
from msgspec.structs import replace

from rapc.language.shapes import Production, Shape, leaves

FOLDER = Path(__file__).parent
SOURCE = FOLDER / "rap.lark"

START = "start"
"""The start rule for whole programs."""

STARTS = (START, "data", "formula", "proposition", "goal", "term")
"""The start rules of the parser."""

MARKS = ("(", ")", "#|", "|#")
"""Quoted texts of the grammar that are not words."""

HEAD = '''\
"""The grammar of `rap.lark` as plain data: terminals, and all that is said of rules.

Written by `python -m rapc.language.build`; a test holds it against `rap.lark`. How to
read shapes is said in `rapc.language.shapes`.
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc.language.shapes import Production, Shape

# fmt: off
# ruff: noqa: E501
'''


@cache
def parser(*, positions: bool = True) -> Lark:
    """Return the LALR parser of whole programs (`start`) and of bare data (`data`).

    Only the rule `data` accepts `#| |#` comments; blank the comments for `start`.
    Without `positions` in its trees the parser takes a third less time.
    """
    return Lark(
        SOURCE.read_text(encoding="utf-8"),
        parser="lalr",
        start=list(STARTS),
        edit_terminals=whole_word,
        propagate_positions=positions,
    )


def whole_word(terminal: TerminalDef) -> None:
    """Make a quoted word of the grammar match a whole symbol or keyword in any case."""
    pattern = terminal.pattern
    if isinstance(pattern, PatternStr) and pattern.value not in MARKS:
        end = terminals()["_END"]
        terminal.pattern = PatternRE(f"(?i:{re.escape(pattern.value)}){end}")
        terminal.priority = 5


@cache
def words() -> Mapping[str, str]:
    """Return the quoted words of the grammar by their names in lark."""
    grammar = parser(positions=False).grammar
    compiled, _, _ = grammar.compile(list(STARTS), "*")
    return {
        one.name: one.pattern.value
        for one in compiled
        if isinstance(one.pattern, PatternStr) and one.pattern.value not in MARKS
    }


@cache
def terminals() -> Mapping[str, str]:
    """Return the regular expression of each named terminal, compiled by lark."""
    grammar = _read()
    compiled, _, _ = grammar.compile(list(STARTS), "*")
    found = {one.name: one.pattern.to_regexp() for one in compiled}
    named = [name for name, _ in grammar.term_defs if name in found]
    return {str(name): found[name] for name in named}


def grammar() -> dict[str, Production]:
    """Return the productions without bare data, in the order of the grammar."""
    shapes = {str(name): _shape(tree) for name, _, tree, _ in _read().rule_defs}
    said = _said()
    found = {}
    for name in (*shapes, *(name for name in said if name not in shapes)):
        if name not in _OF_DATA:
            found[name] = Production(shapes.get(name, name), **said.get(name, {}))
    for group in [one for one in found.values() if one.breaks != _BREAKS]:
        if group.shape[0] == "or":
            for rule in filter(found.__contains__, leaves(group.shape)):
                if found[rule].breaks == _BREAKS:
                    found[rule] = replace(found[rule], breaks=group.breaks)
    return found


_OF_DATA = ("data", "list", "_datum", "_block", "_inner")
_BREAKS = Production("").breaks


def _said() -> dict[str, dict[str, Any]]:
    """Return the annotations (lines with `//:`) by the rule or terminal below them."""
    found: dict[str, dict[str, Any]] = {}
    rows: dict[str, Any] = {}
    for line in SOURCE.read_text(encoding="utf-8").splitlines():
        key, _, value = line.removeprefix("//: ").partition(": ")
        if line.startswith("//: "):
            if key == "page":
                rows["pages"] = (*rows.get("pages", ()), value)
            elif key in Production.__struct_fields__:
                rows[key] = tuple(value.split()) if key == "slips" else value
            else:
                rows["says"] = line.removeprefix("//: ")
        elif rows and (name := re.match(r"\w+", line)):
            found[name[0]], rows = rows, {}
    return found


def _read() -> Any:
    """Return lark's grammar before the expansion of repetitions; it has no types."""
    load: Any = load_grammar
    grammar, _ = load(SOURCE.read_text(encoding="utf-8"), SOURCE.name, [], False)
    return grammar


def _shape(tree: Tree[Token] | Token) -> Shape:
    """Return the shape of an expression in lark's syntax tree of a grammar."""
    if isinstance(tree, Token):
        raise TypeError(f"an expression is wanted, not {tree!r}")
    kind, children = tree.data, tree.children
    if kind == "expansions":
        options = [_shape(child) for child in children]
        return options[0] if len(options) == 1 else ("or", *options)
    if kind == "expansion":
        made = _lists([_shape(child) for child in children])
        return made[0] if len(made) == 1 else ("seq", *made)
    if kind == "maybe":
        return ("?", _shape(children[0]))
    if kind == "expr":
        return (str(children[1]), _shape(children[0]))
    (leaf,) = children
    if isinstance(leaf, Tree):
        (leaf,) = leaf.children
        return json.dumps(json.loads(str(leaf)))
    return str(getattr(leaf, "name"))  # noqa: B009  # lark has no types for it


def _lists(items: list[Shape]) -> list[Shape]:
    """Return the items of a sequence with each parenthesised part as a `list` item."""
    stack: list[list[Shape]] = [[]]
    for item in items:
        if item == '"("':
            stack.append([])
        elif item == '")"':
            inner = stack.pop()
            stack[-1].append(("list", *inner))
        else:
            stack[-1].append(item)
    (whole,) = stack
    return whole


def module() -> str:
    """Return the text of `grammar.py`."""
    named: dict[str, list[str]] = {}
    for name, pattern in terminals().items():
        named.setdefault(pattern, []).append(name)
    patterns = [
        f"    **dict.fromkeys({tuple(names)!r}, {json.dumps(pattern)}),"
        for pattern, names in named.items()
    ]
    rows = [f"    {json.dumps(k)}: {_row(v)}," for k, v in grammar().items()]
    return (
        f"{HEAD}TERMINALS: Mapping[str, str] = {{\n{_lines(patterns)}\n}}\n"
        '"""What lark makes of the grammar\'s terminals."""\n\n'
        f"GRAMMAR: Mapping[str, Production] = {{\n{_lines(rows)}\n}}\n"
        '"""The productions, and terminals of which something is said."""\n\n'
        "RULES: Mapping[str, Shape] = "
        "{k: v.shape for k, v in GRAMMAR.items() if k.islower()}\n"
        '"""The shape of each rule, in the order of the grammar."""\n'
    )


def _row(row: Production) -> str:
    said = [
        f", {field}={getattr(row, field)!r}"
        for field, usual in zip(_SAID, row.__struct_defaults__, strict=True)
        if getattr(row, field) != usual
    ]
    return f"Production({row.shape!r}{''.join(said)})"


_SAID = Production.__struct_fields__[1:]


def _lines(rows: list[str]) -> str:
    return "\n".join(rows)


if __name__ == "__main__":
    (FOLDER / "grammar.py").write_text(module(), encoding="utf-8")
