"""What the table of `grammar.py` is made of: productions with their shapes.

A shape is a string or a tuple. A string is a word in double quotes (`'"and"'`), the
name of a terminal (`TAG`) or of a rule (`goal`). A tuple begins with what it does:

- `("list", a, b)`: a list that holds a, then b;
- `("seq", a, b)`: a, then b, in the list that holds the sequence;
- `("or", a, b)`: either;
- `("?", a)`, `("*", a)`, `("+", a)`: a if wanted, any number of a, one a or more.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import msgspec

Shape = str | tuple["Shape", ...]


class Production(msgspec.Struct, frozen=True):
    """A rule of the grammar, or a terminal, with all that is said of it."""

    #: The shape; of a terminal, its name.
    shape: Shape
    #: The purpose of a list of this kind, as a phrase without a full stop.
    says: str = ""
    #: The operands, as a finding names them: "`believe` takes ...".
    takes: str = ""
    #: One operand of this kind, as a finding names it: "a time".
    wanted: str = ""
    #: The rule of the checker that a datum breaks which does not fit.
    breaks: str = "malformed-clause"
    #: The message about such a datum; `{kind}` stands for it, with its article.
    wrong: str = ""
    #: The advice that goes with the message.
    help: str = ""
    #: The message about a declaration, `{name}`, without this operand.
    missing: str = ""
    #: Not empty if the message is about an operand that is no list, too.
    whole: str = ""
    #: The rule as an operand in tables and messages.
    short: str = ""
    #: A remark of a page that has a table and no text of its own.
    more: str = ""
    #: The pages about the rule, as links from docs/language.
    pages: tuple[str, ...] = ()
    #: Words that printed programs have in place of the head.
    slips: tuple[str, ...] = ()


def is_word(shape: Shape) -> bool:
    """Whether a shape is a word that stands as it is."""
    return isinstance(shape, str) and shape[0] == '"'


def is_list(shape: Shape) -> bool:
    """Whether a shape is that of a list."""
    return isinstance(shape, tuple) and shape[0] == "list"


def is_terminal(shape: Shape) -> bool:
    """Whether a shape is the name of a terminal."""
    return isinstance(shape, str) and shape.isupper()


def is_rule(shape: Shape) -> bool:
    """Whether a shape is the name of a rule."""
    return isinstance(shape, str) and not is_word(shape) and not shape.isupper()


def leaves(shape: Shape) -> Iterator[str]:
    """The words and names in a shape, in order; rules are not entered."""
    if isinstance(shape, str):
        return iter((shape,))
    return chain.from_iterable(map(leaves, shape[1:]))
