"""`rapc test`: what is found, what is printed, with which status it ends."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ..cli.command import rapc
from .small_suite import GRAB, LIBRARY

CHECKOUT = Path(__file__).parents[2]
GIVEN = f"(script {GRAB}) (task (fetch box))"
GOOD = f"(define-test good {GIVEN} (expect (succeeds (fetch box))))\n"
BAD = f'(define-test bad "It fails." {GIVEN} (expect (never (grab ?))))\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A library, a file of tests in a folder below, and a file that is no test."""
    below = tmp_path / "below"
    below.mkdir()
    (tmp_path / "arms.rap").write_text(LIBRARY + BAD)
    (below / "arms.test.rap").write_text(LIBRARY + GOOD)
    (below / "legs.test.rap").write_text('(require "../arms")\n' + GOOD)
    return tmp_path


def test_all_test_files_below_a_folder_are_run(folder: Path) -> None:
    done = rapc("test", ".", cwd=folder)
    assert done.stdout.splitlines() == [
        "below/arms.test.rap",
        "  passed  good",
        "below/legs.test.rap",
        "  passed  good",
        "",
        "2 tests: 2 passed",
    ]
    assert (done.returncode, done.stderr) == (0, "")


def test_named_file_needs_no_test_suffix(folder: Path) -> None:
    done = rapc("test", "arms.rap", "below", cwd=folder)
    row = len(LIBRARY.splitlines()) + 1
    lines = done.stdout.splitlines()
    assert lines[:2] == ["arms.rap", "  failed  bad"]
    at = lines.index("bad: It fails.")
    assert lines[at + 1] == f"arms.rap:{row}:113"
    assert lines[at + 2].startswith(f"  {row} | (define-test bad")
    assert lines[at + 3].endswith(" ^^^^^^^^^^^^^^^^")
    assert lines[at + 4] == (
        "  what happened: (grab box) was requested at time 0 by (fetch box) [1]"
    )
    assert lines[at + 5] == "  the last cycles:"
    assert lines[-1] == "3 tests: 2 passed, 1 failed"
    assert done.returncode == 1


def test_failure_of_a_test_is_reported_on_one_line(folder: Path) -> None:
    told = BAD.replace("It fails.", "It fails,\n   as it is to.")
    (folder / "arms.rap").write_text(LIBRARY + told)
    done = rapc("test", "arms.rap", cwd=folder)
    assert "bad: It fails, as it is to." in done.stdout.splitlines()


def test_tests_come_from_standard_input_too(folder: Path) -> None:
    done = rapc("test", "-", cwd=folder, stdin='(require "arms")\n' + GOOD)
    assert done.stdout.splitlines()[:2] == ["<stdin>", "  passed  good"]
    assert done.returncode == 0


def test_quiet_omits_passed_tests(folder: Path) -> None:
    assert rapc("test", "-q", ".", cwd=folder).stdout == "2 tests: 2 passed\n"


def test_a_test_in_error_ends_with_2(tmp_path: Path) -> None:
    (tmp_path / "it.test.rap").write_text(LIBRARY + "(define-test it (task (fly)))")
    done = rapc("test", ".", cwd=tmp_path)
    assert "  error   it" in done.stdout
    assert "  wrong with the test: unknown RAP `fly`" in done.stdout
    assert done.stdout.endswith("1 test: 1 in error\n")
    assert done.returncode == 2


def test_findings_in_the_library_are_told_once_and_nothing_is_run(
    tmp_path: Path,
) -> None:
    one = '(define-test one (require "a") (task (act)))'
    two = '(define-test two (require "b") (task (act)))'
    (tmp_path / "a.rap").write_text("(declare-memory-proposition p (?x))")
    (tmp_path / "b.rap").write_text("(declare-memory-proposition q (?x))")
    text = "(define-rap (act) (succeed (= ?x 1)))"
    (tmp_path / "it.test.rap").write_text(text + one + two)
    done = rapc("test", "it.test.rap", cwd=tmp_path)
    assert done.stdout.count("error[") == 1
    assert "unbound-variable" in done.stdout
    assert "passed" not in done.stdout
    assert done.returncode == 2


def test_findings_in_a_library_of_several_files_of_tests_are_told_once(
    tmp_path: Path,
) -> None:
    (tmp_path / "lib.rap").write_text("(declare-memory-property p (?x))")
    for name in ("a", "b", "c"):
        text = f'(require "lib")(define-test {name} (until 3))'
        (tmp_path / f"{name}.test.rap").write_text(text)
    done = rapc("test", ".", cwd=tmp_path)
    assert done.stdout.count("requires a default") == 1
    assert done.returncode == 2


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("nowhere",), "`nowhere` does not exist"),
        ((), "missing a file or folder with tests"),
        (("none",), "no tests found in `none`"),
        ((".", "--fault", "(grab ?x)"), "--fault: missing result after"),
        ((".", "--fault", "(grip ?x) x"), "unknown primitive `grip`"),
        ((".", "--seeds", "0"), "--seeds"),
        ((".", "--junit", "no/where.xml"), "cannot write `no/where.xml`"),
    ],
)
def test_untestable_input(folder: Path, args: tuple[str, ...], message: str) -> None:
    (folder / "none").mkdir()
    done = rapc("test", *args, cwd=folder)
    assert message in done.stderr
    assert done.stderr.startswith("error: ")
    assert done.returncode == 2


