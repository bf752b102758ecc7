"""A map of nodes tells apart what is equal and stands at two places."""

from __future__ import annotations

import pytest

from rapc.ir.nodes import Const
from rapc.ir.schema import NodeMap


def test_equal_nodes_have_values_of_their_own() -> None:
    one, other = Const("x"), Const("x")
    found = NodeMap([(one, 1)])
    assert one == other
    assert one in found
    assert other not in found
    found[other] = 2
    assert [found[one], found[other], len(found)] == [1, 2, 2]
    assert [node is one for node in found] == [True, False]


def test_a_node_is_forgotten() -> None:
    one = Const("x")
    found = NodeMap([(one, 1)])
    del found[one]
    assert found.get(one) is None
    with pytest.raises(KeyError):
        del found[one]
