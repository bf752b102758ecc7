"""docs/how-to/embed.md names all that `import rapc` gives, and what it shows works."""

from __future__ import annotations

import contextlib
import inspect
import io
import re
from pathlib import Path
from types import ModuleType

import pytest

import rapc

CHECKOUT = Path(__file__).parents[2]
PAGE = (CHECKOUT / "docs" / "how-to" / "embed.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)


@pytest.mark.parametrize("name", rapc.__all__)
def test_every_public_name_is_there_told_of_and_on_the_page(name: str) -> None:
    found = getattr(rapc, name)
    assert name in dir(rapc)
    assert f"rapc.{name}" in PAGE or f"`{name}`" in PAGE
    if isinstance(found, type) or inspect.isroutine(found):
        assert found.__module__.startswith("rapc.")
    if not isinstance(found, str):
        assert inspect.getdoc(found)
        assert isinstance(found, ModuleType | type) or inspect.signature(found)


@pytest.mark.parametrize("name", rapc.world.__all__)
def test_every_name_for_authors_of_worlds_is_on_the_page(name: str) -> None:
    assert hasattr(rapc.world, name)
    assert f"`{name}`" in PAGE.split("## All names")[1]


def test_errors_have_one_base() -> None:
    errors = [getattr(rapc, name) for name in rapc.__all__ if name.endswith("Error")]
    assert len(errors) > 8
    assert all(issubclass(error, rapc.Error) for error in errors)


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'laod'"):
        rapc.laod  # noqa: B018  # type: ignore[attr-defined]


@pytest.mark.parametrize("kind", [rapc.Interpreter, rapc.CheckedLibrary])
def test_what_a_run_and_a_library_can_do_is_on_the_page(kind: type) -> None:
    names = [name for name in vars(kind) if not name.startswith("_")]
    assert [name for name in names if not re.search(rf"`(\w+\.)?{name}\b", PAGE)] == []


def test_the_page_runs_from_its_first_line_to_its_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(CHECKOUT)
    printed = io.StringIO()
    names: dict[str, object] = {"__name__": "page"}
    with contextlib.redirect_stdout(printed):
        for at, block in enumerate(BLOCKS):
            exec(compile(block, f"python.md block {at}", "exec"), names)  # noqa: S102
    lines = printed.getvalue().splitlines()
    assert lines[0].startswith("done ")
    assert lines[0].endswith(" True")
    assert "unknown predicate `location`" in "\n".join(lines)
    assert lines[-1].startswith("True [('location', 'box-a', 'attic')")
