"""RAP files and folders: their names and their content.

This module is the only reader of files below the front ends. A file that cannot be
read, or that is not text, raises a `LoadError`, one line for the user.
Not here: writing files (`rapc.base.writing`).
"""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from rapc.base.limits import MAX_BYTES
from rapc.errors import LoadError, reason

SUFFIX = ".rap"
TEST_SUFFIX = ".test.rap"

COMPILED = b"rapc-library "
"""The first bytes of a compiled library (`rapc.library.saved`)."""

STANDARD = "rapc:"
"""The prefix of file names in the standard libraries: `rapc:truck/fuel.rap`.

The name of a file does not depend on the folder in which rapc is installed.
"""

_STANDARD_LIBRARIES = Path(__file__).parents[1] / "stdlib"

Identity = tuple[int, int]
"""The device and inode number of a file or folder."""

_Entry = tuple[Path, tuple[Identity, ...] | None]
"""A folder with the folders above it, or a file with None."""


# --- names and paths ----------------------------------------------------------------


def path_named(name: str) -> Path:
    """Return the path of a name that a user typed.

    Raises:
        LoadError: for an empty name and for an unknown standard library; a name must
            not lead out of the folder of the standard libraries.
    """
    path = path_of(name)
    standard = name.startswith(STANDARD)
    if not name or (standard and (os.pardir in path.parts or not is_there(path))):
        raise LoadError(f"`{name}` does not exist")
    return path


def path_of(name: str) -> Path:
    """Return the path of a name, whether the file or folder exists or not.

    A name is a path or the name of a part of a standard library: `rapc:truck`.
    """
    if name.startswith(STANDARD):
        return _STANDARD_LIBRARIES / name.removeprefix(STANDARD).lstrip("/")
    return Path(name)


def same_file(one: str | Path, other: str | Path) -> bool:
    """Return whether two names mean the same file, also if the file is not written yet.

    A missing folder in a name is skipped, as in `write_whole`. A name that cannot be
    read means no file.
    """
    try:
        if os.path.realpath(one) == os.path.realpath(other):
            return True
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        return False


def name_beside(name: str, path: Path) -> str:
    """Return the name of a path that was found from the file or folder `name`."""
    if name.startswith(STANDARD):
        return f"{STANDARD}{path.relative_to(_STANDARD_LIBRARIES).as_posix()}"
    return str(path)


def names_at(name: str, tests: bool) -> Iterator[str]:
    """Yield the names of the files at a path that a user typed; see `files_at`.

    Raises:
        LoadError: as `path_named` and `files_at`.
    """
    for file in files_at(path_named(name), tests):
        yield name_beside(name, file)


def files_at(path: Path, tests: bool) -> Iterator[Path]:
    """Yield the file itself, or all RAP files below a folder, sorted by path.

    Each folder is walked once, also if links lead to it.

    Raises:
        LoadError: if `path` does not exist, or a link leads to a folder above it.
    """
    if not is_there(path):
        raise LoadError(f"`{path}` does not exist")
    if not os.path.isdir(path):
        yield path
        return
    walked: set[Identity] = set()
    stack: list[_Entry] = [(path, ())]
    while stack:
        here, above = stack.pop()
        if above is None:
            yield here
            continue
        identity = identity_of(here)
        if identity in above:
            raise LoadError(f"`{here}` is a link to a folder that contains the link")
        if identity not in walked:
            walked.add(identity)
            stack.extend(reversed(_entries(here, (*above, identity), tests)))


def is_there(path: Path) -> bool:
    """Return whether a file, folder or link exists.

    Raises:
        LoadError: if the user has no permission to search the folder.
    """
    try:
        os.lstat(path)
    except PermissionError as error:
        raise LoadError(_unreadable(path, error)) from None
    except (OSError, ValueError):
        return False
    return True


def identity_of(path: Path) -> Identity:
    """Return the identity of a file or folder, independent of its name."""
    try:
        status = path.stat()
    except OSError as error:
        raise LoadError(_unreadable(path, error)) from None
    return status.st_dev, status.st_ino


def _entries(folder: Path, above: tuple[Identity, ...], tests: bool) -> list[_Entry]:
    """Return a folder's RAP files (with None) and folders (with the folders above)."""
    try:
        with os.scandir(folder) as entries:
            listed = sorted((e.name, e.is_dir()) for e in entries)
    except OSError as error:
        raise LoadError(_unreadable(folder, error)) from None
    found: list[_Entry] = []
    for name, is_folder in listed:
        if is_folder and not name.startswith("."):
            found.append((folder / name, above))
        elif not is_folder and _is_rap(name, tests):
            found.append((folder / name, None))
    return found


