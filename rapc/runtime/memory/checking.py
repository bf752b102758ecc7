"""What a fact has to be to get into memory, and the one form in which it is kept.

Who may assert it, and what else changes with it, is for `rapc.runtime.memory.memory`.
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc.base.values import Atom, Fact, format_list, number
from rapc.errors import FactError
from rapc.language.atoms import is_atom, is_symbol
from rapc.library.signature import Signature


def full_form(fact: Fact, relations: Mapping[str, Signature]) -> Fact:
    """A fact as it is kept: numbers in their one form, no value left out.

    Raises:
        FactError: if the declarations do not allow it.
    """
    relation = relations.get(fact[0]) if fact and type(fact[0]) is str else None
    if relation is None:
        raise _undeclared(fact)
    for part in fact:
        if type(part) is not int and not (type(part) is str and is_symbol(part)):
            fact = tuple([in_one_form(part) for part in fact])
            break
    given, most = len(fact) - 1, relation.most
    if given != most:
        wrong = relation.miscount(given)
        if wrong is not None:
            raise FactError(f"{wrong}: {format_list(fact)}")
        if most is not None:
            fact = (*fact, "true")
    return fact


def check_prefix(prefix: Fact, relations: Mapping[str, Signature]) -> None:
    """See that facts may begin so. Raises FactError."""
    if not prefix or type(prefix[0]) is not str or prefix[0] not in relations:
        raise _undeclared(prefix)
    for part in prefix:
        in_one_form(part)


def _undeclared(fact: Fact) -> FactError:
    return FactError(f"`{fact[0] if fact else ''}` is not declared")


def in_one_form(part: Atom) -> Atom:
    """Return a value as it is kept: a whole float as an integer.

    Raises:
        FactError: for what is no symbol, number or string of the language.
    """
    if is_atom(part):
        return number(part) if type(part) is float else part
    if type(part) is str:
        said = "is not a symbol; a text that is none is a `rapc.world.Text`"
        raise FactError(f"`{part:.60}` {said}")
    raise FactError(f"`{part}` is not a symbol, number or string")
