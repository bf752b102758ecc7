"""Watches: the changes that can make a formula true or false, for monitors.

Each proposition in a formula becomes one `Watch`, as narrow as its bound arguments
allow. A change of memory that matches no watch cannot change the result [L 5].
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Atom
from rapc.ir import nodes
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures

ANYTHING: tuple[str, ...] = ("*",)
"""The key of watches that match every change of memory."""

WordKey = tuple[Atom, ...]

WatchKey = WordKey | Counter | SetResource
"""An index key of memory, a word for another change, or a resource."""


class Watch(msgspec.Struct, frozen=True):
    """A set of changes to listen to.

    For a proposition, `key` holds its name and `arguments` its arguments that are or
    may be known, each with its position: the first argument that is known when a task
    blocks narrows the key. A `resource` watch listens to the resource that its variable
    is bound to. `age` names the variable of a `believe` that returns an age.
    """

    key: WordKey = ()
    arguments: tuple[tuple[int, nodes.Const | nodes.Var], ...] = ()
    resource: str | None = None
    age: str | None = None

    def resolve(self, env: Mapping[str, Value]) -> WatchKey | None:
        """Return the key to listen to in an environment, or None."""
        if self.resource is not None:
            value = env.get(self.resource)
            return value if isinstance(value, Counter | SetResource) else None
        for at, argument in self.arguments:
            known = (
                argument.value
                if isinstance(argument, nodes.Const)
                else env.get(argument.name)
            )
            if known is not None and not isinstance(known, Counter | SetResource):
                return (*self.key, at, known)
        return self.key or None


def of_call(node: nodes.Call, signatures: Signatures) -> Iterator[Watch]:
    """Return the watches of a computed term, without its arguments."""
    if node.function in ("value", "size-of"):
        yield from of_resources(node.args)
    elif node.function in signatures.functions:
        yield from _function(node.function, node.args, signatures)


def of_proposition(node: nodes.Proposition, signatures: Signatures) -> Iterator[Watch]:
    """Return the watches of a fact, or of a function used as a test."""
    relation = signatures.relations.get(node.name)
    if relation is not None:
        yield from _fact(node, relation)
    elif node.name in signatures.functions:
        yield from _function(node.name, node.args, signatures)


def _fact(node: nodes.Proposition, relation: Signature) -> Iterator[Watch]:
    if relation.default_function is not None and relation.is_property:
        yield Watch(ANYTHING)
    args = dict(enumerate(relation.full(node.args), 1))
    if node.name == "location" and relation.is_property and _may_be_external(args[2]):
        yield Watch(("external",))
        del args[2]
    elif relation.is_property and _may_be_default(relation, args[len(args)]):
        del args[len(args)]
    known = tuple(
        (at, arg)
        for at, arg in args.items()
        if isinstance(arg, nodes.Const)
        or (isinstance(arg, nodes.Var) and not arg.anonymous)
    )
    yield Watch((node.name,), known)


def _may_be_external(place: nodes.Term) -> bool:
    return not isinstance(place, nodes.Const) or place.value == "external"


def _may_be_default(relation: Signature, value: nodes.Term) -> bool:
    """Return whether a property's default may apply: then any first value matters."""
    if relation.default_function is not None or not isinstance(value, nodes.Const):
        return True
    return value.value == relation.default


def _function(
    name: str, args: tuple[nodes.Term, ...], signatures: Signatures
) -> Iterator[Watch]:
    yield from of_resources(args)
    reads = signatures.functions[name].reads
    if reads is None:
        yield Watch(ANYTHING)
    else:
        yield from (Watch((predicate,)) for predicate in reads)


def of_resources(args: tuple[nodes.Term, ...]) -> Iterator[Watch]:
    """Return the watches of the resources among some arguments."""
    for arg in args:
        if isinstance(arg, nodes.Var):
            yield Watch(resource=arg.name)


def of_age(age: nodes.Term) -> Iterator[Watch]:
    """Return the watch of a `believe` that may return an age."""
    if isinstance(age, nodes.Var):
        yield Watch(age=age.name)
