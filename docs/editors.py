"""Take pictures of real editors for how-to/editors, and write them into docs/figures.

    python docs/editors.py [neovim] [emacs] [vscode]      default: all

Needs tmux, Neovim 0.11 or later, Emacs with Eglot, and what `bench.vscode` needs; a
variable `NVIM` names another Neovim. The pictures are kept in the repository: take them
again after a change that they show.
"""

from __future__ import annotations

import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.text import Text

sys.path.insert(0, str(Path(__file__).parents[1]))

from bench.vscode import MISTAKE, VSCode, courier, extension, vscode

ROOT = Path(__file__).parents[1].resolve()
FIGURES = ROOT / "docs" / "figures"

COLUMNS, ROWS = 92, 22


def mistaken(project: Path) -> Path:
    """Make the mistake of the pictures in the courier; return the file."""
    file = project / "moving.rap"
    row, column = MISTAKE
    lines = file.read_text().splitlines(keepends=True)
    line = lines[row - 1]
    lines[row - 1] = line[: column - 1] + line[column:]
    file.write_text("".join(lines))
    return file


def terminal(
    name: str, command: list[str], project: Path, shown: str, *keys: str
) -> None:
    """Draw an editor in a terminal.

    Args:
        name: the name of the editor.
        command: the command that starts the editor.
        project: the working directory.
        shown: a text that the editor shows before the first key.
        keys: the keys, in the notation of tmux; the last one is a text that the editor
            shows then.
    """
    tmux = ("tmux", "-L", f"rapc-{name}-{os.getpid()}", "-f", os.devnull)

    def said(*args: str) -> str:
        done = subprocess.run(
            [*tmux, *args], check=True, capture_output=True, text=True, cwd=project
        )
        return done.stdout

    def settle(text: str) -> None:
        end = time.monotonic() + 60
        while text not in said("capture-pane", "-p"):
            if time.monotonic() > end:
                raise TimeoutError(said("capture-pane", "-p"))
            time.sleep(0.2)

    line = f"exec env COLORTERM=truecolor TERM=tmux-256color {shlex.join(command)}"
    said("new-session", "-d", "-x", str(COLUMNS), "-y", str(ROWS + 1), line)
    try:
        settle(shown)
        *pressed, last = keys
        for one in pressed:
            time.sleep(1)
            said("send-keys", one)
        settle(last)
        time.sleep(1)
        screen = said("capture-pane", "-e", "-N", "-p")
    finally:
        said("kill-server")
    console = Console(record=True, width=COLUMNS, file=io.StringIO(), highlight=False)
    console.print(Text.from_ansi(screen.rstrip("\n")), crop=True)
    drawn = console.export_svg(title=f"{name}: moving.rap", unique_id=f"editor-{name}")
    drawn = re.sub(r"@font-face \{.*?\}\s*|<!--.*?-->", "", drawn, flags=re.S)
    (FIGURES / f"editor-{name}.svg").write_text(drawn)


def neovim(folder: Path) -> None:
    """Take the picture of Neovim: findings, hints, lenses and the menu of fixes."""
    project = courier(folder)
    file = mistaken(project)
    look = "set number signcolumn=yes noshowcmd laststatus=2 termguicolors"
    command = [
        *(os.environ.get("NVIM", "nvim"), "--clean", "-i", "NONE", "-n"),
        *("-c", f"luafile {ROOT / 'editors' / 'neovim' / 'rap.lua'}"),
        *("-c", "lua vim.diagnostic.config({ virtual_text = true })"),
        *("-c", look, "-c", f"edit {file.name}"),
        *("-c", f"call cursor({MISTAKE[0]}, 14)"),
    ]
    terminal("neovim", command, project, "unknown RAP", "zz", "gra", "Ignore")


def emacs(folder: Path) -> None:
    """Take the picture of Emacs: the findings and the menu of fixes."""
    project = courier(folder)
    file = mistaken(project)
    setup = (
        "(progn (package-initialize) (menu-bar-mode -1) (setq inhibit-startup-screen t "
        "native-comp-async-report-warnings-errors nil create-lockfiles nil))"
    )
    rows = (
        f'(progn (find-file "{file.name}") (delete-other-windows)'
        f"(forward-line {MISTAKE[0] - 1}) (forward-char 12) (recenter))"
    )
    command = [
        *("emacs", "-nw", "-q", "--eval", setup),
        *("-l", str(ROOT / "editors" / "emacs" / "rap.el"), "--eval", rows),
    ]
    keys = ("C-f", "M-x", "eglot-code-actions", "Enter", "Tab", "Tab", "Ignore")
    terminal("emacs", command, project, "Flymake[1", *keys)


def visual_studio_code(folder: Path) -> None:
    """Take the picture of VS Code: the findings and the menu of fixes."""
    project = courier(folder)
    with vscode(extension(folder), project, folder) as page:
        editor = VSCode(page)
        editor.slip()
        editor.go_to(MISTAKE[0], 13)
        editor.fixes()
        time.sleep(1)
        page.screenshot(path=str(FIGURES / "editor-vscode.png"))


EDITORS = {"neovim": neovim, "emacs": emacs, "vscode": visual_studio_code}

if __name__ == "__main__":
    for chosen in sys.argv[1:] or EDITORS:
        scratch = Path(tempfile.mkdtemp())
        try:
            EDITORS[chosen](scratch)
        finally:
            shutil.rmtree(scratch)
