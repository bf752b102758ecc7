"""Files and folders: which of them hold RAP, and what is in them.

The only reader of files below the front ends. What cannot be read, or is no text, is a
`LoadError`, one line for the user. Files are written by `rapc.base.writing`.
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
"""How a file begins that holds a compiled library (`rapc.library.saved`)."""

STANDARD = "rapc:"
"""How the name of a file of a standard library begins: `rapc:truck/fuel.rap`.

So it is called the same wherever rapc is installed, and whatever that folder is.
"""

_STANDARD_LIBRARIES = Path(__file__).parents[1] / "stdlib"

Identity = tuple[int, int]
"""The device and number of a file or folder."""

_Entry = tuple[Path, tuple[Identity, ...] | None]
"""A folder with those that it lies in, or a file with None."""


# --- which files --------------------------------------------------------------------


def path_named(name: str) -> Path:
    """Return the path of a name that somebody typed.

    Raises:
        LoadError: for an empty one, and for a standard library that there is not: none
            lies above the folder of all.
    """
    path = path_of(name)
    standard = name.startswith(STANDARD)
    if not name or (standard and (os.pardir in path.parts or not is_there(path))):
        raise LoadError(f"`{name}` does not exist")
    return path


def path_of(name: str) -> Path:
    """Return where the file or folder of a name lies, whether there is one or not.

    A name is a path, or that of a part of a standard library: `rapc:truck`.
    """
    if name.startswith(STANDARD):
        return _STANDARD_LIBRARIES / name.removeprefix(STANDARD).lstrip("/")
    return Path(name)


def same_file(one: str | Path, other: str | Path) -> bool:
    """Whether two names are those of one file, or would be once it is written.

    A name that leads through a folder that is not there is that without the folder, as
    for `write_whole`; one that cannot be seen is no file.
    """
    try:
        if os.path.realpath(one) == os.path.realpath(other):
            return True
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        return False


def name_beside(name: str, path: Path) -> str:
    """Return the name of a path that was reached from the file or folder `name`."""
    if name.startswith(STANDARD):
        return f"{STANDARD}{path.relative_to(_STANDARD_LIBRARIES).as_posix()}"
    return str(path)


def names_at(name: str, tests: bool) -> Iterator[str]:
    """Yield the names of the files at a path that somebody typed; see `files_at`.

    Raises:
        LoadError: as `path_named` and `files_at`.
    """
    for file in files_at(path_named(name), tests):
        yield name_beside(name, file)


def files_at(path: Path, tests: bool) -> Iterator[Path]:
    """Yield the file itself, or all RAP files below a folder, sorted by path.

    A folder that is met again through a link is not walked again.

    Raises:
        LoadError: if `path` does not exist, or a folder links back to one above it.
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
            raise LoadError(f"`{here}` is a link back to a folder that it lies in")
        if identity not in walked:
            walked.add(identity)
            stack.extend(reversed(_entries(here, (*above, identity), tests)))


def is_there(path: Path) -> bool:
    """Whether there is a file, folder or link of a name.

    Raises:
        LoadError: if that cannot be seen, in a folder that may not be searched.
    """
    try:
        os.lstat(path)
    except PermissionError as error:
        raise LoadError(_unreadable(path, error)) from None
    except (OSError, ValueError):
        return False
    return True


def identity_of(path: Path) -> Identity:
    """Return what tells a file or folder from all others, whatever it is called."""
    try:
        status = path.stat()
    except OSError as error:
        raise LoadError(_unreadable(path, error)) from None
    return status.st_dev, status.st_ino


def _entries(folder: Path, above: tuple[Identity, ...], tests: bool) -> list[_Entry]:
    """A folder's RAP files (with None) and folders (with those they lie in)."""
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
    """Whether the name of a file is a path or lies below it, as names are given.

    No standard library lies below the working folder, wherever rapc is installed.
    """
    if name == path:
        return True
    folder = str(Path(path))
    if folder == os.curdir:
        return not (os.path.isabs(name) or name.startswith((os.pardir, STANDARD)))
    return name == folder or name.startswith(folder + os.sep)


def seen_from(root: str, file: str) -> str:
    """Return a path as seen from a folder, or the working one if empty, with `/`.

    The name of a text that is no file, such as `<stdin>`, stays, and so does that of a
    file of a standard library.
    """
    if file.startswith(("<", STANDARD)):
        return file
    return Path(os.path.relpath(file, root or os.curdir)).as_posix()


# --- what is in them ------------------------------------------------------------------


def read_standard_input() -> str:
    """The text on standard input.

    Raises:
        LoadError: if it is closed, is not UTF-8, or is beyond measure.
    """
    if sys.stdin is None:  # closed by the caller
        raise LoadError("cannot read `<stdin>`: it is closed")
    return decoded("<stdin>", _all_of("<stdin>", sys.stdin.buffer))


def read_text(path: Path) -> str:
    """The text of a file, with line ends folded to one character.

    Raises:
        LoadError: if it cannot be read, is not UTF-8, or is beyond measure.
    """
    return decoded(str(path), read_bytes(path))


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises:
        LoadError: if it cannot be read, or is beyond measure.
    """
    try:
        with _opened(path) as file:
            return all_there(str(path), file)
    except OSError as error:
        raise LoadError(_unreadable(path, error)) from None


def read_compiled(path: str | Path) -> bytes | None:
    """All of a file that begins as a compiled library does; None for any other path.

    Raises:
        LoadError: for such a file that cannot be read.
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
    """A plain file, opened; a device may never end, and a pipe never begin."""
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(status.st_mode):
        raise LoadError(
            f"`{path}` is neither a file nor a folder; RAP on standard input is `-`"
        )
    _measure(str(path), status.st_size)
    return open(path, "rb", opener=_without_waiting)


def _without_waiting(path: str, flags: int) -> int:
    """Open `path` so that a read with nothing to read returns at once.

    Some files of the system are plain ones to `stat` and wait for what is to come.
    """
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def all_there(name: str, file: BinaryIO) -> bytes:
    """Return all of `file`, opened without waiting.

    Raises:
        LoadError: if it has no end, but more may come later, or is beyond measure.
    """
    data: bytes | None = file.read(MAX_BYTES + 1)
    rest: bytes | None = b"" if data is None else file.read(1)
    if data is None or rest is None:
        raise LoadError(f"cannot read `{name}`: it has no end, and waits for more")
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
    """Return the text that the bytes of a file say; see `read_text`.

    Raises:
        LoadError: if they are not UTF-8, or no text.
    """
    if data.startswith(COMPILED):
        raise LoadError(f"`{name}` is a compiled library: sources are wanted here")
    if b"\0" in data:
        raise LoadError(f"`{name}` is a binary file: it holds a null byte")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = data.count(b"\n", 0, error.start) + 1
        raise LoadError(
            f"`{name}` is not UTF-8: byte 0x{data[error.start]:02x} in line {row}"
        ) from None
    return fold_line_ends(text)


def fold_line_ends(text: str) -> str:
    """A text whose lines all end in one character."""
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
