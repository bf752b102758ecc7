"""What the shapes of `grammar.py` are made of.

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

Shape = str | tuple["Shape", ...]


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
