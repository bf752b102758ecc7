"""The numbered sentences of docs/language and their tests.

Each sentence has a test of its number: a test of tests/rap, run here under several
seeds; or rules of the checker, whose examples are checked here; or tests in Python.
The RAP on the pages is quoted from the files of tests/rap.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from rapc.analysis.driver import check_library
from rapc.analysis.registry import rules
from rapc.console.testing.explain import failure_lines
from rapc.library.loader import load_text
from rapc.testing.discover import find
from rapc.testing.run import Status, run_case

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
RULES = {
    "2.30": ("implied-true",),
    "2.49": ("unbound-variable", "not-a-number"),
    "2.69": ("builtin-name",),
    "2.78": ("builtin-name",),
    "5.17": ("age-in-monitor",),
    "7.9": ("query-in-a-circle",),
    "7.16": ("misplaced-otherwise",),
    "7.22": ("unknown-kind",),
    "7.23": ("wrong-kind",),
    "7.24": ("kinds-apart",),
    "7.26": ("unknown-agenda",),
    "7.27": ("unknown-result",),
    "7.28": ("not-a-fact",),
    "7.29": ("duplicate-definition",),
    "7.30": ("undeclared-function", "wrong-fact-arity"),
    "7.32": ("wrong-kind",),
    "7.36": ("priority-out-of-band",),
    "7.47": ("unknown-rap",),
    "7.48": ("duplicate-method",),
}
"""The sentences about rules of the checker, whose examples are their tests."""

IN_PYTHON: Mapping[str, Mapping[str, Sequence[str]]] = {
    "runtime/test_long_questions.py": {
        "2.70": ("test_query_over_the_step_limit_is_aborted",),
        "2.71": ("test_which_parts_search",),
        "2.72": ("test_which_variables_have_a_value",),
        "2.73": ("test_steps_back_are_counted_from_the_third_part_on",),
        "2.74": ("test_preceding_parts_of_a_part",),
        "2.75": ("test_query_counts_as_its_formula",),
        "2.76": ("test_each_shape_of_question_is_bounded",),
        "2.77": ("test_each_question_has_all_its_steps",),
    },
    "runtime/test_resources.py": {
        "6.28": ("test_task_over_the_limit_gets_no_resources",),
        "6.29": ("test_task_without_its_resources_fails_when_selected",),
    },
    "runtime/test_causes.py": {
        "3.75": ("test_each_way_to_fail_is_told",),
        "3.76": ("test_the_task_given_has_the_chain_down_to_it",),
        "3.77": ("test_finding_it_out_changes_nothing",),
    },
    "planning/test_runs.py": {
        "10.13": ("test_two_runs_and_a_replay_make_the_same_plans",),
    },
    "worlds/test_broken_worlds.py": {
        "3.78": ("test_a_handler_may_give_another_result",),
    },
    "runtime/test_clock.py": {
        "4.48": (
            "test_waits_in_a_row_are_bounded",
            "test_a_cycle_starts_the_count_of_waits_anew",
            "test_waits_of_a_monitor_for_its_own_times_are_bounded",
        ),
        "9.40": ("test_run_waits_for_a_world_without_next_time",),
        "9.41": ("test_patience_begins_anew_with_each_message",),
        "9.42": ("test_after_patience_has_ended_nothing_is_coming",),
        "9.43": ("test_known_time_comes_before_the_end_of_patience",),
        "9.44": ("test_clock_going_back_is_a_fault_of_the_world",),
    },
    "runtime/test_strict.py": {
        "7.37": ("test_handler_violating_its_effects_ends_the_run",),
        "7.38": ("test_possible_effect_need_not_happen",),
        "7.39": ("test_undeclared_result_is_not_checked",),
        "7.40": ("test_items_stand_as_class_and_location",),
        "7.41": ("test_the_handler_of_a_datum_is_held_too",),
        "7.42": ("test_only_declared_data_come_with_a_primitive",),
    },
    "runtime/test_changes.py": {
        "7.49": (
            "test_a_result_without_handler_has_its_declared_effects",
            "test_a_datum_with_possible_effects_requires_a_handler",
        ),
    },
}
"""The sentences with tests in Python, by file."""

INDEX = DOCS / "language" / "index.md"
PAGES = tuple(
    sorted(
        (DOCS / "language").glob("[0-9]*.md"),
        key=lambda page: int(page.name.partition("-")[0]),
    )
)
FILES = tuple(sorted(HERE.glob("*.test.rap")))
SEEDS = range(3)

_NUMBER = re.compile(r'<a id="([\d.]+)"></a>\*\*([\d.]+)\*\*')
_LINK = re.compile(r"\]\(([^)#]*)(?:#([^)]*))?\)")
_RAP = re.compile(r"^```rap\n(.*?)^```$", re.M | re.S)


def text(page: Path) -> str:
    """A page or a file of tests as it stands."""
    return page.read_text(encoding="utf-8")


def sentences(page: Path) -> list[str]:
    """Return the numbers of a page's sentences, in the order of the page."""
    found = _NUMBER.findall(text(page))
    assert all(anchor == number for anchor, number in found)
    return [number for _, number in found]


