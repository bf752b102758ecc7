"""Make `grammar.py` of `rap.lark`, and a lark parser of it.

`python -m rapc.language.build` writes `grammar.py` anew; a test holds the two together.
This module and `rapc.language.complete` alone know lark; neither is imported by what
reads a file.
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
"""The rule that whole programs are examples of."""

STARTS = (START, "data", "formula", "proposition", "goal", "term")
"""The rules that a whole text may be an example of."""

MARKS = ("(", ")", "#|", "|#")
"""Quoted texts of the grammar that are no words."""

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
    """The LALR parser of whole programs (`start`) and of bare data (`data`).

    Comments of the `#| |#` kind are known to `data` alone; blank them for `start`.
    What its trees do not tell of `positions` it need not gather, a third of its work.
    """
    return Lark(
        SOURCE.read_text(encoding="utf-8"),
        parser="lalr",
        start=list(STARTS),
        edit_terminals=whole_word,
        propagate_positions=positions,
    )


def whole_word(terminal: TerminalDef) -> None:
    """Let a quoted word of the grammar match a whole symbol or keyword, in any case."""
    pattern = terminal.pattern
    if isinstance(pattern, PatternStr) and pattern.value not in MARKS:
        end = terminals()["_END"]
        terminal.pattern = PatternRE(f"(?i:{re.escape(pattern.value)}){end}")
        terminal.priority = 5


@cache
def words() -> Mapping[str, str]:
    """The quoted words of the grammar by the names that lark gives them."""
    grammar = parser(positions=False).grammar
    compiled, _, _ = grammar.compile(list(STARTS), "*")
    return {
        one.name: one.pattern.value
        for one in compiled
        if isinstance(one.pattern, PatternStr) and one.pattern.value not in MARKS
    }


@cache
def terminals() -> Mapping[str, str]:
    """Return the regular expression of each named terminal, as lark reads it."""
    grammar = _read()
    compiled, _, _ = grammar.compile(list(STARTS), "*")
    found = {one.name: one.pattern.to_regexp() for one in compiled}
    named = [name for name, _ in grammar.term_defs if name in found]
    return {str(name): found[name] for name in named}


def grammar() -> dict[str, Production]:
    """The productions but those of bare data, in the order of the grammar."""
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
    """What the lines with `//:` say of the rule or terminal below them."""
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
    """The grammar as lark reads it, with its repetitions; lark has no types for it."""
    load: Any = load_grammar
    grammar, _ = load(SOURCE.read_text(encoding="utf-8"), SOURCE.name, [], False)
    return grammar


def _shape(tree: Tree[Token] | Token) -> Shape:
    """The shape of an expression of lark's grammar of grammars."""
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
    """The items of a sequence with what stands in parentheses made one of them."""
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
    """The text of `grammar.py`."""
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
