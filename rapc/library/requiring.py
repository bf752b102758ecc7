"""What a `require` means: a file or folder beside its own, or a standard library.

Reading what was found is for `rapc.library.loader`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.files import STANDARD, SUFFIX, name_beside, path_of, same_file
from rapc.base.names import nearest
from rapc.ir import nodes

_LONG = 60
"""How much of a required name is repeated in messages."""

UNRESOLVED = Rule(
    code="RAP062",
    name="unresolved-require",
    severity=Severity.ERROR,
    summary="a `require` names neither a file, nor a folder, nor a standard library",
    why="""`(require "name")` means the file `name.rap` or the folder `name` beside the
requiring file, else the standard library of that name. What it should have brought in
is missing, so most of what uses it would be reported as unknown too.""",
    source="L 1",
    example="""\
(require "no-such-library")
""",
    better="""\
(declare-memory-proposition seen (?thing))
""",
)


def standard_libraries() -> tuple[str, ...]:
    """The names of the standard libraries that are installed, sorted."""
    folder = path_of(STANDARD)
    if not folder.is_dir():
        return ()
    return tuple(sorted(e.name.removesuffix(SUFFIX) for e in folder.iterdir()))


def resolve(name: str, requiring: str, given: Sequence[Path]) -> str | None:
    """Return the file or folder a `require` means; never the requiring file itself.

    It is named as the requiring file was, without `..` where that is the same file, or
    `rapc:truck` if it comes with rapc. A copy of a standard library among the paths
    `given`, or one that contains the requiring file, stands for the installed one, also
    where one file of it is required: else all its names were defined twice.
    """
    if os.path.isabs(name):
        return None
    here = path_of(requiring)
    beside = _in_folder(name, here.parent, here)
    if beside is not None:
        return name_beside(requiring, _without_detour(beside))
    installed = _in_folder(name, path_of(STANDARD), here)
    if installed is None:
        return None
    library, _, inner = name.partition("/")
    own = None if requiring.startswith(STANDARD) else here
    for copy in _copies(library, path_of(STANDARD + library), own, given):
        meant = _in_folder(inner, copy, here) if inner else copy
        if meant is not None:
            return str(meant)
    return name_beside(STANDARD, installed)


def _without_detour(path: Path) -> Path:
    """Return a path without `..`, unless a link makes that another file."""
    plain = Path(os.path.normpath(path))
    return plain if os.pardir in path.parts and same_file(plain, path) else path


def _copies(
    name: str, installed: Path, requiring: Path | None, given: Sequence[Path]
) -> Iterator[Path]:
    """Yield the copies of an installed library that a reader would take for it.

    Args:
        name: the library.
        installed: where it is installed.
        requiring: the file that requires it; None for one that is installed, too.
        given: the paths that the user named.
    """
    for path in given:
        real = path.resolve()
        for folder in (path, path / name):
            same = folder is not path or real.name == name
            if same and _is_copy(folder, installed):
                yield folder
    if requiring is None:
        return
    for folder in requiring.resolve().parents:
        if folder.name == name and _is_copy(folder, installed):
            yield folder if requiring.is_absolute() else Path(os.path.relpath(folder))


def _is_copy(folder: Path, installed: Path) -> bool:
    """Whether a folder has all the RAP files that an installed library has."""
    try:
        there, here = set(os.listdir(installed)), set(os.listdir(folder))
    except OSError:  # no folder, or one that may not be read
        return False
    return {name for name in there if name.endswith(SUFFIX)} <= here


def _in_folder(name: str, folder: Path, requiring: Path) -> Path | None:
    file = folder / (name + SUFFIX)
    if os.path.isfile(file) and file != requiring:
        return file
    return folder / name if name and os.path.isdir(folder / name) else None


def unresolved(form: nodes.Require, requiring: Path) -> Diagnostic:
    """Return what is to be said of a `require` in a file that means nothing."""
    names = [name for name in _beside(requiring) if name != requiring.stem]
    known = [*names, *standard_libraries()]
    without = form.name.removesuffix(SUFFIX)
    close = without if without in known else nearest(form.name, known)
    name = form.name if len(form.name) <= _LONG else f"{form.name[:_LONG]}..."
    return Diagnostic(
        rule=UNRESOLVED.name,
        message=f"nothing is found for `{name}`",
        span=form.span,
        notes=(
            f"neither `{name}{SUFFIX}` nor a folder `{name}` with RAP files "
            "stands beside this file, and no standard library is called so",
        ),
        help=_advice(form.name, close),
    )


def _advice(name: str, close: str | None) -> str:
    """Return what to write for `name`, where `close` is what may be meant."""
    if close is None:
        return ""
    if name == close + SUFFIX:
        return f"leave the ending out: `{close}`"
    return f"did you mean `{close}`?"


def _beside(requiring: Path) -> list[str]:
    """Return what could be required from beside a file."""
    try:
        with os.scandir(requiring.parent) as entries:
            listed = [(entry.name, entry.is_dir()) for entry in entries]
    except OSError:
        return []
    found = [name for name, is_folder in listed if is_folder or name.endswith(SUFFIX)]
    return [name.removesuffix(SUFFIX) for name in found]
