"""Store of results in a file, from which a batch can continue.

The store is one SQLite file; the key of a result is the hash of its configuration and
its seed. Only the process that distributes the jobs writes.
"""

from __future__ import annotations

import errno
import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from rapc.errors import Error
from rapc.experiments.measures import Measures
from rapc.experiments.run import PointConfig, Result

try:
    import fcntl
except ModuleNotFoundError:  # not a POSIX system
    fcntl = None  # type: ignore[assignment]

FORMAT = 3
"""The version of the tables; different versions are refused."""

_MEASURES = Measures.__struct_fields__
"""The measures of a run, each a column with its name."""

_COLUMNS = ("config", "seed", *_MEASURES, "seconds")

_SCHEMA = f"""
create table config (hash text primary key, config text not null);
create table result (
    config text not null references config (hash), seed integer not null,
    {", ".join(_MEASURES)}, seconds real not null,
    primary key (config, seed)
) without rowid;
"""

_PATIENCE = 60
"""The time limit for locks of other processes, in seconds: a process may be stopped."""

_IN_JSON = ("counts", "figures", "tasks", "times")
"""The measures that are stored as JSON in one column."""

_NO_LOCKS = (errno.EBADF, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS)
"""The errors of file systems that cannot lock a folder."""

_KEEP = f"insert or ignore into result values ({', '.join('?' * len(_COLUMNS))})"  # noqa: S608

_KEEP_CONFIG = "insert or ignore into config values (?, ?)"

_SEEDS = "select seed from result where config = ?"

_CONFIGS = "select hash from config order by hash"

_FIND = f"""
select seed, {", ".join(_MEASURES)} from result
where config = ? and seed >= ? and seed < ? order by seed
"""  # noqa: S608  # the names of columns are those of a class


class StoreError(Error):
    """An invalid file of results, or a folder that is in use."""


@contextmanager
def sole_user(folder: Path) -> Iterator[None]:
    """Lock a folder of results against other processes while the block runs.

    Two processes with the same folder would each execute all runs. On a file system
    without locks both may run: their results agree.

    Raises:
        StoreError: if another process has locked the folder.
    """
    if fcntl is None:
        yield
        return
    held = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise StoreError(
                f"`{folder}` is in use by another `rapc experiment`: try again when it "
                "has ended, or give another folder with --out"
            ) from None
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                raise
        yield
    finally:
        os.close(held)


class Store:
    """The results in a file, which is created if missing; a context manager.

    Raises:
        StoreError: for a file that is not a store, is damaged, or cannot be written.
            All methods raise this error, too.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        with self._blamed():
            self._base = sqlite3.connect(file, timeout=_PATIENCE, isolation_level=None)
            self._prepare()

    def _prepare(self) -> None:
        self._base.execute("begin immediate")
        [(format_,)] = self._base.execute("pragma user_version")
        [(tables,)] = self._base.execute("select count(*) from sqlite_schema")
        if tables and format_ != FORMAT:
            raise StoreError(f"`{self._file}` was not written by this version of rapc")
        if not tables:
            for statement in _SCHEMA.split(";"):
                self._base.execute(statement)
            self._base.execute(f"pragma user_version = {FORMAT}")
        self._base.execute("commit")
        self._base.execute("pragma journal_mode = wal")
        self._base.execute("pragma synchronous = normal")

    @contextmanager
    def _blamed(self) -> Iterator[None]:
        """Raise errors of the database as errors of the file."""
        try:
            yield
        except (sqlite3.Error, msgspec.MsgspecError) as error:
            raise StoreError(f"`{self._file}` cannot be used: {error}") from error

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *raised: object) -> None:
        self._base.close()

    def configs(self) -> list[str]:
        """Return the hashes of the configurations with results."""
        with self._blamed():
            return [digest for (digest,) in self._base.execute(_CONFIGS)]

    def seeds(self, config: str) -> frozenset[int]:
        """Return the seeds with results, by the hash of a configuration."""
        with self._blamed():
            rows = self._base.execute(_SEEDS, (config,))
            return frozenset(seed for (seed,) in rows)

    def add(self, config: PointConfig, results: Iterable[Result]) -> None:
        """Store the results of runs, except results with a fault."""
        digest = config.digest()
        with self._blamed():
            self._base.execute("begin")
            self._base.execute(_KEEP_CONFIG, (digest, config.as_json()))
            for result in results:
                if result.measures is not None:
                    self._keep(digest, result, result.measures)
            self._base.execute("commit")

    def _keep(self, config: str, result: Result, measures: Measures) -> None:
        row = msgspec.structs.asdict(measures)
        for name in _IN_JSON:
            row[name] = msgspec.json.encode(row[name]).decode()
        values = (config, result.seed, *row.values(), round(result.seconds, 4))
        self._base.execute(_KEEP, values)

    def measures(self, config: str, seeds: range) -> dict[int, Measures]:
        """Return the stored measures of a configuration under some seeds, by seed."""
        with self._blamed():
            rows = self._base.execute(_FIND, (config, seeds.start, seeds.stop))
            return {seed: _measures(values) for seed, *values in rows}


def _measures(values: list[object]) -> Measures:
    row = dict(zip(_MEASURES, values, strict=True))
    for name in _IN_JSON:
        row[name] = msgspec.json.decode(str(row[name]))
    return msgspec.convert(row, Measures)
