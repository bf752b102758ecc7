"""Worlds that drive machines in real time, with the same driver in simulated time."""

from __future__ import annotations

from rapc.live.clocks import Clock, SimulatedClock, WallClock
from rapc.live.driver import Action, AsyncAction, Cancelled, Driver
from rapc.live.resumable import ResumableDriver

__all__ = (
    "Action",
    "AsyncAction",
    "Cancelled",
    "Clock",
    "Driver",
    "ResumableDriver",
    "SimulatedClock",
    "WallClock",
)
