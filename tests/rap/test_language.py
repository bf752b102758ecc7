"""The pages of the language and the tests of tests/rap hold each other to account.

Sections from 2 on are numbered sentences. Each names a test, which runs here under
several seeds, or a rule of the checker, whose example runs here too; no test that is
named after a sentence is without one. Sentences on the handlers of worlds and on
questions that are given up name a test in Python. What the pages show in RAP stands in
a file of tests.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rapc.analysis.driver import check_library
from rapc.analysis.registry import rules
from rapc.console.testing.explain import failure_lines
from rapc.library.loader import load_text
from rapc.testing.discover import find
from rapc.testing.run import Status, run_case
from tests.cli.command import rapc

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
IN_PYTHON = (
    "runtime/test_strict.py",
    "runtime/test_long_questions.py",
    "runtime/test_causes.py",
    "runtime/test_clock.py",
    "worlds/test_broken_worlds.py",
)
INDEX = DOCS / "language.md"
PAGES = tuple(sorted((DOCS / "language").glob("*.md")))
FILES = tuple(sorted(HERE.glob("*.test.rap")))
SEEDS = range(3)

_SENTENCE = re.compile(r"^- \*\*(\d+)\.(\d+)\*\* (.*?)(?=^- |^$|\Z)", re.M | re.S)
_TEST = re.compile(r"`(s\d+-\d+-[a-z0-9-]+)`")
_IN_PYTHON = re.compile(r"`(test_[a-z_]+)`")
_RULE = re.compile(r"rule\s+\[`([a-z-]+)`\]\((?:\.\./)?rules\.md#\1\)")
_LINKED_RULE = re.compile(r"\[`([a-z-]+)`\]\(\.\./rules\.md#([a-z-]+)\)")
_LINK = re.compile(r"\]\(([^)#]*)(?:#([^)]*))?\)")
_RAP = re.compile(r"^```rap\n(.*?)^```$", re.M | re.S)
_TYPED = re.compile(
    r"^```rap (\S+)\n(.*?)^```\n\n```console\n\$ rapc (.*?)\n(.*?)^```$", re.M | re.S
)
_HEADING = re.compile(r"^#+ (.*)$", re.M)


def text(page: Path) -> str:
    """A page or a file of tests as it stands."""
    return page.read_text(encoding="utf-8")


def sentences(page: Path) -> list[tuple[int, int, str]]:
    """The numbered sentences of a page: both parts of the number, and the words."""
    found = _SENTENCE.findall(text(page))
    return [(int(section), int(number), words) for section, number, words in found]


def numbered_tests() -> list[str]:
    """The tests of this folder that are named after a sentence, in any order."""
    names = [c.test.name for file in FILES for c in find([file]).cases]
    return [name for name in names if _TEST.fullmatch(f"`{name}`")]


def _page(page: Path) -> str:
    return page.name


@pytest.fixture(params=PAGES, ids=_page)
def page(request: pytest.FixtureRequest) -> Path:
    """Each page in turn."""
    assert isinstance(request.param, Path)
    return request.param


# --- sentences and tests ------------------------------------------------------------


def test_sentences_are_numbered_in_a_row(page: Path) -> None:
    section = int(page.name.partition("-")[0])
    numbers = [(major, minor) for major, minor, _ in sentences(page)]
    assert numbers == [(section, n + 1) for n in range(len(numbers))]


def test_sections_from_2_on_are_made_of_sentences() -> None:
    assert [page.name[0] for page in PAGES] == list("123456789")
    counts = [len(sentences(page)) for page in PAGES]
    assert counts[0] == 0
    assert all(count >= 15 for count in counts[1:])


def test_each_sentence_names_a_test_of_its_number_or_a_rule(page: Path) -> None:
    for section, number, words in sentences(page):
        named = _TEST.findall(words)
        others = _RULE.findall(words) or _IN_PYTHON.findall(words)
        assert named or others, f"{section}.{number} names none"
        for name in named:
            assert name.startswith(f"s{section}-{number}-"), name


def test_each_named_test_is_there_and_each_numbered_test_is_named() -> None:
    named = [name for page in PAGES for name in _TEST.findall(text(page))]
    assert sorted(set(named)) == sorted(numbered_tests())
    assert len(set(named)) == len(named)


def test_each_test_in_python_is_there() -> None:
    files = [text(HERE.parent / name) for name in IN_PYTHON]
    there = set(re.findall(r"^def (test_\w+)", "\n".join(files), re.M))
    named = [name for page in PAGES for name in _IN_PYTHON.findall(text(page))]
    assert len(named) == 26
    assert set(named) <= there


@pytest.mark.parametrize("file", FILES, ids=_page)
def test_the_tests_pass_whatever_the_seed(file: Path) -> None:
    found = find([file])
    assert found.reports == ()
    assert found.cases
    for case in found.cases:
        for seed in SEEDS:
            outcome = run_case(case, seed, modules=["tests.rap.language_world"])
            assert outcome.status is Status.PASSED, "\n".join(
                line.text for line in failure_lines(outcome)
            )


def test_named_rules_find_what_their_pages_say() -> None:
    known = rules()
    for page in PAGES:
        for name in _RULE.findall(text(page)):
            report = check_library(load_text(known[name].example))
            assert [finding.rule.name for finding in report.findings] == [name]


# --- pages --------------------------------------------------------------------------


def test_what_a_page_shows_stands_in_a_file_of_tests(page: Path) -> None:
    files = "\n".join(text(file) for file in sorted(HERE.glob("*.rap")))
    shown = _RAP.findall(text(page))
    assert shown
    for block in shown:
        assert f"\n{block}" in files, block


def test_what_is_typed_on_a_page_prints_what_it_shows(
    page: Path, tmp_path: Path
) -> None:
    for name, program, command, printed in _TYPED.findall(text(page)):
        (tmp_path / name).write_text(program, encoding="utf-8")
        done = rapc(*command.split(), "--color", "never", cwd=tmp_path)
        assert done.stdout + done.stderr == printed


def test_every_block_of_a_page_is_tried(page: Path) -> None:
    blocks = re.findall(r"^```[a-z]", text(page), re.M)
    assert len(blocks) == len(_RAP.findall(text(page))) + 2 * len(
        _TYPED.findall(text(page))
    )


@pytest.mark.parametrize("page", [INDEX, *PAGES], ids=_page)
def test_links_lead_somewhere(page: Path) -> None:
    for name, anchor in _LINKED_RULE.findall(text(page)):
        assert name == anchor
        assert name in rules()
    for target, anchor in _LINK.findall(text(page)):
        file = (page.parent / target).resolve() if target else page
        assert file.is_file(), target
        assert not anchor or anchor in _anchors(file), f"{target}#{anchor}"


def _anchors(file: Path) -> set[str]:
    plain = (re.sub(r"[^\w\- ]", "", h.lower()) for h in _HEADING.findall(text(file)))
    return {heading.replace(" ", "-") for heading in plain}


def test_the_index_lists_all_pages() -> None:
    listed = [f"language/{page.name}" for page in PAGES]
    assert [t for t, _ in _LINK.findall(text(INDEX)) if t in listed] == listed
