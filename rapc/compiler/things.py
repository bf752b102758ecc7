"""What a method asks for before it starts: things it uses and things it claims.

What its request or its skills use is said where the primitive or the skill is declared;
the terms of the request stand for the variables of the declaration.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rapc.compiler.compiler import Compiler, RequestPlan
from rapc.ir import nodes


class ThingPlan:
    """A thing to be filled in; `used` by the request itself, or else claimed."""

    __slots__ = ("plan", "used")

    def __init__(self, plan: RequestPlan, used: bool) -> None:
        self.plan = plan
        self.used = used


def things_of(compiler: Compiler, method: nodes.Method) -> tuple[ThingPlan, ...]:
    """Return what `method` asks for: what its request uses, then what it claims."""
    found = [(thing, True) for thing in _used(compiler, method)]
    found += [(thing, False) for thing in method.claims]
    return tuple(
        [
            ThingPlan(compiler.assertion(one, "use" if used else "claim"), used)
            for one, used in found
        ]
    )


def _used(compiler: Compiler, method: nodes.Method) -> Iterator[nodes.Thing]:
    """Yield what the request or the skills of a method use, as they are declared."""
    for asked in _asked(method):
        yield from used_by(compiler, asked)


def used_by(compiler: Compiler, asked: nodes.Pattern) -> Iterator[nodes.Thing]:
    """Yield what a request or a skill uses, as it is declared."""
    declared: nodes.DeclarePrimitive | nodes.DeclareSkill | None
    if isinstance(asked, nodes.Skill):
        declared = compiler.library.skills.get(asked.name)
    else:
        declared = compiler.library.primitives.get(asked.name)
    if declared is None:
        return
    names = [arg.variable.name for arg in declared.args]
    given = dict(zip(names, asked.args, strict=False))
    for thing in declared.uses:
        args = [_filled_in(arg, given) for arg in thing.args]
        yield nodes.Thing(thing.name, tuple(args), thing.span)


def _asked(method: nodes.Method) -> tuple[nodes.Pattern, ...]:
    """Return what a method asks of the world: a request, or skills."""
    if isinstance(method.body, nodes.Primitive):
        return (method.body.request,)
    if isinstance(method.body, nodes.Skills):
        return method.body.enable
    return method.skills


def _filled_in(term: nodes.Term, given: Mapping[str, nodes.Term]) -> nodes.Term:
    """Return `term` with terms in the place of variables; terms nest a few levels."""
    if isinstance(term, nodes.Var):
        return given.get(term.name, term)
    if isinstance(term, nodes.Call):
        args: Sequence[nodes.Term] = [_filled_in(arg, given) for arg in term.args]
        return nodes.Call(term.function, tuple(args), term.span)
    return term
