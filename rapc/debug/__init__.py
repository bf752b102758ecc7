"""The debugger, without terminal and protocol: step a run, ask it, go back."""

from rapc.debug.session import Session

__all__ = ("Session",)
