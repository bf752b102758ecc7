"""Which variables lack a value because of another slip, which is told of already.

A fact that stands where a value is computed binds nothing, though it was meant to; so
does a step that names no outputs, or a word that has lost its question mark. What its
variables lack then is no finding of its own.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX, NameUse
from rapc.analysis.named import MISUSES
from rapc.analysis.passes.bindings import Missing
from rapc.analysis.passes.constants import ANALYZER as CONSTANTS
from rapc.analysis.passes.outputs import ANALYZER as OUTPUTS
from rapc.ir import nodes
from rapc.ir.walk import subterms


class Explained(msgspec.Struct, frozen=True):
    """What other findings explain."""

    #: By the `id` of a form: the variables that something else was to bind.
    names: Mapping[int, set[str]]
    #: The `id` of each form with a step that names no outputs, or the wrong ones.
    without_outputs: set[int]
    #: The `id` of each `?` beside or in a fact that stands where a value is computed.
    anonymous: set[int]

    def explains(self, form: int, one: Missing, *, bound: bool) -> bool:
        """Whether what a variable lacks is due to another slip in its form.

        Args:
            form: the `id` of the form.
            one: the variable, and where it stands.
            bound: whether something else in the form binds it.
        """
        if one.variable.name in self.names.get(form, ()):
            return True
        lacks = form in self.without_outputs and one.step is not None
        return lacks and not bound


def _run(run: Pass) -> Explained:
    names: dict[int, set[str]] = {}
    without: set[int] = run.result(OUTPUTS).copy()
    anonymous: set[int] = set()
    for form, name in run.result(CONSTANTS):
        names.setdefault(form, set()).add(name)
    computed: set[int] = set()
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
                without.add(id(used.owner))
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
    return Explained(names, without, anonymous)


def _variables(used: NameUse) -> list[nodes.Var]:
    """The variables in the arguments of a name."""
    found = [one for term in used.node.args for one in subterms(term)]
    return [one for one in found if isinstance(one, nodes.Var)]


EXPLAINED = Analyzer(
    name="explained",
    doc="Gathers the variables that lack a value because of another slip.",
    run=_run,
    needs=(INDEX, MISUSES, CONSTANTS, OUTPUTS),
)
