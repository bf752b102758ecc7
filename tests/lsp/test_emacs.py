"""All features of the language server in Emacs, with `editors/emacs`."""

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
    pytest.mark.xdist_group("emacs"),
]


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What Emacs shows of each feature, in one session."""
    folder = project(tmp_path_factory.mktemp("robot"))
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    more = {"PATH": path, "HOME": str(folder), "FEATURES": " ".join(FEATURES)}
    done = subprocess.run(
        [
            *("emacs", "--batch", "-q", "--eval", "(package-initialize)"),
            *("-l", str(CONFIG), "-l", str(HERE / "emacs.el")),
        ],
        check=False,
        cwd=folder,
        env={**os.environ, **more},
        capture_output=True,
        text=True,
        timeout=300,
    )
    result = folder / "result.json"
    assert result.exists(), done.stdout + done.stderr
    found = json.loads(result.read_text())
    assert "problem" not in found, found["problem"]
    return found


class TestEmacs(Features):
    """Eglot 1.9 shows no hierarchy of calls, folds, tokens, hints and lenses.

    The session sends the requests of these features itself.
    """

    def test_words_have_colours(self, shown: Any) -> None:
        assert shown["colours"]["tokens"] == 21
        assert shown["colours"]["faces"] == [
            "font-lock-keyword-face",
            "font-lock-function-name-face",
            "font-lock-variable-name-face",
            "font-lock-comment-face",
            "font-lock-string-face",
        ]
