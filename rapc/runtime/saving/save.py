"""Save a run, or restore a saved run in place: completely, or not at all.

Not here: how values are saved (`codecs`), the contents of a run (`runs`), and the bytes
(`format`). Registrations of a host are not saved. Listeners stay registered when a run
is restored. Timers of the host cannot be saved: a run with timers is neither saved nor
replaced.
"""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.code_places import place_of
from rapc.base.values import Atom, format_atom
from rapc.errors import StateError
from rapc.runtime.held_world import OF_THE_BYTES
from rapc.runtime.run import Run
from rapc.runtime.saving.checks import check
from rapc.runtime.saving.codecs import WrongRecordError
from rapc.runtime.saving.format import RunRecord, decode_run, encode_run, not_a_run
from rapc.runtime.saving.runs import RestoredRun, capture, options_of
from rapc.world import Savable, World


def save(run: Run, seed: int) -> bytes:
    """Return a whole run as bytes, without changing the run.

    Raises:
        PortError: if the world breaks while it is saved.
        StateError: in the middle of a cycle, with timers of the host, or if the world
            cannot be saved.
    """
    if run.in_loop:
        raise StateError("a run cannot be saved in the middle of a cycle")
    if run.broken:
        raise StateError("the run ended in the middle of a cycle")
    _look_for_callbacks(run, "saved")
    return encode_run(capture(run, seed, _savable(run.port).save()))


def restore(run: Run, saved: bytes) -> int:
    """Replace the contents of `run` by those of a saved run; return the seed.

    Raises:
        StateError: for bytes that are no saved run of this library, this world and
            these settings; then nothing has changed. Also as `save`, except after an
            aborted run.
        PortError: if the world breaks while it is restored.
    """
    if run.in_loop:
        raise StateError("a run cannot be replaced in the middle of a cycle")
    _look_for_callbacks(run, "replaced")
    world = _savable(run.port)
    record = decode_run(saved)
    _look_whose(run, record)
    try:
        restored = RestoredRun(run, record)
        check(restored)
    except WrongRecordError as error:
        raise not_a_run(error) from error
    before = world.save()
    try:
        world.restore(record.world)
    except OF_THE_BYTES as error:
        raise not_a_run(error) from error
    if run.port.now() < record.time:
        world.restore(before)
        raise not_a_run(ValueError("its world is at an earlier time"))
    restored.install()
    run.broken = False
    return record.seed


def _look_whose(run: Run, record: RunRecord) -> None:
    """Check that a saved run is of this library, world and settings."""
    if record.library != run.library.digest:
        raise StateError("the saved run belongs to another library")
    if record.world_name != run.port.name:
        raise StateError(
            f"the saved run belongs to the world `{record.world_name}`, "
            f"not `{run.port.name}`"
        )
    if record.settings != run.settings:
        raise StateError("the saved run has different settings")
    mine, its = options_of(run.port), record.options
    for name in sorted({*mine, *its}):
        if mine.get(name) != its.get(name):
            raise StateError(
                f"the saved run has a different value of the option "
                f"`{run.port.name}.{name}`: {_option(its.get(name))}, "
                f"not {_option(mine.get(name))}"
            )


def _option(value: Atom | bool | None) -> str:
    """Return the value of an option as text, cut if it is long."""
    if value is None:
        return "nothing"
    return f"`{str(value).lower() if isinstance(value, bool) else value!s:.40}`"


def _savable(world: World) -> Savable:
    if not isinstance(world, Savable):
        raise StateError(f"the world `{world.name}` cannot be saved")
    return world


def _look_for_callbacks(run: Run, done: str) -> None:
    """Refuse a run that would lose callbacks of its host."""
    timers = sorted((time, number) for time, number, _ in run.host_timers)
    actions = {number: action for _, number, action in run.host_timers}
    waiting = {
        "call_at": [
            f"{_named(actions[number])} at {format_atom(time)}"
            for time, number in timers
        ],
        "call_at_end": [_named(action) for action in run.at_end],
        "call_when_waiting": [_named(action) for action in run.when_waiting],
    }
    for asked, named in waiting.items():
        if named:
            listed = ", ".join(dict.fromkeys(named))
            raise StateError(
                f"the run cannot be {done}: the host has set `{asked}`: {listed}"
            )


def _named(action: Callable[[], None]) -> str:
    """Return the name of a callable of the host, with its file and line."""
    name = getattr(action, "__qualname__", type(action).__qualname__)
    return f"`{name}`{place_of(action)}"
