"""Whatever a program hands to a public name is refused in words, not by accident.

Each function and class of `rapc` and `rapc.world`, each method of a run and of its
memory is called with nothing, with too much, with a keyword it does not know, and with
values of all sorts in each place. It may answer; it may raise a `rapc.Error` of one
line, or a `TypeError` that the call itself or a look at what it was given raises.
"""

from __future__ import annotations

import inspect
import math
import traceback
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest

import rapc
import rapc.world
from rapc.runtime.memory.access import MemoryView
from rapc.worlds.scripted import ScriptedWorld

PACKAGE = str(Path(rapc.__file__).parent)

LIBRARY = """
(declare-memory-property p (?item ?value) unknown)
(declare-primitive look () (okay))
(define-rap (go) (succeed (p a done)) (method (primitive (look))))
"""


class Word(str):
    """A symbol of a type of its own."""


ODD: tuple[Any, ...] = (
    *(None, math.nan, math.inf, 7, -1, 10**400, 1.5, True, 1j),
    *(b"x", "zzz", "", "(go", "x" * 10_000, "a\0b", "\ud800", Word("go"), Path("nope")),
    *([], [None], (), (None,), ("p", []), {}, {"a": None}, {1}),
    *(object(), len, int),
)

NOT_FOR_CALLERS = {"CheckError", "Plan", "RefusedError"}
"""Classes whose objects only rapc makes: with what it has at hand."""

LOOKS = ("__post_init__", "_look_at", "__init__", "_no_init_or_replace_init")
"""Where a `TypeError` is raised that says what a class of values is made of."""


@cache
def _library() -> rapc.CheckedLibrary:
    return rapc.loads(LIBRARY)


def _run() -> rapc.Interpreter:
    library = _library()
    return library.start(ScriptedWorld([], declared=library.program.library))


@cache
def _fitting() -> dict[str, Any]:
    """What fits a parameter, by its name."""
    return {
        **{"library": _library(), "program": _library().program, "run": _run()},
        **{"world": "truck", "tasks": "(go)", "task": "(go)", "goal": ("go",)},
        **{"text": "(define-rap (x))", "name": "p", "paths": "x.rap", "time": 5},
        **{"formula": "(p ?x ?y)", "action": len, "listener": len, "saved": b"x"},
        **{"seed": 0, "reason": "done", "settings": rapc.Settings()},
        **{"spec": rapc.RunSpec(), "number": 1},
    }


def _calls(
    call: Callable[..., Any],
) -> Iterator[tuple[str, tuple[Any, ...], dict[str, Any]]]:
    """Yield what to call with: a word on it, arguments, keywords."""
    yield "nothing", (), {}
    yield "too much", (None,) * 20, {}
    yield "an unknown keyword", (), {"nope": 1}
    try:
        found = list(inspect.signature(call).parameters.values())
    except ValueError:  # some that are compiled do not say
        return
    fitting = _fitting()
    by_place = [
        p for p in found if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)
    ]
    needed = [fitting.get(p.name) for p in by_place if p.default is p.empty]
    for at, one in enumerate(found):
        for odd in ODD:
            told = f"{one.name}={odd!a:.40}"
            if one.kind is one.KEYWORD_ONLY:
                yield told, tuple(needed), {one.name: odd}
            elif one.kind is not one.VAR_KEYWORD:
                before = [fitting.get(p.name) for p in by_place[:at]]
                yield told, (*before, odd, *needed[at + 1 :]), {}


def _amiss(
    call: Callable[..., Any], args: tuple[Any, ...], more: dict[str, Any]
) -> str:
    """Return what is wrong with how a call goes, or nothing."""
    try:
        call(*args, **more)
    except rapc.Error as error:
        return "" if error.message and "\n" not in error.message else "no line"
    except TypeError as error:
        frames = traceback.extract_tb(error.__traceback__)[1:]
        by_itself = not [f for f in frames if f.filename.startswith(PACKAGE)]
        if by_itself or frames[-1].name in LOOKS:
            return ""
        return f"{frames[-1].filename}:{frames[-1].lineno}: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def _of_run(name: str) -> Callable[..., Any]:
    found: Callable[..., Any] = getattr(_run(), name)
    return found


def _of_memory(name: str) -> Callable[..., Any]:
    found: Callable[..., Any] = getattr(_run().memory, name)
    return found