def numbered_tests() -> list[tuple[str, str]]:
    """Return the numbers and names of the tests of this folder that have numbers."""
    names = [c.test.name for file in FILES for c in find([file]).cases]
    found = [re.match(r"s(\d+)-(\d+)-", name) for name in names]
    return [(f"{m[1]}.{m[2]}", m.string) for m in found if m]


def _page(page: Path) -> str:
    return page.name


@pytest.fixture(params=PAGES, ids=_page)
def page(request: pytest.FixtureRequest) -> Path:
    """Each page in turn."""
    assert isinstance(request.param, Path)
    return request.param


# --- sentences and tests ------------------------------------------------------------


def test_sentences_have_all_numbers_from_1(page: Path) -> None:
    chapter = page.name.partition("-")[0]
    numbers = sorted(int(n.removeprefix(f"{chapter}.")) for n in sentences(page))
    assert numbers == list(range(1, len(numbers) + 1))


def test_chapters_from_2_on_are_made_of_sentences() -> None:
    chapters = [int(page.name.partition("-")[0]) for page in PAGES]
    assert chapters == list(range(1, 11))
    counts = [len(sentences(page)) for page in PAGES]
    assert counts[0] == 0
    assert all(count >= 13 for count in counts[1:])


def test_each_sentence_has_a_test_and_each_test_a_sentence() -> None:
    in_rap = {number for number, _ in numbered_tests()}
    in_python = {number for tests in IN_PYTHON.values() for number in tests}
    assert in_rap | in_python | {*RULES} == {n for p in PAGES for n in sentences(p)}
    assert not in_rap & (in_python | {*RULES})
    assert not in_python & {*RULES}


def test_pages_name_no_tests(page: Path) -> None:
    assert re.findall(r"`(?:s\d+-\d+-|test_)[^`]*`", text(page)) == []


@pytest.mark.parametrize("file", IN_PYTHON)
def test_each_test_in_python_exists(file: str) -> None:
    defined = set(re.findall(r"^def (test_\w+)", text(HERE.parent / file), re.M))
    assert {name for names in IN_PYTHON[file].values() for name in names} <= defined


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


@pytest.mark.parametrize("number", RULES)
def test_rules_find_what_their_sentences_state(number: str) -> None:
    known = rules()
    for name in RULES[number]:
        report = check_library(load_text(known[name].page.example))
        assert [finding.rule.name for finding in report.findings] == [name]


# --- pages --------------------------------------------------------------------------


def test_what_a_page_shows_stands_in_a_file_of_tests(page: Path) -> None:
    files = "\n".join(text(file) for file in sorted(HERE.glob("*.rap")))
    shown = _RAP.findall(text(page))
    assert shown
    for block in shown:
        assert f"\n{block}" in files, block


def test_blocks_of_a_page_are_rap(page: Path) -> None:
    opened = re.findall(r"^```([a-z].*)$", text(page), re.M)
    assert {*opened} == {"rap"}


def test_the_index_lists_all_pages() -> None:
    listed = [page.name for page in PAGES]
    linked = dict.fromkeys(t for t, _ in _LINK.findall(text(INDEX)) if t in listed)
    assert [*linked] == listed
