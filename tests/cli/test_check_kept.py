"""Whatever the options of `rapc check`: what is printed and written is the same with a
cache and without, while a library is edited."""

from __future__ import annotations

import os
import random
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from rapc.analysis import cache_file
from rapc.cli.check import check
from tests.analysis.libraries import Maker, damaged, edited
from tests.effort import first

RAPS = 8
"""So many RAPs are in the library."""

OPTIONS: Mapping[str, Sequence[str]] = {
    "none": (),
    "fix": ("--fix", "--unsafe-fixes"),
    "baseline": ("--baseline", "known.json"),
    "select": ("--select", "misspelt-constant,unknown-rap,RAP015,malformed-form"),
    "fix what is safe": ("--fix",),
    "diff": ("--diff",),
    "diff of all": ("--diff", "--unsafe-fixes"),
    "statistics": ("--statistics",),
    "statistics as json": ("--statistics", "--output-format", "json"),
    "baseline that is written": ("--write-baseline", "noted.json"),
    "rules besides": ("--extend-select", "unused-declaration,singleton-variable"),
    "ignore": ("--ignore", "unbound-variable,RAP015"),
    "ignore by files": ("--per-file-ignores", "p1.rap:unbound-variable"),
    "errors": ("--select", "unknown-rap,wrong-step-arity,unbound-variable"),
    "one rule": ("--select", "misspelt-constant"),
    "grave": ("--fail-level", "error", "-q"),
    "exit zero": ("--exit-zero", "--fail-level", "info"),
    "configured": ("--config", "other.toml"),
    "isolated": ("--isolated",),
    "colour": ("--color", "always"),
    "grouped": ("--output-format", "grouped"),
    "concise": ("--output-format", "concise"),
    "json": ("--output-format", "json"),
    "json-lines": ("--output-format", "json-lines"),
    "sarif": ("--output-format", "sarif"),
    "github": ("--output-format", "github"),
    "junit": ("--output-format", "junit"),
    "a file": ("--output-format", "json", "--output-file", "found.json"),
}

OTHER = """\
ignore = ["unknown-result"]
[per-file-ignores]
"lib/p0*" = ["unknown-rap"]
[severity]
unbound-variable = "info"
misspelt-constant = "error"
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, in which libraries of any size are kept."""
    monkeypatch.setattr(cache_file, "SMALLEST", 0)
    monkeypatch.setenv("RAPC_CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lib").mkdir()
    (tmp_path / "other.toml").write_text(OTHER)
    return tmp_path


def _libraries(dice: random.Random, edits: int) -> Iterator[Mapping[str, str]]:
    """Yield a library, and what becomes of it; slips come, and go again."""
    maker = Maker(dice, RAPS)
    begin = texts = maker.files(2)
    yield texts
    for _ in range(edits):
        texts = begin if dice.random() < 0.1 else edited(dice, maker, texts)
        yield damaged(dice, texts) if dice.random() < 0.3 else texts


def _write(folder: Path, texts: Mapping[str, str]) -> None:
    for file in folder.glob("*.rap"):
        if file.name not in texts:
            file.unlink()
    for name, text in texts.items():
        (folder / name).write_text(text)


def _done(folder: Path, options: Sequence[str]) -> object:
    """Run the command; return its output, and all files that may be other by now."""
    done = CliRunner().invoke(check, [*options, "lib"])
    assert done.exit_code in (0, 1)
    assert done.exception is None or isinstance(done.exception, SystemExit)
    files = [*folder.glob("lib/*.rap"), *folder.glob("*.json")]
    texts = {str(file): file.read_text() for file in sorted(files)}
    return done.exit_code, done.stdout, done.stderr, texts


@pytest.mark.parametrize("edits", first(1, [1, 30]), ids="{} edits".format)
@pytest.mark.parametrize("option", first(4, OPTIONS))
def test_what_is_kept_changes_no_output(option: str, edits: int, here: Path) -> None:
    dice, options, different = random.Random(option), OPTIONS[option], set()
    for number, texts in enumerate(_libraries(dice, edits)):
        _write(here / "lib", texts)
        if number % 20 == 0:
            _done(here, ("--no-cache", "--write-baseline", "known.json"))
        plain = _done(here, (*options, "--no-cache"))
        _write(here / "lib", texts)
        assert _done(here, options) == plain
        _write(here / "lib", texts)
        different.add(repr(plain))
    assert len(different) > edits / 4
    mends = "--fix" in options or "--diff" in options
    assert mends is not any(here.glob("kept/*.checked"))


@pytest.mark.parametrize("edits", first(1, [2, 60]), ids="{} edits".format)
def test_what_is_watched_is_found_as_without_a_cache(
    edits: int, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def watched(*options: str) -> tuple[str, str]:
        libraries = _libraries(random.Random(edits), edits)
        times = iter(range(1, edits + 2))

        def edit(seconds: float) -> None:
            texts = next(libraries, None)
            if texts is None:
                raise KeyboardInterrupt
            _write(here / "lib", texts)
            time = next(times)
            for file in here.glob("lib/*.rap"):
                os.utime(file, (time, time))

        monkeypatch.setattr(
            "rapc.cli.watch.time", SimpleNamespace(sleep=edit, time_ns=lambda: edits)
        )
        edit(0)
        done = CliRunner().invoke(check, ["--watch", *options, "lib"])
        assert done.exit_code == 0
        return done.stdout, done.stderr

    told, said = watched()
    assert (told, said) == watched("--no-cache")
    assert said.count("waiting for a change") > edits
    assert told.count("checked ") > edits
