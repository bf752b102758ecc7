"""What surely comes of a goal: facts that hold, or do not, once it has been reached.

That is what its RAP declares as `effects`, asks for in `succeed` or, without that, what
all of its primitives do if they end `okay`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rapc.analysis.conjunction import Conjunction
from rapc.analysis.literals import Literal, literals
from rapc.ir import nodes
from rapc.ir.walk import steps, substitute, variable_names, variables
from rapc.library.library import Library
from rapc.library.signatures import Signatures


def fact_name(literal: Literal) -> str:
    """Return the name of the fact that a literal is about; nothing if about none."""
    fact = literal.formula
    return fact.name if isinstance(fact, nodes.Proposition) else ""


def done(library: Library, goal: nodes.Goal) -> list[Literal]:
    """Return what surely comes of a goal that is reached, in the caller's terms."""
    rap = library.raps.get(goal.name)
    if rap is None:
        return []
    found = [_effect(effect) for effect in rap.effects]
    found += [one for one in literals(rap.succeed) if fact_name(one)]
    if rap.succeed is None:
        found += _of_methods(library, rap)
    return put_in(
        found, {v.name: t for v, t in zip(rap.inputs, goal.args, strict=False)}
    )


def contradict(signatures: Signatures, one: Literal, other: Literal) -> bool:
    """Whether two literals never hold together, whatever their variables are."""
    given = variable_names(one.formula, other.formula)
    both = Conjunction(signatures.relations, given)
    both.add(one)
    return both.add(other) is not None


def _of_methods(library: Library, rap: nodes.DefineRap) -> list[Literal]:
    """Return what every method of a RAP brings about, if each is a primitive."""
    every: list[list[Literal]] = []
    for method in rap.methods:
        if not isinstance(method.body, nodes.Primitive):
            return []
        every.append(_of_request(library, method.body.request))
    return (
        [one for one in every[0] if all(one in row for row in every)] if every else []
    )


def _of_request(library: Library, request: nodes.Request) -> list[Literal]:
    """Return what a request surely does if it ends `okay`."""
    form = library.primitives.get(request.name)
    if form is None:
        return []
    given = dict(zip([a.variable.name for a in form.args], request.args, strict=False))
    okay = [on for on in form.on if on.result == "okay"]
    sure = [_effect(e) for on in okay for e in on.effects if not e.possible]
    return put_in(sure, given)


def _effect(effect: nodes.DeclaredEffect) -> Literal:
    return Literal(effect.pattern, not effect.negated)


def put_in(found: Sequence[Literal], given: Mapping[str, nodes.Term]) -> list[Literal]:
    """Return facts with terms for their variables, without those that keep some."""
    made = []
    for one in found:
        if all(variable.name in given for variable in variables(one.formula)):
            fact = substitute(one.formula, given)
            assert isinstance(fact, nodes.Proposition)
            if all(isinstance(arg, nodes.Var | nodes.Const) for arg in fact.args):
                made.append(Literal(fact, one.holds))
    return made


def done_by_method(library: Library, method: nodes.Method) -> list[Literal]:
    """Return what surely holds when a method has ended well.

    Of a task-net that is what its steps bring about, without facts of which more than
    one step has something to say, and without steps that may be ended before.
    """
    if isinstance(method.body, nodes.Primitive):
        return _of_request(library, method.body.request)
    whole = [step for step in steps(method) if not any(map(_ends, step.annotations))]
    found = [one for step in whole for one in done(library, step.goal)]
    often: dict[str, set[bool]] = {}
    for one in found:
        often.setdefault(fact_name(one), set()).add(one.holds)
    return [one for one in found if len(often[fact_name(one)]) == 1]


def _ends(note: nodes.Annotation) -> bool:
    """Whether an annotation may end its step well before its work is done."""
    if isinstance(note, nodes.WaitFor):
        return note.mode == "succeed"
    return isinstance(note, nodes.UntilStart | nodes.UntilEnd)
