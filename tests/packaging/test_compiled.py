"""The wheel with compiled modules: it is one, and its runs are those of the plain one.

Built as CONTRIBUTING.md says. The reference interpreter says what a run has to be; it
is plain Python here as everywhere.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.xdist_group("wheel"),
    pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler"),
]


def _run(command: list[str], folder: Path, **more: str) -> str:
    """What a command prints, run away from the checkout; it must succeed."""
    keep = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(
        command,
        cwd=folder,
        env={**keep, **more},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The Python of an environment with the compiled wheel in it."""
    folder = tmp_path_factory.mktemp("compiled")
    build = [sys.executable, "-m", "build", "--outdir", str(folder), str(CHECKOUT)]
    _run(build, folder, HATCH_BUILD_HOOK_ENABLE_MYPYC="1")
    _run([sys.executable, "-m", "venv", "venv"], folder)
    [wheel] = folder.glob("*.whl")
    found = str(folder / "venv" / "bin" / "python")
    _run([found, "-m", "pip", "install", "-q", str(wheel)], folder)
    return found


def test_what_a_cycle_goes_through_is_compiled(python: str, tmp_path: Path) -> None:
    """Every module that pyproject.toml lists, and a cycle among them."""
    config = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
    hook = config["tool"]["hatch"]["build"]["targets"]["wheel"]["hooks"]["mypyc"]
    names = [path.removesuffix(".py").replace("/", ".") for path in hook["include"]]
    assert "rapc.runtime.tasks.cycle" in names
    code = (
        "import sys; from importlib import import_module; "
        "print(*{import_module(name).__file__.rpartition('.')[2] "
        "for name in sys.argv[1:]})"
    )
    ending = "pyd" if os.name == "nt" else "so"
    assert _run([python, "-c", code, *names], tmp_path).strip() == ending


def test_compiled_and_reference_interpreter_agree(python: str, tmp_path: Path) -> None:
    shutil.copytree(CHECKOUT / "tests" / "reference", tmp_path / "tests" / "reference")
    (tmp_path / "tests" / "__init__.py").touch()
    compare = ["-m", "tests.reference.compare", "--seeds", "300"]
    assert "\n0 of 300 seeds disagree" in "\n" + _run([python, *compare], tmp_path)
