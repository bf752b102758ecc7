"""The index of a library: what stands at a place, and where names are used."""

from __future__ import annotations

import pytest

from rapc.analysis.facts.index import Index
from rapc.ir import nodes
from rapc.library.loader import load_text

TEXT = """\
(declare-memory-proposition at (?place))
(define-rap (go ?place)
  (succeed (at ?place))
  (method (task-net (t1 (go (home ?place))) (t2 (go hall)))))
(define-test goes
  (facts (at hall))
  (task (go hall))
  (expect (memory (not (at kitchen)))))
"""


@pytest.fixture
def index() -> Index:
    return Index(load_text(TEXT).library)


@pytest.mark.parametrize(
    ("before", "kind", "parent", "owner"),
    [
        ("(succeed (|at", nodes.Proposition, nodes.DefineRap, nodes.DefineRap),
        ("(succeed (at ?p|lace", nodes.Var, nodes.Proposition, nodes.DefineRap),
        ("(go (ho|me", nodes.Call, nodes.Goal, nodes.DefineRap),
        ("(t2 (go h|all", nodes.Const, nodes.Goal, nodes.DefineRap),
        ("(not (at k|itchen", nodes.Const, nodes.Proposition, nodes.DefineTest),
        ("define-t|est", nodes.DefineTest, nodes.DefineTest, nodes.DefineTest),
    ],
)
def test_the_innermost_node_at_a_place(
    index: Index, before: str, kind: type, parent: type, owner: type
) -> None:
    front, back = before.split("|")
    offset = TEXT.index(front + back) + len(front)
    found = index.at("<text>", offset)
    assert found is not None
    types = (type(found.node), type(found.parent), type(found.owner))
    assert types == (kind, parent, owner)


def test_nothing_stands_between_forms_or_in_other_files(index: Index) -> None:
    assert index.at("<text>", TEXT.index("\n(define-rap")) is None
    assert index.at("<text>", len(TEXT) + 5) is None
    assert index.at("other.rap", 3) is None


def test_uses_of_a_name_are_told_by_how_it_is_used(index: Index) -> None:
    def places(found: object) -> list[str]:
        assert isinstance(found, list | tuple)
        return [TEXT[one.span.start : one.span.end] for one in found]

    assert places(index.uses_of("goal", "go")) == [
        "(go (home ?place))",
        "(go hall)",
        "(go hall)",
    ]
    assert places(index.uses_of("asserted", "at")) == ["(at hall)"]
    assert places(index.uses_of("test", "at")) == ["(at ?place)", "(at kitchen)"]
    assert places(index.uses_of("computed", "home")) == ["(home ?place)"]
    assert index.uses_of("goal", "home") == ()
