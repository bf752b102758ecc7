"""Writing of files: whole or not at all, or with errors that name the file.

Not here: the line ends of RAP files (`rapc.parser.rewriting`).
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterable
from contextlib import suppress
from io import BufferedWriter, FileIO, TextIOWrapper
from pathlib import Path
from typing import Any

from rapc.base.files import read_bytes
from rapc.errors import WriteError, reason

_PART = re.compile(r".+\.([1-9][0-9]{0,8})\.rapc-part")
"""The name of a temporary file, with the number of the process that writes it."""


class Output(FileIO):
    """A file that is written piece by piece.

    Raises:
        WriteError: if the file cannot be opened, or later written.
    """

    def __init__(self, file: str | Path, mode: str = "w") -> None:
        try:
            super().__init__(file, mode)
        except OSError as error:
            raise WriteError(f"cannot write `{file}`: {reason(error)}") from error

    def write(self, data: Any, /) -> int:
        """Write bytes; return their number. Raises WriteError."""
        try:
            return super().write(data)
        except BrokenPipeError:  # the reader has ended
            raise
        except OSError as error:
            raise WriteError(f"cannot write `{self.name}`: {reason(error)}") from error

    def text(self) -> TextIOWrapper:
        """Return a buffered stream of text; on a terminal line by line."""
        lines = self.isatty()
        return TextIOWrapper(
            BufferedWriter(self), "utf-8", newline="\n", line_buffering=lines
        )


def write_whole(file: str | Path, data: bytes) -> None:
    """Write a file whole or not at all; write to a device or a pipe directly.

    A link stays a link: its target is written. An existing file keeps its mode, and its
    owner and group if the user may set them.

    Raises:
        WriteError: if the file cannot be written.
    """
    try:
        if os.path.exists(file) and not os.path.isfile(file):
            Path(file).write_bytes(data)
        else:
            _put(file, data, None)
    except OSError as error:
        raise WriteError(f"cannot write `{file}`: {reason(error)}") from None


def replace(file: Path, before: bytes, data: bytes) -> None:
    """Replace the content of a file, whole or not at all, if it is still `before`.

    Mode, owner and group stay. A file is refused if it is read-only, has several hard
    links, or was changed by a different program.

    Raises:
        LoadError: if the file is missing.
        WriteError: if the file is refused, or cannot be written.
    """
    try:
        status = os.stat(file)
        if status.st_nlink > 1:
            raise WriteError(
                f"cannot write `{file}`: it has {status.st_nlink} hard links"
            )
        if not (status.st_mode & 0o222 and os.access(file, os.W_OK)):
            raise WriteError(f"cannot write `{file}`: it is read-only")
        _put(file, data, before)
    except OSError as error:
        raise WriteError(f"cannot write `{file}`: {reason(error)}") from None


def changed(file: Path) -> WriteError:
    """Return the error for a file changed meanwhile by a different program."""
    return WriteError(f"cannot write `{file}`: the file changed after rapc read it")


def _put(file: str | Path, data: bytes, before: bytes | None) -> None:
    """Write a temporary file, then replace `file` if its content is still `before`."""
    target = Path(os.path.realpath(file))
    old = os.stat(target) if target.exists() else None
    part = Path(f"{target}.{os.getpid()}.rapc-part")
    part.unlink(missing_ok=True)  # left by a killed process of the same number
    try:
        with open(part, "xb", opener=_open if old is None else _open_privately) as new:
            new.write(data)
            new.flush()
            os.fsync(new.fileno())
        if old is not None:
            _give(file, part, old, must=before is not None)
        if before is not None and read_bytes(target) != before:
            raise changed(Path(file))
        os.replace(part, target)
    finally:
        part.unlink(missing_ok=True)


def _open(path: str, flags: int) -> int:
    return os.open(path, flags, 0o666)


def _open_privately(path: str, flags: int) -> int:
    """Open a new file only for its owner: the replaced file may be secret."""
    return os.open(path, flags, 0o600)


def _give(file: str | Path, part: Path, old: os.stat_result, *, must: bool) -> None:
    """Set the owner, group and mode of a new file to those of the replaced file.

    Raises:
        WriteError: if the user may not set owner and group, and `must` is true.
    """
    if _owner(os.stat(part)) != _owner(old):
        try:
            os.chown(part, old.st_uid, old.st_gid)
        except PermissionError:
            if must:
                raise WriteError(
                    f"cannot write `{file}`: the owner and group cannot be preserved"
                ) from None
    part.chmod(stat.S_IMODE(old.st_mode))


def _owner(status: os.stat_result) -> tuple[int, int]:
    return status.st_uid, status.st_gid


def remove_parts(files: Iterable[Path]) -> None:
    """Remove the temporary files that killed processes left beside some files."""
    for folder in {os.path.dirname(os.path.realpath(file)) for file in files}:
        with suppress(OSError), os.scandir(folder) as entries:  # may not be searched
            for entry in entries:
                named = _PART.fullmatch(entry.name)
                if named and entry.is_file() and _has_ended(int(named[1])):
                    os.unlink(entry)


def _has_ended(process: int) -> bool:
    """Return whether a process has ended; true for the number of this process."""
    if os.name != "posix":  # where signal 0 would reach the process
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except PermissionError:  # a process of another user
        return False
    return process == os.getpid()
