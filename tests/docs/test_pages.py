"""Each page of the manual does as it shows (`tests.docs.follow`).

The folder of a page is empty, except that `examples` and `stdlib` are those of the
repository if commands, programs or configurations of the page name them. An untitled
`rap` block has no error of form.
"""

from __future__ import annotations

import shlex
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import pytest

from rapc.base.source import SourceFile
from rapc.cli.main import cli
from rapc.parser.formatter import formatted
from rapc.repl.draw import draw
from rapc.repl.shell import Shell

from .follow import Session, follow
from .pages import CHECKOUT, agrees, blocks, page

DOCS = CHECKOUT / "docs"
COLUMNS = 76
"""The columns of a block of code on the site, and of the terminal in pages."""

WIDE = frozenset(
    {
        "how-to/behaviour-trees",
        "how-to/ci",
        "index",
        "language/1-text",
        "language/2-queries",
        "language/8-things",
        "language/9-skills",
        "reference/cli",
    }
)
"""The pages with wider code, on a terminal of 100 columns."""

PAGES = sorted(
    path.relative_to(DOCS).with_suffix("").as_posix()
    for path in DOCS.rglob("*.md")
    if path.parent.name != "rules"
)


def started(command: str) -> Shell:
    """Start the session of a command `rapc repl ...`."""
    with mock.patch("rapc.cli.repl.run_script", return_value=True) as run:
        cli.main(shlex.split(command)[1:], standalone_mode=False)
    shell = run.call_args.args[0]
    assert isinstance(shell, Shell)
    return shell


def session(command: str, columns: int) -> Session:
    """Start a session that compares its answers with those of a page."""
    shell = started(command)

    def check(said: str, told: list[str]) -> None:
        drawn = draw(shell.answer(said), columns, color=False)
        printed = drawn.rstrip("\n").split("\n")
        assert agrees(_bare(printed), _bare(told)), f"rapc> {said}\n{drawn}"

    return check


def _bare(lines: list[str]) -> list[str]:
    return [line.strip() for line in lines]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder; modules that a page has written are forgotten at the end."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name, module in [*sys.modules.items()]:
        if str(getattr(module, "__file__", None)).startswith(str(tmp_path)):
            del sys.modules[name]


@pytest.mark.parametrize("name", PAGES)
def test_page_does_as_it_shows(name: str, folder: Path) -> None:
    text = page(name)
    if "exec:node" in text and shutil.which("node") is None:
        pytest.skip("the page runs node, which is missing")
    languages = ("console", "python", "toml")
    shown = "".join(b.text for b in blocks(text) if b.language in languages)
    for link in ("examples", "stdlib"):
        if f"{link}/" in shown:
            (folder / link).symlink_to(CHECKOUT / link)
    names: dict[str, object] = {"__name__": "page"}

    def python(code: str) -> None:
        exec(compile(code, name, "exec"), names)  # noqa: S102  # our own page

    columns = 100 if name in WIDE else COLUMNS
    follow(
        text,
        folder,
        Path(sys.executable).parent,
        lambda command: session(command, columns),
        python,
        columns,
    )


@pytest.mark.parametrize("name", PAGES)
def test_rap_on_a_page_has_no_error_of_form(name: str) -> None:
    for block in blocks(page(name), "rap"):
        if not block.name:
            assert formatted(SourceFile(name, block.text)).diagnostics == ()


@pytest.mark.parametrize("name", PAGES)
def test_code_fits_the_column_of_the_site(name: str) -> None:
    lines = [line for block in blocks(page(name)) for line in block.text.splitlines()]
    wide = [line for line in lines if len(line) > COLUMNS]
    assert wide == [] or name in WIDE


def test_lines_that_differ_do_not_agree() -> None:
    assert agrees(["a", "b", "c"], ["a", "...", "c"])
    assert agrees(["a"], ["a", "..."])
    assert not agrees(["a", "b"], ["a"])
    assert not agrees(["a", "x"], ["a", "...", "c"])
