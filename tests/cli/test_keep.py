"""`rapc run --keep`: the methods that solvers found, as a library like any other."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

import rapc as package
from tests.cli.command import rapc

LIBRARY = """\
(declare-primitive nap (?where) (okay cold))
(declare-memory-proposition rested (?where))
(define-rap (doze ?where)
  (succeed (last-result okay))
  (method bed (context (rested ?where)) (primitive (nap bed))))
"""

WORLD = """\
import os, signal
from rapc.world import Kit, Offer, Reply, SimpleWorld
from rapc import methods

TEXT = "(method {name} (context (= ?where {place})) (primitive (nap {place})))"

def sleep(goal, memory):
    place = str(goal[1])
    name = "bed" if place == "attic" else f"on-{place}"
    return methods(TEXT.format(name=name, place=place))

def wrong(goal, memory):
    return methods("(method (context (= ?where ?there)) (primitive (nap ?nowhere)))")

class Beds(SimpleWorld):
    "Beds."
    name = "beds"
    kit = Kit(Offer({"nap": (1, ("okay", "cold"))}), solvers={"doze": sleep})
    def perform(self, ticket, request):
        if request[1] == "hall":
            os.kill(os.getpid(), signal.SIGINT)
        if request[1] == "cellar":
            raise ValueError("dark")
        if request[1] == "den":
            open("kept.rap", "w").close()
        return Reply("okay")

class Wrong(Beds):
    kit = Kit(Offer({"nap": (1, ("okay", "cold"))}), solvers={"doze": wrong})
"""


@pytest.fixture
def beds(tmp_path: Path) -> Path:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "doze.rap").write_text(LIBRARY)
    (tmp_path / "beds.py").write_text(WORLD)
    return tmp_path


def _run(
    folder: Path,
    *places: str,
    library: str = "lib",
    file: str = "kept.rap",
    world: str = "Beds",
) -> subprocess.CompletedProcess[str]:
    tasks = [part for place in places for part in ("--task", f"(doze {place})")]
    args = ("--world", f"beds:{world}", "-q", "--keep", file)
    return rapc("run", library, *args, *tasks, cwd=folder)


def test_kept_methods_are_a_library_that_needs_no_solver(beds: Path) -> None:
    done = _run(beds, "sofa", "attic")
    assert (done.returncode, done.stderr) == (0, "kept 2 methods in kept.rap\n")
    assert (
        (beds / "kept.rap").read_text()
        == """\
;;; Methods found in a run in the world `beds`.

(require "lib")

(define-method doze on-sofa
  (context (= ?where sofa))
  (primitive (nap sofa)))

(define-method doze bed-2
  (context (= ?where attic))
  (primitive (nap attic)))
"""
    )
    assert rapc("check", "kept.rap", cwd=beds).returncode == 0
    assert rapc("fmt", "--check", "kept.rap", cwd=beds).returncode == 0
    again = _run(beds, "attic", "sofa", library="kept.rap", file="more.rap")
    note = "note: no method was found; `more.rap` is not written\n"
    assert (again.returncode, again.stderr) == (0, note)
    assert not (beds / "more.rap").exists()


@pytest.mark.parametrize(
    ("library", "file", "required"),
    [
        ("lib/doze.rap", "kept.rap", '"lib/doze"'),
        ("lib", "lib/kept.rap", '"."'),
        ("lib/doze.rap", "lib/kept.rap", '"doze"'),
        ("lib", "else/kept.rap", '"../lib"'),
    ],
)
def test_kept_file_requires_the_library(
    beds: Path, library: str, file: str, required: str
) -> None:
    (beds / "else").mkdir()
    assert _run(beds, "sofa", library=library, file=file).returncode == 0
    assert f"(require {required})" in (beds / file).read_text()
    assert package.load(beds / file).raps == ("doze",)
    assert rapc("check", file, cwd=beds).returncode == 0
    assert rapc("check", str(beds / file)).returncode == 0


def test_kept_file_of_a_saved_library_requires_nothing(beds: Path) -> None:
    assert rapc("compile", "lib", "-o", "lib.rapc", cwd=beds).returncode == 0
    assert _run(beds, "sofa", library="lib.rapc").returncode == 0
    assert "require" not in (beds / "kept.rap").read_text()
    assert package.load(beds / "lib", beds / "kept.rap").raps == ("doze",)


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("lib/doze.rap", "cannot write `lib/doze.rap`: the file exists"),
        ("no/kept.rap", "cannot write `no/kept.rap`: missing file or folder"),
        ("kept.txt", "expected the name of a RAP file, not `kept.txt`"),
        ("kept.test.rap", "expected the name of a RAP file, not `kept.test.rap`"),
    ],
)
def test_files_that_cannot_be_written_are_refused_before_the_run(
    beds: Path, file: str, said: str
) -> None:
    done = _run(beds, "sofa", file=file)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: --keep: {said}")
    assert (beds / "lib" / "doze.rap").read_text() == LIBRARY


@pytest.mark.parametrize(("place", "status"), [("hall", 1), ("cellar", 2)])
def test_methods_are_kept_if_the_run_is_broken_off(
    beds: Path, place: str, status: int
) -> None:
    done = _run(beds, "sofa", place)
    assert done.returncode == status
    text = (beds / "kept.rap").read_text()
    assert "(define-method doze on-sofa" in text
    assert f"(define-method doze on-{place}" in text


def test_faulty_methods_are_kept_and_reported(beds: Path) -> None:
    done = _run(beds, "sofa", world="Wrong")
    assert "unbound-variable" in done.stdout + done.stderr
    assert "(primitive (nap ?nowhere))" in (beds / "kept.rap").read_text()


def test_methods_are_printed_if_the_file_appears_during_the_run(beds: Path) -> None:
    done = _run(beds, "den")
    assert done.returncode == 2
    assert "(define-method doze on-den" in done.stdout
    assert "cannot write `kept.rap`: the file exists" in done.stderr
