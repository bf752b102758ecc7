"""A debugger on a real pseudo-terminal, and the screen that a person would see."""

from __future__ import annotations

import os
import termios
from contextlib import suppress
from pathlib import Path

import pexpect
import pyte

from tests.cli.command import COMMAND, HOME, PATIENCE


class _Screen(pyte.Screen):
    """A screen that answers what the program asks of its terminal."""

    child: pexpect.spawn[str] | None = None

    def write_process_input(self, data: str) -> None:
        """Send an answer to the program."""
        if self.child is not None:
            self.child.send(data)


class Terminal:
    """`rapc repl` with the truck on a terminal.

    Args:
        columns: how wide it is.
        home: the home of the user, where inputs are kept.
        args: what else the command is given.
    """

    def __init__(self, columns: int, home: Path, *args: str) -> None:
        self._screen = _Screen(columns, 60)
        self._stream = pyte.Stream(self._screen)
        self.child = pexpect.spawn(
            str(COMMAND),
            ["repl", "examples/rock-order.rap", "--world", "truck", *args],
            dimensions=(60, columns),
            env={
                **HOME,
                "PATH": os.environ.get("PATH", ""),
                "HOME": str(home),
                "TERM": "xterm-256color",
                "LANG": "C.UTF-8",
            },
            encoding="utf-8",
            timeout=PATIENCE,
        )
        self._screen.child = self.child

    def see(self, text: str) -> None:
        """Read until a text stands on the screen, however it is broken into lines.

        Raises:
            AssertionError: if nothing comes any more and it does not.
        """
        while "".join(text.split()) not in self._all():
            try:
                self._stream.feed(self.child.read_nonblocking(4096, timeout=PATIENCE))
            except (pexpect.TIMEOUT, pexpect.EOF) as end:
                raise AssertionError(f"{text!r} is not in {self.lines()}") from end

    def _all(self) -> str:
        return "".join("".join(self._screen.display).split())

    def until_carried_out(self) -> None:
        """Read until the input is taken: the prompt has left the terminal as it was."""
        self._until(canonical=True)

    def press(self, keys: str) -> None:
        """Press keys as soon as the prompt has the terminal, and so takes them.

        Before, the terminal would make an interrupt of Ctrl-C and an end of Ctrl-D.
        """
        self._until(canonical=False)
        self.child.send(keys)

    def _until(self, *, canonical: bool) -> None:
        while canonical != self._canonical():
            with suppress(pexpect.TIMEOUT):
                self._stream.feed(self.child.read_nonblocking(4096, timeout=0.1))

    def _canonical(self) -> bool:
        return bool(termios.tcgetattr(self.child.child_fd)[3] & termios.ICANON)

    def clear(self) -> None:
        """Wipe the screen on this side, so that what is old is not seen again."""
        self._screen.erase_in_display(2)

    def ask(self, text: str, answer: str) -> list[str]:
        """Type an input, wait for what is in its answer, and return the screen."""
        self.clear()
        self.press(text + "\r")
        self.see(answer)
        return self.lines()

    def lines(self) -> list[str]:
        """Return what stands on the screen."""
        return [line.rstrip() for line in self._screen.display if line.strip()]

    def leave(self, keys: str = "\x04") -> int | None:
        """Leave by Ctrl-D, or other keys, and return the exit status."""
        self.press(keys)
        self.child.expect(pexpect.EOF)
        self.child.close()
        status: int | None = self.child.exitstatus
        return status
