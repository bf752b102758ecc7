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


def neovim(
    folder: Path, rapc: Path, *commands: str, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run Neovim in a folder with the configuration.

    Args:
        folder: the folder.
        rapc: the folder with the command `rapc`.
        commands: the commands of Neovim.
        variables: variables of the environment.
    """
    arguments = [
        one for line in (f"luafile {CONFIG}", *commands) for one in ("-c", line)
    ]
    path = f"{rapc}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        [str(NVIM), "--headless", "--clean", "-i", "NONE", "-n", *arguments],
        check=False,
        cwd=folder,
        env={**os.environ, "PATH": path, **variables},
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What Neovim shows of each feature, in one session."""
    folder = project(tmp_path_factory.mktemp("robot"))
    rapc = Path(sys.executable).parent
    features = " ".join((*FEATURES, "agenda"))
    done = neovim(folder, rapc, f"luafile {HERE / 'neovim.lua'}", FEATURES=features)
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
    wait = f"lua vim.wait(60000, function() return {shown} end)"
    done = neovim(tmp_path, tmp_path, "edit go.rap", wait, "qa!")
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
