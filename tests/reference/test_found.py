"""What the comparison has found: one small program for each fault it showed in rapc.

Each gives the events that docs/language asks for, of the kinds that matter; both
interpreters must make them.
"""

from __future__ import annotations

from rapc.runtime.settings import Settings
from rapc.worlds.script import At, Row
from tests.reference.play import FIND, SUB, USE, play

# --- what is told -----------------------------------------------------------------


def test_results_of_a_run_name_outputs_by_value() -> None:
    text = "(define-rap (find ?x => ?place) (succeed (p ?x ?place)))"
    (ended,) = play(text, "(find a)", only="run-ended", facts=("(p a c)",))
    assert "'goal': '(find a => c)'" in ended


def test_a_deadline_is_told_once_however_often_a_delay_is_set_anew() -> None:
    text = """
    (define-rap (tick) (monitor-time now 2 50) (succeed (q a))
      (method (primitive (rest))))
    """
    rows = (Row(("rest",), times=2), Row(("rest",), asserts=(("q", "a"),)))
    told = play(text, "(tick) :deadline 1", only="deadline-missed", rows=rows)
    assert told == ["2 missed 1 1"]


def test_an_absolute_deadline_is_told_once() -> None:
    text = """
    (define-rap (tick) (monitor-time absolute 2 4) (succeed (q a))
      (method (primitive (rest))))
    """
    rows = (Row(("rest",), takes=3),)
    told = play(text, "(tick)", only="deadline-missed", rows=rows)
    assert told == ["5 missed 1 4"]


def test_a_deadline_passed_in_a_primitive_is_told_though_the_next_one_is_set() -> None:
    text = "(define-rap (tick) (monitor-time now 2 4) (method (primitive (rest))))"
    told = play(
        text,
        "(tick)",
        only="method-ended deadline-missed",
        rows=(Row(("rest",), takes=5),),
    )
    assert told == ["7 ended 1 #1 okay", "7 missed 1 4"]


def test_a_wait_shows_what_is_bound_of_its_signal() -> None:
    text = "(define-rap (top ?i) (method (task-net (t1 (sub) (wait-for (:go ?i))))))"
    told = play(text + SUB, "(top a)", only="task-blocked")
    assert told == ["0 blocked 2 (:go a)"]


def test_whole_times_stay_whole_when_cycles_cost_time() -> None:
    told = play(
        "(define-rap (top) (method (task-net (t1 (sub)))))" + SUB,
        "(top)",
        only="task-selected",
        settings=Settings(cycle_cost=0.5),
    )
    assert [line.split()[0] for line in told] == ["0", "0.5", "1", "1.5"]


# --- faults -----------------------------------------------------------------------


def test_a_fault_of_repeat_while_is_its_own_and_no_context_is_asked() -> None:
    text = """
    (define-rap (tick) (repeat-while (< ?u 3))
      (method (context (< ?v 3)) (primitive (rest))))
    """
    (told,) = play(text, "(tick)", only="query-faulted")
    assert "repeat-while" in told
    assert told.endswith("?u is not bound")


def test_each_clause_names_its_variable_or_value_once() -> None:
    text = """
    (define-rap (tick ?i)
      (duration (+ ?i 1))
      (resources (counter ?c ?i) (set ?s ?i) (counter ?d ?u))
      (monitor-time now ?i 3)
      (method (task-net)))
    """
    told = play(text, "(tick a)", only="query-faulted task-failed")
    assert [line.rpartition(": ")[2] for line in told] == [
        "`a` is not a counter",
        "`a` is not a set",
        "?u is not bound",
        "`a` is not a number",
        "`a` is not a number",
        "0 failed 1 (tick a) interference interference",
    ]


def test_notations_requests_and_effects_say_what_was_unbound_or_unfit() -> None:
    text = """
    (define-rap (tick)
      (resources (set ?s))
      (method one (notations (q ?u)) (task-net))
      (method 2 (primitive (act ?s)))
      (method (task-net (t1 (sub) (set-add ?s ?v)))))
    """
    told = play(
        text + SUB,
        "(tick)",
        only="query-faulted",
        settings=Settings(futile_limit=1),
    )
    assert [line.rpartition(": ")[2] for line in told] == [
        "?u is not bound",
        "`#set()` is not a symbol, number or string",
        "?v is not bound",
    ]


