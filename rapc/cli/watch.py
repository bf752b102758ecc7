"""Do something again whenever a file changes: `--watch`."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import click

from rapc.base.files import files_at, path_named, path_of
from rapc.errors import Error, LoadError

_INTERVAL = 0.2
"""Seconds between two looks at the files."""

Snapshot = frozenset[tuple[str, int, int]]
"""Files with when they were last changed and how long they are."""


def watch(paths: Sequence[str], act: Callable[[], Iterable[str]]) -> None:
    """Call `act`, and again after each change, until Ctrl-C.

    Args:
        paths: files and folders; a file that is new in a folder is a change, too.
        act: what to do; what it raises as `rapc.Error` is told, and a change waited
            for. It returns names of further files to watch.
    """
    others: Iterable[str] = ()
    try:
        while True:
            before = _snapshot(paths, others)
            click.clear()
            try:
                others = act()
            except Error as error:
                click.echo(f"error: {error.message}", err=True)
            before |= _snapshot((), others)
            click.echo("waiting for a change; Ctrl-C ends", err=True)
            while _snapshot(paths, others) == before:
                time.sleep(_INTERVAL)
    except KeyboardInterrupt:
        click.echo(err=True)


def _snapshot(paths: Iterable[str], others: Iterable[str]) -> Snapshot:
    return frozenset(_stamps([*_below(paths), *map(path_of, others)]))


def _below(paths: Iterable[str]) -> Iterator[Path]:
    for path in paths:
        try:
            yield from files_at(path_named(path), tests=False)
        except LoadError:
            yield path_of(path)


def _stamps(files: Iterable[Path]) -> Iterator[tuple[str, int, int]]:
    for file in files:
        try:
            status = os.stat(file)
        except (OSError, ValueError):
            yield str(file), 0, 0
        else:
            yield str(file), status.st_mtime_ns, status.st_size
