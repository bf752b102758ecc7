"""Values about RAPs that are kept from check to check, `rapc.analysis.rap_cache`."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from random import Random

import msgspec
import pytest

from rapc.analysis import checks
from rapc.analysis.check import Pass, RapFact
from rapc.analysis.driver import Finding, check_libraries
from rapc.analysis.facts.effects import reached
from rapc.analysis.rap_cache import RapCache
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.loader import Loaded, Units, load, load_text
from tests.damage import slipped, sound_texts

ROOT = Path(__file__).parents[2]
SHIPPED = ("examples/courier", "examples/cookbook", "stdlib/truck")

FACTS = [
    one
    for module in iter_modules(checks.__path__)
    for one in vars(import_module(f"{checks.__name__}.{module.name}")).values()
    if isinstance(one, RapFact)
]


# --- what the values depend on --------------------------------------------------------


def narrowed(library: Library, rap: nodes.DefineRap) -> Library:
    """Return a library without the RAPs that the steps of a RAP do not reach."""
    raps = {**reached(library, [rap.name]), rap.name: rap}
    forms = [
        one
        for one in library.forms
        if not isinstance(one, nodes.DefineRap) or raps.get(one.name) is one
    ]
    return msgspec.structs.replace(library, raps=raps, forms=tuple(forms))


def differences(library: Library) -> Iterator[str]:
    """Yield the RAPs with a value that depends on RAPs beside or above."""
    run = Pass(library)
    for rap in library.raps.values():
        alone = Pass(narrowed(library, rap))
        for at, fact in enumerate(FACTS):
            if run.of(fact, rap) != alone.of(fact, rap):
                yield f"value {at} of {rap.name}"


def test_values_depend_only_on_what_a_rap_reaches() -> None:
    assert len(FACTS) > 4
    libraries = [load([ROOT / name]).library for name in SHIPPED]
    libraries += [load_text(text).library for text in sound_texts()[::6]]
    assert [one for each in libraries for one in differences(each)] == []


# --- edits ----------------------------------------------------------------------------


class Files:
    """Files that are edited, checked with what was kept from earlier checks."""

    def __init__(self, paths: Sequence[str]) -> None:
        self.paths = paths
        self.texts = {path: Path(path).read_text(encoding="utf-8") for path in paths}
        self.units = Units()
        self.cache = RapCache()
        self.loaded = self.load()

    def load(self) -> Loaded:
        self.loaded = load(self.paths, texts=self.texts, parser=self.units)
        return self.loaded

    def findings(self) -> Sequence[Finding]:
        return check_libraries([self.load()], cache=self.cache).findings

    def fresh(self) -> Sequence[Finding]:
        return check_libraries([load(self.paths, texts=self.texts)]).findings

    def values(self) -> Mapping[str, object]:
        """Return the values about each RAP; each kept one is the same object."""
        library = self.load().library
        kept = self.cache.values(library, True, lambda span: False)
        return {name: kept[id(rap)] for name, rap in library.raps.items()}


@pytest.fixture
def files(tmp_path: Path) -> Files:
    (tmp_path / "world.rap").write_text("(declare-primitive act () (okay))\n")
    rows = [
        f"(define-rap ({one}) (method (task-net (s ({two})))))"
        for one, two in (("a", "b"), ("b", "c"), ("d", "c"), ("e", "e"))
    ]
    rows.append("(define-rap (c) (method (primitive (act))))")
    for name, row in zip("abdec", rows, strict=True):
        (tmp_path / f"{name}.rap").write_text(row + "\n")
    return Files([str(path) for path in sorted(tmp_path.glob("*.rap"))])


def changed(files: Files, name: str, old: str, new: str) -> str:
    """Return the RAPs whose values are dropped after an edit of a file."""
    before = files.values()
    (path,) = (one for one in files.paths if one.endswith(f"/{name}.rap"))
    assert old in files.texts[path]
    files.texts[path] = files.texts[path].replace(old, new)
    after = files.values()
    return "".join(n for n in sorted(after) if after[n] is not before.get(n))


def test_edit_of_a_rap_drops_its_values_and_those_above(files: Files) -> None:
    assert changed(files, "c", "(act)", "(wait)") == "abcd"
    assert changed(files, "b", "(s (c))", "(s (d))") == "ab"
    assert changed(files, "a", "(a)", "(f)") == "f"
    assert changed(files, "e", "(s (e))", "(s (d))") == "e"
    assert changed(files, "a", "(method", "(method (context true)") == "f"


def test_edit_of_a_declaration_drops_all_values(files: Files) -> None:
    assert changed(files, "world", "(okay)", "(okay lost)") == "abcde"
    assert changed(files, "world", "(dec", "\n(dec") == "abcde"
    assert changed(files, "world", "\n(dec", "\n(dec") == ""


def test_new_rap_drops_the_values_of_its_callers(files: Files) -> None:
    assert changed(files, "c", "(c)", "(z)") == "abdz"
    assert changed(files, "c", "(z)", "(c)") == "abcd"


def test_text_before_a_rap_moves_it(files: Files) -> None:
    assert changed(files, "b", "(define-rap", "; Go.\n(define-rap") == "ab"
    after = "\n; Go."
    assert changed(files, "b", ")))))", f"))))){after}") == ""


@pytest.mark.parametrize(
    "count",
    [
        10,
        pytest.param(60, marks=pytest.mark.slow),
        pytest.param(2000, marks=pytest.mark.nightly),
    ],
)
def test_findings_after_each_edit_are_those_of_a_fresh_check(
    tmp_path: Path, count: int
) -> None:
    dice = Random(count)
    shutil.copytree(ROOT / "examples" / "courier", tmp_path, dirs_exist_ok=True)
    files = Files([str(path) for path in sorted(tmp_path.glob("*.rap"))])
    sound = dict(files.texts)
    for _ in range(count):
        path = dice.choice(files.paths)
        if dice.random() < 0.3:
            files.texts[path] = sound[path]
        else:
            files.texts[path] = slipped(files.texts[path], dice)
        assert files.findings() == files.fresh()
