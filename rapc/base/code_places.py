"""Where Python code of other authors stands, for messages about it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType, FunctionType


def code_of(call: object) -> CodeType | None:
    """Return the code that runs first when `call` is called, if it is in Python."""
    for name in ("func", "__func__"):  # of a partial, of a method
        call = getattr(call, name, call)
    if not isinstance(call, FunctionType):
        call = vars(type(call)).get("__call__")
    return call.__code__ if isinstance(call, FunctionType) else None


def place_of(call: object) -> str:
    """Return ` (lamps.py:23)`, where the code of `call` begins, or nothing."""
    code = code_of(call) if callable(call) else None
    if code is None:
        return ""
    return f" ({Path(code.co_filename).name}:{code.co_firstlineno})"


def said_by(error: BaseException) -> str:
    """Return the type of an error and what it says, in one line.

    Other authors' errors may be unable to say anything.
    """
    try:
        said = str(error)
    except KeyboardInterrupt:
        raise
    except BaseException as other:  # whatever code from elsewhere may raise
        said = f"(it cannot be printed: {type(other).__name__})"
    return " ".join(f"{type(error).__name__}: {said}".split()).removesuffix(":")


def frames(error: BaseException) -> Iterator[tuple[FrameType, int]]:
    """Yield the frames that an error came through, each with the line in it."""
    at = error.__traceback__
    while at is not None:
        yield at.tb_frame, at.tb_lineno
        at = at.tb_next


def place_of_error(error: BaseException) -> str:
    """Return ` (lamps.py:23)`, where other code than rapc's raised `error`, or nothing.

    Of a syntax error that is the place of the mistake.
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
