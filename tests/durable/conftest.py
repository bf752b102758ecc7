"""Runs that are killed in the process of the tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.durable.helpers import Traces


@pytest.fixture
def killable(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let a killed run, which is still in this process, lose its lock and files."""
    monkeypatch.setattr("rapc.durable.folder.fcntl.flock", lambda *_: None)
    traces = Traces(monkeypatch)
    yield
    traces.close()
