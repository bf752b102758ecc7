"""Worlds in other processes, in any language; and Python worlds as such processes."""

from __future__ import annotations

from rapc.worlds.remote.server import listen, serve

__all__ = ("listen", "serve")
