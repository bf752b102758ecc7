"""Options changed while a run goes on: settings of the interpreter, some of a world's.

A change is an act: it goes back with the run, and is made again where it was made.
Settings are part of what a run is made with; options of a world part of its state.
"""

from __future__ import annotations

from msgspec.structs import replace

from rapc.base.names import hint
from rapc.base.values import Atom, Text, typed
from rapc.debug.acts import Act, taken_up
from rapc.errors import ArgumentError
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.format import decode_run
from rapc.runtime.settings import Settings, read_settings
from rapc.world import Adjustable, innermost
from rapc.worlds.registry import read_options

OWN = "rapc"
"""What owns the settings of the interpreter, as in `--set rapc.futile-limit=3`."""


class ChangeOption(Act, frozen=True):
    """Lets a run go on with another setting, or with another option of its world."""

    #: `rapc`, or the name of the world.
    owner: str
    name: str
    value: Atom | bool

    def do(self, run: Interpreter) -> Interpreter | None:
        """Change the option.

        Raises:
            ArgumentError: if the world does not let it be changed, or not so.
            PortError: if the world breaks.
            StateError: if the run cannot be saved: another setting makes it anew.
        """
        if self.owner == OWN:
            settings = replace(run.settings, **{_field(self.name): self.value})
            record = replace(decode_run(run.save()), settings=settings)
            return taken_up(run, run.machine.library, record)
        world = run.machine.world
        if not isinstance(world, Adjustable):
            raise ArgumentError(
                f"the world `{world.name}` lets no option be changed while it runs"
            )
        try:
            text = isinstance(self.value, Text)
            world.adjust(self.name, typed(self.value) if text else self.value)
        except ValueError as said:
            raise ArgumentError(f"the world `{world.name}` refuses: {said}") from said
        return None

    def __str__(self) -> str:
        return f"option {self.owner}.{self.name} {typed(self.value)}"


def _field(name: str) -> str:
    """Return the field of the settings that a name stands for."""
    return name.replace("-", "_")


def changeable_options(run: Interpreter) -> dict[str, Atom | bool]:
    """Return what can be changed while a run goes on, `owner.name`, with its value.

    Raises:
        PortError: if the world breaks, or returns no mapping.
    """
    names = Settings.__struct_fields__
    own = {f"{OWN}.{n.replace('_', '-')}": getattr(run.settings, n) for n in names}
    world = run.machine.world
    known = world.adjustable() if isinstance(world, Adjustable) else {}
    return own | {f"{world.name}.{name}": value for name, value in known.items()}


def change_option(run: Interpreter, owner: str, name: str, text: str) -> Act:
    """Return the act that gives an option another value.

    Args:
        run: the run.
        owner: `rapc`, or the name of the world.
        name: the name of the option.
        text: the value, as it is typed.

    Raises:
        SettingError: for a setting that is none, or a value that it does not take.
        WorldError: for an option that the world has not, or a value of another kind.
        ArgumentError: for another owner, or an option of a world that stays as it is.
    """
    world = run.machine.world
    if owner == OWN:
        value = getattr(read_settings({name: text}), _field(name))
        return ChangeOption(owner, name, value)
    if owner != world.name:
        raise ArgumentError(f"`{owner}` is neither `{OWN}` nor `{world.name}`")
    read = read_options(type(innermost(world)), {name: text})
    if isinstance(world, Adjustable) and name not in (known := world.adjustable()):
        said = f"`{owner}.{name}` counts at the beginning of a run alone"
        raise ArgumentError(said + hint(name, known))
    return ChangeOption(owner, name, read[name])
