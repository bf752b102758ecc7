"""What the parts of a text hold where that is not just a field of its node.

`rapc.ir.printer` takes operands from the fields of a node in the order of its rule.
Here stand the nodes whose fields are otherwise, and options that tell of two fields.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rapc.base.values import Number
from rapc.ir import nodes
from rapc.language.heads import ARROW


def _index(node: nodes.DefineRap) -> Iterable[Any]:
    kinds = {one.variable: one for one in node.kinds}
    inputs, outputs = (
        [kinds.get(one.name, one) for one in row] for row in (node.inputs, node.outputs)
    )
    arrow = [ARROW] if outputs else []
    return ((node.name, *inputs, *arrow, *outputs),)


def _row_request(node: nodes.ScriptRow) -> Iterable[Any]:
    asked = node.request if node.kind == "request" else (node.kind, node.request)
    return (asked, node.result)


def _asked(one: nodes.Request | nodes.Skill) -> Any:
    """A request as it is, a skill as what is asked: that it be enabled."""
    return ("enable", one) if isinstance(one, nodes.Skill) else one


OPERANDS_OF: Mapping[type, Callable[[Any], Iterable[Any]]] = {
    nodes.SetTest: lambda node: node.args,
    nodes.HistoryTest: lambda node: node.args,
    nodes.For: lambda node: [one for one in (node.formula, node.tag) if one],
    nodes.ResourceChange: lambda node: (node.resource, node.amount),
    nodes.WaitFor: lambda node: (nodes.Signal(node.signal, node.args), node.mode),
    nodes.Step: lambda node: (
        *(node.tag, node.priority or None, node.goal),
        node.annotations,
    ),
    nodes.DefineRap: _index,
    nodes.DefineQuery: lambda node: ((node.name, *node.args), node.formula, node.doc),
    nodes.ResultEffects: lambda node: ((node.result, *node.effects),),
    nodes.EventRule: lambda node: (nodes.Signal(node.signal, node.args), node.rules),
    nodes.ScriptRow: _row_request,
    **dict.fromkeys(
        (nodes.Primitives, nodes.PrimitivesInclude),
        lambda node: ([_asked(one) for one in node.requests],),
    ),
    nodes.Never: lambda node: (_asked(node.request),),
}
"""The operands of nodes whose fields are not those of their rules."""


def _row_signals(row: nodes.ScriptRow) -> tuple[nodes.Signal | Number, ...]:
    """The signals of a row, each behind the wait for it if there is one."""
    waits = row.pauses or [0] * len(row.signals)
    told = zip(waits, row.signals, strict=True)
    return tuple([part for wait, one in told for part in (wait, one) if part])


HELD_BY: Mapping[str, Callable[[Any], Any]] = {"row_signals": _row_signals}
"""What options hold that is more than their field."""
