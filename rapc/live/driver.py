"""The base class of worlds that drive machines.

Each request runs a method of the driver, in a thread or in asyncio. The interpreter
calls the driver from one thread; all other threads only send messages.
"""

from __future__ import annotations

import asyncio
import atexit
import inspect
import logging
import math
import threading
import weakref
from abc import ABC
from collections.abc import Callable, Coroutine, Mapping, Sequence
from random import Random
from types import MappingProxyType
from typing import Any, ClassVar

from rapc.base.watchdog import PERIOD, Watchdog
from rapc.live.clocks import Clock, SimulatedClock, WallClock
from rapc.world import (
    NOT_KNOWN,
    OKAY,
    Atom,
    Fact,
    Finished,
    Lost,
    Message,
    Refused,
    Reply,
    Signal,
    Time,
    World,
)

LONG_CYCLE = 0.05
"""The seconds between two calls of the driver above which it reports a long cycle."""

STOPPING = 1.0
"""The seconds that a cancelled action may take to end."""

_BEATS = 4
"""The number of signs of life in the period of the watchdog."""

_LOG = logging.getLogger("rapc.live")
_LOG.addHandler(logging.NullHandler())  # a host decides on what is printed


class Cancelled(BaseException):
    """Raised by `Action.sleep` in an action that is cancelled."""


class Action:
    """A request that a driver carries out in a thread, or a job of `Driver.start`."""

    def __init__(self, driver: Driver, ticket: int | None, limit: Time | None) -> None:
        #: The ticket of the request; None for a job.
        self.ticket = ticket
        self._driver, self._limit = driver, limit
        self._stopped, self._over = threading.Event(), threading.Event()
        self._finished = False
        self._outcome: Reply | str | None = None
        #: Ends the `wait` of the action in real time.
        self._wake: Callable[[], Any] = lambda: None

    @property
    def cancelled(self) -> bool:
        """Whether the action is cancelled: an action that does not sleep asks this."""
        return self._stopped.is_set()

    def sleep(self, seconds: float) -> Any:
        """Sleep for time units of the clock. Raises Cancelled if cancelled."""
        clock = self._driver.clock
        if not self.cancelled:
            if isinstance(clock, SimulatedClock):
                woken = threading.Event()
                clock.sleep(self, seconds, woken.set)
                woken.wait()
            else:
                self._stopped.wait(seconds / clock.scale)
        if self.cancelled:
            raise Cancelled

    def finish(self, outcome: Reply | str | None = None) -> None:
        """End the `wait` of the action, which returns the outcome.

        A callback of the machine may call this method, in any thread. Later calls, and
        calls after the end of the action, have no effect.
        """
        if not self._finished:
            self._outcome, self._finished = outcome, True
            self._end_wait()

    def wait(self) -> Any:
        """Wait for `finish`; return its outcome. Raises Cancelled if cancelled."""
        woken = threading.Event()
        self._begin_wait(woken.set)
        woken.wait()
        if self.cancelled:
            raise Cancelled
        return self._outcome

    def _begin_wait(self, wake: Callable[[], Any]) -> None:
        """Call `wake` when the wait is over, which may be at once."""
        clock = self._driver.clock
        if isinstance(clock, SimulatedClock):
            clock.sleep(self, math.inf, wake)
        else:
            self._wake = wake
        if self._finished or self.cancelled:
            self._end_wait()

    def _end_wait(self) -> None:
        self._wake()
        self._driver.clock.shorten(self)

    def _start(self, function: Callable[..., Any], arguments: Sequence[Any]) -> None:
        """Start the action."""
        run = [function, arguments]
        threading.Thread(target=self._run, args=run, daemon=True).start()

    def _run(self, function: Callable[..., Any], arguments: Sequence[Any]) -> None:
        try:
            self._driver._take_end(self, function(self, *arguments), None)
        except Cancelled:
            self._driver._take_end(self, None, None)
        except BaseException as error:  # raised again in the thread of the interpreter
            self._driver._take_end(self, None, error)

    def _cancel(self) -> None:
        """Cancel the action; it ends later."""
        self._stopped.set()
        self._wake()
        self._driver.clock.interrupt(self)


