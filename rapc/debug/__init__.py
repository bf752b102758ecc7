"""The debugger, independent of terminal and protocol.

Not here: commands and prompt of the REPL (`rapc.repl`).
"""

from rapc.debug.history import History

Session = History
"""The name of `History` for Python programs."""

__all__ = ("History", "Session")
