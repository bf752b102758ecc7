"""`rap.lark` and the front end are one language, but for the attributes listed.

`python -m tests.parser.agreement 5000` holds more programs against both.
"""

from __future__ import annotations

import random
import re

import pytest

from rapc.language import build, grammar
from rapc.language.shapes import Production
from rapc.parser.syntax import Datum, List
from tests.effort import first
from tests.parser.agreement import ATTRIBUTES, accepted, disagreement, excused
from tests.parser.programs import texts
from tests.parser.reading import parsed, reading


def test_grammar_py_is_what_build_makes() -> None:
    """`python -m rapc.language.build` writes it anew."""
    assert build.module() == (build.FOLDER / "grammar.py").read_text(encoding="utf-8")
    assert build.grammar() == grammar.GRAMMAR


def test_lines_above_rules_have_known_keys() -> None:
    text = build.SOURCE.read_text(encoding="utf-8")
    keys = {found[1] for found in re.finditer(r"^//: (\w+): ", text, re.M)}
    assert keys <= {*Production.__struct_fields__, "page"}
    assert not keys & {"shape", "says", "pages"}


def test_words_of_rules_stand_in_the_grammar_alone() -> None:
    takes = {row.takes for row in grammar.GRAMMAR.values() if len(row.takes) > 20}
    said = {row.wrong for row in grammar.GRAMMAR.values() if row.wrong}
    parser = build.FOLDER.parent / "parser"
    for file in (*parser.glob("*.py"), *parser.glob("special/*.py")):
        text = file.read_text(encoding="utf-8")
        assert [words for words in takes | said if words in text] == [], file


@pytest.mark.parametrize("batch", first(1, range(6)))
def test_forms_with_a_part_left_out_or_put_elsewhere(batch: int) -> None:
    """Some are sound and most are not: both say which."""
    rng = random.Random(f"mutants:{batch}")
    forms = _sound_forms()
    sound = 0
    for _ in range(100):
        text = _mutant(rng, rng.choice(forms))
        assert disagreement(text) == set(), text
        sound += accepted(text)
    assert 15 < sound < 85


def _sound_forms() -> list[str]:
    found: set[str] = set()
    for text in texts().values():
        if not parsed(text).diagnostics:
            data = [top.datum for top in reading(text).forms]
            found.update(text[datum.start : datum.end] for datum in data)
    return sorted(found)


def _mutant(rng: random.Random, text: str) -> str:
    (top,) = reading(text).forms
    parts = list(_parts(top.datum))[1:]
    here, other = rng.choice(parts), rng.choice(parts)
    what = rng.choice(["drop", "double", "replace"])
    if what == "drop":
        return text[: here.start] + text[here.end :]
    put = here if what == "double" else other
    kept = here.end if what == "double" else here.start
    return f"{text[:kept]} {text[put.start : put.end]}{text[here.end :]}"


def _parts(datum: Datum) -> list[Datum]:
    inner = datum.items if isinstance(datum, List) else ()
    return [datum, *(part for item in inner for part in _parts(item))]


EXAMPLES = {
    "depth": f"(define-rap (a) (succeed {'(not ' * 100}t{')' * 100}))",
    "length": f"(define-rap ({'a' * 1001}))",
    "looks like a number": "(define-rap (a) (succeed (p 1e3)))",
    "clause twice": "(define-rap (a) (duration 1) (duration 2))",
    "variable twice": "(define-rap (a ?x ?x))",
    "method twice": "(define-rap (a) (method m (task-net)) (method m (task-net)))",
    "defaults twice": "(define-test-defaults) (define-test-defaults)",
    "too many parts": f"(define-rap (a) (succeed (or{' (p)' * 201})))",
    "true or false": "(define-rap (a) (succeed (know-sensor-name ?x maybe)))",
    "reserved word": "(define-rap (a) (succeed (p (and))))",
}


@pytest.mark.parametrize("attribute", EXAMPLES)
def test_what_the_front_end_alone_refuses(attribute: str) -> None:
    text = EXAMPLES[attribute]
    assert accepted(text)
    assert {excused(found) for found in parsed(text).diagnostics} == {attribute}


def test_every_such_attribute_has_an_example() -> None:
    assert list(EXAMPLES) == list(ATTRIBUTES)


def test_what_the_grammar_alone_refuses() -> None:
    """The parts of a declaration behind its name come in any order."""
    text = '(declare-memory-function f "doc" :reads (p) (?x))'
    assert not accepted(text)
    assert parsed(text).diagnostics == ()


@pytest.mark.parametrize("word", ["false", "t", "otherwise", "for", "okay"])
def test_words_of_the_language_are_terms(word: str) -> None:
    for asked in (f"(believe (p) {word})", f"(p {word})", f"(and (p) (= {word} 1))"):
        program = f"(define-rap (a) (succeed {asked}))"
        assert accepted(program)
        assert parsed(program).diagnostics == ()


@pytest.mark.parametrize(
    "program",
    [
        "(define-rap (go) (method (task-net (=> (go)))))",
        "(define-rap (go) (method => (task-net)))",
        "(define-rap (go) (method (task-net (t1 (go) (for =>)))))",
        "(define-query (=>) (p))",
        "(define-agenda => (task (go)))",
        "(declare-memory-proposition => (?x))",
        "(define-test => (task (go)) (expect (succeeds (go))))",
        "(define-test done (task (go =>)) (expect (succeeds (go))))",
        "(define-test done (task (go)) (expect (succeeds (go =>))))",
    ],
)
def test_the_arrow_names_nothing(program: str) -> None:
    assert not accepted(program)
    assert parsed(program).diagnostics


@pytest.mark.parametrize("text", ["(p => x)", "(=> x)"])
def test_the_arrow_is_no_value_and_no_name(text: str) -> None:
    program = f"(define-rap (a) (succeed {text}))"
    assert not accepted(program)
    assert len(parsed(program).diagnostics) == 1
