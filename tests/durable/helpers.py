"""Runs with journals that are ended like by SIGKILL, at any record."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.base.values import Fact
from rapc.compiler.program import Program
from rapc.durable import runs
from rapc.durable.folder import Options, Writer
from rapc.durable.journal import Trace
from rapc.durable.runs import DurableRun, begin, resume
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.world import World

FAIL = Options(sync="off")


class Killed(BaseException):
    """The end of a process."""


class Traces(list[Trace]):
    """The files of traces that have been opened; a killed run does not close its file.

    Args:
        patch: replaces the class of these files.
    """

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        def opened(*args: Any) -> Trace:
            self.append(Trace(*args))
            return self[-1]

        patch.setattr(runs, "Trace", opened)

    def close(self) -> None:
        """Close the files."""
        while self:
            self.pop().close()


class Run:
    """A run with a journal, which may be killed and resumed.

    Args:
        folder: the folder for its files.
        library: the library.
        spec: the description of the run.
        world: makes its world.
    """

    def __init__(
        self,
        folder: Path,
        library: Program,
        spec: RunSpec,
        world: Callable[[], World],
    ) -> None:
        self.journal, self.trace = folder / "journal", folder / "trace.jsonl"
        self.library, self.spec, self._world = library, spec, world
        self.options = FAIL
        #: The treatment of a request for which a primitive says `ask`.
        self.decide: Callable[[Fact], str] = lambda request: "fail"

    def begin(self) -> DurableRun:
        """Begin the run."""
        run = Interpreter.prepared(self.library, self._world(), self.spec)
        until = self.spec.until
        return begin(self.journal, run, self.options, until=until, trace=self.trace)

    def resume(self, *, take_up: bool = False) -> DurableRun:
        """Resume the run."""
        return resume(
            self.journal,
            self.library,
            self._world(),
            options=self.options,
            decide=self.decide,
            trace=self.trace,
            take_up=take_up,
        )

    def whole(self) -> str:
        """Return the trace of the run without a journal."""
        run = Interpreter.prepared(self.library, self._world(), self.spec)
        trace = self.trace.with_suffix(".whole")
        with trace.open("w") as stream:
            run.listen(rapc.JsonTrace(stream))
            run.run(until=self.spec.until)
        return trace.read_text()


def kill_after(writes: int, patch: pytest.MonkeyPatch) -> None:
    """End the process after some writes of records from now on."""
    left = writes
    write = Writer.write

    def kill(self: Writer, data: bytes) -> None:
        nonlocal left
        write(self, data)
        left -= 1
        if left <= 0:
            raise Killed

    patch.setattr(Writer, "write", kill)
