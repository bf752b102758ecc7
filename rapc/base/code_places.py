"""Positions of other authors' Python code, for messages."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType, FunctionType


def code_of(call: object) -> CodeType | None:
    """Return the code that runs first when `call` is called, or None if not Python."""
    for name in ("func", "__func__"):  # of a partial, of a method
        call = getattr(call, name, call)
    if not isinstance(call, FunctionType):
        call = vars(type(call)).get("__call__")
    return call.__code__ if isinstance(call, FunctionType) else None


def place_of(call: object) -> str:
    """Return the start of the code of `call`, as ` (lamps.py:23)`, or nothing."""
    code = code_of(call) if callable(call) else None
    if code is None:
        return ""
    return f" ({Path(code.co_filename).name}:{code.co_firstlineno})"


def said_by(error: BaseException) -> str:
    """Return the type and the message of an error, in one line.

    The `__str__` of other authors' errors may raise.
    """
    try:
        said = str(error)
    except KeyboardInterrupt:
        raise
    except BaseException as other:  # other authors' code may raise anything
        said = f"(it cannot be printed: {type(other).__name__})"
    return " ".join(f"{type(error).__name__}: {said}".split()).removesuffix(":")


def frames(error: BaseException) -> Iterator[tuple[FrameType, int]]:
    """Yield the frames of an error's traceback, each with its line number."""
    at = error.__traceback__
    while at is not None:
        yield at.tb_frame, at.tb_lineno
        at = at.tb_next


def place_of_error(error: BaseException) -> str:
    """Return the position where code outside rapc raised `error`, or nothing.

    The form is ` (lamps.py:23)`. For a syntax error it is the position of the mistake.
    """
    if isinstance(error, SyntaxError) and error.filename:
        return f" ({Path(error.filename).name}:{error.lineno})"
    places = [
        f" ({Path(frame.f_code.co_filename).name}:{row})"
        for frame, row in frames(error)
        if not frame.f_code.co_filename.startswith("<frozen ")
        and str(frame.f_globals.get("__name__")).partition(".")[0]
        not in ("rapc", "importlib")
    ]
    return places[-1] if places else ""
