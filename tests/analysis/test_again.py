"""After a change what is found is found by looking at a part of the library alone."""

from __future__ import annotations

import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from bench.parse import DECLARATIONS, DEFINITION
from rapc.analysis import cache as keeping
from rapc.analysis.again import Again, check_again
from rapc.analysis.cache import Cache
from rapc.analysis.check_files import check_files
from rapc.analysis.driver import CheckReport
from rapc.analysis.selection import Selection, by_default, errors, rule_names
from rapc.base.source import SourceFile
from rapc.library.units import Units
from rapc.parser.unit import SourceUnit
from tests.analysis.libraries import Maker, edited


class Seen(Units):
    """Units that know which files were parsed."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []

    def __call__(self, source: SourceFile) -> SourceUnit:
        self.names.append(source.name)
        return super().__call__(source)


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """For each library with another state than before: whether a part was enough."""
    found: list[bool] = []

    def noted(*given: Any) -> Again | None:
        made = check_again(*given)
        found.append(made is not None)
        return made

    monkeypatch.setattr(keeping, "check_again", noted)
    return found


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for a library, in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lib").mkdir()
    return tmp_path / "lib"


def _write(folder: Path, texts: Mapping[str, str]) -> None:
    for file in folder.iterdir():
        if file.name not in texts:
            file.unlink()
    for name, text in texts.items():
        (folder / name).write_text(text)


def _kept(units: Units | None = None, rules: frozenset[str] | None = None) -> object:
    selection = Selection(rules or by_default())
    cache = Cache(Path("kept", "x.checked"), ("lib",), selection, units or Units())
    return _told(check_files(("lib",), selection, cache=cache))


def _plain(rules: frozenset[str] | None = None) -> object:
    return _told(check_files(("lib",), Selection(rules or by_default())))


def _told(report: CheckReport) -> object:
    texts = [(name, source.text) for name, source in report.files.items()]
    return report.findings, texts, dict(report.raps_in)


# --- the same findings ----------------------------------------------------------------

SIZES = [
    (20, 6),
    *[
        pytest.param(raps, edits, marks=pytest.mark.slow)
        for raps, edits in ((30, 200), (60, 80), (120, 40))
    ],
]


@pytest.mark.parametrize(("raps", "edits"), SIZES)
def test_a_part_tells_what_the_whole_does(
    raps: int, edits: int, here: Path, parts: list[bool]
) -> None:
    dice = random.Random(raps * edits)
    maker, units = Maker(dice, raps), Units()
    first = texts = maker.files(5)
    for _ in range(edits):
        _write(here, texts)
        assert _kept(units) == _plain()
        texts = first if dice.random() < 0.1 else edited(dice, maker, texts)
    assert sum(parts) > edits / 5  # a part often is enough


LIBRARY = {
    "a.rap": DECLARATIONS,
    **{
        f"p{part}.rap": "".join(
            DEFINITION.format(n=n, other=n // 2)
            for n in range(part * 6 + 1, part * 6 + 7)
        )
        for part in range(6)
    },
}

EDITS = {
    "a number in a context": ("p4.rap", "(> ?size 26)", "(> ?size 99)", ["p4.rap"]),
    "another step": ("p4.rap", "(pickup-14 ", "(pickup-3 ", ["p4.rap"]),
    "a method more": (
        "p1.rap",
        "  (method m8",
        "  (method again (primitive (arm-grasp ?arm ?thing)))\n  (method m8",
        ["p1.rap"],
    ),
    "an unbound variable": (
        "p2.rap",
        "(go-to ?place) ((at ?place) for t2)",
        "(go-to ?spot) ((at ?place) for t2)",
        ["p2.rap"],
    ),
    "an unknown name": ("p4.rap", "(pickup-14 ", "(pickup-400 ", ["p4.rap"]),
    "an argument more": ("p4.rap", "(pickup-14 ", "(pickup-14 box ", ["p4.rap"]),
    "another goal": ("p0.rap", "(arm-holding ?arm ?thing)", "(at ?arm)", ["p0.rap"]),
    "a parenthesis": ("p4.rap", "(task-net", "task-net", ["p4.rap"]),
    "a parenthesis of a form": ("p4.rap", "(define-rap", "define-rap", ["p4.rap"]),
    "a word that is no clause": ("p4.rap", "(succeed", "(suceed", ["p4.rap"]),
    "a comment": ("p3.rap", ";;; Number 20", ";;; No. 20", ["p3.rap"]),
}


@pytest.mark.parametrize("edit", EDITS)
def test_of_a_small_change_one_file_is_read_anew(
    edit: str, here: Path, parts: list[bool]
) -> None:
    name, before, after, read = EDITS[edit]
    _write(here, LIBRARY)
    _kept()
    assert before in LIBRARY[name]
    _write(here, {**LIBRARY, name: LIBRARY[name].replace(before, after, 1)})
    seen = Seen()
    assert _kept(seen) == _plain()
    assert parts == [True]
    assert sorted(set(seen.names)) == [f"lib/{file}" for file in read]


AGENDA = """\
(define-agenda day
  (task (pickup-2 left box) :priority 2 :background true)
  (task (pickup-3 left box) :priority 4))
