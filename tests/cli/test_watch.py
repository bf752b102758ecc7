"""What is done again when files change, in files that change at chosen moments."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from rapc.cli.check import check
from rapc.cli.watch import watch

NOW = 10**18
"""The time of the clock, in nanoseconds."""


@pytest.fixture
def times(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """Return how often something is done while files of a folder change.

    What changes is given as a function of the number of the time, which is called while
    it is done, and one that is called while a change is waited for, until it is false.
    """

    def count(during: Callable[[int], object], later: Callable[[int], object]) -> int:
        done: list[int] = []

        def act() -> list[str]:
            done.append(len(done) + 1)
            during(done[-1])
            return [str(file) for file in tmp_path.glob("**/*.rap")]

        def wait(seconds: float) -> None:
            if not later(done[-1]):
                raise KeyboardInterrupt

        clock = SimpleNamespace(sleep=wait, time_ns=lambda: NOW)
        monkeypatch.setattr("rapc.cli.watch.time", clock)
        for name in ("lib/a.rap", "lib/b.rap", "required.rap"):
            (tmp_path / name).parent.mkdir(exist_ok=True)
            _write(tmp_path / name, NOW - 10**9)
        watch([str(tmp_path / "lib")], act)
        return len(done)

    return count


def _write(file: Path, time: int) -> None:
    file.write_text("(define-rap (a))")
    os.utime(file, ns=(time, time))


def _nothing(number: int) -> bool:
    return False


def test_a_new_test_is_a_change(times: Callable[..., int], tmp_path: Path) -> None:
    def add(number: int) -> bool:
        _write(tmp_path / "lib" / "new.test.rap", NOW)
        return number == 1

    assert times(_nothing, add) == 2


def test_nothing_is_done_again_without_a_change(times: Callable[..., int]) -> None:
    assert times(_nothing, _nothing) == 1


def test_file_changed_during_the_first_read_is_read_again(
    times: Callable[..., int], tmp_path: Path
) -> None:
    """It was not watched before: nobody knew that it would be required."""

    def change(number: int) -> None:
        if number == 1:
            _write(tmp_path / "required.rap", NOW)

    assert times(change, _nothing) == 2


def test_removed_file_is_one_change(times: Callable[..., int], tmp_path: Path) -> None:
    def remove(number: int) -> bool:
        (tmp_path / "lib/b.rap").unlink(missing_ok=True)
        return number == 1

    assert times(_nothing, remove) == 2


def test_removed_required_file_is_one_change(
    times: Callable[..., int], tmp_path: Path
) -> None:
    def remove(number: int) -> bool:
        (tmp_path / "required.rap").unlink(missing_ok=True)
        return number == 1

    assert times(_nothing, remove) == 2


def test_new_file_in_a_folder_is_a_change(
    times: Callable[..., int], tmp_path: Path
) -> None:
    def add(number: int) -> bool:
        _write(tmp_path / "lib/c.rap", NOW - 10**9)
        return number == 1

    assert times(_nothing, add) == 2


EDITS = (
    "(define-rap (go) (method (task-net (t1 (walk)))))",
    "(define-rap (go) (method (task-net (t1 (walk))))",
    "(define-rap (walk))\n(define-rap (go) (method (task-net (t1 (walk)))))",
    "(define-rap (go ?x) (method (task-net (t1 (walk)))))",
)


def test_watched_findings_are_those_of_a_plain_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = iter(enumerate((*EDITS, *EDITS), 1))
    plain = ""

    def edit(seconds: float) -> None:
        nonlocal plain
        number, text = next(texts, (0, ""))
        if not number:
            raise KeyboardInterrupt
        Path("lib/a.rap").write_text(text)
        os.utime("lib/a.rap", ns=(number, number))
        plain += CliRunner().invoke(check, ["lib"]).stdout

    clock = SimpleNamespace(sleep=edit, time_ns=lambda: NOW)
    monkeypatch.setattr("rapc.cli.watch.time", clock)
    monkeypatch.chdir(tmp_path)
    Path("lib").mkdir()
    Path("lib/b.rap").write_text("(define-rap (home) (method (task-net (t1 (go)))))")
    edit(0)
    watched = CliRunner().invoke(check, ["--watch", "lib"])
    assert (watched.exit_code, watched.stdout) == (0, plain)
    assert plain.count("checked 2 files") == 2 * len(EDITS)
    assert len(set(plain.split("checked 2 files"))) > len(EDITS)
