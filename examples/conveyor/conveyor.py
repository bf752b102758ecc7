"""The driver of a conveyor, whose controller is a process of its own."""

import threading
from collections.abc import Sequence
from multiprocessing.connection import Client
from typing import Any

from rapc.live import Action, Cancelled, ResumableDriver
from rapc.world import Datum, Finished, Kit, Message, Offer, Option


class Conveyor(ResumableDriver):
    """A conveyor that carries parcels."""

    name = "conveyor"
    kit = Kit(
        Offer(
            {"label": (1, ("okay",)), "carry": (1, ("okay",))},
            data={"scanned": 1},
            not_atomic=("carry",),
            arguments={
                "label": ("parcel",),
                "carry": ("parcel",),
                "scanned": ("parcel",),
            },
        ),
        options=(
            Option("socket", "text", "conveyor.socket", "", "the controller's socket"),
        ),
    )

    def open(self) -> None:
        """Open the connection to the controller."""
        self._connection = Client(str(self.options["socket"]), "AF_UNIX")
        self._calling = threading.Lock()

    def call(self, name: str, *arguments: Any) -> Any:
        """Call a method of the controller."""
        with self._calling:
            self._connection.send((name, *arguments))
            return self._connection.recv()

    def connect(self) -> None:
        """Connect to the controller for a new run: it forgets all before."""
        self.open()
        self.call("clear")
        self.start(self.watch)

    def reconnect(self, tickets: Sequence[int]) -> None:
        """Connect to the controller; it forgets all but some tickets."""
        self.open()
        self.call("keep", tickets)
        self.start(self.watch)

    def watch(self, action: Action) -> None:
        """Send the parcels that the scanner sees, with their numbers."""
        last = 0
        while True:
            for number, parcel in self.call("scans", last).items():
                self.send(Datum(("scanned", parcel), number=number))
                last = number
            action.sleep(0.02)

    def acknowledged(self, messages: Sequence[Message]) -> None:
        """Let the controller forget the jobs and scans that are in the journal."""
        for message in messages:
            if isinstance(message, Finished):
                self.call("stop", message.ticket)
            elif isinstance(message, Datum):
                self.call("forget", message.number)

    def do_label(self, parcel: str) -> None:
        """Put a label on a parcel."""
        self.call("label", self.ticket, parcel)

    def do_carry(self, action: Action, parcel: str) -> None:
        """Carry a parcel."""
        self.call("carry", action.ticket, parcel)
        try:
            while not self.call("arrives", action.ticket):
                action.sleep(0.02)
        except Cancelled:
            self.call("stop", action.ticket)
            raise
