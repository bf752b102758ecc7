"""Where names stand: definitions, occurrences, renaming."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.analysis.facts.index import Index
from rapc.analysis.facts.usage import SPACES
from rapc.analysis.naming import Naming, NamingError
from rapc.base.diagnostics import edited
from rapc.ir import nodes
from rapc.library.loader import Units, alike, load, load_tests, load_text, read_tests
from rapc.worlds.source_names import names_in_code

ROOT = Path(__file__).parents[2]

HOUSE = """
(declare-kind room (hall den))
(declare-memory-property robot-at ((?where room)) unknown)
(declare-sensor-datum seen ((?where room)))
(declare-primitive drive ((?to room)) (okay stuck) :tells (seen)
  :on (okay (robot-at ?to)))
(declare-event :bump ())
(define-query (here ?where) (robot-at ?where))
(define-rap (go ?to)
  (succeed (robot-at ?to))
  (method straight
    (context (and (here ?from) (not (last-result stuck))))
    (task-net (t1 (leave ?from) (for t2)) (t2 (move ?to))))
  (method around
    (context (and (here ?from) (method-tried straight)))
    (task-net (t1 (leave ?from) (wait-for (:bump) :fail)))))
(define-rap (move ?to) (method straight (primitive (drive ?to))))
(define-rap (leave ?where) (method (task-net)))
(define-method go third (task-net (t1 (move ?to))))
(define-memory-rule (move ?to) :finish
  (match-result ((bump) (rule (t (mem-del (robot-at)))))))
(define-agenda day (task (go hall)))
(define-test robot-goes
  (agenda day)
  (script ((drive ?x) stuck :data ((seen ?x))))
  (expect (fails (go hall) stuck) (method go straight)
          (trace (method-chosen :rap go :method around)
                 (task-created :goal (move hall)))))
