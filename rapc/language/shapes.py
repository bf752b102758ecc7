"""Productions with their shapes, the entries of the table in `grammar.py`.

A shape is a string or a tuple. A string is a word in double quotes (`'"and"'`), the
name of a terminal (`TAG`) or of a rule (`goal`). A tuple begins with its operator:

- `("list", a, b)`: a list of a, then b;
- `("seq", a, b)`: a, then b, in the list around the sequence;
- `("or", a, b)`: a or b;
- `("?", a)`, `("*", a)`, `("+", a)`: an optional a, any number of a, at least one a.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import msgspec

Shape = str | tuple["Shape", ...]


class Production(msgspec.Struct, frozen=True):
    """A rule or terminal of the grammar, with its annotations."""

    #: The shape; of a terminal, its name.
    shape: Shape
    #: The purpose of a list of this kind, as a phrase without a full stop.
    says: str = ""
    #: The words for the operands in findings: "`believe` takes ...".
    takes: str = ""
    #: The words for an operand of this kind in findings: "a time".
    wanted: str = ""
    #: The rule of the checker for an invalid datum.
    breaks: str = "malformed-clause"
    #: The message about an invalid datum; `{kind}` is the datum with its article.
    wrong: str = ""
    #: The help of the finding.
    help: str = ""
    #: The message about a declaration, `{name}`, without this operand.
    missing: str = ""
    #: Not empty if the message applies also to an operand that is not a list.
    whole: str = ""
    #: The rule as an operand in tables and messages.
    short: str = ""
    #: A remark for a page that has only a table.
    more: str = ""
    #: The pages about the rule, as links from docs/language.
    pages: tuple[str, ...] = ()
    #: Words that printed programs have in place of the head.
    slips: tuple[str, ...] = ()


def is_word(shape: Shape) -> bool:
    """Return whether a shape is a word."""
    return isinstance(shape, str) and shape[0] == '"'


def is_list(shape: Shape) -> bool:
    """Return whether a shape is a list."""
    return isinstance(shape, tuple) and shape[0] == "list"


def is_terminal(shape: Shape) -> bool:
    """Return whether a shape is the name of a terminal."""
    return isinstance(shape, str) and shape.isupper()


def is_rule(shape: Shape) -> bool:
    """Return whether a shape is the name of a rule."""
    return isinstance(shape, str) and not is_word(shape) and not shape.isupper()


def leaves(shape: Shape) -> Iterator[str]:
    """Return the words and names in a shape, in order; rules are not entered."""
    if isinstance(shape, str):
        return iter((shape,))
    return chain.from_iterable(map(leaves, shape[1:]))
