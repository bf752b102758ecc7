"""The names that `import rapc` gives."""

from __future__ import annotations

import inspect
from types import ModuleType

import pytest

import rapc


@pytest.mark.parametrize("name", rapc.__all__)
def test_public_name_has_a_docstring_and_a_signature(name: str) -> None:
    found = getattr(rapc, name)
    assert name in dir(rapc)
    if isinstance(found, type) or inspect.isroutine(found):
        assert found.__module__.startswith("rapc.")
    if not isinstance(found, str):
        assert inspect.getdoc(found)
        assert isinstance(found, ModuleType | type) or inspect.signature(found)


@pytest.mark.parametrize("name", rapc.world.__all__)
def test_name_for_authors_of_worlds_exists(name: str) -> None:
    assert hasattr(rapc.world, name)


def test_errors_have_one_base() -> None:
    errors = [getattr(rapc, name) for name in rapc.__all__ if name.endswith("Error")]
    assert len(errors) > 8
    assert all(issubclass(error, rapc.Error) for error in errors)


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'laod'"):
        rapc.laod  # noqa: B018  # type: ignore[attr-defined]
