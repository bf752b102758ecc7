"""The language server in Neovim, with the configuration of `editors/neovim`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.lsp.programs import RAPS, WORLD

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("nvim") is None, reason="Neovim is not installed"),
]

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "editors" / "neovim" / "rap.lua"


def nvim(folder: Path, file: str, script: str) -> Any:
    """Open a file, run a Lua script, and return what it passes to `told`."""
    result = folder / "result.json"
    (folder / "script.lua").write_text(
        f"local function told(value) answer('{result}', value) end\n"
        f"local ok, problem = pcall(function()\n{script}\nend)\n"
        f"if not ok then told({{ problem = tostring(problem) }}) end\n"
        "vim.cmd('qa!')\n"
    )
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [
            *("nvim", "--headless", "--clean", "-i", "NONE", "-n"),
            *("-c", f"luafile {CONFIG}", "-c", f"luafile {HERE / 'neovim.lua'}"),
            *("-c", f"edit {file}", "-c", f"luafile {folder / 'script.lua'}"),
        ],
        check=False,
        cwd=folder,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert result.exists(), done.stderr
    told = json.loads(result.read_text())
    assert "problem" not in told, told
    return told


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "rapc.toml").write_text("")
    (tmp_path / "world.rap").write_text(WORLD)
    (tmp_path / "raps.rap").write_text(RAPS)
    return tmp_path


def test_findings_hover_and_definition(robot: Path) -> None:
    (robot / "raps.rap").write_text(RAPS.replace("go hall", "goo hall"))
    found = nvim(
        robot,
        "raps.rap",
        """
        settle(function() return vim.tbl_contains(codes(), "unknown-rap") end)
        local hover = ask("textDocument/hover", at("drive"))
        local place = ask("textDocument/definition", at("drive"))
        told({ codes = codes(), hover = hover.contents.value, place = place })
        """,
    )
    assert found["codes"] == ["unknown-rap"]
    assert "äöü 🤖" in found["hover"]
    assert found["place"][0]["uri"].endswith("world.rap")
