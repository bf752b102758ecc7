"""Names that seem to be slips are put right by fixes that have to be asked for."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from rapc.analysis.driver import CheckReport, check_library
from rapc.analysis.fixes import mend
from rapc.library.loader import load_text

FACTS = """\
(declare-kind door (red blue))
(declare-memory-property open ((?door door) ?is) unknown)
(declare-memory-proposition locked (?what))
(declare-primitive push (?door) (okay stuck))
(declare-event :creaking ())
(declare-memory-function reach (?door))
(define-rap (wait))
"""

SLIPS = {
    "a RAP": ("(define-rap (go) (method (task-net (t1 (wiat)))))", "wiat", "wait"),
    "a fact": ("(define-rap (go) (succeed (lokced home)))", "lokced", "locked"),
    "a primitive": ("(define-rap (go) (method (primitive (psuh a))))", "psuh", "push"),
    "a function": (
        "(define-rap (go ?d) (succeed (> (raech ?d) 3)))",
        "raech",
        "reach",
    ),
    "an event": (
        "(define-rap (go)\n (method (task-net (t1 (wait) (wait-for (:creakign))))))",
        ":creakign",
        ":creaking",
    ),
    "a result": (
        "(define-rap (go)\n  (method (context (not (last-result stukc)))"
        " (primitive (push a))))",
        "stukc",
        "stuck",
    ),
    "a kind": ("(define-rap (go (?d dor)) (succeed (open ?d ?)))", "dor", "door"),
    "a value": ("(define-rap (go) (succeed (open blu true)))", "blu", "blue"),
    "a tag": (
        "(define-rap (go)\n  (method (task-net (first (wait) (for secnd)) "
        "(second (wait)))))",
        "secnd",
        "second",
    ),
    "a method": (
        "(define-rap (go) (method pushing (context (not (method-tried pusing)))\n"
        "  (primitive (push a))))",
        "pusing",
        "pushing",
    ),
    "a variable": (
        "(define-rap (go ?where)\n  (succeed (locked ?where))\n"
        "  (method (primitive (push ?wehre))))",
        "?wehre",
        "?where",
    ),
    "a resource": (
        "(define-rap (go)\n  (resources (counter ?count))\n  (succeed (> (value ?count)"
        " 3))\n  (method (task-net (t1 (wait) (counter-add ?coutn 1)))))",
        "?coutn",
        "?count",
    ),
    "an output": (
        "(define-rap (go => ?place)\n  (succeed (locked ?plase))\n"
        "  (method (primitive (push a))))",
        "?plase",
        "?place",
    ),
    "an event of a trace": (
        "(define-test t (task (wait)) (expect (trace (task-lots :goal (wait)))))",
        "task-lots",
        "task-lost",
    ),
}
"""Forms with a slip, where it is and what was meant."""


def _mended(text: str, *, unsafe: bool) -> tuple[str, CheckReport]:
    def check(texts: Mapping[str, str]) -> CheckReport:
        return check_library(load_text(texts.get("<text>", text)))

    mended = mend(check, lambda _: True, unsafe=unsafe)
    return mended.texts.get("<text>", text), mended.report


@pytest.mark.parametrize("what", [w for w in SLIPS if w != "an event of a trace"])
def test_the_name_that_is_meant_is_written(what: str) -> None:
    form, slip, meant = SLIPS[what]
    text = f"; before {slip}\n{FACTS}; {slip} here\n{form} ; behind {slip}\n"
    mended, _ = _mended(text, unsafe=True)
    assert mended == text.replace(form, form.replace(slip, meant))


def test_all_uses_of_a_name_are_put_right_at_once() -> None:
    text = f"{FACTS}(define-rap (go)\n  (succeed (lokced a))\n"
    text += "  (preconditions (and (lokced b) (lokced c) (LOKCED d)))\n"
    text += "  (method (primitive (push a))))\n"
    mended, _ = _mended(text, unsafe=True)
    assert mended == text.replace("lokced", "locked").replace("LOKCED", "locked")


def test_nothing_of_it_is_safe() -> None:
    for form, _, _ in SLIPS.values():
        text = f"{FACTS}{form}\n"
        assert _mended(text, unsafe=False)[0] == text


def test_where_the_name_stands_twice_nobody_guesses() -> None:
    text = "(declare-sensor-datum seen (?x))\n"
    text += "(declare-primitive look () (okay) :tells (sene sene))\n"
    assert _mended(text, unsafe=True)[0] == text


COMMON_ENDS = {
    "a primitive as a step": (
        "(define-rap (pickup ?thing)\n"
        "  (method (task-net (t1 (arm-pickup arm1 ?thing)))))\n"
    ),
    "a RAP like its caller": (
        "(define-rap (handle-enemy-troops ?place)\n"
        "  (method (task-net (t1 (shoot-enemy-troops ?place)))))\n"
    ),
}


@pytest.mark.parametrize("text", COMMON_ENDS.values(), ids=COMMON_ENDS)
def test_a_rap_with_a_common_end_is_not_offered_as_its_own_step(text: str) -> None:
    mended, report = _mended(text, unsafe=True)
    found = [f.diagnostic for f in report.findings if f.rule.name == "unknown-rap"]
    assert [(f.help, f.fix) for f in found] == [
        ("define it, or `require` its file", None)
    ]
    assert mended == text


def test_a_rap_is_offered_as_its_own_step_where_one_letter_is_wrong() -> None:
    text = "(define-rap (walk ?there)\n  (succeed nil)\n"
    text += "  (method (task-net (t1 (wolk ?there)))))\n"
    _, report = _mended(text, unsafe=False)
    found = [f.diagnostic for f in report.findings if f.rule.name == "unknown-rap"]
    assert [f.help for f in found] == ["did you mean `walk`?"]
    assert found[0].fix is not None


NO_FIX = {
    "other arguments": "(define-rap (go) (method (task-net (t1 (wiat a)))))",
    "other arguments of a fact": "(define-rap (go) (succeed (lokced a b)))",
    "other outputs": "(define-rap (go) (method (task-net (t1 (wiat => ?x)))))",
    "other arguments in one place": (
        "(define-rap (go) (succeed (or (lokced a) (lokced a b))))"
    ),
    "a common end": "(define-rap (go) (succeed (unlocked a)))",
}


@pytest.mark.parametrize("form", NO_FIX.values(), ids=NO_FIX)
def test_a_name_that_cannot_be_written_there_is_a_question_alone(form: str) -> None:
    _, report = _mended(f"{FACTS}{form}\n", unsafe=False)
    rules = ("unknown-rap", "undeclared-predicate")
    found = [f.diagnostic for f in report.findings if f.rule.name in rules]
    assert [f.help.startswith("did you mean") for f in found] == [True]
    assert found[0].fix is None
