"""The ten questions that were really asked while a run was debugged by hand.

Each is answered by one command; the faults are planted in a small ward or in the truck.
"""

from __future__ import annotations

import pytest

import rapc
from rapc.debug.answer import Answer, say, table
from rapc.debug.history import History
from rapc.repl.commands.table import commands
from rapc.repl.draw import draw
from rapc.repl.shell import Shell
from tests.debug.sessions import row, scripted
from tests.repl.shells import rows, said, truck_shell

WARD = """
(declare-primitive drive (?place) (okay blocked) :uses (wheels))
(declare-primitive ride (?level) (okay) :uses (wheels))
(declare-primitive charge () (okay) :uses (plug))
(declare-memory-proposition robot-at (?place))
(declare-memory-proposition medicine (?box ?kind))
(declare-memory-proposition lies-at (?box ?place))
(declare-memory-proposition ward (?place ?what))
(declare-memory-proposition lost)
(define-rap (order ?kind)
  (succeed (lost))
  (method fetch
    (context (and (medicine ?box ?kind) (lies-at ?box ?place) (ward ?place ?what)))
    (task-net (t1 (go-to ?place))))
  (method search
    (task-net (t1 (look-for ?kind)) (t2 (look-for ?kind)))))
(define-rap (look-for ?kind)
  (method here (primitive (drive shelf)))
  (method there (primitive (drive tray))))
(define-rap (go-to ?place)
  (succeed (robot-at ?place))
  (method from-ward
    (context (and (robot-at ?here) (n= ?here ?place)))
    (task-net (t1 (wait-here)))))
(define-rap (wait-here)
  (succeed (lost))
  (monitor-state (lost))
  (method (primitive (charge))))
(define-rap (lift) (method (claims wheels) (task-net (t1 (wait-here)))))
(define-rap (move) (method (primitive (drive hall))))
"""


def _ward(*tasks: str) -> Shell:
    session = scripted(
        WARD,
        *tasks,
        rows=(
            row("(drive shelf)", "blocked", takes=2),
            row("(drive tray)", "blocked", takes=3),
            row("(drive ?x)", takes=4),
            row("(charge)", takes=9),
        ),
    )
    shell = Shell(session, commands())
    for fact in (
        "(robot-at icu)",
        "(medicine item-11 aspirin)",
        "(lies-at item-11 tray)",
        "(medicine item-12 aspirin)",
        "(lies-at item-12 tray)",
    ):
        shell.answer(f":assert {fact}")
    return shell


def _said(shell: Shell, *inputs: str) -> str:
    return said(shell, ":show none", *inputs, width=160)


def test_1_why_failed_down_to_the_first_cause() -> None:
    shell = _ward("(order aspirin)")
    text = _said(shell, ":run", ":why failed 1")
    assert text.startswith("[1] (order aspirin) failed in cycle ")
    assert "method `search` of `order` at small.rap:" in text
    assert "primitive of `look-for` at small.rap:" in text
    assert "the world answered `blocked`" in text


def test_2_why_not_this_method() -> None:
    shell = _ward("(order aspirin)")
    text = _said(shell, ":why-not 1 fetch")
    assert "  (medicine ?box ?kind): 2" in text
    assert "  (lies-at ?box ?place): 2" in text
    assert "> (ward ?place ?what): 0" in text
    assert "?place tray" in text
    other = _said(shell, ":why-not 1")
    assert ": (ward ?place ?what) fails, conjunct 3 of 3" in other
    assert "  method fetch at small.rap:" in other
    assert "method search: no context" in other


def test_3_holders_of_a_thing() -> None:
    shell = _ward("(lift)", "(move)")
    shell.answer(":step 6")
    assert shell.history.over
    shell.answer(":back")
    [held] = rows(shell, ":claims")
    assert held[:2] == ("wheels", 1)
    assert held[4] == "[2]"


def test_4_why_it_is_not_running_and_why_another_ran() -> None:
    shell = _ward("(lift)", "(move) :priority 0")
    shell.answer(":step 6")
    shell.answer(":back")
    assert "waiting for wheels, held by (lift) [1]" in _said(shell, ":why-not 2")
    assert "[1] was selected in cycle " in _said(shell, ":why 1")


def test_5_chain_up_to_the_top() -> None:
    shell = _ward("(order aspirin)")
    shell.answer(":step 2")
    found = rows(shell, ":chain 2")
    assert [row[1] for row in found] == ["(look-for aspirin)", "(order aspirin)"]


