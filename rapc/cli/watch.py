"""Run again when a file changes (`--watch`)."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import click

from rapc.base.files import files_at, path_named, path_of
from rapc.cli.options import say_error
from rapc.errors import Error, LoadError

_INTERVAL = 0.2
"""The interval between two checks of the files, in seconds."""

_COARSE = 10_000_000
"""Nanoseconds by which the times of files may lag behind the clock."""

Stamps = dict[str, tuple[int, int]]
"""The time of the last change, in nanoseconds, and the size of files, by name."""

_UNKNOWN = (-1, -1)
"""The stamp of a file whose state at the time of reading is unknown."""


def watch(paths: Sequence[str], act: Callable[[], Iterable[str]]) -> None:
    """Call `act`, and again after each change, until Ctrl-C.

    Args:
        paths: files and folders; a new file in a folder is a change, too.
        act: the function to call; it returns the names of further files to watch. A
            `rapc.Error` is printed, and the command waits for the next change.
    """
    others: Iterable[str] = ()
    try:
        while True:
            expected = _stamps(_below(paths))
            before = expected | _stamps(map(path_of, others))
            began = time.time_ns() - _COARSE
            click.clear()
            try:
                others = list(act())
            except Error as error:
                say_error(error.message)
            # Files that were not watched before may have changed since they were read.
            for name, found in _stamps(map(path_of, others)).items():
                read_late = name not in before and found[0] >= began
                expected[name] = _UNKNOWN if read_late else before.get(name, found)
            click.echo("waiting for changes; press Ctrl-C to stop", err=True)
            while _stamps([*_below(paths), *map(path_of, others)]) == expected:
                time.sleep(_INTERVAL)
    except KeyboardInterrupt:
        click.echo(err=True)


def _below(paths: Iterable[str]) -> Iterator[Path]:
    for path in paths:
        try:
            yield from files_at(path_named(path), tests=True)
        except LoadError:
            yield path_of(path)


def _stamps(files: Iterable[Path]) -> Stamps:
    found = {}
    for file in files:
        try:
            status = os.stat(file)
        except (OSError, ValueError):
            found[str(file)] = 0, 0
        else:
            found[str(file)] = status.st_mtime_ns, status.st_size
    return found
