"""The prompt: input on a terminal with completion and colours, and output.

All code that depends on terminals is in this module. Not here: the meaning of an input
(`rapc.repl.shell`).
"""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from prompt_toolkit import PromptSession
from prompt_toolkit.application import Application
from prompt_toolkit.application.current import get_app_or_none
from prompt_toolkit.auto_suggest import AutoSuggestFromHistory
from prompt_toolkit.buffer import Buffer
from prompt_toolkit.completion import (
    CompleteEvent,
    Completer,
    Completion,
    ThreadedCompleter,
)
from prompt_toolkit.document import Document
from prompt_toolkit.formatted_text import StyleAndTextTuples
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings
from prompt_toolkit.key_binding.key_processor import KeyPressEvent
from prompt_toolkit.layout.processors import HighlightMatchingBracketProcessor
from prompt_toolkit.lexers import Lexer
from prompt_toolkit.shortcuts import CompleteStyle
from prompt_toolkit.styles import Style

from rapc.base.values import readable
from rapc.base.visible import visible
from rapc.debug.answer import Answer, say
from rapc.debug.arguments import is_balanced
from rapc.language.highlight import indentation, tokens
from rapc.repl.complete import candidates
from rapc.repl.draw import draw
from rapc.repl.shell import Shell

_STYLE = Style.from_dict(
    {
        "comment": "italic ansigray",
        "string": "ansigreen",
        "variable": "ansicyan",
        "keyword": "ansimagenta",
        "number": "ansiyellow",
        "form": "bold",
        "clause": "bold",
        "operator": "bold",
        "word": "bold",
        "bottom-toolbar": "noreverse ansigray",
    }
)

GREETING = "`:help` lists the commands; Tab completes; Ctrl-D quits"


class _Completer(Completer):
    """A completer that uses the completions of the shell."""

    def __init__(self, shell: Shell) -> None:
        self._shell = shell

    def get_completions(
        self, document: Document, complete_event: CompleteEvent
    ) -> Iterable[Completion]:
        """Yield the completions at the cursor."""
        for one in candidates(self._shell, document.text_before_cursor):
            yield Completion(
                one.text,
                start_position=-one.replaces,
                display_meta=visible(" ".join(one.doc.split())),
            )


class _Lexer(Lexer):
    """A lexer that colours RAP text."""

    def lex_document(self, document: Document) -> Callable[[int], StyleAndTextTuples]:
        """Return a function from a line number to the coloured parts of the line."""
        lines: list[StyleAndTextTuples] = [[]]
        for kind, said in tokens(document.text):
            for at, part in enumerate(said.split("\n")):
                if at:
                    lines.append([])
                lines[-1].append((f"class:{kind}", part))
        return lambda number: lines[number] if number < len(lines) else []


