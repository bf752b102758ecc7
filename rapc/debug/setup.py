"""What a run is made with: its library and the settings of the interpreter."""

from __future__ import annotations

from typing import NamedTuple, Self

from rapc.compiler.program import Program
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.format import encode
from rapc.runtime.saving.records import RunRecord
from rapc.runtime.settings import Settings


class Setup(NamedTuple):
    """A library and settings; what a run has in memory is built by them."""

    program: Program
    settings: Settings

    @classmethod
    def of(cls, run: Interpreter) -> Self:
        """Return what a run is made with."""
        return cls(run.machine.library, run.settings)

    def made(self, run: Interpreter) -> Interpreter:
        """Return a run that is made so, in the world of another and with its listeners.

        It is `run` itself if that is made so. Another one stands nowhere before a state
        is restored in it.

        Raises:
            RefusedError: if the library cannot be run in the world.
        """
        if run.machine.library is self.program and run.settings == self.settings:
            return run
        return run.remade(self.program, self.settings)

    def taken_up(self, run: Interpreter, record: RunRecord) -> Interpreter:
        """Return a run that is made so and stands where a record says.

        Args:
            run: the run that it takes the place of; nothing changes in that.
            record: the state, as this library and these settings have it.

        Raises:
            RefusedError: if the library cannot be run in the world.
            StateError: if the record is no state of such a run.
        """
        found = run.remade(self.program, self.settings)
        found.restore(encode(record))
        return found
