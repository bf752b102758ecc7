"""The things that tasks of each RAP use, in the terms of its inputs [L 8].

A request uses the things of its primitive, and an enabled skill those of the skill. A
use is free if no method on the way to the request claims a thing of that name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.ir import nodes
from rapc.ir.walk import input_terms, steps
from rapc.library.library import Library


class Use(msgspec.Struct, frozen=True):
    """A thing that is used below, with `?` for unknown arguments."""

    thing: nodes.Thing
    #: Whether no method below claims the thing for the use.
    free: bool


class Things:
    """The things that the RAPs of a library use, themselves or in their descendants.

    Args:
        library: the library.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._below: dict[str, set[Use]] = {name: set() for name in library.raps}
        callers: dict[str, list[str]] = {}
        for rap in library.raps.values():
            for method in rap.methods:
                for step in steps(method):
                    callers.setdefault(step.goal.name, []).append(rap.name)
        waiting = list(library.raps)
        while waiting:
            name = waiting.pop()
            rap = library.raps[name]
            found = {one for method in rap.methods for one in self._exported(method)}
            given = {variable.name: variable for variable in rap.inputs}
            new = {_put_in(one, given) for one in found} - self._below[name]
            if new:
                self._below[name] |= new
                waiting += [by for by in callers.get(name, ()) if by not in waiting]

    def of(self, method: nodes.Method) -> Iterator[Use]:
        """Yield the uses below a method, in the terms of the method."""
        yield from self._own(method)
        for step in steps(method):
            rap = self._library.raps.get(step.goal.name)
            if rap is not None:
                terms = input_terms(rap, step.goal)
                for one in self._below[rap.name]:
                    yield _put_in(one, terms)

    def _exported(self, method: nodes.Method) -> Iterator[Use]:
        claimed = {thing.name for thing in method.claims}
        for one in self.of(method):
            yield Use(one.thing, one.free and one.thing.name not in claimed)

    def _own(self, method: nodes.Method) -> Iterator[Use]:
        """Yield the things of the requests and skills of a method itself."""
        library, body = self._library, method.body
        if isinstance(body, nodes.Primitive):
            form = library.primitives.get(body.request.name)
            if form is not None:
                yield from _declared(form, body.request.args)
        enabled = body.enable if isinstance(body, nodes.Skills) else ()
        for skill in (*method.skills, *enabled):
            declared = library.skills.get(skill.name)
            if declared is not None:
                yield from _declared(declared, skill.args)


def _declared(
    form: nodes.DeclarePrimitive | nodes.DeclareSkill, args: Iterable[nodes.Term]
) -> Iterator[Use]:
    terms = {a.variable.name: t for a, t in zip(form.args, args, strict=False)}
    for thing in form.uses:
        yield _put_in(Use(thing, True), terms)


def _put_in(use: Use, terms: Mapping[str, nodes.Term]) -> Use:
    """Return a use in other terms; a term that is not known becomes `?`."""
    args: list[nodes.Term] = []
    for term in use.thing.args:
        new = terms.get(term.name, _ANY) if isinstance(term, nodes.Var) else term
        args.append(new if isinstance(new, nodes.Var | nodes.Const) else _ANY)
    return Use(msgspec.structs.replace(use.thing, args=tuple(args)), use.free)


_ANY = nodes.Var("?")


def _run(run: Pass) -> Things:
    return Things(run.library)


THINGS = Fact(_run)
"""The things that RAPs use."""