def _keys() -> KeyBindings:
    """Return the key bindings: Enter sends a complete input or starts a new line."""
    keys = KeyBindings()

    @keys.add("enter")
    def _(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        text = buffer.text
        if text.lstrip().startswith(":") or is_balanced(text):
            buffer.validate_and_handle()
        else:
            before = buffer.document.text_before_cursor
            buffer.insert_text("\n" + " " * indentation(before))

    return keys


class Prompt:
    """A prompt that reads inputs from a terminal and writes answers.

    Args:
        shell: the shell that answers inputs.
        color: whether answers are coloured.
        history: the file of earlier inputs; None to save no inputs.
    """

    def __init__(self, shell: Shell, *, color: bool, history: Path | None) -> None:
        self._shell = shell
        self._color = color
        self._session: PromptSession[str] = PromptSession(
            message="rapc> ",
            lexer=_Lexer() if color else None,
            completer=ThreadedCompleter(_Completer(shell)),
            complete_while_typing=False,
            complete_style=CompleteStyle.MULTI_COLUMN,
            history=_history(history),
            auto_suggest=AutoSuggestFromHistory(),
            enable_history_search=True,
            multiline=True,
            prompt_continuation="      ",
            key_bindings=_keys(),
            input_processors=[HighlightMatchingBracketProcessor()],
            bottom_toolbar=self._toolbar,
            interrupt_exception=_ClearedError,
            style=_STYLE,
        )
        self._typed = False
        self._session.default_buffer.on_text_changed += self._note_typed

    def _note_typed(self, buffer: Buffer) -> None:
        self._typed = True

    def run(self) -> None:
        """Answer inputs until the user leaves."""
        interrupts = _Interrupts(self._shell)
        with interrupts.handled():
            self._answer_inputs(interrupts)

    def _answer_inputs(self, interrupts: _Interrupts) -> None:
        shell = self._shell
        greeting = [f"{shell.history.stand()}; {GREETING}"]
        if shell.recording:
            told = f"recorded run: {shell.recording}; use `:goto end` to go to its end"
            greeting.insert(0, told)
        self._write(say(*greeting))
        interrupted = False
        while not shell.left:
            self._typed = False
            try:
                text = interrupts.read(self._session)
            except EOFError:
                return
            except KeyboardInterrupt:
                if interrupted and not self._typed:
                    return
                interrupted = True
                sys.stdout.write("press Ctrl-C again to quit\n")
                continue
            interrupted = False
            self._write(shell.answer(text))

    def _write(self, answer: Answer) -> None:
        width = shutil.get_terminal_size().columns
        sys.stdout.write(draw(answer, width, color=self._color))
        sys.stdout.flush()

    def _toolbar(self) -> str:
        history = self._shell.history
        if not history.is_run:
            return visible(history.stand())
        words = [f"time {readable(history.now)}", f"cycle {history.cycle}"]
        if history.branch.name != "main":
            words.append(history.branch.name)
        if history.over:
            words.append(f"ended ({history.reason})")
        entries = {entry.task: entry for entry in history.run.agenda()}
        entry = entries.get(history.selected or 0)
        more: list[str] = []
        if entry is not None:
            more.append(f"[{entry.task}] {entry.goal}")
            top = entries.get(entry.family)
            if top is not None and top is not entry:
                more.append(f"for [{top.task}] {top.goal}")
        width = shutil.get_terminal_size().columns - 1
        while more and len("  ".join([*words, *more])) > width:
            more.pop()
        return visible("  ".join([*words, *more]))[: max(width, 1)]


class _ClearedError(Exception):
    """An input cleared by Ctrl-C. KeyboardInterrupt would end the event loop early."""


class _Interrupts:
    """The handling of Ctrl-C in a session.

    The first Ctrl-C pauses the run, the second interrupts the command. While the user
    types an input, Ctrl-C clears the input. The terminal then reports Ctrl-C as a key.
    Ctrl-C arrives as a signal if another process sends the signal, or while the prompt
    starts or ends. The default handler of the prompt is not used, because that handler
    fails after the input is sent.

    Args:
        shell: the shell whose run is paused.
    """

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        self._times = 0
        #: Whether the prompt starts, reads or ends: an exception between two
        #: instructions of its event loop would leave the loop half made or half closed.
        self._prompts = False

    @contextmanager
    def handled(self) -> Iterator[None]:
        """Handle the signal in the block."""
        before = signal.signal(signal.SIGINT, self._take)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)

    def read(self, session: PromptSession[str]) -> str:
        """Return an input.

        Raises:
            EOFError: at the end of the inputs.
            KeyboardInterrupt: if Ctrl-C has cleared the input, or was pressed twice
                after the input was sent.
        """
        self._prompts = True
        try:
            text = session.prompt(pre_run=self._forget, handle_sigint=False)
        except _ClearedError:
            raise KeyboardInterrupt from None
        finally:
            self._prompts = False
        if self._times > 1:
            raise KeyboardInterrupt
        return text

    def _forget(self) -> None:
        self._times = 0
        self._shell.history.pause(False)

    def _take(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        prompt = get_app_or_none()
        if prompt is not None and prompt.loop is not None and _is_typed(prompt):
            prompt.loop.call_soon_threadsafe(self._clear, prompt)
        else:
            self._pause()

    def _clear(self, prompt: Application[str]) -> None:
        if _is_typed(prompt):
            prompt.exit(exception=_ClearedError(), style="class:aborting")
        else:
            self._pause()

    def _pause(self) -> None:
        self._times += 1
        if self._times > 1 and not self._prompts:
            raise KeyboardInterrupt
        self._shell.history.pause()


def _is_typed(prompt: Application[str]) -> bool:
    """Return whether the input of a prompt is not yet sent."""
    return prompt.future is not None and not prompt.future.done()


def history_file(path: str | None) -> Path:
    """Return the path of the file that keeps inputs between sessions.

    Args:
        path: the library or the recording; each has inputs of its own.
    """
    state = os.environ.get("XDG_STATE_HOME") or "~/.local/state"
    whole = str(Path(path).resolve()) if path else ""
    digest = hashlib.sha256(whole.encode("utf-8", "surrogateescape")).hexdigest()
    name = f"{Path(whole).name or 'typed'}-{digest[:12]}"
    return Path(state).expanduser() / "rapc" / "inputs" / name


def _history(path: Path | None) -> History:
    if path is None:
        return InMemoryHistory()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a", encoding="utf-8"):
            return FileHistory(str(path))
    except OSError:  # the folder is not writable: save no inputs
        return InMemoryHistory()