def _methods(kind: type) -> Iterator[str]:
    for name, _ in inspect.getmembers(kind, inspect.isroutine):
        if not name.startswith("_"):
            yield name


def _public() -> dict[str, Callable[[], Callable[..., Any]]]:
    """What is called, by name, each made anew for a call."""
    found: dict[str, Callable[[], Callable[..., Any]]] = {}
    for module in (rapc, rapc.world):
        for name in set(module.__all__) - NOT_FOR_CALLERS:
            one = getattr(module, name)
            is_protocol = getattr(one, "_is_protocol", False)
            if inspect.isroutine(one) or (inspect.isclass(one) and not is_protocol):
                found[f"{module.__name__}.{name}"] = partial(getattr, module, name)
    for name in _methods(rapc.Interpreter):
        found[f"run.{name}"] = partial(_of_run, name)
    for name in _methods(MemoryView):
        found[f"memory.{name}"] = partial(_of_memory, name)
    return dict(sorted(found.items()))


@pytest.mark.parametrize("name", _public())
def test_what_is_handed_over_wrongly_is_told_in_words(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    make = _public()[name]
    calls = list(_calls(make()))
    amiss = {told: _amiss(make(), args, more) for told, args, more in calls}
    assert {told: said for told, said in amiss.items() if said} == {}


def test_what_was_once_told_by_accident_is_told_in_words() -> None:
    run = _run()
    run.assert_fact("p", "a", "done")
    with pytest.raises(rapc.ArgumentError, match="the name of the property is missing"):
        run.memory.value()
    with pytest.raises(
        rapc.ArgumentError, match="an argument of the pattern is a list"
    ):
        run.memory.query("p", [])  # type: ignore[arg-type]
    with pytest.raises(rapc.ArgumentError, match="`library` is of type rapc"):
        run.extend(_library())  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="'nope'"):
        rapc.Settings(nope=1)  # type: ignore[call-arg]
    run.call_at(10**400, len)  # type: ignore[arg-type]


NOT_HELD: tuple[Any, ...] = (
    *(True, math.nan, math.inf, (), object(), 1j, None, [1], b"x"),
    *(Word("go"), "\ud800", "A b", "?x", "5", "a\x1b", rapc.world.Text("\ud800")),
)
"""Values that no run can hold: in no saved run, or in no text of a program."""

NOT_HELD_SAID = r"(invalid value .* in|an argument of) the (task|signal)"


@pytest.mark.parametrize("value", NOT_HELD, ids=range(len(NOT_HELD)))
def test_value_that_no_run_can_hold_is_refused_at_once(value: Any) -> None:
    library = rapc.loads("(declare-event :ring (?x)) (define-rap (order ?a))")
    run = library.start(ScriptedWorld([], declared=library.program.library))
    with pytest.raises(rapc.ArgumentError, match=NOT_HELD_SAID):
        run.submit(rapc.TaskRequest(("order", value)))
    with pytest.raises(rapc.ArgumentError, match=NOT_HELD_SAID):
        run.signal(":ring", value)
    assert run.results() == ()


@pytest.mark.parametrize(
    "given",
    [
        {"priority": 1.5},
        {"priority": True},
        {"deadline": "soon"},
        {"deadline": math.inf},
        {"at": -1},
        {"at": math.nan},
        {"background": 1},
    ],
    ids=ascii,
)
def test_task_request_of_other_types_is_refused_at_once(given: Any) -> None:
    with pytest.raises(rapc.ArgumentError, match="of a task is"):
        _run().submit(rapc.TaskRequest(("go",), **given))


@pytest.mark.parametrize(
    "given",
    [
        {"functions": [1]},
        {"solvers": "x"},
        {"comparators": "/"},
        {"functions": {1: len}},
        {"options": print},
        {"options": ("rooms", 1)},
        {"seed": None},
        {"seed": "x"},
        {"seed": True},
        {"seed": 1.0},
    ],
    ids=ascii,
)
def test_start_refuses_arguments_of_other_types(given: Any) -> None:
    (name,) = given
    with pytest.raises(rapc.ArgumentError, match=f"`{name}`"):
        _library().start("truck", **given)


def test_world_is_opened_with_a_whole_number_as_seed() -> None:
    with pytest.raises(rapc.ArgumentError, match="`seed`"):
        rapc.open_world("truck", None)  # type: ignore[arg-type]