def _is_rap(name: str, tests: bool) -> bool:
    return name.endswith(SUFFIX) and (tests or not name.endswith(TEST_SUFFIX))


def lies_in(name: str, path: str) -> bool:
    """Return whether the name of a file equals a path or lies below it, by spelling.

    No standard library lies below the working directory, wherever rapc is installed.
    """
    if name == path:
        return True
    folder = str(Path(path))
    if folder == os.curdir:
        return not (os.path.isabs(name) or name.startswith((os.pardir, STANDARD)))
    return name == folder or name.startswith(folder + os.sep)


def seen_from(root: str, file: str) -> str:
    """Return the path of `file` relative to `root`, with `/` as separator.

    An empty `root` means the working directory.

    The name of a text without a file, for example `<stdin>`, stays unchanged. The name
    of a file in a standard library stays unchanged, too.
    """
    if file.startswith(("<", STANDARD)):
        return file
    return Path(os.path.relpath(file, root or os.curdir)).as_posix()


# --- content --------------------------------------------------------------------------


def read_standard_input() -> str:
    """Return the text on standard input.

    Raises:
        LoadError: if standard input is closed, not UTF-8, or over the size limit.
    """
    if sys.stdin is None:  # closed by the caller
        raise LoadError("cannot read `<stdin>`: standard input is closed")
    return decoded("<stdin>", _all_of("<stdin>", sys.stdin.buffer))


def read_text(path: Path) -> str:
    r"""Return the text of a file, with all line ends as ``\n``.

    Raises:
        LoadError: if the file cannot be read, is not UTF-8, or is over the size limit.
    """
    return decoded(str(path), read_bytes(path))


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises:
        LoadError: if the file cannot be read, or is over the size limit.
    """
    try:
        with _opened(path) as file:
            return all_there(str(path), file)
    except OSError as error:
        raise LoadError(_unreadable(path, error)) from None


def read_compiled(path: str | Path) -> bytes | None:
    """Return the bytes of a compiled library; None for any other path.

    Raises:
        LoadError: if the compiled library cannot be read.
    """
    if not os.path.isfile(path):
        return None
    try:
        with _opened(Path(path)) as file:
            if file.read(len(COMPILED)) != COMPILED:
                return None
            file.seek(0)
            return all_there(str(path), file)
    except OSError as error:
        raise LoadError(_unreadable(Path(path), error)) from None


def _opened(path: Path) -> BinaryIO:
    """Open a regular file; refuse devices and pipes, which may block without end."""
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(status.st_mode):
        raise LoadError(
            f"`{path}` is neither a file nor a folder; use `-` for standard input"
        )
    _measure(str(path), status.st_size)
    return open(path, "rb", opener=_without_waiting)


def _without_waiting(path: str, flags: int) -> int:
    """Open `path` without blocking reads.

    Some files of the system are regular for `stat`, but their reads block.
    """
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def all_there(name: str, file: BinaryIO) -> bytes:
    """Return the bytes of `file`, which was opened without blocking.

    Raises:
        LoadError: if a read would block, or the file is over the size limit.
    """
    data: bytes | None = file.read(MAX_BYTES + 1)
    rest: bytes | None = b"" if data is None else file.read(1)
    if data is None or rest is None:
        raise LoadError(f"cannot read `{name}`: reading blocks without end")
    _measure(name, len(data))
    return data


def _all_of(name: str, file: BinaryIO) -> bytes:
    data = file.read(MAX_BYTES + 1)
    _measure(name, len(data))
    return data


def _measure(name: str, size: int) -> None:
    if size > MAX_BYTES:
        raise LoadError(f"`{name}` is too large: more than {MAX_BYTES // 10**6} MB")


def _unreadable(path: Path, error: OSError) -> str:
    return f"cannot read `{path}`: {reason(error)}"


def decoded(name: str, data: bytes) -> str:
    """Return the text of a file from its bytes; see `read_text`.

    Raises:
        LoadError: if the bytes are not UTF-8, or not text.
    """
    if data.startswith(COMPILED):
        raise LoadError(f"expected a source file, not the compiled library `{name}`")
    if b"\0" in data:
        raise LoadError(f"`{name}` is a binary file: it contains a null byte")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = data.count(b"\n", 0, error.start) + 1
        raise LoadError(
            f"`{name}` is not UTF-8: byte 0x{data[error.start]:02x} in line {row}"
        ) from None
    return fold_line_ends(text)


def fold_line_ends(text: str) -> str:
    r"""Return a text with all line ends as ``\n``."""
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
