"""The declared effects (`:on`) that state every changed fact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rapc.base.values import Atom, Fact
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.signatures import Signatures

Effects = tuple[tuple[Fact, bool], ...]
"""Patterns of facts with the variables of the declaration; true: to be erased."""


def named_effects(
    form: nodes.DeclarePrimitive | nodes.DeclareDatum, signatures: Signatures
) -> Mapping[str, Effects]:
    """Return the effects that a declaration states completely, by result.

    The result of a datum is an empty text. Effects with `may`, or with a variable that
    is no argument, are not complete.
    """
    if isinstance(form, nodes.DeclareDatum):
        told = {} if form.on is None else {"": form.on}
    else:
        told = {one.result: one.effects for one in form.on}
    variables = {arg.variable.name for arg in form.args}
    found = {result: _named(told[result], variables, signatures) for result in told}
    return {result: named for result, named in found.items() if named is not None}


def complete_data(
    library: Library, signatures: Signatures | None = None
) -> frozenset[str]:
    """Return the data of a library that need no handler: `:on` states their effects."""
    known = Signatures.of(library) if signatures is None else signatures
    data = library.data.items()
    return frozenset(name for name, form in data if named_effects(form, known))


def _named(
    effects: Sequence[nodes.DeclaredEffect], variables: set[str], signatures: Signatures
) -> Effects | None:
    """Return the effects of a result, erased facts first; None if not complete."""
    named: list[tuple[Fact, bool]] = []
    for effect in effects:
        relation = signatures.relations.get(effect.pattern.name)
        if effect.possible or relation is None:
            return None
        parts: list[Atom] = [effect.pattern.name]
        for term in relation.full(effect.pattern.args):
            if isinstance(term, nodes.Const):
                parts.append(term.value)
            elif isinstance(term, nodes.Var) and term.name in variables:
                parts.append(term.name)
            else:
                return None
        named.append((tuple(parts), effect.negated))
    return tuple(sorted(named, key=lambda one: not one[1]))
