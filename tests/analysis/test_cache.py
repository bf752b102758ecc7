"""What is kept of checks: findings are the same with it and without."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import pytest

from bench.parse import DECLARATIONS, DEFINITION
from rapc.analysis import cache as keeping
from rapc.analysis.cache import Cache
from rapc.analysis.check_files import check_files
from rapc.analysis.driver import CheckReport
from rapc.analysis.selection import Selection, by_default, rule_names
from rapc.base.source import SourceFile
from rapc.library.requiring import UNRESOLVED
from rapc.library.units import Units
from rapc.parser.unit import SourceUnit
from tests.effort import first

PATHS = ("lib", "one.test.rap", "two.test.rap")

TEST = """\
(require "lib")
(define-test t{0}
  (script ((arm-grasp left box) arm-dropped) ((drive-to depot)))
  (task (pickup-{0} left box)))
(define-test u{0} (require "more") (task (go-to {1})))
"""


class NoUnits(Units):
    """Units for a check that must not need any."""

    def __call__(self, source: SourceFile) -> SourceUnit:
        raise AssertionError(f"{source.name} is parsed")


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A library of some files, in the working folder, with two files of tests."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lib").mkdir()
    (tmp_path / "more.rap").write_text("(define-rap (rest))\n")
    (tmp_path / "lib" / "a.rap").write_text(DECLARATIONS)
    for part in range(4):
        numbers = range(part * 3 + 1, part * 3 + 4)
        forms = [DEFINITION.format(n=n, other=n // 2) for n in numbers]
        head = '(require "a")\n' if part else ""
        (tmp_path / "lib" / f"p{part}.rap").write_text(head + "".join(forms))
    (tmp_path / "one.test.rap").write_text(TEST.format(3, "depot"))
    (tmp_path / "two.test.rap").write_text(TEST.format(5, "home"))
    return tmp_path


def _check(
    units: Units | None = None,
    rules: frozenset[str] | None = None,
    file: Path | None = None,
) -> CheckReport:
    selection = Selection(rules or by_default())
    where = file or Path("kept", "x.checked")
    cache = Cache(where, PATHS, selection, units or Units())
    return check_files(PATHS, selection, cache=cache)


def _told(report: CheckReport) -> object:
    texts = {name: source.text for name, source in report.files.items()}
    return report.findings, texts, list(texts), report.raps


def _plain() -> object:
    return _told(check_files(PATHS))


# --- the same findings ----------------------------------------------------------------


def test_what_is_kept_is_found_again_and_nothing_is_parsed(project: Path) -> None:
    (project / "lib" / "p1.rap").write_text("(define-rap (x) (succeed (gone)))\n")
    made = _check()
    assert made.findings
    assert _told(_check(NoUnits())) == _told(made) == _plain()


@pytest.mark.parametrize("edits", first(1, [20, 200]), ids="{} edits".format)
def test_findings_are_the_same_after_any_edit(edits: int, project: Path) -> None:
    dice = random.Random(edits)
    units, different = Units(), set()
    for _ in range(edits):
        _edit(dice, project)
        report = _check(units)
        assert _told(report) == _plain()
        if not any(f.rule is UNRESOLVED for f in report.findings):
            assert _told(_check(NoUnits())) == _told(report)
        different.add(len(report.findings))
    assert len(different) > edits / 20  # the edits do change what is found


def _edit(dice: random.Random, project: Path) -> None:
    """Change a file, make one, or take one away; what is required has to stay."""
    files = sorted(project.glob("*.rap")) + sorted(project.glob("lib/p*.rap"))
    file = dice.choice([*files, project / "lib" / "a.rap"])
    lines = file.read_text().splitlines(keepends=True)
    at = dice.randrange(len(lines)) if lines else 0
    other = dice.choice(files)
    match dice.randrange(8):
        case 0 if other.parent.name == "lib" and len(files) > 5:
            other.unlink()
            return
        case 1:
            number = dice.randrange(30)
            text = DEFINITION.format(n=number, other=dice.randrange(30))
            (project / "lib" / f"p{dice.randrange(9)}.rap").write_text(text)
            return
        case 2:
            lines.insert(at, "; rapc: ignore[unknown-rap] an edit\n")
        case 3:
            lines.insert(at, dice.choice(other.read_text().splitlines(True) or [""]))
        case 4 if lines:
            del lines[at]
        case 5 if lines:
            lines[at] = lines[at].replace("location", "place", 1)
        case 6 if lines:
            lines[at] = lines[at].replace("thing", "thin", 1)
        case _:
            lines.insert(at, "\n")
    file.write_text("".join(lines))


def test_one_library_of_several_is_checked_again(project: Path) -> None:
    seen: list[str] = []

    class Seen(Units):
        def __call__(self, source: SourceFile) -> SourceUnit:
            seen.append(source.name)
            return super().__call__(source)

    _check()
    changed = project / "two.test.rap"
    changed.write_text(changed.read_text().replace("box", "bin"))
    assert _told(_check(Seen())) == _plain()
    assert "two.test.rap" in seen


def test_rules_that_are_chosen_make_another_cache(project: Path) -> None:
    (project / "lib" / "p1.rap").write_text("(define-rap (x) (succeed (gone)))\n")
    _check()
    chosen = rule_names(["undeclared-predicate"])
    few = _check(rules=chosen)
    assert {f.rule.name for f in few.findings} == set(chosen)
    assert _told(_check()) == _plain()


def test_what_depends_on_a_folder_is_not_kept(project: Path) -> None:
    (project / "lib" / "p1.rap").write_text('(require "nexts")\n')
    assert any("nexts" in f.diagnostic.message for f in _check().findings)
    (project / "lib" / "next.rap").write_text("")
    assert _told(_check()) == _plain()


# --- caches that are none -------------------------------------------------------------


def _flip(data: bytes) -> Iterator[bytes]:
    """Yield some bytes with damage here and there."""
    for at in range(0, len(data), max(1, len(data) // 4)):
        yield data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]
        yield data[:at]


def test_a_damaged_cache_is_as_if_there_were_none(project: Path) -> None:
    _check()
    file = project / "kept" / "x.checked"
    before = file.read_bytes()
    for data in (*_flip(before), b"", b"\0" * 100, before + b"x"):
        file.write_bytes(data)
        assert _told(_check()) == _plain()
        assert file.read_bytes() == before


def test_what_another_program_wrote_is_not_read(project: Path) -> None:
    _check()
    file = project / "kept" / "x.checked"
    for made in ({"a": 1}, ["owner", {}, {"x": 3}], ["owner"], "x"):
        payload = msgspec.msgpack.encode(made)
        file.write_bytes(keeping._checksum(payload) + payload)
        assert _told(_check()) == _plain()


@pytest.mark.parametrize("what", ["VERSION", "_stamps"])
def test_a_cache_of_another_rapc_is_not_read(
    what: str, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _check()
    new: str | Callable[[], object] = "0" if what == "VERSION" else list
    monkeypatch.setattr(keeping, what, new)
    with pytest.raises(AssertionError, match="is parsed"):
        _check(NoUnits())
    assert _told(_check()) == _plain()


def test_where_nothing_can_be_written_nothing_is_kept(project: Path) -> None:
    (project / "kept").write_text("a file, and no folder")
    assert _told(_check()) == _plain()
    (project / "folder").mkdir()
    (project / "folder" / "x.checked").mkdir()
    assert _told(_check(file=project / "folder" / "x.checked")) == _plain()


def test_the_oldest_caches_are_taken_away(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping, "MOST_FILES", 3)
    folder = project / "kept"
    for number in range(6):
        _check(file=folder / f"{number}.checked")
    left = sorted(path.name for path in folder.iterdir())
    assert left == [".gitignore", "3.checked", "4.checked", "5.checked"]
    assert (folder / ".gitignore").read_text() == "*\n"
