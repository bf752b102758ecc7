"""Write the terminals of the grammar as Python, so that reading a file needs no lark.

python -m tests.parser.terminals > rapc/language/terminals.py
"""

from __future__ import annotations

import json
from pathlib import Path

from lark import Lark

GRAMMAR = Path(__file__).parents[2] / "rapc" / "language" / "rap.lark"

TEXT = '''\
"""The terminals of `rap.lark` as regular expressions, by name.

Written by `python -m tests.parser.terminals`; a test holds it against the grammar.
"""

from __future__ import annotations

from collections.abc import Mapping

# fmt: off
# ruff: noqa: E501
TERMINALS: Mapping[str, str] = {{
{rows}
}}
"""What lark makes of the grammar's terminals."""
'''


def terminals() -> dict[str, str]:
    """The regular expression of each terminal, as lark understands the grammar."""
    grammar = Lark.open(str(GRAMMAR), parser=None, lexer="basic")
    return {one.name: one.pattern.to_regexp() for one in grammar.terminals}


def module() -> str:
    """The text of `rapc/language/terminals.py`."""
    rows = [f"    {json.dumps(k)}: {json.dumps(v)}," for k, v in terminals().items()]
    return TEXT.format(rows="\n".join(rows))


if __name__ == "__main__":
    print(module(), end="")