def test_seeds_faults_junit_and_coverage(folder: Path) -> None:
    done = rapc(
        "test",
        "below/legs.test.rap",
        "--seed=3",
        "--seeds=2",
        "--fault=(grab ?) dropped",
        "--junit=out.xml",
        "--coverage=out.json",
        cwd=folder,
    )
    assert "  failed  good (seed 3)" in done.stdout
    assert "coverage" in done.stdout
    assert done.stdout.endswith("1 test, each under 2 seeds: 1 failed\n")
    assert (
        b'<testcase classname="below/legs.test.rap" name="good"'
        in (folder / "out.xml").read_bytes()
    )
    covered = json.loads((folder / "out.json").read_bytes())
    assert covered["files"][0]["file"] == "arms.rap"
    assert done.returncode == 1


def test_two_reports_are_not_written_to_one_file(folder: Path) -> None:
    both = ("--junit=out.json", "--coverage=./out.json")
    done = rapc("test", "below/legs.test.rap", *both, cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert "cannot write --junit and --coverage to the same file" in done.stderr


def test_coverage_without_a_file(folder: Path) -> None:
    """What follows it is a path unless it ends in `.json`."""
    done = rapc("test", "--coverage", "below/legs.test.rap", cwd=folder)
    assert done.stdout.count("passed") == 2
    assert "coverage" in done.stdout
    assert done.returncode == 0


def test_colour_is_asked_for(folder: Path) -> None:
    assert "\x1b[" not in rapc("test", ".", cwd=folder).stdout
    assert "\x1b[" in rapc("test", ".", "--color=always", cwd=folder).stdout


ORDER = CHECKOUT / "examples" / "rock-order.rap"
TASK = ("--world", "truck", "--task", "(rock-order red 1)", "--until", "60", "-q")


def test_faults_in_a_run_of_any_world(tmp_path: Path) -> None:
    faults = ("--fault=(eye-scan ?) eye-cant-find p=0.5", "--fault=(truck-move) okay")
    args = ("run", str(ORDER), *TASK, *faults, "--seed", "1", "--trace")
    first, second = (rapc(*args, name, cwd=tmp_path) for name in ("a.jsonl", "b.jsonl"))
    assert first.stdout == second.stdout
    assert "eye-cant-find)" in first.stdout
    told = (tmp_path / "a.jsonl").read_text()
    events = [json.loads(line) for line in told.splitlines()]
    assert events[0]["spec"]["faults"] == [fault.partition("=")[2] for fault in faults]
    ends = [e for e in events if e["event"] == "primitive-ended"]
    scans = {e["result"] for e in ends if e["request"].startswith("(eye-scan")}
    assert scans == {"okay", "eye-cant-find"}
    assert all(e["data"] == [] for e in ends if e["request"] == "(truck-move)")


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("(eye-scan) eye-cant-find", "--fault: `eye-scan` takes 1 argument, not 0"),
        (
            "(eye-scan ?) eye-cant-fnd",
            "--fault: `eye-cant-fnd` is not a result of `eye-scan`; did "
            "you mean `eye-cant-find`?",
        ),
        ("eye-scan", "--fault: expected a proposition, not a symbol: eye-scan"),
    ],
)
def test_faults_unknown_to_the_world_are_refused(fault: str, message: str) -> None:
    done = rapc("run", str(ORDER), *TASK, "--fault", fault)
    assert done.stderr.splitlines()[0] == f"error: {message}"
    assert (done.stdout, done.returncode) == ("", 2)


def test_passing_test_reports_no_seed(tmp_path: Path) -> None:
    (tmp_path / "still.test.rap").write_text("(define-test still (expect (memory t)))")
    done = rapc("test", ".", "--seeds", "3", cwd=tmp_path)
    assert "  passed  still\n" in done.stdout


EVIL = """
(define-rap (idle) (succeed t))
(define-test it (world "evil:Evil") (task (idle)) (expect (succeeds (idle))))
"""
EVIL_PY = """
from pathlib import Path
from rapc.worlds.scripted import ScriptedWorld
from rapc.world import Kit
Path("imported").touch()
class Evil(ScriptedWorld):
    name = "evil"
    kit = Kit()
    def __init__(self, rng, options):
        super().__init__(())
"""


