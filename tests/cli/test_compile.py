"""`rapc compile`: what it writes, what that is good for, and what it refuses."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rapc.library.saved import FORMAT
from tests.cli.command import rapc

pytestmark = pytest.mark.xdist_group("compile")

CHECKOUT = Path(__file__).parents[2]
KITCHEN = CHECKOUT / "tests" / "library" / "kitchen.rap"
FAULTY = """\
(declare-primitive push (?thing) (okay))
(declare-memory-proposition big (?thing))
(define-rap (go ?thing)
  (succeed (last-result okay))
  (method
    (context (big (+ ?thing 1)))
    (primitive (push ?thing))))
(define-test it-goes (script ((push ?x)))
  (task (go ball)) (expect (succeeds (go ball))))
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """What becomes of the faulty library."""
    folder = tmp_path_factory.mktemp("compiled")
    (folder / "go.test.rap").write_text(FAULTY)
    done = rapc("compile", "go.test.rap", "-o", "go.rapc", cwd=folder)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    return (folder / "go.rapc").read_bytes()


@pytest.fixture
def faulty(tmp_path: Path, compiled: bytes) -> Path:
    """A folder with a library, and a test of it that fails for a fault at run time."""
    (tmp_path / "go.test.rap").write_text(FAULTY)
    (tmp_path / "go.rapc").write_bytes(compiled)
    return tmp_path


def test_compiled_run_equals_the_run_from_sources(tmp_path: Path) -> None:
    (tmp_path / "rocks.rap").write_text('(require "truck")\n')
    done = rapc("compile", "rocks.rap", "-o", "rocks", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    ran = [
        rapc(
            *(
                "run",
                path,
                "--world",
                "truck",
                "--task",
                "(fill-order red 1 factory-1)",
            ),
            *("--seed", "4", "--trace", f"{path}.jsonl"),
            cwd=tmp_path,
        )
        for path in ("rocks.rap", "rocks")
    ]
    assert ran[0].returncode == 0
    assert ran[0].stdout == ran[1].stdout
    traces = [(tmp_path / f"rocks{end}.jsonl").read_bytes() for end in (".rap", "")]
    assert traces[0] == traces[1]


def test_a_fault_at_run_time_points_at_the_source(faulty: Path) -> None:
    told = [
        rapc("test", path, cwd=faulty).stdout for path in ("go.test.rap", "go.rapc")
    ]
    assert "context of method `#1` at go.test.rap:6" in told[0]
    assert "9 |   (task (go ball)) (expect" in told[0]
    assert told[0] == told[1]


def test_the_sources_are_wanted_no_more(faulty: Path) -> None:
    (faulty / "go.test.rap").unlink()
    done = rapc("test", "go.rapc", "--coverage", cwd=faulty)
    assert done.returncode == 1
    assert "1 test: 1 failed" in done.stdout


@pytest.mark.slow
def test_a_folder_is_compiled_with_its_tests(tmp_path: Path) -> None:
    truck, file = CHECKOUT / "stdlib" / "truck", tmp_path / "truck.rapc"
    assert rapc("compile", str(truck), "-o", str(file)).returncode == 0
    told = [rapc("test", "-q", str(path)).stdout for path in (truck, file)]
    assert told[0] == told[1]
    assert " passed" in told[0]


def test_standard_input_can_be_compiled(tmp_path: Path) -> None:
    text = "(define-rap (nothing) (method (task-net)))\n"
    done = rapc("compile", "-", "-o", "x", cwd=tmp_path, stdin=text)
    assert done.returncode == 0
    ran = rapc("run", "x", "--world", "truck", "--task", "(nothing)", cwd=tmp_path)
    assert "initial facts of `place`" in ran.stderr


def test_errors_are_printed_and_nothing_is_written(tmp_path: Path) -> None:
    (tmp_path / "bad.rap").write_text("(define-rap (go) (succeed (nowhere)))")
    (tmp_path / "old").write_text("kept")
    done = rapc("compile", "bad.rap", "-o", "old", cwd=tmp_path)
    assert done.returncode == 2
    assert "error[RAP015 undeclared-predicate]" in done.stdout
    assert (tmp_path / "old").read_text() == "kept"
    assert sorted(os.listdir(tmp_path)) == ["bad.rap", "old"]


def test_errors_in_its_tests_stop_it_too(tmp_path: Path) -> None:
    (tmp_path / "good.rap").write_text("(define-rap (go) (method (task-net)))")
    (tmp_path / "good.test.rap").write_text('(require "bad")')
    done = rapc("compile", ".", "-o", "out", cwd=tmp_path)
    assert done.returncode == 2
    assert "cannot find `bad`" in done.stdout
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("compile", "go.test.rap"), "missing -o FILE or --explain RAP"),
        (("compile", "go.rapc", "-o", "x"), "`go.rapc` is already a compiled library"),
        (
            ("compile", "go.test.rap", "-o", "go.test.rap"),
            "-o: `go.test.rap` is a source file of the library",
        ),
        (
            ("compile", "go.test.rap", "-o", "no/x"),
            "cannot write `no/x`: missing file or folder",
        ),
        (("compile", "go.test.rap", "-o", "."), "-o: cannot write `.`: it is a folder"),
        (
            ("compile", "go.test.rap", "--explain", "goo"),
            "unknown RAP `goo`; did you mean `go`?",
        ),
        (
            ("compile", "go.test.rap", "-o", "-"),
            "-o requires a file; use /dev/stdout for standard output",
        ),
        (
            ("check", "go.rapc"),
            "expected a source file, not the compiled library `go.rapc`",
        ),
        (
            ("test", "cut"),
            "`cut` is damaged: its content does not match its checksum",
        ),
        (
            ("run", "cut", "--world", "truck", "--task", "(go a)"),
            "`cut` is damaged: its content does not match its checksum",
        ),
    ],
)
def test_slips_are_refused_in_one_line(
    args: tuple[str, ...], said: str, faulty: Path
) -> None:
    data = (faulty / "go.rapc").read_bytes()
    (faulty / "cut").write_bytes(data[:-9])
    done = rapc(*args, cwd=faulty)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert (faulty / "go.rapc").read_bytes() == data
    assert (faulty / "go.test.rap").read_text() == FAULTY


def test_existing_files_are_kept(tmp_path: Path) -> None:
    """Neither a test beside the library nor one that could be taken for a part."""
    tests = "(define-test it-goes (task (go)) (expect (succeeds (go))))"
    texts = {
        "go.rap": "(define-rap (go) (method (task-net)))",
        "go.test.rap": f'(require "go")\n{tests}',
        "go.rapc.part": "kept",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    assert rapc("compile", ".", "-o", "go.rapc", cwd=tmp_path).returncode == 0
    done = rapc("compile", ".", "-o", "go.test.rap", cwd=tmp_path)
    assert done.stderr == "error: -o: `go.test.rap` is a source file of the library\n"
    assert sorted(os.listdir(tmp_path)) == sorted([*texts, "go.rapc"])
    assert {name: (tmp_path / name).read_text() for name in texts} == texts


def test_special_file_is_written_directly() -> None:
    done = rapc("compile", str(KITCHEN), "-o", "/dev/stdout")
    assert done.stdout.startswith(f"rapc-library {FORMAT} ")
