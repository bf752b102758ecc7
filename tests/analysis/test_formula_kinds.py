"""What the fields of a kind of formula declare about its variables."""

from __future__ import annotations

import msgspec
import pytest

from rapc.analysis.facts.bindings import BindingWalker, Bound, Findings
from rapc.ir import nodes, schema


class Every(msgspec.Struct, frozen=True):
    """Each solution of the case has a solution of the claim: a kind for this test."""

    case: nodes.Closed
    claim: nodes.Closed


def test_closed_parts_are_one_scope(monkeypatch: pytest.MonkeyPatch) -> None:
    fields = schema._fields(Every)  # type: ignore[arg-type]
    monkeypatch.setitem(schema._FIELDS, Every, fields)
    x = nodes.Var("?x")
    case = nodes.Proposition("weight", (x,))
    claim = nodes.Compare("<", x, nodes.Var("?limit"))
    walker, bound = BindingWalker({}, {}, Findings()), Bound()
    assert walker.formula(Every(case, claim), bound)  # type: ignore[arg-type]
    assert [one.name for one in walker.findings.unbound] == ["?limit"]
    assert bound.names == set()


def test_formula_with_terms_has_no_parts_but_propositions() -> None:
    """The compiler writes such a formula as a whole: all its variables are bound."""
    for kind in schema.PARTS.keys() - schema.CONNECTIVES:
        for field in schema.PARTS[kind]:
            assert schema.declared(kind, field) == "Proposition", (kind, field)