"""
TASKS = {
    "a priority": (":priority 4", ":priority 1"),
    "another task": ("(pickup-3 ", "(pickup-30 "),
    "a task that is not there": ("(pickup-3 ", "(pickup-3000 "),
    "a task with an argument more": ("(pickup-3 ", "(pickup-3 box "),
    "a parenthesis": ("(task (pickup-3", "(task pickup-3"),
    "no agenda": (AGENDA, ""),
}


@pytest.mark.parametrize("edit", TASKS)
def test_of_an_agenda_one_file_is_read_anew(
    edit: str, here: Path, parts: list[bool]
) -> None:
    before, after = TASKS[edit]
    assert before in AGENDA
    _write(here, {**LIBRARY, "z.rap": AGENDA})
    _kept()
    _write(here, {**LIBRARY, "z.rap": AGENDA.replace(before, after)})
    seen = Seen()
    assert _kept(seen) == _plain()
    assert parts == [True]
    assert {*seen.names} == {"lib/z.rap"}


def test_two_agendas_of_one_name_are_told(here: Path, parts: list[bool]) -> None:
    _write(here, {**LIBRARY, "y.rap": AGENDA, "z.rap": AGENDA.replace("day", "night")})
    _kept()
    _write(here, {**LIBRARY, "y.rap": AGENDA, "z.rap": AGENDA})
    assert "`day` is defined already" in str(_kept())
    assert _kept() == _plain()
    assert parts == [False]


def test_errors_alone_are_found_again_too(here: Path, parts: list[bool]) -> None:
    rules = errors().enabled
    _write(here, LIBRARY)
    _kept(rules=rules)
    text = LIBRARY["p4.rap"].replace("(go-to ?place)", "(go-to ?spot)", 1)
    _write(here, {**LIBRARY, "p4.rap": text})
    assert "`?spot` is not bound" in str(_kept(rules=rules))
    assert _kept(rules=rules) == _plain(rules)
    assert parts == [True]


def test_files_may_come_and_go(here: Path, parts: list[bool]) -> None:
    _write(here, LIBRARY)
    _kept()
    more = DEFINITION.format(n=99, other=5) + DEFINITION.format(n=98, other=99)
    _write(here, {**LIBRARY, "p31.rap": more})
    assert _kept() == _plain()
    _write(here, LIBRARY)
    assert _kept() == _plain()
    assert parts == [True, True]


def test_findings_move_with_their_forms(here: Path, parts: list[bool]) -> None:
    text = LIBRARY["p2.rap"].replace("(t1 (go-to ?place)", "(t1 (go-to ?spot)", 1)
    _write(here, {**LIBRARY, "p2.rap": text})
    before = _kept()
    _write(here, {**LIBRARY, "p2.rap": f"; a comment\n\n{text}"})
    assert _kept() == _plain() != before
    assert parts == [True]


def test_suppressions_hold_for_what_is_kept(here: Path, parts: list[bool]) -> None:
    text = LIBRARY["p2.rap"].replace("(t1 (go-to ?place)", "(t1 (go-to ?spot)", 1)
    wrong = {**LIBRARY, "p2.rap": text}
    _write(here, wrong)
    _kept()
    ignored = "; rapc: file-ignore[unbound-variable] so it is\n"
    _write(here, {**wrong, "p2.rap": ignored + text})
    assert _kept() == _plain()
    _write(here, {**LIBRARY, "p2.rap": ignored + LIBRARY["p2.rap"]})
    assert _kept() == _plain()
    assert parts == [True, True]


STATES = """\
(declare-memory-property door-state (?door ?state) unknown)
(declare-primitive push (?door) (okay))
"""
ASKING = """\
(define-rap ({} ?door)
  (preconditions (not (door-state ?door {})))
  (method (primitive (push ?door))))
"""


def _asking(**states: str) -> dict[str, str]:
    raps = [ASKING.format(name, state) for name, state in states.items()]
    return {"a.rap": STATES, "b.rap": "".join(raps)}


def test_a_constant_may_go_from_one_rap_to_another(
    here: Path, parts: list[bool]
) -> None:
    _write(here, _asking(a="shut", b="jammed", c="shut", d="jammed", e="jamed"))
    before = _kept()
    _write(here, _asking(a="jammed", b="jammed", c="shut", d="shut", e="jamed"))
    assert _kept() == _plain() != before  # the first of these constants is another
    assert parts == [True]


MANY = " ".join(["(+ 1 1)"] * 70)
BOXES = f"""\
(declare-memory-proposition inside (?thing ?box))
(declare-primitive open ({" ".join(f"?n{at}" for at in range(70))} ?box) (okay))
(declare-primitive lift (?thing) (okay))
(define-rap (unpack ?thing)
  (method (context (inside ?thing ?box)) (primitive (open {MANY} ?box))))