class AsyncAction(Action):
    """A request that a driver carries out as a coroutine of asyncio."""

    _task: asyncio.Task[Any]

    async def sleep(self, seconds: float) -> None:
        """Sleep for time units of the clock; asyncio cancels the coroutine."""
        clock = self._driver.clock
        if not isinstance(clock, SimulatedClock):
            await asyncio.sleep(seconds / clock.scale)
            return
        woken, wake = _waking()
        clock.sleep(self, seconds, wake)
        await woken

    async def wait(self) -> Any:
        """Wait for `finish`; return its outcome; asyncio cancels the coroutine."""
        woken, wake = _waking()
        self._begin_wait(wake)
        await woken
        return self._outcome

    def _start(
        self,
        function: Callable[..., Coroutine[Any, Any, Any]],
        arguments: Sequence[Any],
    ) -> None:
        """Start the action."""
        loop = self._driver._own_loop()

        def start() -> None:
            self._task = loop.create_task(function(self, *arguments))
            self._task.add_done_callback(self._ended)

        loop.call_soon_threadsafe(start)

    def _ended(self, task: asyncio.Task[Any]) -> None:
        if task.cancelled():
            self._driver._take_end(self, None, None)
        elif (error := task.exception()) is not None:
            self._driver._take_end(self, None, error)
        else:
            self._driver._take_end(self, task.result(), None)

    def _cancel(self) -> None:
        """Cancel the action; it ends later."""

        def stop() -> None:
            self._task.cancel()  # it exists by now

        super()._cancel()
        self._driver._own_loop().call_soon_threadsafe(stop)


