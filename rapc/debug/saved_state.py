"""The file of a saved state: a run at a moment, with the text of its library.

The file is data from any source: all that is read from it is checked. A run with
another library continues the state by the rules of a reload (`rapc.debug.reload`).
"""

from __future__ import annotations

from pathlib import Path

import msgspec

from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.source import SourceFile
from rapc.base.values import Atom
from rapc.compiler.program import Program
from rapc.debug.acts import ForcedWorld
from rapc.debug.reload import TakeUp
from rapc.errors import Error, StateError
from rapc.host import find_plan, linked
from rapc.library.loader import load_sources
from rapc.library.signatures import Signatures
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.format import RunRecord, decode_run
from rapc.spec import RunSpec
from rapc.world import Callables, Time, World
from rapc.worlds.faults import FaultyWorld, InjectedFault, problem
from rapc.worlds.registry import check_options

_KIND = b"rapc-state "
_MARK = _KIND + b"1\n"
"""The first bytes of a file: the kind of file and the version of its format."""


def is_saved_state(path: Path) -> bool:
    """Return whether a path is a file with a saved state, of any version."""
    try:
        with path.open("rb") as file:
            return file.read(len(_KIND)) == _KIND
    except OSError:
        return False


class _Contents(msgspec.Struct, frozen=True):
    """The contents of a file after its mark, as JSON."""

    #: The name and the text of each file of the library.
    sources: tuple[tuple[str, str], ...]
    #: The faults of the world.
    faults: tuple[InjectedFault, ...]
    #: Whether the world may have results that the user has forced (`ForcedWorld`).
    forced: bool
    #: The state of the run and its world; see `Interpreter.save`.
    run: bytes


def state_file(run: Interpreter) -> bytes:
    """Return the contents of the file for the present state of a run.

    Raises:
        StateError: as `Interpreter.save`.
        PortError: if the world breaks while it is saved.
    """
    files = run.library.library.files.values()
    sources = tuple([(file.name, file.text) for file in files])
    world: World = run.port.behind
    forced = isinstance(world, ForcedWorld)
    if isinstance(world, ForcedWorld):
        world = world.behind
    faults = world.faults if isinstance(world, FaultyWorld) else ()
    contents = _Contents(sources, faults, forced, run.save())
    return _MARK + msgspec.json.encode(contents)


class SavedState:
    """The state in a file, to be continued with any library of the same declarations.

    Args:
        data: the contents of the file.

    Raises:
        StateError: if `data` is not a saved state of this version of rapc.
    """

    def __init__(self, data: bytes) -> None:
        if not data.startswith(_KIND):
            raise StateError("the file is not a saved state")
        if not data.startswith(_MARK):
            raise StateError("another version of rapc wrote the saved state")
        try:
            self._contents = msgspec.json.decode(data[len(_MARK) :], type=_Contents)
        except UNREADABLE as error:
            raise StateError(f"the saved state is damaged: {flaw(error)}") from error
        self._record: RunRecord = decode_run(self._contents.run)

    def options_of(self, world: type[World]) -> dict[str, Atom | bool]:
        """Return the options of the world of the state.

        Args:
            world: the class of the world that is expected.

        Raises:
            StateError: if the state belongs to another world.
            WorldError: if the world does not have these options.
        """
        saved = self._record.world_name
        if saved != world.name:
            raise StateError(f"the saved state belongs to the world `{saved:.60}`")
        return check_options(world, self._record.options)

    @property
    def world(self) -> str:
        """Return the name of the world of the state."""
        return self._record.world_name

    @property
    def seed(self) -> int:
        """Return the seed of the run."""
        return self._record.seed

    @property
    def time(self) -> Time:
        """Return the time of the state."""
        return self._record.time

    def continued(
        self, library: Program, world: World, functions: Callables
    ) -> Interpreter:
        """Return a run of a library that continues the state.

        Args:
            library: the library; its text may differ from that of the saved run.
            world: a world made with the options of the state.
            functions: as for `Interpreter`.

        Raises:
            RefusedError: if the library does not fit the state.
            StateError: if the state is damaged, or does not belong to the world.
            PortError: if the world breaks.
        """
        is_same = library.digest == self._record.library
        saved = library if is_same else self.library()
        spec = RunSpec(seed=self.seed, settings=self._record.settings.named())
        world = self._with_faults(world)
        run = Interpreter.prepared(
            saved, world, spec, functions=functions, planner=find_plan
        )
        run.restore(self._contents.run)
        return run if is_same else TakeUp(library, ()).do(run)

    def _with_faults(self, world: World) -> World:
        """Return a world inside the wrappers that the world of the state had."""
        faults = self._contents.faults
        for fault in faults:
            wrong = problem(fault, Signatures.offered(world.kit.offer))
            if wrong is not None:
                raise StateError(f"the saved state is damaged: {wrong}")
        world = FaultyWorld(world, faults, self.seed) if faults else world
        return ForcedWorld(world) if self._contents.forced else world

    def library(self) -> Program:
        """Return the library of the saved run.

        Raises:
            StateError: if the state is damaged.
        """
        sources = [SourceFile(name, text) for name, text in self._contents.sources]
        try:
            return linked(load_sources(sources), "saved state").program
        except Error as error:
            raise StateError(f"the saved state is damaged: {error}") from error