(define-rap (take ?thing)
  (preconditions (inside ?thing ?))
  (method (primitive (lift ?thing))))
(define-rap (free ?thing)
  (method (context (inside ?thing ?box)) (primitive (open {MANY} ?box))))
"""
SWAPPED = f"""\
(define-rap (empty-out ?box)
  (method one
    (context (inside ?box ?thing))
    (task-net (t1 (take ?thing))))
  (method shake (primitive (open {MANY} ?box))))
"""


def test_an_argument_behind_many_others_is_compared_too(
    here: Path, parts: list[bool]
) -> None:
    """Only the last argument of `open` tells what the second of `inside` is."""
    _write(here, {"a.rap": BOXES, "b.rap": SWAPPED})
    before = _kept()
    assert "swapped-arguments" in str(before)
    shut = BOXES.replace(f"{MANY} ?box", f"{MANY} 1")
    _write(here, {"a.rap": shut, "b.rap": SWAPPED})
    assert _kept() == _plain() != before
    assert parts == [True]


KINDS = """\
(declare-kind door (front back))
(declare-kind room)
(declare-memory-proposition at ((?room room)))
(declare-memory-proposition shut ((?door door)))
(declare-primitive push ((?door door)) (okay))
(define-rap (leave ?door) (method (primitive (push ?door))))
(define-rap (out) (method (task-net (t1 (leave hall)))))
(define-rap (away) (method (task-net (t1 (leave hall)))))
(define-rap (home) (succeed (at hall)) (method (primitive (push front))))
"""


def test_what_kind_others_take_is_known_of_all(here: Path, parts: list[bool]) -> None:
    """That `hall` is a door is told by `leave`, to which `home` does not lead."""
    _write(here, {"a.rap": KINDS})
    assert "`hall` is a door" in str(_kept())
    _write(here, {"a.rap": KINDS.replace("(at hall)", "(at  hall)")})
    assert _kept() == _plain()
    assert parts == [True]


def test_what_kind_others_take_may_be_another(here: Path, parts: list[bool]) -> None:
    _write(here, {"a.rap": KINDS})
    before = _kept()
    leaving = "(define-rap (leave ?door) (method (primitive (push ?))))"
    whole = "(define-rap (leave ?door) (method (primitive (push ?door))))"
    _write(here, {"a.rap": KINDS.replace(whole, leaving)})
    assert _kept() == _plain() != before
    assert parts == [False]


# --- where a part is not enough -------------------------------------------------------

WHOLE = {
    "a declaration": ("a.rap", "(?place) (okay road-closed)", "(?place) (okay)"),
    "forms in another order": (
        "p4.rap",
        LIBRARY["p4.rap"],
        "".join(DEFINITION.format(n=n, other=n // 2) for n in range(30, 24, -1)),
    ),
    "a set": ("p4.rap", "(method m26", "(resources (set ?s))\n  (method m26"),
}


@pytest.mark.parametrize("edit", WHOLE)
def test_the_whole_is_checked_where_more_has_changed(
    edit: str, here: Path, parts: list[bool]
) -> None:
    name, before, after = WHOLE[edit]
    _write(here, LIBRARY)
    _kept()
    changed = {**LIBRARY, name: LIBRARY[name].replace(before, after, 1)}
    assert changed != LIBRARY
    _write(here, changed)
    assert _kept() == _plain()
    assert parts == [False]
    _write(here, LIBRARY)
    assert _kept() == _plain()  # from what was known before


def test_a_rap_that_is_edited_and_put_first_is_in_another_order(
    here: Path, parts: list[bool]
) -> None:
    _write(here, _asking(b="jammed", d="jammed", e="jamed"))
    _kept()
    turned = _asking(d="jammed", b="jammed", e="jamed")
    turned["b.rap"] = turned["b.rap"].replace("(d ?door)", "(d  ?door)")
    _write(here, turned)
    assert _kept() == _plain()
    assert parts == [False]


def test_rules_about_everybody_need_everybody(here: Path, parts: list[bool]) -> None:
    rules = frozenset((*by_default(), *rule_names(["unused-declaration"])))
    _write(here, LIBRARY)
    _kept(rules=rules)
    lost = LIBRARY["a.rap"] + "(declare-memory-proposition lost ())"
    _write(here, {**LIBRARY, "a.rap": lost})
    assert _kept(rules=rules) == _plain(rules)
    assert parts == [False]