def test_6_commitments_of_a_choice_and_stale_facts() -> None:
    shell = _ward("(go-to lab)")
    shell.answer(":step")
    shell.answer(":erase (robot-at icu)")
    shell.answer(":assert (robot-at radiology)")
    text = _said(shell, ":when chosen 1")
    assert "[1] (go-to lab) chose from-ward with" in text
    assert "?here icu" in text
    assert "because of (robot-at icu): no longer in memory" in text
    assert "choice now: from-ward with ?here radiology" in text


def test_7_history_of_an_item() -> None:
    shell = truck_shell()
    shell.answer(":to 110")
    found = rows(shell, ":history item-1 location")
    assert [row[3] for row in found if row[2] == "+"] == [
        "(location item-1 quarry-1)",
        "(location item-1 arm1)",
        "(location item-1 bay2)",
    ]
    assert found[1][4] == "(arm-grasp arm1 item-1) [56]"


def test_8_timeline_of_a_run() -> None:
    shell = _ward("(order aspirin)")
    text = _said(shell, ":run", ":timeline")
    assert "(drive shelf)" in text
    assert "family [1]: " in text
    assert "100 %" in text


def test_8_timeline_of_skills_and_signals() -> None:
    library = rapc.load("stdlib/hallway")
    session = History.open(library, "hallway", agenda="errand")
    shell = Shell(session, commands())
    shell.answer(":to at 12")
    found = rows(shell, ":timeline")
    assert str(found[0][4]).startswith("(:report-position)")
    assert found[0][5] == ":position 12 times"
    assert "(:door-closed)" in [row[5] for row in found]
    assert found[-1][4] == "(:move-thru-doorway -1.565 0.3)"


def test_8_skills_and_their_signals_have_task_and_line() -> None:
    library = rapc.load("stdlib/hallway")
    session = History.open(library, "hallway", agenda="errand")
    shell = Shell(session, commands())
    shell.answer(":to at 14.5")
    found = rows(shell, ":skills")
    assert [one[4] for one in found if one[1] == 1] == ["stdlib/hallway/travel.rap:55"]
    *_, change = rows(shell, ":history (orientation robot)")
    assert str(change[4]).startswith("rule for (:position ")
    assert str(change[4]).endswith(
        ") of (:report-position) at stdlib/hallway/travel.rap:55 [1]"
    )
    use, *_ = rows(shell, ":who (orientation robot)")
    assert use[3] == change[4]


def test_8_times_are_told_without_the_dust_of_subtraction() -> None:
    shell = truck_shell("(rock-order red 1) :deadline 100")
    shell.answer(":run")
    [found] = rows(shell, ":deadlines")
    assert found[2:] == (100, "missed", 274.77, 174.77)
    assert 274.77 - 100 != 174.77


def test_9_retries() -> None:
    shell = _ward("(order aspirin)")
    shell.answer(":run")
    [found] = rows(shell, ":retries")
    assert found[0] == "(look-for aspirin)"
    assert isinstance(found[1], int)
    assert found[1] >= 2


@pytest.mark.parametrize(
    "text",
    [
        ":deadlines",
        ":to 5",
        ":step",
        ":back 2",
        "(and (medicine ?box ?kind) (lies-at ?box ?place))",
        ":assert (lost)",
        ":what-if (assert (ward tray east)) 2",
        ":diff 0 2",
    ],
)
def test_10_each_of_the_other_questions_has_an_answer(text: str) -> None:
    shell = _ward("(order aspirin) :deadline 1")
    shell.answer(":step 4")
    answer = shell.answer(text)
    assert not answer.failed, answer.lines
    assert draw(answer, 80, color=False)


def test_10_what_if_shows_the_choice() -> None:
    shell = _ward("(order aspirin)")
    text = _said(shell, ":what-if (assert (ward tray east))")
    assert "actual:" in text
    assert "method search of order" in text.partition("with the change:")[0]
    assert "method fetch of order" in text.partition("with the change:")[2]


def test_long_numbers_are_rounded_for_people_but_not_in_code() -> None:
    noisy = "(turn-to -0.29200000000000004)"
    shown = draw(table(("what",), [(noisy,)], noisy), 80, color=False)
    assert shown.count("(turn-to -0.292)") == 2
    version = "x1.00000000001 1.2.00000000003"
    assert draw(say(version), 80, color=False) == f"{version}\n"
    code = Answer((noisy,), is_code=True)
    assert draw(code, 80, color=False) == f"{noisy}\n"
