"""Each field of each state class stands in the table by which it is saved."""

from __future__ import annotations

import pkgutil
import random
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import msgspec
import pytest

from rapc.runtime import memory, state
from rapc.runtime.fields import LEFT_OUT
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.saving.codecs import codec
from rapc.runtime.state.agenda import Agenda
from tests.runtime.helpers import Play

WITHOUT_STATE = {
    "Candidates",
    "ItemEvents",
    "MemoryBatch",
    "MemoryView",
    "SameKnown",
    "Score",
    "Scores",
    "Tables",
}
"""Classes of memory that hold nothing of a run but what others have."""


def _modules(package: Any) -> Iterator[Any]:
    for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        yield import_module(found.name)


def _classes() -> list[Any]:
    return [
        one
        for package in (state, memory)
        for module in _modules(package)
        for name, one in vars(module).items()
        if isinstance(one, type)
        and one.__module__ == module.__name__
        and not name.startswith("_")
        and not issubclass(one, tuple | msgspec.Struct)
        and not getattr(one, "_is_protocol", False)
        and name not in WITHOUT_STATE
    ]


def _fields(kind: Any) -> set[str]:
    """Return the names of the attributes of a class's objects."""
    if kind is Agenda:
        return set(vars(Agenda(random.Random())))
    if kind is MemoryAccess:
        run = Play("(define-rap (go) (method (primitive (slow a))))").interpreter
        return set(vars(run.access))
    return {name for one in kind.__mro__ for name in getattr(one, "__slots__", ())}


@pytest.mark.parametrize("kind", _classes())
def test_fields_of_state_class_are_saved_or_left_out(kind: Any) -> None:
    assert set(kind.FIELDS) == _fields(kind)
    for saved_as in kind.FIELDS.values():
        assert saved_as == LEFT_OUT or codec(saved_as).saved is not None


def test_field_of_unknown_type_has_no_codec() -> None:
    with pytest.raises(TypeError, match="no codec for"):
        codec(random.Random)
