"""Errors that a user of rapc can cause, as exceptions with one base class.

Each error has a line of text, `message`, and an optional remedy, `help`. A front end
prints both without a traceback. An exception of any other class that leaves rapc is a
fault of rapc or of the host.

Not here: `CheckError`, which has a report (`rapc.host`).
"""

from __future__ import annotations

import errno
from collections.abc import Mapping, Sequence


class Error(Exception):
    """An invalid input to rapc: files, text, a world, a setting, a task."""

    #: The error, in one line, beginning in lower case.
    message: str
    #: The remedy, or an empty text.
    help: str

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.help = help


class LoadError(Error):
    """A path that cannot be read, or contains no text."""


class WriteError(Error):
    """A file that cannot be written."""


class SavedError(Error):
    """A file that is not a saved library for this version of rapc."""


class TextError(Error, ValueError):
    """An invalid short text: a fact, a formula or a task."""


class FactError(Error, ValueError):
    """A fact that the declarations of the library do not allow."""


class PlanError(Error, ValueError):
    """A goal that cannot be planned for, or a RAP that a plan cannot use."""


class SettingError(Error, ValueError):
    """An unknown setting, or a setting with an invalid value."""


class ArgumentError(Error, TypeError):
    """An argument of the wrong type for a function of `rapc`."""


class RefusedError(Error):
    """A library, world or task that cannot be run, reported before the run starts."""

    #: One line for each reason.
    reasons: tuple[str, ...]
    #: The names that the library declares and the world does not have, if their number
    #: suggests that a different world is meant.
    lacking: tuple[str, ...]

    def __init__(self, reasons: Sequence[str], lacking: Sequence[str] = ()) -> None:
        super().__init__("; ".join(reasons))
        self.reasons = tuple(reasons)
        self.lacking = tuple(lacking)


class WorldError(Error):
    """An unknown or unavailable world, or an invalid option of a world."""


class PortError(Error):
    """A world, or code registered with a world, that violates the port.

    If the code of the world raised an exception, it is the `__cause__`.
    """


class StateError(Error):
    """A run that cannot be saved, or a saved run that cannot be restored."""


def in_a_line(error: Error) -> str:
    """Return an error and its help as one line."""
    return f"{error.message}; {error.help}" if error.help else error.message


def reason(error: OSError) -> str:
    """Return the reason of a failed system call, in lower case."""
    said = _REASONS.get(error.errno or 0) or error.strerror or str(error)
    return said.lower()


_REASONS: Mapping[int, str] = {
    errno.EEXIST: "the file exists",
    errno.EISDIR: "it is a folder",
    errno.ENOENT: "missing file or folder",
    errno.ENOTDIR: "a part of the path is a file",
}
"""The reasons in which the system speaks of directories."""
