"""Ctrl-C as a signal, sent at a moment that is chosen: none is lost, none fails."""

from __future__ import annotations

import asyncio
import signal
from asyncio import AbstractEventLoop
from collections.abc import Callable, Iterator

import pytest
from prompt_toolkit.application import Application, create_app_session
from prompt_toolkit.input import PipeInput, create_pipe_input
from prompt_toolkit.output import DummyOutput

from rapc.repl.prompt import Prompt
from tests.repl.shells import truck_shell

TASK = "(rock-order red 1)"


@pytest.fixture
def keys() -> Iterator[PipeInput]:
    """What is typed."""
    with (
        create_pipe_input() as typed,
        create_app_session(input=typed, output=DummyOutput()),
    ):
        yield typed


def _run(
    do: Callable[[Application[str]], None], capsys: pytest.CaptureFixture[str]
) -> str:
    """Return what a prompt says whose every drawing is followed by `do`."""
    prompt = Prompt(truck_shell(TASK), color=False, history=None)
    prompt._session.app.after_render += do
    prompt.run()
    said = capsys.readouterr()
    assert said.err == ""
    return said.out


def test_a_signal_after_the_input_was_sent_pauses_the_run(
    keys: PipeInput, capsys: pytest.CaptureFixture[str]
) -> None:
    """The prompt is drawn once more when it has its input, and still has the signal."""
    sent: list[str] = []

    def interrupt(app: Application[str]) -> None:
        if app.is_done and not sent:
            sent.append("Ctrl-C")
            signal.raise_signal(signal.SIGINT)

    keys.send_text(":show none\r:run\r:quit\r")
    said = _run(interrupt, capsys)
    assert sent
    assert "Exception" not in said
    assert "paused" not in said  # `:show` has nothing to pause, and it is forgotten

    sent.clear()
    keys.send_text(":run\r:quit\r")
    said = _run(interrupt, capsys)
    assert "paused\ncycle 1, time 0" in said


def test_a_signal_while_an_input_is_typed_clears_it(
    keys: PipeInput, capsys: pytest.CaptureFixture[str]
) -> None:
    sent: list[str] = []

    def interrupt(app: Application[str]) -> None:
        if sent == ["Ctrl-C"] and app.is_done:
            sent.append(":to 2")
            keys.send_text(":to 2\r:quit\r")
        if not app.is_done and app.current_buffer.text == ":step" and not sent:
            sent.append("Ctrl-C")
            signal.raise_signal(signal.SIGINT)

    keys.send_text(":step")
    said = _run(interrupt, capsys)
    assert sent
    assert "press Ctrl-C again to quit" in said
    assert "cycle 2, time 0" in said
    assert "cycle 3" not in said


def test_two_signals_after_the_input_was_sent_take_it_back(
    keys: PipeInput, capsys: pytest.CaptureFixture[str]
) -> None:
    sent: list[str] = []

    def interrupt(app: Application[str]) -> None:
        if app.is_done and not sent:
            sent.append("twice")
            keys.send_text(":quit\r")
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)

    keys.send_text(":run\r")
    said = _run(interrupt, capsys)
    assert sent
    assert "press Ctrl-C again to quit" in said
    assert "considering" not in said


def test_signals_while_the_prompt_starts_are_forgotten(
    keys: PipeInput,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No event loop, nor the coroutine of the prompt, is left half made."""
    sent: list[str] = []
    make = asyncio.events.new_event_loop

    def interrupted() -> AbstractEventLoop:
        loop = make()
        if not sent:
            sent.append("twice")
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
        return loop

    monkeypatch.setattr(asyncio.events, "new_event_loop", interrupted)
    keys.send_text(":step\r:quit\r")
    said = _run(lambda app: None, capsys)
    assert sent
    assert "press Ctrl-C" not in said
    assert "cycle 1, time 0" in said
