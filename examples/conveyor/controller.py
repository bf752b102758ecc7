"""The controller of a conveyor: a process that goes on when that of the driver dies.

python controller.py SOCKET
"""

import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from multiprocessing.connection import Listener

SECONDS = 0.1
"""The time that a parcel takes."""


class Controller:
    """A conveyor with jobs by ticket.

    Args:
        now: returns the time in seconds.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        #: The parcel of each job, and the time of its end; None: it has ended.
        self._jobs: dict[int, tuple[str, float | None]] = {}
        #: The parcels that the scanner has seen at the end, by number.
        self._scans: dict[int, str] = {}
        self._scanned = 0
        #: The ticket of the last parcel with a label.
        self._labelled = 0
        #: How often each parcel got a label, was put on the conveyor, and arrived.
        self.labels: Counter[str] = Counter()
        self.begun: Counter[str] = Counter()
        self.arrived: Counter[str] = Counter()

    def clear(self) -> None:
        """Stop and forget all jobs, and forget all scanned parcels."""
        self.keep(())
        self._scans.clear()

    def keep(self, tickets: Sequence[int]) -> None:
        """Stop and forget all jobs but those with some tickets."""
        self._jobs = {one: job for one, job in self._jobs.items() if one in tickets}
        if self._labelled not in tickets:
            self._labelled = 0

    def label(self, ticket: int, parcel: str) -> None:
        """Put a label on a parcel, once for a ticket."""
        if ticket != self._labelled:
            self._labelled = ticket
            self.labels[parcel] += 1

    def carry(self, ticket: int, parcel: str) -> None:
        """Begin to carry a parcel, once for a ticket."""
        if ticket not in self._jobs:
            self._jobs[ticket] = parcel, self._now() + SECONDS
            self.begun[parcel] += 1

    def arrives(self, ticket: int) -> bool:
        """Return whether the parcel of a job has arrived."""
        parcel, end = self._jobs[ticket]
        if end is not None and end <= self._now():
            self._jobs[ticket] = parcel, None
            self.arrived[parcel] += 1
            self._scanned += 1
            self._scans[self._scanned] = parcel
        return self._jobs[ticket][1] is None

    def scans(self, after: int) -> dict[int, str]:
        """Return the scanned parcels after a number, by number."""
        return {n: parcel for n, parcel in self._scans.items() if n > after}

    def forget(self, number: int) -> None:
        """Forget the scanned parcels up to a number."""
        self._scans = self.scans(number)

    def stop(self, ticket: int) -> None:
        """Stop and forget a job."""
        self._jobs.pop(ticket, None)

    def counts(self) -> tuple[Counter[str], Counter[str], Counter[str]]:
        """Return the numbers of labels, jobs and arrivals of each parcel."""
        return self.labels, self.begun, self.arrived


def serve(socket: str) -> None:
    """Serve one process of the driver after the other."""
    controller = Controller()
    with Listener(socket, "AF_UNIX") as listener:
        print("ready", flush=True)
        while True:
            with listener.accept() as connection:
                try:
                    while True:
                        name, *arguments = connection.recv()
                        connection.send(getattr(controller, name)(*arguments))
                except (EOFError, OSError):
                    continue  # the driver has died


if __name__ == "__main__":
    serve(sys.argv[1])
