"""The debugger, without terminal and protocol: step a run, ask it, go back."""

from rapc.debug.history import History

Session = History
"""A history under the name that Python programs use."""

__all__ = ("History", "Session")
