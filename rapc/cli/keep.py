"""`--keep`: the methods that problem solvers have found, as a library."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import click

from rapc.base.files import STANDARD, SUFFIX, TEST_SUFFIX
from rapc.base.interrupts import interrupts_held
from rapc.base.names import plural
from rapc.base.source import SourceFile
from rapc.base.visible import visible
from rapc.base.writing import write_whole
from rapc.cli.common import print_findings
from rapc.cli.options import fail
from rapc.errors import WriteError, reason
from rapc.host import CheckError, load, methods_text
from rapc.parser.formatter import formatted
from rapc.runtime.interpreter import Interpreter


def refuse_kept(file: str, option: str = "--keep") -> None:
    """End the command if an option cannot write a new RAP file."""
    if not file.endswith(SUFFIX) or file.endswith(TEST_SUFFIX):
        fail(f"{option}: expected the name of a RAP file, not `{file}`")
    try:
        open(file, "xb").close()
        os.unlink(file)
    except FileExistsError:
        said = f"{option}: cannot write `{file}`: the file exists"
        fail(said, "choose another file, or remove this one")
    except OSError as error:
        fail(f"{option}: cannot write `{file}`: {reason(error)}")


def keep(file: str, interpreter: Interpreter, library: str) -> None:
    """Write the methods that solvers have found in a run.

    If the file cannot be written, the methods are printed: nothing is lost.

    Args:
        file: the new RAP file.
        interpreter: the run.
        library: the library of the run, as the user named it.
    """
    requires = list(_requires(library, file))
    with interrupts_held():
        text = methods_text(interpreter, requires)
        if not text:
            note = f"note: no method was found; `{file}` is not written"
            click.echo(visible(note), err=True)
            return
        head = f";;; Methods found in a run in the world `{interpreter.port.name}`."
        number = sum(map(len, interpreter.added_methods.values()))
        _write(file, head, text, number, checked=bool(requires))


def keep_plan(file: str, rap: str, library: str) -> None:
    """Write a RAP with its plan; the arguments are as for `keep`."""
    requires = list(_requires(library, file))
    lines = [f'(require "{name}")\n' for name in requires]
    head = ";;; A plan for a goal."
    _write(file, head, f"{''.join(lines)}{rap}", 1, checked=bool(requires))


def _write(file: str, head: str, forms: str, number: int, checked: bool) -> None:
    """Write forms with a number of methods to a new file; check the file."""
    text = formatted(SourceFile(file, forms)).text
    with interrupts_held():
        try:
            if os.path.lexists(file):
                raise WriteError(f"cannot write `{file}`: the file exists")
            write_whole(file, f"{visible(head)}\n\n{text}".encode())
        except WriteError as error:
            click.echo(text)
            fail(f"--keep: {error.message}; standard output has the methods")
    click.echo(visible(f"kept {plural(number, 'method')} in {file}"), err=True)
    if checked:
        try:
            load(file)
        except CheckError as found:
            print_findings(found.report, "full")


def _requires(library: str, file: str) -> Iterator[str]:
    """Yield the name of the library for `require`, if it is a RAP file or a folder.

    A saved library and standard input cannot be required.
    """
    if library.startswith(STANDARD):
        yield library.removeprefix(STANDARD).removesuffix(SUFFIX)
    elif library.endswith(SUFFIX) or os.path.isdir(library):
        folder = os.path.realpath(os.path.dirname(file))
        there = Path(os.path.relpath(os.path.realpath(library), folder))
        yield there.as_posix().removesuffix(SUFFIX)