def test_an_ill_typed_input_is_told_when_the_step_fails_not_when_it_is_made() -> None:
    text = """
    (define-rap (top ?i) (succeed (last-result interference))
      (method (task-net (t1 (use (+ ?i 1))))))
    """
    told = play(text + USE, "(top a)", only="method-chosen query-faulted task-failed")
    assert [line.split()[1] for line in told] == ["chosen", "faulted", "failed"]
    assert told[-1] == "0 failed 2 (use (+ a 1)) interference interference"


def test_a_string_in_a_fault_is_written_as_a_string() -> None:
    text = "(define-rap (top ?i) (succeed (= (+ ?i 1) 2)))"
    (told,) = play(text, '(top "a")', only="query-faulted")
    assert told.endswith('`"a"` is not a number')


# --- when things are read -----------------------------------------------------------


def test_a_computed_input_is_read_when_the_order_lets_the_step_run() -> None:
    text = """
    (define-rap (top) (resources (counter ?c 1))
      (method (task-net (t1 (sub) (counter-add ?c 4) (for t2)) (t2 (use (value ?c))))))
    """
    told = play(text + SUB + USE, "(top)", only="task-created primitive-requested")
    assert told[-2:] == [
        "0 created 3 (use 1) 1 1 0 t2",
        "0 requested 3 (act 5) (act 5)",
    ]


def test_a_computed_input_unbound_when_made_is_read_again_at_selection() -> None:
    text = """
    (define-rap (top) (method (task-net
      (t1 (fill)) (t2 -1 (use (+ (look-up a) 1))))))
    (define-rap (fill) (method (primitive (rest))))
    """
    rows = (Row(("rest",), asserts=(("p", "a", 3),)),)
    told = play(text + USE, "(top)", only="task-selected", rows=rows)
    assert told[3] == "0 selected 3 (use 4)"


def test_a_new_step_is_told_as_its_inputs_are_once_notations_stand() -> None:
    text = """
    (define-rap (top) (method (notations (p a 3)) (task-net (t1 (use (look-up a))))))
    """
    told = play(text + USE, "(top)", only="task-created")
    assert told[1] == "0 created 2 (use 3) 1 1 0 t1"


def test_a_duration_that_uses_no_unbound_input_counts_at_once() -> None:
    """Latest starts are 10 and 15, so the step without its input goes first."""
    text = """
    (define-rap (top) (method (task-net
      (t1 (long ?u) (window now 0 20)) (t2 (sub) (window now 0 15)))))
    (define-rap (long ?i) (duration 10) (method (primitive (act ?i))))
    """
    told = play(text + SUB, "(top)", only="task-selected")
    assert told[1] == "0 selected 2 (long ?u)"


def test_a_duration_bound_late_changes_the_order_of_an_eligible_step() -> None:
    text = """
    (define-rap (top) (method (task-net
      (t1 1 (find => ?u))
      (t2 (long ?u) (window now 0 20))
      (t3 (sub) (window now 0 15)))))
    (define-rap (long ?i) (duration ?i) (method (primitive (act ?i))))
    """
    told = play(text + SUB + FIND, "(top)", only="task-selected", facts=("(p a 10)",))
    assert told[2] == "0 selected 3 (long 10)"


def test_resources_that_use_no_unbound_input_are_made_at_once() -> None:
    text = """
    (define-rap (top) (method (task-net (t1 (long ?u)))))
    (define-rap (long ?i) (resources (counter ?c (look-up a))))
    """
    told = play(text, "(top)", only="query-faulted task-selected")
    assert [line.split()[1] for line in told[:3]] == ["selected", "faulted", "selected"]


def test_a_window_may_use_what_an_earlier_step_binds() -> None:
    text = """
    (define-rap (top) (method (task-net
      (t1 (find => ?u) (for t2)) (t2 (sub) (window now ?u 15)))))
    """
    told = play(
        text + SUB + FIND,
        "(top)",
        only="task-selected query-faulted",
        facts=("(p a 6)",),
    )
    assert told[2] == "6 selected 3 (sub)"


# --- monitors and times -------------------------------------------------------------


def test_a_monitor_bound_late_is_tested_before_its_step_can_be_selected() -> None:
    text = """
    (define-rap (top) (method (task-net (t1 (find => ?u)) (t2 -1 (mon ?u)))))
    (define-rap (mon ?i) (monitor-state (q ?i)) (method (task-net)))
    """
    told = play(
        text + FIND,
        "(top)",
        only="task-selected task-blocked task-woken",
        facts=("(p a c)",),
        at=(At(6, asserts=(("q", "c"),)),),
    )
    assert told[2:5] == [
        "0 blocked 3 (q c)",
        "6 woken 3 (q c)",
        "6 selected 3 (mon c)",
    ]


