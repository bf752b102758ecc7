"""Pictures of the world in a trace, if the setting `rapc.pictures` is on."""

from __future__ import annotations

import msgspec

from rapc.base import pictures
from rapc.events import Pictured
from rapc.runtime.answers import RecordedWorld
from rapc.runtime.run import Run
from rapc.world import Drawable


def tell_picture(run: Run, drawn: Drawable) -> None:
    """Emit the change of the world's picture since the last one, if there is any.

    Raises:
        PortError: if the world's picture is invalid.
    """
    world = run.port.behind
    if isinstance(world, RecordedWorld):
        found = world.answers.ask("picture", (), drawn.picture)
    else:
        found = drawn.picture()
    text = msgspec.json.encode(pictures.plain(found)).decode()
    if text == run.state.picture:
        return
    before, after = map(msgspec.json.decode, (run.state.picture or "{}", text))
    run.state.picture = text
    run.recorder.emit(Pictured, changed=pictures.change(before, after))