class Driver(World, ABC):
    """A world that drives a machine; a time unit is a second.

    The method `do_NAME` carries out the primitive NAME, with `_` for `-` in the name.
    If the offer lists the primitive in `not_atomic`, the method is called with an
    `Action` and the arguments, in a thread of its own; a coroutine is called with an
    `AsyncAction`, in the thread of asyncio. It may take time. Any other primitive is
    atomic: its method is called with the arguments only, and must return at once.

    A method returns a `Reply` or a result; None means `okay`. An `OSError` ends the
    request as `Lost`, and so the method of the task; any other exception ends the run.

    Args:
        rng: the random stream.
        options: the values of the options.
        clock: the clock; by default the time of the computer.
    """

    #: The seconds after which requests are cancelled, by primitive. They end with the
    #: result `timeout`, which the offer must list.
    timeouts: ClassVar[Mapping[str, float]] = MappingProxyType({})

    def __init__(
        self,
        rng: Random | None = None,
        options: Mapping[str, Atom | bool] = MappingProxyType({}),
        clock: Clock | None = None,
    ) -> None:
        self.rng = rng or Random(0)
        self.options = options
        self.clock = clock or WallClock()
        self._refuse_incomplete()
        self._changed = threading.Condition()
        self._inbox: list[Message] = []
        #: The requests under way by ticket, and actions that are cancelled or jobs.
        self._actions: dict[int, Action] = {}
        self._others: list[Action] = []
        self._error: BaseException | None = None
        self._time: Time = 0
        self._connected = False
        self._closed = threading.Event()
        self._watchdog = Watchdog(self.halt)
        self._loop: asyncio.AbstractEventLoop | None = None

    def _refuse_incomplete(self) -> None:
        offer = self.kit.offer
        for name, (_, results) in offer.primitives.items():
            method = getattr(self, _method(name), None)
            if method is None:
                raise TypeError(f"the driver `{self.name}` requires `{_method(name)}`")
            if name not in offer.not_atomic and inspect.iscoroutinefunction(method):
                said = f"`{_method(name)}` is a coroutine, but `{name}` is atomic"
                raise TypeError(f"{said}: `not_atomic` of the offer does not list it")
            if name in self.timeouts and "timeout" not in results:
                raise TypeError(f"`{name}` has a timeout, but no result `timeout`")

    # --- for authors ------------------------------------------------------------------

    def connect(self) -> None:
        """Connect to the machine, and start jobs; called once, at the start of a run.

        The constructor must not connect: `rapc worlds` makes the world, too.
        """

    def stop_body(self) -> None:
        """Stop the machine at once; called by the watchdog, from any thread.

        The driver has cancelled the actions under way, which end at the same time.
        """

    def send(self, message: Message) -> None:
        """Send a datum or a signal; may be called in any thread."""
        with self._changed:
            self._inbox.append(message)
            self._changed.notify_all()

    def start(self, job: Callable[..., Any], *arguments: Any) -> Action:
        """Run a function or a coroutine besides the requests, until `close`.

        The job is called with an `Action` and the arguments. An exception of the job
        ends the run.
        """
        return self._run(job, None, arguments, None)

    def halt(self) -> None:
        """Stop the body; the requests under way end as `Lost`. Called by watchdogs."""
        _LOG.error("no sign of life for %g s: the body is stopped", PERIOD)
        halted = list(self._actions.items())
        for _, action in halted:
            action._cancel()
        try:
            self.stop_body()
        finally:
            with self._changed:
                for ticket, action in halted:
                    if self._actions.get(ticket) is action:
                        self._drop(ticket, action)
                        reason = (
                            f"the interpreter gave no sign of life for {PERIOD:g} s"
                        )
                        self._inbox.append(Lost(ticket, reason))
                self._changed.notify_all()

    def close(self) -> None:
        """Cancel all actions and jobs, and wait until they have ended."""
        self._closed.set()
        for ticket in list(self._actions):
            self.cancel(ticket)
        for action in list(self._others):
            self._cancel(action)
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._loop = None

    # --- the world --------------------------------------------------------------------

    def now(self) -> Time:
        """Return the time of the last request, wait or message."""
        self._beat()
        if self._inbox:
            self._time = max(self._time, self.clock.now())
        return self._time

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request, or start its action."""
        self._beat()
        self._begin()
        name, *arguments = request
        method = getattr(self, _method(str(name)))
        if name not in self.kit.offer.not_atomic:
            found: Reply | Refused = _reply(method(*arguments))
            self._time = max(self._time, self.clock.now())
            self._watchdog.beat()
            return found
        for action in [one for one in self._others if one.cancelled]:
            self._wait_for(action)
        self._time = max(self._time, self.clock.now())
        limit = self.timeouts.get(str(name))
        self._run(method, ticket, arguments, limit)
        self.clock.settle()
        return None

    def cancel(self, ticket: int) -> None:
        """Cancel the action of a request; wait until it has ended, at most 1 s."""
        with self._changed:
            self._inbox = [one for one in self._inbox if not _ends(one, ticket)]
            action = self._actions.get(ticket)
            if action is None:
                return
            self._drop(ticket, action)
        self._cancel(action)
        self._watchdog.beat()

    def next_time(self) -> Time:
        """Return the present if there are messages; else the time is not known."""
        return self._time if self._inbox or self._error else NOT_KNOWN

    def advance(self, to: Time) -> None:
        """Wait until `to`, or for the first message."""
        self._beat()
        self._begin()
        with self._changed:
            limits = [one._limit for one in self._actions.values()]
        until = min([to, *(limit for limit in limits if limit is not None)])
        beat = self._watchdog.beat
        self.clock.wait(self._changed, until, self._ready, beat, PERIOD / _BEATS)
        self._time = max(self._time, self.clock.now())
        self._end_late()
        beat()

    def messages(self) -> Sequence[Message]:
        """Return the messages so far. Raises the exception of an action, if any."""
        self._beat()
        if self._error is not None:
            raise self._error
        with self._changed:
            sent, self._inbox = self._inbox, []
        return sent

    def _ready(self) -> bool:
        return bool(self._inbox or self._error)

    def _beat(self) -> None:
        """Note a sign of life of the interpreter; report a long cycle."""
        gap = self._watchdog.beat()
        if gap > LONG_CYCLE and self._connected and self.clock.real:
            milliseconds = round(gap * 1000)
            _LOG.warning("cycle of %d ms at time %g", milliseconds, self._time)
            self.send(Signal((":long-cycle", milliseconds)))

    def _begin(self, connect: Callable[[], None] | None = None) -> None:
        """Start the clock, and connect to the machine, once.

        `connect` replaces the method of this name.
        """
        if self._connected:
            return
        self._connected = True
        atexit.register(_close, weakref.ref(self))
        self.clock.start()
        if self.clock.real:
            watch = self._watchdog.watch
            threading.Thread(target=watch, args=[self._closed], daemon=True).start()
        (connect or self.connect)()
        self.clock.settle()
        self._watchdog.beat()

    # --- actions ----------------------------------------------------------------------

    def _run(
        self,
        function: Callable[..., Any],
        ticket: int | None,
        arguments: Sequence[Any],
        seconds: float | None,
    ) -> Action:
        limit = None if seconds is None else self._time + seconds
        kind = AsyncAction if inspect.iscoroutinefunction(function) else Action
        action = kind(self, ticket, limit)
        with self._changed:
            if ticket is None:
                self._others.append(action)
            else:
                self._actions[ticket] = action
                self._watchdog.armed = self.clock.real
        self.clock.begun()
        action._start(function, arguments)
        return action

    def _take_end(
        self, action: Action, result: object, error: BaseException | None
    ) -> None:
        """Take in the end of an action; called in its thread."""
        action._finished = True
        with self._changed:
            ticket = action.ticket
            known = ticket is not None and self._actions.get(ticket) is action
            if ticket is not None and known and not action.cancelled:
                self._forget(ticket)
                if error is None:
                    self._inbox.append(Finished(ticket, _reply(result)))
                elif isinstance(error, OSError):
                    _LOG.error("request %d is lost: %s", ticket, error)
                    self._inbox.append(Lost(ticket, f"{type(error).__name__}: {error}"))
                else:
                    self._error = self._error or error
            else:
                if action in self._others:
                    self._others.remove(action)
                if isinstance(error, OSError) and action.cancelled:
                    _LOG.error("a cancelled action failed: %s", error)
                elif error is not None:
                    self._error = self._error or error
            action._over.set()
            self._changed.notify_all()
        self.clock.ended()

    def _forget(self, ticket: int) -> None:
        del self._actions[ticket]
        self._watchdog.armed = bool(self._actions) and self.clock.real

    def _drop(self, ticket: int, action: Action) -> None:
        """Take no result from an action any more."""
        self._forget(ticket)
        if not action._over.is_set():
            self._others.append(action)

    def _cancel(self, action: Action) -> None:
        action._cancel()
        self._wait_for(action)

    def _wait_for(self, action: Action) -> None:
        if not action._over.wait(STOPPING):
            _LOG.error("an action goes on %g s after it was cancelled", STOPPING)

    def _end_late(self) -> None:
        """End the actions whose limit has come."""
        for ticket, action in list(self._actions.items()):
            if action._limit is not None and action._limit <= self._time:
                with self._changed:
                    if ticket not in self._actions:
                        continue
                    self._drop(ticket, action)
                self._cancel(action)
                self.send(Finished(ticket, Reply("timeout")))

    def _own_loop(self) -> asyncio.AbstractEventLoop:
        """Return the loop of asyncio, which runs in a thread of its own."""
        if self._loop is None:
            self._loop = asyncio.new_event_loop()
            run = [self._loop]
            threading.Thread(target=_run_loop, args=run, daemon=True).start()
        return self._loop


def _waking() -> tuple[asyncio.Future[None], Callable[[], Any]]:
    """Return a future, and a function that ends it and that any thread may call."""
    loop = asyncio.get_running_loop()
    woken: asyncio.Future[None] = loop.create_future()

    def wake() -> None:
        if not woken.done():
            woken.set_result(None)

    return woken, lambda: loop.call_soon_threadsafe(wake)


def _close(driver: weakref.ref[Driver]) -> None:
    """Let the actions of a driver clean up before the process ends."""
    if (known := driver()) is not None:
        known.close()


def _run_loop(loop: asyncio.AbstractEventLoop) -> None:
    loop.run_forever()
    loop.close()


def _method(name: str) -> str:
    return "do_" + name.replace("-", "_")


def _ends(message: Message, ticket: int) -> bool:
    return isinstance(message, Finished | Lost) and message.ticket == ticket


def _reply(result: Any) -> Any:
    """Return the result of an action as a reply."""
    if result is None:
        return Reply(OKAY)
    return Reply(result) if isinstance(result, str) else result
