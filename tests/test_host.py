"""What a caller in Python gets, and what it gets told for wrong arguments."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.worlds.scripted import ScriptedWorld

LAMPS = Path(__file__).parent / "worlds" / "lamps" / "lamps.rap"
WORLD = "tests.worlds.lamps.lamps:LampWorld"
DOOR: Any = rapc
"""The package without its types: its functions may be called with anything."""


@pytest.fixture(scope="module")
def lamps() -> rapc.CheckedLibrary:
    return rapc.load(LAMPS)


def test_a_path_may_be_text_a_path_or_in_a_list(lamps: rapc.CheckedLibrary) -> None:
    for paths in ((str(LAMPS),), (LAMPS,), ([str(LAMPS)],), ([LAMPS, LAMPS],)):
        assert DOOR.load(*paths).raps == lamps.raps == ("light", "light-all")


def test_tasks_may_be_text_requests_or_several(lamps: rapc.CheckedLibrary) -> None:
    request = rapc.TaskRequest(("light", "room-1"))
    for tasks in ("(light room-1)", request, ["(light room-1)"], [request]):
        result = DOOR.run(lamps, WORLD, tasks, seed=3)
        assert result.succeeded
        assert [str(task.goal) for task in result.tasks] == ["(light room-1)"]


def test_a_world_may_be_a_name_a_class_or_an_object(lamps: rapc.CheckedLibrary) -> None:
    from tests.worlds.lamps.lamps import LampWorld  # noqa: PLC0415  # one of the three

    made = rapc.open_world(WORLD, seed=3, every=50)
    times = set()
    for world, options in (
        (WORLD, {"every": 50}),
        (LampWorld, {"every": 50}),
        (made, None),
    ):
        result = DOOR.run(lamps, world, "(light-all)", seed=3, options=options)
        assert result.succeeded
        times.add(result.time)
    assert len(times) == 1


def test_a_run_is_stepped_and_given_tasks_as_text(lamps: rapc.CheckedLibrary) -> None:
    run = lamps.start(WORLD, seed=3, facts=["(lamp-state room-2 on)"])
    run.submit("(light room-2)")
    run.submit("(light room-1) :priority 3")
    assert [entry.priority for entry in run.agenda()] == [0, 3]
    while run.step():
        pass
    assert run.reason == "done"
    assert [task.outcome for task in run.results()] == ["succeeded", "succeeded"]


def test_a_saved_library_is_loaded_like_its_sources(
    lamps: rapc.CheckedLibrary, tmp_path: Path
) -> None:
    from rapc.library.saved import encode  # noqa: PLC0415  # nowhere else here

    file = tmp_path / "lamps.rapc"
    file.write_bytes(encode(lamps.program.library, lamps.name))
    assert rapc.load(file).raps == lamps.raps


ANY: Any = 3
NEXT: Any = "soon"


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda lib: DOOR.load(), rapc.ArgumentError, "missing path"),
        (lambda lib: DOOR.load(3), rapc.ArgumentError, "a path is of type int"),
        (lambda lib: DOOR.load(["a", 3]), rapc.ArgumentError, "a path is of type int"),
        (lambda lib: DOOR.load("nowhere"), rapc.LoadError, "`nowhere` does not exist"),
        (lambda lib: DOOR.check("nowhere"), rapc.LoadError, "does not exist"),
        (lambda lib: DOOR.loads(LAMPS), rapc.ArgumentError, "the text is of type"),
        (lambda lib: DOOR.run("lib", WORLD, "(a)"), rapc.ArgumentError, "is a text"),
        (lambda lib: DOOR.run(lib, 3, "(a)"), rapc.ArgumentError, "not a world"),
        (lambda lib: DOOR.run(lib, WORLD, 3), rapc.ArgumentError, "`tasks` is of type"),
        (
            lambda lib: DOOR.run(lib, WORLD, [3]),
            rapc.ArgumentError,
            "a task is of type",
        ),
        (lambda lib: DOOR.run(lib, WORLD, "(light"), rapc.TextError, "is not closed"),
        (lambda lib: DOOR.run(lib, WORLD, "(lihgt a)"), rapc.RefusedError, "`light`"),
        (
            lambda lib: DOOR.run(lib, WORLD, "(light a)", until="3"),
            rapc.ArgumentError,
            "`until` is a text",
        ),
        (
            lambda lib: lib.start(WORLD, facts=["(lamp-stat a on)"]),
            rapc.FactError,
            "lamp-stat",
        ),
        (
            lambda lib: lib.start(WORLD, options={"rooms": "3"}),
            rapc.WorldError,
            "`lamps.rooms` takes one integer, not `'3'`",
        ),
        (
            lambda lib: lib.start(WORLD, options={"room": 3}),
            rapc.WorldError,
            "has no option `room`",
        ),
        (
            lambda lib: lib.start(rapc.open_world(WORLD), options={"rooms": 3}),
            rapc.ArgumentError,
            "options require the name or class",
        ),
        (lambda lib: DOOR.methods("(metod)"), rapc.TextError, "metod"),
        (lambda lib: DOOR.methods(""), rapc.TextError, "expected methods"),
        (lambda lib: lib.extend(3), rapc.ArgumentError, "the text is of type int"),
        (lambda lib: rapc.open_world(ANY), rapc.ArgumentError, "name of a world is"),
        (
            lambda lib: DOOR.run(lib, WORLD, until=math.nan),
            rapc.ArgumentError,
            "`until` is nan, not a time",
        ),
        (
            lambda lib: lib.start(WORLD, settings=rapc.Settings(query_steps=-1)),
            rapc.SettingError,
            "value that it does not take",
        ),
        (
            lambda lib: lib.start(WORLD, settings=ANY),
            rapc.ArgumentError,
            "`settings` is of type int",
        ),
        (lambda lib: lib.start(WORLD).submit(ANY), rapc.ArgumentError, "a task is"),
        (lambda lib: lib.start(WORLD).listen(ANY), rapc.ArgumentError, "a listener"),
        (
            lambda lib: lib.start(WORLD).watch_contexts(ANY),
            rapc.ArgumentError,
            "a listener is",
        ),
        (
            lambda lib: lib.start(WORLD).call_at(ANY, ANY),
            rapc.ArgumentError,
            "`action` is",
        ),
        (
            lambda lib: lib.start(WORLD).call_at(NEXT, print),
            rapc.ArgumentError,
            "`time` is a text, not a time",
        ),
        (
            lambda lib: lib.start(WORLD).call_at_end(ANY),
            rapc.ArgumentError,
            "`action` is",
        ),
        (
            lambda lib: lib.start(WORLD).call_when_waiting(ANY),
            rapc.ArgumentError,
            "`action` is",
        ),
        (
            lambda lib: lib.start(WORLD).question(ANY),
            rapc.ArgumentError,
            "a query is of type int",
        ),
        (
            lambda lib: lib.start(WORLD).question("(lmap ?x)"),
            rapc.TextError,
            "unknown predicate `lmap`",
        ),
        (
            lambda lib: lib.start(WORLD).question("(= ?x 3)", "?y"),
            rapc.TextError,
            "`?y` is not in the query",
        ),
    ],
)
def test_what_a_caller_gets_wrong_is_told_in_a_line(
    call: Any, error: type[rapc.Error], said: str, lamps: rapc.CheckedLibrary
) -> None:
    with pytest.raises(error) as caught:
        call(lamps)
    assert said in caught.value.message
    assert "\n" not in caught.value.message


UNBOUND = (
    "(define-rap (go) (succeed (last-result okay)) (method (task-net (t1 (at ?x)))))"
)
AT = "(define-rap (at ?place) (succeed nil))"


def test_library_is_linked_without_the_checker(tmp_path: Path) -> None:
    (tmp_path / "a.rap").write_text(UNBOUND + AT)
    with pytest.raises(rapc.CheckError):
        rapc.load(tmp_path)
    for library in (
        rapc.load(tmp_path, check=False),
        rapc.loads(UNBOUND + AT, check=False),
    ):
        assert library.raps == ("go", "at")
        result = rapc.run(library, ScriptedWorld([]), "(go)", cycles=20)
        assert result.tasks[0].outcome == "failed"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("(define-rap (go) (succeed", rapc.CheckError),
        (AT + AT, rapc.CheckError),
        ('(require "nowhere")', rapc.CheckError),
        (UNBOUND, rapc.RefusedError),
        ("(define-rap (go) (succeed (nothing)))", rapc.RefusedError),
    ],
)
def test_library_that_cannot_be_run_is_not_linked(
    text: str, kind: type[rapc.Error]
) -> None:
    with pytest.raises(kind):
        rapc.loads(text, check=False)


def test_result_leads_to_the_figures_of_the_world() -> None:
    library = rapc.load("rapc:truck")
    result = rapc.run(library, "truck", seed=1)
    assert result.world is result.run.world
    assert isinstance(result.world, rapc.world.Measured)
    assert result.world.figures()


def test_names_of_the_package_are_the_public_ones() -> None:
    own = {name for name in dir(rapc) if not name.startswith("__")}
    assert own == {name for name in rapc.__all__ if name != "__version__"}
