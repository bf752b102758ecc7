"""Commands of the server: apply all fixes, run a test, run an agenda.

Tests and agendas run in a process of their own, because they import the code of worlds.
"""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Mapping

from lsprotocol import types
from pygls.lsp.server import LanguageServer

from rapc.analysis.check_files import check_files
from rapc.analysis.driver import CheckReport
from rapc.analysis.fixes import mend
from rapc.library.loader import Units
from rapc.lsp.formatting import edits_to
from rapc.lsp.navigation import workspace_edit
from rapc.lsp.workspace import View, Workspace, path

_LAST = 40
"""The number of lines of output that a message shows."""


async def fix_all(server: LanguageServer, rap: Workspace, uri: str) -> None:
    """Apply all safe fixes in a file."""
    view = rap.view(uri)
    if view is None:
        return
    texts = rap.work().texts
    before = view.text
    fixed = await asyncio.to_thread(_fixed, view, texts)
    if fixed is None or fixed == before.text or before is not view.text:
        return
    edit = workspace_edit(view, {uri: edits_to(before, fixed)})
    params = types.ApplyWorkspaceEditParams(edit, "Apply all safe fixes")
    await server.workspace_apply_edit_async(params)


def _fixed(view: View, texts: Mapping[str, str]) -> str | None:
    """Return the text of a file after all safe fixes; None if nothing was fixed."""
    units = Units()
    paths = view.snapshot.spec.paths

    def check(changed: Mapping[str, str]) -> CheckReport:
        return check_files(paths, None, {**texts, **changed}, parser=units)

    mended = mend(check, lambda name: name == view.name, unsafe=False)
    return mended.texts.get(view.name)


async def run_test(server: LanguageServer, rap: Workspace, uri: str, name: str) -> bool:
    """Run a test of a file, and show the last line of the report."""
    view = rap.view(uri)
    if view is None:
        return False
    args = ("test", path(view.name), "--only", name)
    return await _run(server, f"test `{name}`", ("passed", "failed"), -1, *args)


async def run_agenda(
    server: LanguageServer, rap: Workspace, uri: str, agenda: str, world: str
) -> bool:
    """Run an agenda of a file in a world, and show the first line of the report."""
    view = rap.view(uri)
    if view is None:
        return False
    library = path(view.snapshot.spec.paths[0])  # test files follow
    args = ("run", "--quiet", library, "--world", world, "--agenda", agenda)
    return await _run(server, f"agenda `{agenda}`", ("succeeded", "failed"), 0, *args)


async def _run(
    server: LanguageServer, name: str, results: tuple[str, str], line: int, *args: str
) -> bool:
    """Run rapc, and show the result with a line of the output; log all the output.

    Args:
        server: the server.
        name: the name of the test or agenda.
        results: the words for the exit status 0, and for all others.
        line: the index of the line to show.
        args: the arguments of rapc.
    """
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "rapc", *args),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        env={**os.environ, "NO_COLOR": "1"},
    )
    output, _ = await process.communicate()
    lines = output.decode(errors="replace").rstrip().splitlines()
    text = "\n".join(lines[-_LAST:])
    passed = process.returncode == 0
    kind = types.MessageType.Info if passed else types.MessageType.Error
    server.window_log_message(types.LogMessageParams(kind, text))
    shown = lines[line] if lines else "no output"
    message = f"{name}: {results[not passed]}; {shown}"
    server.window_show_message(types.ShowMessageParams(kind, message))
    return passed