def test_until_start_waits_for_a_first_selection_with_the_monitors_holding() -> None:
    """t2 is first selected to get its input, and is blocked there."""
    text = """
    (define-rap (top) (method (task-net
      (t1 (mon c) (until-start t2))
      (t2 (mon ?u))
      (t3 (sub) ((p a ?u) for t2)))))
    (define-rap (mon ?i) (monitor-state (q ?i)) (method (task-net)))
    """
    told = play(
        text + SUB,
        "(top)",
        only="task-blocked task-removed task-woken",
        facts=("(p a d)",),
        at=(At(6, asserts=(("q", "d"),)),),
    )
    assert told == [
        "0 blocked 2 (q c)",
        "0 blocked 3 (q d)",
        "6 woken 3 (q d)",
        "6 removed 2 until",
    ]


def test_all_untils_of_a_step_come_before_what_follows_is_let_go() -> None:
    """t2 leaves before it can begin to listen, though t1 before it has ended."""
    text = """
    (define-rap (top) (method (task-net
      (t1 (mon) (for t2) (until-end t3))
      (t2 (sub) (until-end t3) (wait-for (:stop)))
      (t3 (sub)))))
    (define-rap (mon) (monitor-state (q a)) (method (task-net)))
    """
    told = play(text + SUB, "(top)", only="task-blocked task-removed")
    assert told == ["0 blocked 2 (q a)", "0 removed 2 until", "0 removed 3 until"]


def test_a_monitor_waits_for_its_time_alone_before_that_has_come() -> None:
    """The clock does not stop at 3, where the belief goes stale: nobody waits for it.

    The deadline is told at the next time at which something happens.
    """
    text = """
    (define-rap (mon) (monitor-time now 9 20) (monitor-state (not (believe (q a) 3)))
      (method (task-net)))
    (define-rap (top) (method (primitive (slow a))))
    """
    told = play(
        text,
        "(mon)",
        "(top) :deadline 1",
        only="deadline-missed task-woken",
        facts=("(q a)",),
        rows=(Row(("slow", "?"), after=12),),
    )
    assert told == ["9 woken 1 time 9", "9 missed 2 1"]


def test_a_belief_nobody_waits_for_any_more_does_not_keep_a_run_going() -> None:
    text = """
    (define-rap (mon) (monitor-state (believe (q a) 4)) (succeed nil)
      (method (primitive (act a))))
    """
    rows = (Row(("act", "?"), takes=1, erases=(("q",),)),)
    told = play(text, "(mon)", only="run-ended", facts=("(q a)",), rows=rows)
    assert told[0].startswith("1 ended stuck")


def test_top_level_tasks_count_in_the_recursion_test() -> None:
    text = "(define-rap (again ?i) (method (task-net (t1 (again ?i)))))"
    told = play(text, "(again a)", only="task-created task-failed")
    assert told == [
        "0 created 1 (again a) None 1 0 None",
        "0 failed 1 (again a) futile-loop futile-loop",
    ]


def test_an_input_that_has_lost_its_value_when_the_step_may_run_fails_it() -> None:
    """It is 9 + 1 when the step is made; at 5, when it is read again, it is nothing."""
    text = """
    (define-rap (top) (method (task-net (t1 (use (+ (look-up a) 1)) (window now 5 9)))))
    (define-rap (use ?i) (method (primitive (act c))))
    """
    told = play(
        text,
        "(top)",
        only="query-faulted task-failed",
        facts=("(p a 9)",),
        at=(At(2, asserts=(("p", "a", "a"),)),),
        settings=Settings(futile_limit=1),
    )
    assert told[0].startswith("5 faulted 1 step `t1` at lib.rap:")
    assert told[1] == "5 failed 2 (use (+ (look-up a) 1)) interference interference"


def test_windows_of_a_step_that_may_run_are_read_in_the_order_of_the_text() -> None:
    text = """
    (define-rap (top ?i) (method (task-net (t1 (sub)) (t2 (sub) {}))))
    (define-rap (sub) (method (primitive (act c))))
    """
    at_once = "(window now 4 ?w) (window now 2 (* 1 ?i))"
    after_a_step = "(window t1 4 ?w) (window t1 2 (* 1 ?i))"
    for windows in (at_once, after_a_step):
        told = play(text.format(windows), "(top d)", only="query-faulted")
        assert [line.rpartition(": ")[2] for line in told[:2]] == [
            "?w is not bound",
            "`d` is not a number",
        ]
