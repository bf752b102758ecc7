"""The base class of drivers whose machine goes on when their process dies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from rapc.live.driver import Driver
from rapc.world import Fact, Finished, Lost, Message, Refused, Reply

_MOST_KEPT = 10_000
"""The number of messages that a driver keeps without an acknowledgement."""


class ResumableDriver(Driver, ABC):
    """A driver of a machine that goes on when the process of the driver dies.

    The ticket of a request is its key in the machine: `action.ticket`, or `self.ticket`
    in the method of an atomic primitive. A resumed run carries out each request under
    way once more with the same ticket. The machine does not begin a request again whose
    ticket it knows, and reports the outcome as often as it is asked. So it does each
    request once.

    A message of the driver that is not in the journal is lost with the process. The
    machine keeps its data until `acknowledged`, and sends them again after `reconnect`.
    The machine numbers the data of each name, and the driver sends each datum with its
    number: then the run takes in each datum once.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        #: The ticket of the last request.
        self.ticket = 0
        #: The messages after the first `_forgotten` ones of the run that the
        #: interpreter has received, and not acknowledged.
        self._kept: deque[Message] = deque()
        self._forgotten = 0
        #: The answer to the last request that was atomic, by ticket.
        self._answered: dict[int, Reply | Refused] = {}

    # --- for authors ------------------------------------------------------------------

    @abstractmethod
    def reconnect(self, tickets: Sequence[int]) -> None:
        """Connect to the machine in a resumed run, and start jobs.

        `connect` is called at the start of every other run: the machine then forgets
        all tickets.

        Args:
            tickets: the requests that the machine may have received and whose end is
                not known. The machine cancels and forgets all others.
        """

    def acknowledged(self, messages: Sequence[Message]) -> None:
        """Let the machine forget messages: they are in the journal.

        After the `Finished` of a request the machine may forget its ticket, too.
        """

    # --- the world --------------------------------------------------------------------

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request, or start its action."""
        self.ticket = ticket
        answer = super().perform(ticket, request)
        self._answered = {} if answer is None else {ticket: answer}
        return answer

    def messages(self) -> Sequence[Message]:
        """Return the messages so far. Raises the exception of an action, if any."""
        sent = super().messages()
        self._kept.extend(sent)
        while len(self._kept) > _MOST_KEPT:
            self._kept.popleft()
            self._forgotten += 1
        return sent

    def acknowledge(self, received: int) -> None:
        """Forget the first `received` messages of the run."""
        gone = [self._kept.popleft() for _ in range(received - self._forgotten)]
        if gone:
            self._forgotten = received
            self.acknowledged(gone)

    def resume(
        self, tickets: Sequence[int], received: int
    ) -> Mapping[int, Reply | Refused | None]:
        """Continue the run with a new process of the interpreter.

        A driver in the process of the interpreter is new, too, and knows no ticket.

        Raises:
            ValueError: if the driver no longer has all later messages.
        """
        if not self._connected:
            self._forgotten = received
            self._begin(partial(self.reconnect, tickets))
            return {}
        if received < self._forgotten:
            raise ValueError(f"the first {self._forgotten} messages are forgotten")
        for ticket in {*self._actions}.difference(tickets):
            self.cancel(ticket)
        self.acknowledge(received)
        with self._changed:
            self._inbox = [*self._kept, *self._inbox]
            self._kept.clear()
            ends = [one for one in self._inbox if isinstance(one, Finished | Lost)]
            under_way = {*self._actions, *(one.ticket for one in ends)}
        known = {**dict.fromkeys(under_way), **self._answered}
        return {ticket: known[ticket] for ticket in tickets if ticket in known}