@pytest.mark.parametrize("name", ["evil.test.rap", "evil.rapc"])
def test_test_imports_only_permitted_modules(name: str, tmp_path: Path) -> None:
    (tmp_path / "evil.test.rap").write_text(EVIL)
    (tmp_path / "evil.py").write_text(EVIL_PY)
    rapc("compile", "evil.test.rap", "-o", "evil.rapc", cwd=tmp_path)
    done = rapc("test", name, cwd=tmp_path)
    assert done.returncode == 2
    assert "the module `evil` may not be imported for a test" in done.stdout
    assert "permit it by `--world-module evil`" in done.stdout
    assert not (tmp_path / "imported").exists()
    done = rapc("test", name, "--world-module", "evil", cwd=tmp_path)
    assert done.returncode == 0, done.stdout
    assert (tmp_path / "imported").exists()


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("rapc.toml", 'world-modules = ["evil"]'),
        ("pyproject.toml", '[tool.rapc]\nworld-modules = ["others", "evil"]'),
    ],
)
def test_the_configuration_permits_worlds_of_modules(
    file: str, text: str, tmp_path: Path
) -> None:
    """The nearest one of the first path; `rapc check` imports nothing all the same."""
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "evil.test.rap").write_text(EVIL)
    (tmp_path / "evil.py").write_text(EVIL_PY)
    (tmp_path / file).write_text(text)
    assert rapc("check", "tests/evil.test.rap", cwd=tmp_path).returncode == 0
    assert not (tmp_path / "imported").exists()
    done = rapc("test", "tests", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    done = rapc("test", str(tmp_path), cwd=tmp_path.parent)
    assert (done.returncode, done.stderr) == (0, "")
    (tmp_path / "tests" / "rapc.toml").write_text("")
    done = rapc("test", "tests", cwd=tmp_path)
    assert done.returncode == 2
    assert "or by `world-modules` in `rapc.toml`" in done.stdout
    (tmp_path / "tests" / "rapc.toml").write_text("world-module = 3")
    done = rapc("test", "tests", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "unknown key `world-module`\n  did you mean `world-modules`?" in done.stderr


def test_world_class_with_capitals_requires_quotes(tmp_path: Path) -> None:
    (tmp_path / "evil.test.rap").write_text(EVIL.replace('"', "", 2))
    (tmp_path / "evil.py").write_text(EVIL_PY)
    done = rapc("test", "evil.test.rap", "--world-module", "evil", cwd=tmp_path)
    assert done.returncode == 2
    assert 'so in a test it is written "evil:' in done.stdout


@pytest.mark.parametrize("option", ["--junit", "--coverage"])
@pytest.mark.parametrize("name", ["lib.rap", "it.test.rap", "all.json"])
def test_source_file_is_not_overwritten(tmp_path: Path, option: str, name: str) -> None:
    """Not under another name either, and `--coverage` takes a name in `.json`."""
    (tmp_path / "lib.rap").write_text(LIBRARY)
    (tmp_path / "it.test.rap").write_text('(require "lib") ' + GOOD)
    path = "it.test.rap"
    if name == "all.json":
        path = name
        assert rapc("compile", "it.test.rap", "-o", name, cwd=tmp_path).returncode == 0
    (tmp_path / "link.json").symlink_to(name)
    before = (tmp_path / name).read_bytes()
    done = rapc("test", option, "link.json", path, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"error: {option}: `link.json` is a source file of the tests or of their "
        f"library\n"
    )
    assert (tmp_path / name).read_bytes() == before


def test_jobs_change_no_byte_of_the_output(tmp_path: Path) -> None:
    tests = [
        f"(define-test t{n} (script {GRAB}) (task (fetch box))"
        f" (expect (never (grab {'box' if n % 3 else 'cup'}))))"
        for n in range(7)
    ]
    for name, part in (("a", tests[:4]), ("b", tests[4:])):
        text = "\n".join((LIBRARY, *part))
        (tmp_path / f"{name}.test.rap").write_text(text, encoding="utf-8")
    alone, many = (
        rapc("test", ".", "--seeds", "3", "--jobs", jobs, cwd=tmp_path)
        for jobs in ("1", "3")
    )
    assert (many.stdout, many.stderr) == (alone.stdout, alone.stderr)
    assert many.returncode == alone.returncode == 1
    assert many.stdout.endswith("7 tests, each under 3 seeds: 3 passed, 4 failed\n")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((".", "--coverage"), "cannot combine --jobs and --coverage"),
        ((".", "--coverage-min", "3"), "cannot combine --jobs and --coverage"),
        (("-",), "cannot combine --jobs and standard input"),
    ],
)
def test_jobs_refuse_coverage_and_standard_input(
    tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    done = rapc("test", *options, "--jobs", "2", cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr


def test_process_that_ends_early_ends_the_command(tmp_path: Path) -> None:
    world = """
import os
from rapc.world import Kit
from rapc.worlds.scripted import ScriptedWorld

class Exits(ScriptedWorld):
    name = "exits"
    kit = Kit()
    def __init__(self, rng, options): os._exit(3)
"""
    (tmp_path / "exits.py").write_text(world, encoding="utf-8")
    text = '(define-rap (idle) (succeed t)) (define-test it (world "exits:Exits"))'
    (tmp_path / "it.test.rap").write_text(text, encoding="utf-8")
    options = ("--world-module", "exits", "--jobs", "2")
    done = rapc("test", ".", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert "a process ended before its test: 0 of 1 ran" in done.stderr
