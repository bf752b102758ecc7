"""The control of a run that goes on by the readers of its page.

Readers pause the run, step, and perform acts of the debugger. Their threads only put
requests into a queue; the thread of the run carries the requests out between two
cycles. The run has a history from the first request on: a run that nobody controls is
not slower. The history never goes back, because the trace has been written.
"""

from __future__ import annotations

from queue import SimpleQueue
from threading import Lock
from typing import NamedTuple

import msgspec

from rapc.base.values import readable
from rapc.debug.answer import Answer, Command, failure, say
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.log import EventLog
from rapc.errors import PortError, TextError
from rapc.events import RunEnded
from rapc.repl.commands import acting
from rapc.repl.shell import Shell
from rapc.runtime.interpreter import Interpreter
from rapc.world import Time

_CYCLES = 64
"""The highest number of cycles between two looks for requests."""

_ACTS = ("submit", "cancel", "assert", "erase", "signal", "force", "fail", "retry")

_COMMANDS = {
    one.name: one
    for one in vars(acting).values()
    if isinstance(one, Command) and one.name in _ACTS
}

_CONTINUE = {
    "name": "continue",
    "takes": "[TIME]",
    "doc": "Continue the run; with TIME, pause at that time.",
}


_ENDED = failure("the run has ended")


class Status(msgspec.Struct, frozen=True):
    """The state of a run for its readers."""

    #: `running`, `paused` or `ended`.
    state: str
    #: The present moment of a paused run as text.
    moment: str = ""


class _Request(NamedTuple):
    """A request of a reader."""

    name: str
    text: str
    reply: SimpleQueue[Answer]


class Control:
    """A run that readers control.

    Args:
        run: the run; it has not begun.
        paused: whether the run pauses before its first cycle.
    """

    def __init__(self, run: Interpreter, *, paused: bool = False) -> None:
        self._run, self._paused = run, paused
        #: The time at which the run pauses.
        self._until: Time | None = None
        self._shell: Shell | None = None
        self._requests: SimpleQueue[_Request] = SimpleQueue()
        self._lock = Lock()
        #: The present state, which only the thread of the run replaces.
        self.status = Status("running")

    @property
    def run(self) -> Interpreter:
        """Return the run; an act may replace the run."""
        return self._run if self._shell is None else self._shell.history.run

    @staticmethod
    def commands() -> list[dict[str, str]]:
        """Return the requests with arguments, each with its usage and its help."""
        found = [_COMMANDS[name] for name in _ACTS]
        acts = [{"name": o.name, "takes": o.takes, "doc": o.doc} for o in found]
        return [*acts, _CONTINUE]

    # --- threads of readers ---------------------------------------------------------

    def ask(self, name: str, text: str = "") -> Answer:
        """Return the answer to a request, after the run has carried it out.

        Args:
            name: `pause`, `continue`, `step` or an act of the debugger.
            text: the arguments.
        """
        if name not in ("pause", "continue", "step", *_ACTS):
            return failure(f"unknown request `{name}`")
        request = _Request(name, text, SimpleQueue())
        with self._lock:
            if self.status.state == "ended":
                return _ENDED
            self._requests.put(request)
        return request.reply.get()

    # --- the thread of the run ------------------------------------------------------

    def go(self) -> None:
        """Run to the end, and carry out requests on the way.

        Raises:
            PortError: if the world breaks.
        """
        try:
            if self._paused:
                self._tell(self._taken())
            while self.run.reason is None:
                if self._paused or not self._requests.empty():
                    self._carry_out(self._requests.get())
                else:
                    self._go_on()
            if self._shell is not None and self.run.reason == "broken":
                end = next(self._shell.history.log.backwards(RunEnded))
                raise PortError(end.keys["because"])
        finally:
            self._close()

    def _go_on(self) -> None:
        """Run until a request arrives or the time to pause has come, or for a while."""
        shell = self._shell
        if shell is not None:
            shell.history.go(lambda: "" if self._is_due() else None)
            self._paused = self._comes()
            self._tell(shell)
        elif self._run.run_ready(_CYCLES) < _CYCLES and self._requests.empty():
            self._run.step()

    def _is_due(self) -> bool:
        return self._comes() or not self._requests.empty()

    def _comes(self) -> bool:
        """Return whether the time to pause has come."""
        return self._until is not None and self.run.now >= self._until

    def _carry_out(self, request: _Request) -> None:
        """Carry out a request, and answer, also if Ctrl-C ends the run meanwhile."""
        answer = _ENDED
        try:
            shell = self._taken()
            if request.name in _ACTS:
                answer = shell.answer(f":{request.name} {request.text}")
            else:
                answer = self._move(shell.history, request)
            self._tell(shell)
        finally:
            request.reply.put(answer)

    def _move(self, history: History, request: _Request) -> Answer:
        """Pause, step or continue."""
        args, until = Arguments(request.text), None
        try:
            if request.name == "continue" and args:
                until = args.time("time")
                if until < history.now:
                    raise TextError(f"time {readable(until)} is in the past")
            args.end()
        except TextError as error:
            return failure(error.message)
        self._paused, self._until = request.name != "continue", until
        if request.name == "step":
            stop = history.step()
            if stop.kind == "broken":
                return failure(f"run ended by an error: {stop.said}")
        return say(history.stand())

    def _taken(self) -> Shell:
        """Return the shell of the run; make its history on the first call."""
        if self._shell is None:
            log = EventLog()
            self._run.listen(log)
            self._shell = Shell(History(self._run, log), [*_COMMANDS.values()])
            self._shell.shows = "none"
        return self._shell

    def _tell(self, shell: Shell) -> None:
        """Report the state of the run to its readers."""
        moment = shell.history.stand() if self._paused else ""
        status = Status("paused" if self._paused else "running", moment)
        if status != self.status:
            self.status = status

    def _close(self) -> None:
        """Refuse all requests from now on."""
        with self._lock:
            self.status = Status("ended")
            while not self._requests.empty():
                self._requests.get().reply.put(_ENDED)
