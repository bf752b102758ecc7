"""All that a user of rapc can get wrong, as exceptions with one base.

Each carries a line of text, `message`, and perhaps a remedy, `help`. A front end prints
both; a traceback would add nothing. An exception of any other class that leaves rapc is
a fault of rapc, or the host's own.

Not here: `CheckError`, which carries a report (`rapc.host`).
"""

from __future__ import annotations

from collections.abc import Sequence


class Error(Exception):
    """A mistake in what rapc was given: files, text, a world, a setting, a task."""

    #: What is wrong, in one line, beginning in lower case.
    message: str
    #: What to do about it, or an empty text.
    help: str

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.help = help


class LoadError(Error):
    """A path that cannot be read, or holds no text."""


class WriteError(Error):
    """A file that cannot be written."""


class SavedError(Error):
    """A file that holds no saved library that this rapc can run."""


class TextError(Error, ValueError):
    """A small text (a fact, a formula, a task) that is not what it should be."""


class FactError(Error, ValueError):
    """A fact that the declarations of the library do not allow."""


class SettingError(Error, ValueError):
    """A setting that does not exist, or takes another value."""


class ArgumentError(Error, TypeError):
    """An argument of the wrong type given to a function of `rapc`."""


class RefusedError(Error):
    """A library, world or task that cannot be run, said before anything happens."""

    #: One line for each reason.
    reasons: tuple[str, ...]
    #: The names that the library declares and the world does not have, if they are so
    #: many that another world is meant.
    lacking: tuple[str, ...]

    def __init__(self, reasons: Sequence[str], lacking: Sequence[str] = ()) -> None:
        super().__init__("; ".join(reasons))
        self.reasons = tuple(reasons)
        self.lacking = tuple(lacking)


class WorldError(Error):
    """A world, or an option of one, that is not to be had."""


class PortError(Error):
    """A world, or code registered with one, that does not keep to the port.

    What the code of the world raised, if it did, is the `__cause__`.
    """


class StateError(Error):
    """A run that cannot be saved, or a saved run that cannot be taken up."""


def in_a_line(error: Error) -> str:
    """Return an error with what to do about it."""
    return f"{error.message}; {error.help}" if error.help else error.message


def reason(error: OSError) -> str:
    """Return why the system could not do something, in lower case."""
    return (error.strerror or str(error)).lower()
