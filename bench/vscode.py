"""VS Code in headless Chromium, with the extension of `editors/vscode`.

`code-server` of npm runs VS Code on this machine; no other host is reached but the npm
registry. Needs Node.js, npm, a C++ compiler and Chromium.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Page

from bench.browser import browser

VERSION = "4.100.3"
"""The version of code-server, which contains VS Code 1.100.3 and needs Node.js 20."""

EXTENSION = Path(__file__).parents[1] / "editors" / "vscode"

COURIER = Path(__file__).parents[1] / "examples" / "courier"

MISTAKE = (21, 18)
"""The row and column in `moving.rap` of a letter without which a step is unknown."""

SETTINGS = {
    "editor.minimap.enabled": False,
    "extensions.autoCheckUpdates": False,
    "extensions.autoUpdate": False,
    "security.workspace.trust.enabled": False,
    "telemetry.telemetryLevel": "off",
    "update.mode": "none",
    "window.commandCenter": False,
    "workbench.colorTheme": "Default Light Modern",
    "workbench.startupEditor": "none",
}

_NPM = ("--ignore-scripts", "--no-audit", "--no-fund", "--loglevel", "error")


def run(command: Sequence[str | Path], folder: Path) -> None:
    """Run a command in a folder.

    Raises:
        RuntimeError: if the command fails; the message is its output.
    """
    done = subprocess.run(
        list(map(str, command)), cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{command}: {done.stdout}{done.stderr}")


def extension(folder: Path) -> Path:
    """Build the package of the extension in a folder, and test its grammar."""
    made = folder / "vscode"
    skipped = shutil.ignore_patterns("node_modules", "out", "*.vsix")
    shutil.copytree(EXTENSION, made, ignore=skipped)
    run(("npm", "ci", *_NPM), made)
    run(("npm", "run", "package"), made)
    run(("npm", "test"), made)
    return made / "rapc.vsix"


def server() -> Path:
    """Return the script that starts code-server; install it, about 320 MB, if missing.

    The packages of VS Code itself are not among those of code-server: npm installs them
    from the lists in its folders. Only two packages are compiled; the terminal and some
    others, which need more, are not used.
    """
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    folder = cache / f"rapc-code-server-{VERSION}"
    entry = folder / "node_modules" / "code-server" / "out" / "node" / "entry.js"
    ready = folder / "ready"
    if ready.exists():
        return entry
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "package.json").write_text("{}")
    run(("npm", "install", *_NPM, f"code-server@{VERSION}"), folder)
    inner = folder / "node_modules" / "code-server" / "lib" / "vscode"
    for one in (inner, inner / "extensions"):
        run(("npm", "install", "--omit=dev", *_NPM), one)
    (inner / "node_modules.asar").symlink_to("node_modules")
    run(("npm", "rebuild", "@vscode/spdlog", "@parcel/watcher"), inner)
    run(("npm", "rebuild", "argon2"), folder)
    ready.touch()
    return entry


def courier(folder: Path) -> Path:
    """Copy the courier into a folder, with an environment that has this rapc."""
    project = folder / "courier"
    shutil.copytree(COURIER, project)
    (project / "rapc.toml").write_text("")
    (project / ".venv" / "bin").mkdir(parents=True)
    (project / ".venv" / "bin" / "rapc").symlink_to(
        Path(sys.executable).parent / "rapc"
    )
    return project


@contextmanager
def vscode(package: Path, project: Path, folder: Path) -> Iterator[Page]:
    """Open a project in VS Code with the extension, and end both.

    Args:
        package: the package of the extension.
        project: the folder of the project.
        folder: an empty folder for the state of VS Code.
    """
    user = folder / "data" / "User"
    user.mkdir(parents=True)
    (user / "settings.json").write_text(json.dumps(SETTINGS))
    (folder / "config.yaml").write_text("auth: none\n")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    start = (
        *("node", str(server()), "--config", str(folder / "config.yaml")),
        *("--user-data-dir", str(folder / "data")),
        *("--extensions-dir", str(folder / "extensions")),
    )
    run((*start, "--install-extension", package), folder)
    options = ("--bind-addr", address, "--disable-telemetry", "--disable-update-check")
    with (
        (folder / "log").open("w") as log,
        subprocess.Popen((*start, *options), stdout=log, stderr=log) as process,
    ):
        try:
            _await(address)
            with browser() as chromium:
                page = chromium.new_page(viewport={"width": 1000, "height": 560})
                page.goto(f"http://{address}/?folder={project}")
                yield page
        finally:
            process.terminate()


def _await(address: str) -> None:
    """Wait until a server listens."""
    host, port = address.split(":")
    for _ in range(300):
        with socket.socket() as tried:
            if tried.connect_ex((host, int(port))) == 0:
                return
        time.sleep(0.1)
    raise TimeoutError(f"code-server does not listen at {address}")


class VSCode:
    """What a person does in VS Code; each call waits for the result."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.keys = page.keyboard

    def open(self, file: str) -> None:
        """Open a file of the project from the list of files."""
        rows = self.page.locator(".explorer-folders-view .monaco-list-row")
        rows.filter(has_text=file).dblclick(timeout=60_000)
        self.page.wait_for_selector(f".tab:has-text('{file}')")

    def slip(self) -> None:
        """Open `moving.rap`, and make the mistake after the first check."""
        self.open("moving.rap")
        self.page.wait_for_selector(".codelens-decoration:has-text('4 callers')")
        self.go_to(*MISTAKE)
        self.keys.press("Delete")
        self.squiggle()

    def go_to(self, row: int, column: int) -> None:
        """Put the cursor at a place of the file."""
        self.keys.press("Control+g")
        line = self.page.wait_for_selector(".quick-input-widget input")
        assert line is not None
        line.fill(f":{row}:{column}")
        self.keys.press("Enter")
        self.page.wait_for_selector(f"text=Ln {row}, Col {column}")

    def squiggle(self, present: bool = True) -> None:
        """Wait until an error is underlined, or no error."""
        error = self.page.locator(".squiggly-error").first
        error.wait_for(state="attached" if present else "detached")

    def hover(self) -> str:
        """Return the text about the place of the cursor."""
        self.keys.press("Control+k")
        self.keys.press("Control+i")
        self.page.wait_for_selector(".monaco-hover:visible")
        text = self.page.locator(".monaco-hover:visible").first.inner_text()
        self.keys.press("Escape")
        return text

    def fixes(self) -> list[str]:
        """Open the menu of quick fixes, and return its entries."""
        self.keys.press("Control+.")
        self.page.wait_for_selector(".action-widget .monaco-list-row.action")
        return self.page.locator(
            ".action-widget .monaco-list-row.action"
        ).all_inner_texts()

    def save(self) -> None:
        """Save all files."""
        self.keys.press("Control+k")
        self.keys.press("s")

    def rename(self, name: str) -> None:
        """Rename what is at the cursor."""
        self.keys.press("F2")
        line = self.page.wait_for_selector(".rename-box input")
        assert line is not None
        line.fill(name)
        self.keys.press("Enter")
