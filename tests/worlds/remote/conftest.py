"""Peers in tests answer as late as they like, on a machine with much else to do."""

from __future__ import annotations

import pytest

import rapc.worlds.remote.peer


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a peer start slowly; the limits that a peer states stay as they are."""
    monkeypatch.setattr(rapc.worlds.remote.peer, "TIMEOUT", 120.0)
