"""The language server in Emacs, with the configuration of `editors/emacs`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.lsp.programs import RAPS, TESTS, WORLD

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "editors" / "emacs" / "rap.el"


def _has_eglot() -> bool:
    if shutil.which("emacs") is None:
        return False
    start = "(progn (package-initialize) (require 'eglot))"
    command = ["emacs", "--batch", "--eval", start]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not _has_eglot(), reason="Emacs with Eglot is not installed"),
]


def emacs(folder: Path, file: str, script: str) -> Any:
    """Open a file, run a script, and return what it passes to `told`."""
    (folder / "rapc.toml").write_text("")
    (folder / "world.rap").write_text(WORLD)
    (folder / "raps.test.rap").write_text(TESTS)
    connect = "(apply #'eglot (eglot--guess-contact))"
    (folder / "script.el").write_text(f'(find-file "{file}")\n{connect}\n{script}')
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [
            *("emacs", "--batch", "-q", "--eval", "(package-initialize)"),
            *("-l", str(CONFIG), "-l", str(HERE / "emacs.el"), "-l", "script.el"),
        ],
        cwd=folder,
        env={**os.environ, "PATH": path, "HOME": str(folder)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    lines = [one for one in done.stdout.splitlines() if one.startswith("told: ")]
    assert lines, done.stdout + done.stderr
    return json.loads(lines[-1].removeprefix("told: "))


def test_findings_hover_and_definition(tmp_path: Path) -> None:
    (tmp_path / "raps.rap").write_text(RAPS.replace("go hall", "goo hall"))
    found, hover, file = emacs(
        tmp_path,
        "raps.rap",
        """
        (let ((found (settle #'findings)) hover)
          (from "drive")
          (setq hover (ask :textDocument/hover))
          (xref-find-definitions (xref-backend-identifier-at-point 'eglot))
          (told (vconcat found) (plist-get (plist-get hover :contents) :value)
                (file-name-nondirectory (buffer-file-name))))
        """,
    )
    assert "unknown RAP `goo`" in found[0]
    assert "äöü 🤖" in hover
    assert file == "world.rap"
