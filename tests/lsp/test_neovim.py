"""All features of the language server in Neovim, with `editors/neovim`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.lsp.features import FEATURES, Features, project

NVIM = shutil.which("nvim")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(NVIM is None, reason="Neovim is not installed"),
    pytest.mark.xdist_group("neovim"),
]

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "editors" / "neovim" / "rap.lua"


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What Neovim shows of each feature, in one session."""
    folder = project(tmp_path_factory.mktemp("robot"))
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [
            *(str(NVIM), "--headless", "--clean", "-i", "NONE", "-n"),
            *("-c", f"luafile {CONFIG}", "-c", f"luafile {HERE / 'neovim.lua'}"),
        ],
        check=False,
        cwd=folder,
        env={**os.environ, "PATH": path, "FEATURES": " ".join((*FEATURES, "agenda"))},
        capture_output=True,
        text=True,
        timeout=300,
    )
    result = folder / "result.json"
    assert result.exists(), done.stderr
    found = json.loads(result.read_text())
    assert "problem" not in found, found["problem"]
    return found


def test_server_without_its_packages_names_the_extra(tmp_path: Path) -> None:
    program = tmp_path / "rapc"
    program.write_text("#!/bin/sh\nexit 2\n")
    program.chmod(0o700)
    shown = "string.find(vim.fn.execute('messages'), 'rapc%[lsp')"
    done = subprocess.run(
        [
            *(str(NVIM), "--headless", "--clean", "-i", "NONE", "-n"),
            *("-c", f"luafile {CONFIG}", "-c", "edit go.rap"),
            *("-c", f"lua vim.wait(60000, function() return {shown} end)", "-c", "qa!"),
        ],
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert "rapc lsp cannot start: pip install 'rapc[lsp]'" in done.stderr


class TestNeovim(Features):
    """Colours require Neovim 0.9, hints 0.10, folds 0.11: see `neovim.lua`."""

    def test_findings_have_pages_and_related_places(self, shown: Any) -> None:
        (*_, page, _), (*_, places) = shown["findings"]
        assert page.endswith("/rules/unknown-rap.md")
        assert places == 1

    def test_lens_runs_an_agenda(self, shown: Any) -> None:
        assert shown["agenda"] == {
            "titles": ["run in hallway"],
            "result": "agenda `day`: succeeded; "
            "Run over (done) at time 126.2 after 136 cycles.",
        }

    def test_words_have_colours(self, shown: Any) -> None:
        if isinstance(shown["colours"], int):
            assert shown["colours"] == 21
        else:
            assert shown["colours"] == {
                "define-rap": "keyword",
                "go ?place": "function",
                "?place": "variable",
                "; Go": "comment",
                '"world"': "string",
            }
