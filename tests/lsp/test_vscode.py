"""The extension for VS Code: its grammar and its package."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from rapc.language.heads import FORMS, QUERIES

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
    root = tmp_path / "rapc"
    folder = root / "editors" / "vscode"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("node_modules"))
    shutil.copy(FOLDER.parents[1] / "LICENSE", root)
    for command in (
        ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"],
        ["npm", "run", "package"],
        ["npm", "test"],
    ):
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    assert (folder / "rapc.vsix").stat().st_size <= MOST
