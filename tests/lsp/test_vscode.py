"""The extension for VS Code: its grammar, its package, and VS Code itself."""

from __future__ import annotations

import json
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from bench.browser import chromium
from bench.vscode import COURIER, VSCode, courier, extension, vscode
from rapc.analysis.check_files import check_files
from rapc.language.heads import FORMS, QUERIES
from tests.lsp.programs import PYTHON

FOLDER = Path(__file__).parents[2] / "editors" / "vscode"

MOST = 300_000
"""The number of bytes of the package."""


def test_grammar_has_the_words_of_the_language() -> None:
    """`docs/generate.py` writes the grammar."""
    written = (FOLDER / "rap.tmLanguage.json").read_text()
    for word in (*FORMS, *QUERIES):
        assert json.dumps(re.escape(word))[1:-1] in written


def test_manifest_names_the_files_of_the_extension() -> None:
    manifest = json.loads((FOLDER / "package.json").read_text())
    contributes = manifest["contributes"]
    (language,), (grammar,) = contributes["languages"], contributes["grammars"]
    (snippets,) = contributes["snippets"]
    for file in (language["configuration"], grammar["path"], snippets["path"]):
        json.loads((FOLDER / file).read_text())


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("npm") is None, reason="npm is not installed")
def test_package_is_built_from_the_registry(tmp_path: Path) -> None:
    assert extension(tmp_path).stat().st_size <= MOST


@pytest.mark.nightly
@pytest.mark.skipif(shutil.which("npm") is None, reason="npm is not installed")
@pytest.mark.skipif(chromium() is None, reason="Chromium is not installed")
def test_courier_is_mended_and_renamed_in_vs_code(tmp_path: Path) -> None:
    project = courier(tmp_path)
    raps, orders = project / "moving.rap", project / "orders.rap"
    before = raps.read_text()
    (project / "robot.py").write_text(PYTHON)
    with vscode(extension(tmp_path), project, tmp_path) as page:
        editor = VSCode(page)
        editor.slip()
        assert "help: did you mean `halt-for`?" in editor.hover()
        assert editor.fixes() == [
            "Write `halt-for`",
            "Define the RAP `halt-fr`",
            "Ignore unknown-rap here",
        ]
        editor.keys.press("Enter")
        editor.squiggle(present=False)
        editor.save()
        until(lambda: raps.read_text() == before)
        editor.go_to(9, 15)
        editor.rename("go-to")
        until(lambda: "(go-to " in orders.read_text())
        editor.save()
        until(lambda: "(go-to " in raps.read_text())
        editor.open("robot.py")
        editor.go_to(4, 6)
        editor.keys.press("F12")
        page.wait_for_selector(".tab.active:has-text('world.rap')")
    for file in COURIER.glob("*.rap"):
        renamed = file.read_text().replace("travel-to", "go-to")
        assert (project / file.name).read_text() == renamed
    assert not check_files([str(project)]).findings


def until(ready: Callable[[], bool]) -> None:
    """Wait until VS Code has written a file."""
    end = time.monotonic() + 30
    while not ready():
        assert time.monotonic() < end
        time.sleep(0.1)
