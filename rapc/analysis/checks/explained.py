"""Which variables lack a value because of another slip, which is told of already.

A fact that stands where a value is computed binds nothing, though it was meant to; so
does a step that names no outputs, or a word that has lost its question mark. What its
variables lack then is no finding of its own.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.checks.bindings import Missing
from rapc.analysis.checks.constants import CONSTANTS
from rapc.analysis.checks.outputs import OUTPUTS
from rapc.analysis.facts.index import INDEX, NameUse
from rapc.analysis.facts.names import MISUSES
from rapc.ir import nodes
from rapc.ir.walk import subterms


class Explained(msgspec.Struct, frozen=True):
    """What other findings explain."""

    #: By the `id` of a form: the variables that something else was to bind.
    names: Mapping[int, set[str]]
    #: By the `id` of a form: how many variables it lacks, for outputs or arguments of
    #: facts that are left out.
    lacking: Mapping[int, int]
    #: The `id` of each `?` beside or in a fact that stands where a value is computed.
    anonymous: set[int]

    def left(
        self, form: int, missing: Iterable[Missing], binds: Callable[[Missing], bool]
    ) -> list[Missing]:
        """Return what is missing for no other reason.

        Args:
            form: the `id` of the form.
            missing: the variables that lack a value in it.
            binds: whether something else in the form binds one of them.
        """
        known = self.names.get(form, set())
        rest = [one for one in missing if one.variable.name not in known]
        free = dict.fromkeys(one.variable.name for one in rest if not binds(one))
        due = set(list(free)[: self.lacking.get(form, 0)])
        return [one for one in rest if one.variable.name not in due or binds(one)]


def _run(run: Pass) -> Explained:
    names: dict[int, set[str]] = {}
    lacking: Counter[int] = Counter()
    for told in run.result(OUTPUTS).value:
        lacking[told] += 1
    anonymous: set[int] = set()
    for form, name in run.result(CONSTANTS).value:
        names.setdefault(form, set()).add(name)
    computed: set[int] = set()
    for used in run.result(INDEX).uses():
        short = used.use == "test" and run.signatures.relations.get(used.name)
        if short and not short.is_property and used.count + 1 == short.most:
            lacking[id(used.owner)] += 1
    for misuse in run.result(MISUSES).found:
        used = misuse.used
        if used.use == "computed" and misuse.fault.sort != "arguments":
            computed.add(id(used.node))
            found = _variables(used)
            names.setdefault(id(used.owner), set()).update(v.name for v in found)
            anonymous.update(id(v) for v in found if v.anonymous)
        elif used.use == "goal" and misuse.fault.sort == "arguments":
            rap = run.library.raps[used.name]
            if rap.outputs and not used.outputs:
                lacking[id(used.owner)] += len(rap.outputs)
                found = _variables(used)
                names.setdefault(id(used.owner), set()).update(v.name for v in found)
    for test in run.result(INDEX).of(nodes.Compare) if computed else ():
        for one, other in (
            (test.node.left, test.node.right),
            (test.node.right, test.node.left),
        ):
            if id(one) in computed and isinstance(other, nodes.Var):
                names.setdefault(id(test.owner), set()).add(other.name)
                anonymous.add(id(other))
    return Explained(names, lacking, anonymous)


def _variables(used: NameUse) -> list[nodes.Var]:
    """The variables in the arguments of a name."""
    found = [one for term in used.node.args for one in subterms(term)]
    return [one for one in found if isinstance(one, nodes.Var)]


EXPLAINED = Fact(_run)
"""Gathers the variables that lack a value because of another slip."""
