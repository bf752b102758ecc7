"""Paths that cannot be read, searched or written end a command in one line."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from rapc.base.files import all_there
from rapc.errors import LoadError
from rapc.host import load
from rapc.library.saved import encode, seal
from tests.cli.command import rapc

LIBRARY = """
(declare-primitive nap () (okay))
(define-rap (spin) (succeed (last-result okay)) (method (primitive (nap))))
(define-rap (nobody-asks) (succeed (last-result okay)) (method (primitive (nap))))
"""
WORLD = """
from rapc.world import Kit, Offer, Reply, World
class Bed(World):
    "A bed."
    name = "bed"
    kit = Kit(Offer({"nap": (0, ("okay",))}))
    def __init__(self, rng, options): pass
    def now(self): return 0
    def perform(self, ticket, request): return Reply("okay")
    def next_time(self): return None
    def advance(self, to): pass
    def messages(self): return []
"""
RUN = ("--world", "bed:Bed", "--task", "(spin)")

needs_permissions = pytest.mark.skipif(
    os.geteuid() == 0, reason="nothing is forbidden to root"
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "doze.rap").write_text(LIBRARY)
    (tmp_path / "bed.py").write_text(WORLD)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "circle").symlink_to("circle")
    return tmp_path


@pytest.mark.parametrize(
    "command",
    [
        ("compile", "doze.rap", "-o", "x" * 300),
        ("run", "doze.rap", *RUN, "--trace", "x" * 300),
        ("compile", "doze.rap", "-o", "doze.rap/below"),
        ("run", "doze.rap", *RUN, "--trace", "doze.rap/below"),
        ("compile", "x" * 300, "-o", "y"),
        ("check", "x" * 300),
        ("run", "x" * 300, *RUN),
        ("test", "x" * 300),
        ("compile", "doze.rap", "-o", "doze.rapc/x"),
        ("experiment", "x" * 300),
        ("experiment", "doze.rap/below"),
        ("check", "doze.rap/below"),
        ("check", "doze.rap", "doze\n.rap"),
        ("test", "doze.rap/below"),
        ("test", "doze.rap", "--junit", "x" * 300),
        ("test", "doze.rap", "--junit", "no-folder/x"),
        ("test", "doze.rap", "--coverage", "x" * 300),
        ("run", "doze.rap", *RUN, "--trace", "no-folder/x"),
        ("run", "doze.rap", "--world", "x" * 300, "--task", "(spin)"),
        (
            "run",
            "doze.rap",
            "--world",
            "truck",
            "--task",
            "(spin)",
            "--facts",
            "x" * 300,
        ),
        ("worlds", "x" * 300),
        ("check", "pipe"),
        ("run", "pipe", *RUN),
        ("compile", "pipe", "-o", "y"),
        ("test", "pipe"),
        ("experiment", "pipe"),
        ("check", "circle"),
        ("experiment", "circle"),
        ("test", "circle"),
        ("run", "circle", *RUN),
        ("compile", "circle", "-o", "y"),
    ],
)
def test_odd_paths_end_in_one_line(command: tuple[str, ...], folder: Path) -> None:
    done = rapc(*command, cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: ")
    said, *advice = done.stderr.splitlines()
    assert all(line.startswith("  ") for line in advice)
    assert len(advice) <= 1
    assert "rapc itself" not in said


@pytest.mark.parametrize("begun", [b"", b"(define-rap (wait))"])
def test_file_without_end_is_refused(begun: bytes) -> None:
    """The system has plain files whose end never comes, the kernel's log for one."""
    out, into = os.pipe()
    os.set_blocking(out, False)
    with open(out, "rb") as file, open(into, "wb") as writer:
        writer.write(begun)
        writer.flush()
        with pytest.raises(LoadError, match="reading blocks without end"):
            all_there("log", file)


@needs_permissions
@pytest.mark.parametrize("kind", ["file", "folder"])
def test_forbidden_file_is_reported_on_one_line(kind: str, folder: Path) -> None:
    shut = folder / "shut"
    shut.mkdir()
    (shut / "a.rap").write_text(LIBRARY)
    (shut / "a.rap" if kind == "file" else shut).chmod(0)
    for command in (
        ("compile", "shut/a.rap", "-o", "x"),
        ("check", "shut/a.rap"),
        ("compile", "doze.rap", "-o", "shut/x"),
    ):
        done = rapc(*command, cwd=folder)
        assert "rapc itself" not in done.stderr
    shut.chmod(0o700)


def test_unreadable_folder_is_not_treated_as_empty(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def shut(path: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    monkeypatch.setattr(os, "lstat", shut)
    with pytest.raises(LoadError, match=r"cannot read `shut/a\.rap`: permission"):
        load("shut/a.rap")


def _damaged(folder: Path, name: str) -> None:
    """Save the library with a RAP that nobody asks for damaged."""
    library = load(folder / "doze.rap")
    data = encode(library.program.library, library.name).split(b"\n", 1)[1]
    at = data.rindex(b'["Primitive",["Request"') if b'["Request"' in data else -1
    at = data.rindex(b'"nobody-asks"') if at < 0 else at
    damaged = data[:at] + data[at:].replace(b'"nap"', b'"map"', 1)
    assert damaged != data
    (folder / name).write_bytes(seal(damaged))


def test_unreachable_damaged_rap_is_ignored(folder: Path) -> None:
    _damaged(folder, "doze.rapc")
    done = rapc("run", "doze.rapc", *RUN, "-q", cwd=folder)
    assert done.returncode == 0, done.stderr
    trace = ("--trace", "trace.jsonl")
    reached = rapc(
        *("run", "doze.rapc", "--world", "bed:Bed", "--task", "(nobody-asks)", *trace),
        cwd=folder,
    )
    assert (reached.returncode, reached.stdout) == (2, "")
    assert "`doze.rapc` cannot be run" in reached.stderr
    assert not (folder / "trace.jsonl").exists()