"""


def names(text: str) -> Naming:
    return Naming([load_text(text, "house.rap")])


def marked(text: str, word: str, count: int = 0) -> int:
    """Return the offset of an occurrence of a text."""
    at = -1
    for _ in range(count + 1):
        at = text.index(word, at + 1)
    return at


def renamed(text: str, word: str, new: str, inside: int = 1) -> str:
    """Return the text after a new name for the name at the first `word`."""
    naming = names(text)
    named = naming.at("house.rap", marked(text, word) + inside)
    assert named is not None
    return edited(text, naming.renamed(named, new))


@pytest.mark.parametrize(
    ("word", "new", "count"),
    [
        ("(go ?to)", "travel", 6),
        ("(move ?to)", "step-to", 5),
        ("straight\n", "direct", 3),
        ("around", "detour", 2),
        ("?from", "?start", 2),
        ("t1 (leave", "first", 1),
        ("stuck", "blocked", 4),
        ("seen", "sight", 3),
        ("room", "place", 4),
        ("day", "week", 2),
        (":bump", ":hit", 3),
        ("(here", "now-at", 3),
        ("robot-at", "robot-place", 5),
        ("(drive", "steer", 3),
    ],
)
def test_name_is_renamed_in_its_scope(word: str, new: str, count: int) -> None:
    after = renamed(HOUSE, word, new)
    assert after.count(new.removeprefix(":")) == count
    assert not load_text(after).diagnostics


def test_input_is_renamed_in_added_methods() -> None:
    after = renamed(HOUSE, "?to)\n  (succeed", "?goal")
    assert after.count("?goal") == 4
    assert "(define-method go third (task-net (t1 (move ?goal))))" in after


def test_event_without_colon_is_renamed_without_colon() -> None:
    assert "(match-result ((hit) " in renamed(HOUSE, ":bump", ":hit")


def test_definition_of_method_depends_on_the_rap() -> None:
    naming = names(HOUSE)
    named = naming.at("house.rap", marked(HOUSE, "(method go straight)") + 12)
    assert named is not None
    (defined,) = naming.definitions(named)
    assert defined.span.start == marked(HOUSE, "straight\n")


def test_names_of_a_damaged_form_are_found() -> None:
    text = (
        "(define-rap (go ?to)\n  (method (task-net (t1 (move ?to\n(define-rap (move))"
    )
    naming = names(text)
    found = [one.name for one in naming.names("house.rap")]
    assert found == ["go", "?to", "t1", "move", "?to", "move"]


@pytest.mark.parametrize(
    ("word", "new", "reason"),
    [
        ("(go ?to)", "move", "the name `move` is in use"),
        ("(go ?to)", "two words", "expected a symbol"),
        ("(go ?to)", "?x", "expected a symbol"),
        ("(go ?to)", "12", "expected a symbol"),
        ("(here", "and", "`and` is reserved"),
        ("?from", "?to", "the name `?to` is in use"),
        ("?to)\n  (succeed", "?from", "the name `?from` is in use"),
        ("t1 (leave", "t2", "the name `t2` is in use"),
        ("straight\n", "around", "the name `around` is in use"),
        ("okay", "fine", "`okay` is reserved"),
        (":bump", "hit", "begins with `:`"),
    ],
)
def test_renaming_is_refused(word: str, new: str, reason: str) -> None:
    with pytest.raises(NamingError) as raised:
        renamed(HOUSE, word, new)
    assert reason in str(raised.value)


def test_renaming_to_a_word_of_the_language_is_refused() -> None:
    text = "(define-rap (go) (method (task-net (t1 (go) (window t1 0 3)))))"
    with pytest.raises(NamingError, match="`now` has a meaning here"):
        renamed(text, "t1", "now")


def test_renaming_a_name_in_the_code_of_a_world_is_refused(tmp_path: Path) -> None:
    (tmp_path / "lab.py").write_text(
        '"""On the day."""\nX = "(drive ?x)"\ndef seen(): ...'
    )
    code = names_in_code(["lab:World"], tmp_path)
    assert set(code) == {"drive", "?x", "seen"}
    naming = Naming([load_text(HOUSE, "house.rap")])
    named = naming.at("house.rap", marked(HOUSE, "(drive") + 1)
    assert named is not None
    with pytest.raises(NamingError, match=r"cannot rename `drive`: `.*lab.py` uses it"):
        naming.renamed(named, "steer", code)


SHIPPED = [Path("stdlib/truck"), Path("stdlib/hallway"), Path("examples/courier")]


@pytest.mark.parametrize("folder", SHIPPED, ids=str)
def test_names_agree_with_the_nodes(folder: Path) -> None:
    units = Units()
    libraries = [load([folder], parser=units)]
    for group in alike(read_tests([folder]), units):
        libraries += load_tests(group, parser=units).libraries
    naming = Naming(libraries)
    found = {
        (one.span.file, one.span.start): one
        for loaded in libraries
        for file in loaded.files
        for one in naming.names(file)
    }
    for loaded in libraries:
        index = Index(loaded.library)
        for use in index.uses():
            place = use.place(loaded.files)
            if not isinstance(use.node, nodes.WaitFor | nodes.EventRule):
                one = found[place.file, place.start]
                assert (one.space, one.name) == (SPACES[use.use], use.name)
        for variable in index.of(nodes.Var):
            span = variable.node.span
            if not variable.node.anonymous:
                one = found[span.file, span.start]
                assert (one.space, one.name) == ("variable", variable.node.name)


def test_definitions_are_the_occurrences_that_define() -> None:
    loaded = load([ROOT / "examples" / "courier"])
    naming = Naming([loaded])
    names = [one for file in loaded.files for one in naming.names(file)]
    for named in {(one.space, one.name): one for one in names}.values():
        every = naming.occurrences(named)
        defining = tuple([one for one in every if one.defines])
        if named.space == "variable":
            defining = defining or every[:1]
        assert naming.definitions(named) == defining
        beside = tuple([one for one in every if one.span.file == named.span.file])
        assert naming.occurrences_beside(named) == beside
