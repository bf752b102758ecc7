"""`rapc bug`: write a run to one file, to be repeated by somebody else."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import click

from rapc.base.outputs import BUG
from rapc.cli.common import refuse_output
from rapc.cli.options import TypedPath, command, fail, say
from rapc.cli.repl import shell_of
from rapc.cli.run_options import run_options, until_option
from rapc.debug.bug import SUFFIX, write_bug

EXAMPLES = """\b
Examples:
  rapc bug rocks.rap --world truck --task '(rock-order red 1)' -o rocks.bug
  rapc bug run.jsonl -o run.bug
  rapc repl rocks.bug
"""


@command(EXAMPLES)
@click.argument("path", type=TypedPath())
@click.option("--world", "world_name", help="World to run against.")
@run_options
@until_option
@click.option(
    "-o", "--output", metavar="FILE", required=True, help="Write the report to FILE."
)
def bug(path: str, world_name: str | None, output: str, **more: Any) -> None:
    """Run the library at PATH, and write a report of the run to a file.

    The report has the specification of the run, the texts of the library, and the
    versions of rapc and Python. `rapc repl FILE` repeats the run on another computer.
    PATH may be a recorded run. Ctrl-C ends the run; the report ends there. The name of
    FILE ends with `.bug`. `:bug` of the debugger writes a session with all its acts.

    Exit status: 0 if the report was written, 2 if not.
    """
    if not output.endswith(SUFFIX):
        fail(f"-o: the file name must end with `{SUFFIX}`")
    shell = shell_of(path, world_name, **more)
    history = shell.history
    refuse_output("-o", output, BUG)
    before = signal.signal(signal.SIGINT, lambda *_: history.pause())
    try:
        stop = history.go(heed=False)
    finally:
        signal.signal(signal.SIGINT, before)
        write_bug(history, Path(output))
    said = f": {stop.said}" if stop.kind == "broken" else ""
    say(f"wrote {output}: {history.stand()}{said}")
