"""The control of a run that goes on by the readers of its page.

Readers pause the run, step, and perform acts of the debugger. Their threads only put
requests into a queue; the thread of the run carries the requests out between two
cycles. The run never goes back, because the trace has been written.
"""

from __future__ import annotations

from queue import SimpleQueue
from threading import Lock
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rapc.base.values import readable
from rapc.debug.acts import Act, SubmitTask
from rapc.debug.answer import Answer, Command, failure, say
from rapc.debug.arguments import Arguments
from rapc.errors import Error, TextError
from rapc.repl.commands import acting
from rapc.repl.shell import refusal, submitted
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import read_task_request
from rapc.world import Time

if TYPE_CHECKING:
    from rapc.durable.runs import DurableRun

_CYCLES = 64
"""The highest number of cycles between two looks for requests."""

_MOVES = ("pause", "continue", "step")

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


class _Driven:
    """A run that goes forward, and on which readers act (`rapc.repl.shell.Actor`).

    Args:
        run: the run.
        durable: the run with its journal, if it has one; it gets the acts, too.
    """

    def __init__(self, run: Interpreter, durable: DurableRun | None) -> None:
        self.run, self._durable = run, durable

    def step(self) -> None:
        """Run a cycle, after its time has come."""
        (self.run if self._durable is None else self._durable).step()

    def run_ready(self) -> int:
        """Run cycles that need no wait, at most `_CYCLES`; return their number.

        A run with a journal runs none: each of its cycles is a step.
        """
        return 0 if self._durable is not None else self.run.run_ready(_CYCLES)

    def stand(self) -> str:
        """Return the present moment as text."""
        run = self.run
        ended = "" if run.reason is None else f", run ended ({run.reason})"
        return f"cycle {run.cycle}, time {readable(run.now)}{ended}"

    def act(self, act: Act) -> Answer:
        """Perform an act."""
        if self._durable is None:
            act.do(self.run)
        else:
            self._durable.act(act)
        return say(str(act))

    def submit(self, text: str) -> Answer:
        """Submit a task."""
        request = read_task_request(text)
        self.act(SubmitTask(request))
        return submitted(self.run, request, text)

    def task(self, args: Arguments) -> int:
        """Take an argument as the number of a task."""
        return args.count("task")


class Control:
    """A run that readers control.

    Args:
        paused: whether the run pauses before its first cycle.
    """

    def __init__(self, *, paused: bool = False) -> None:
        self._paused = paused
        #: The time at which the run pauses.
        self._until: Time | None = None
        self._requests: SimpleQueue[_Request] = SimpleQueue()
        self._lock = Lock()
        #: The present state, which only the thread of the run replaces.
        self.status = Status("running")

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
        if name not in (*_MOVES, *_ACTS):
            return failure(f"unknown request `{name}`")
        request = _Request(name, text, SimpleQueue())
        with self._lock:
            if self.status.state == "ended":
                return _ENDED
            self._requests.put(request)
        return request.reply.get()

    # --- the thread of the run ------------------------------------------------------

    def go(self, run: Interpreter, durable: DurableRun | None = None) -> None:
        """Run to the end, and carry out requests on the way.

        Args:
            run: the run.
            durable: the run with its journal, if it has one.

        Raises:
            PortError: if the world breaks.
        """
        driven = _Driven(run, durable)
        try:
            self._tell(driven)
            while run.reason is None:
                if self._paused or not self._requests.empty():
                    self._carry_out(driven, self._requests.get())
                elif self._until is not None:
                    driven.step()
                    self._paused = run.now >= self._until
                    self._tell(driven)
                elif driven.run_ready() < _CYCLES and self._requests.empty():
                    driven.step()
        finally:
            self._close()

    def _carry_out(self, driven: _Driven, request: _Request) -> None:
        """Carry out a request, and answer, also if Ctrl-C ends the run meanwhile."""
        answer = _ENDED
        try:
            answer = self._answer(driven, request)
            self._tell(driven)
        finally:
            request.reply.put(answer)

    def _answer(self, driven: _Driven, request: _Request) -> Answer:
        try:
            if request.name in _ACTS:
                return _COMMANDS[request.name](driven, request.text)
            self._move(driven.run, request)
        except (Error, ValueError) as error:
            return refusal(error)
        if request.name == "step":
            driven.step()
        return say(driven.stand())

    def _move(self, run: Interpreter, request: _Request) -> None:
        """Pause from now on, or continue. Raises TextError for invalid arguments."""
        args, until = Arguments(request.text), None
        if request.name == "continue" and args:
            until = args.time("time")
            if until < run.now:
                raise TextError(f"time {readable(until)} is in the past")
        args.end()
        self._paused, self._until = request.name != "continue", until

    def _tell(self, driven: _Driven) -> None:
        """Report the state of the run to its readers."""
        state = "paused" if self._paused else "running"
        status = Status(state, driven.stand() if self._paused else "")
        if status != self.status:
            self.status = status

    def _close(self) -> None:
        """Refuse all requests from now on."""
        with self._lock:
            self.status = Status("ended")
            while not self._requests.empty():
                self._requests.get().reply.put(_ENDED)
