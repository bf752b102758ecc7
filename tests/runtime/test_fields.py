"""Each field of each state class stands in the table by which it is saved."""

from __future__ import annotations

import pkgutil
import random
from importlib import import_module
from typing import Any

import pytest

from rapc.runtime import state
from rapc.runtime.fields import LEFT_OUT
from rapc.runtime.saving.codecs import codec
from rapc.runtime.state.agenda import Agenda


def _classes() -> list[Any]:
    names = [found.name for found in pkgutil.iter_modules(state.__path__)]
    modules = [import_module(f"{state.__name__}.{name}") for name in names]
    return [
        one
        for module in modules
        for name, one in vars(module).items()
        if isinstance(one, type)
        and one.__module__ == module.__name__
        and not name.startswith("_")
        and not issubclass(one, tuple)
    ]


@pytest.mark.parametrize("kind", _classes())
def test_fields_of_state_class_are_saved_or_left_out(kind: Any) -> None:
    slots = getattr(kind, "__slots__", None)
    fields = vars(Agenda(random.Random())) if slots is None else slots
    assert set(kind.FIELDS) == set(fields)
    for saved_as in kind.FIELDS.values():
        assert saved_as == LEFT_OUT or codec(saved_as).saved is not None


def test_field_of_unknown_type_has_no_codec() -> None:
    with pytest.raises(TypeError, match="nothing says how"):
        codec(random.Random)
