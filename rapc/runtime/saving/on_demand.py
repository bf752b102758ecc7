"""The two doors to saving; what is behind them is imported when one is first opened.

Most runs are never saved, and the records of a run take a while to import.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rapc.base.later import later
from rapc.runtime.machine import Machine

if TYPE_CHECKING:
    from rapc.runtime.saving import save as saving
else:
    saving = later("rapc.runtime.saving.save")


def save(machine: Machine, seed: int) -> bytes:
    """Return a whole run as bytes; see `rapc.runtime.saving.save`."""
    return saving.save(machine, seed)


def restore(machine: Machine, saved: bytes) -> int:
    """Put a saved run in place of another, and return its seed; see there."""
    return saving.restore(machine, saved)
