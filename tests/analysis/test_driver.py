"""The driver: order and validation of passes, what becomes of findings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest

import rapc
from rapc.analysis import grave, suite
from rapc.analysis.analyzer import Analyzer, Pass, never
from rapc.analysis.driver import (
    Analysis,
    check_library,
    ordered,
    passes,
    reporting,
)
from rapc.analysis.selection import Selection, errors
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.source import NOWHERE
from rapc.library.loader import load, load_text
from rapc.library.signatures import Signatures

RULE = Rule("RAP900", "some-fault", Severity.ERROR, "s", "why", "example", "better")


def _nothing(run: Pass) -> None:
    assert run.library.raps == {}


def _pass(name: str, *needs: Analyzer[Any], rule: Rule | None = None) -> Analyzer[None]:
    return Analyzer(name, "A page.", _nothing, needs, (rule,) if rule else ())


def _run_of(analyzer: Analyzer[Any]) -> Pass:
    library = load_text("").library
    ask = Analysis(library, True, never, {}).result
    return Pass(analyzer, library, Signatures.of(library), ask, complete=True)


def test_passes_follow_what_they_need() -> None:
    first = _pass("z-first")
    second = _pass("m-second", first)
    third = _pass("a-third", second, first)
    assert ordered([third, second, first]) == (first, second, third)


def test_order_does_not_depend_on_the_list() -> None:
    assert ordered(suite.ANALYZERS[::-1]) == passes()


def test_undocumented_pass_is_refused() -> None:
    with pytest.raises(ValueError, match="pass `mute` is not documented"):
        ordered([Analyzer("mute", "", _nothing)])


def test_undocumented_rule_is_refused() -> None:
    rule = Rule("RAP900", "some-fault", Severity.ERROR, "s", "", "e", "b")
    with pytest.raises(ValueError, match="rule `some-fault` is not documented"):
        ordered([_pass("one", rule=rule)])


def test_rule_of_two_passes_is_refused() -> None:
    with pytest.raises(ValueError, match=r"`some-fault` .* exists already"):
        ordered([_pass("one", rule=RULE), _pass("two", rule=RULE)])


def test_two_passes_of_one_name_are_refused() -> None:
    with pytest.raises(ValueError, match="two passes have one name"):
        ordered([_pass("one"), _pass("one")])


def test_need_that_is_not_listed_is_refused() -> None:
    with pytest.raises(ValueError, match="needs `one`, not in the suite"):
        ordered([_pass("two", _pass("one"))])


def test_circle_of_needs_is_named() -> None:
    one = _pass("one")
    two = _pass("two", one)
    msgspec.structs.force_setattr(one, "needs", (two,))
    with pytest.raises(ValueError, match=r"in a circle: (one -> two|two -> one)"):
        ordered([one, two])


def test_pass_reports_its_own_rules_only() -> None:
    run = _run_of(_pass("one", rule=RULE))
    run.report(Diagnostic("some-fault", "message", NOWHERE))
    assert len(run.found) == 1
    with pytest.raises(ValueError, match="does not own rule `other-fault`"):
        run.report(Diagnostic("other-fault", "message", NOWHERE))


def test_pass_gets_results_of_its_needs_only() -> None:
    one = _pass("one")
    run = _run_of(_pass("two"))
    with pytest.raises(ValueError, match="does not need `one`"):
        run.result(one)


def _found(text: str) -> list[str]:
    return [f.rule.name for f in check_library(load_text(text)).findings]


def test_findings_come_in_the_order_of_the_text() -> None:
    text = "(define-rap (a) (succeed (b)) (method (task-net (t1 (c)))))"
    assert _found(text) == ["undeclared-predicate", "unknown-rap"]
    turned = "(define-rap (a) (method (task-net (t1 (c)))) (succeed (b)))"
    assert _found(turned) == ["unknown-rap", "undeclared-predicate"]


def test_nothing_is_missed_in_forms_that_were_not_read_whole() -> None:
    broken = "(define-rap (a) (contxt (x)) (method (task-net (t1 (b ?c)))))"
    assert _found(broken) == ["unknown-clause", "unknown-rap"]
    other = "(define-rap (d) (method (task-net (t1 (e ?f)))))"
    assert _found(f"{broken}\n{other}") == [
        "unknown-clause",
        "unknown-rap",
        "unknown-rap",
        "unbound-variable",
    ]


def test_suppressions_of_rules_that_do_not_run_are_not_called_unused() -> None:
    text = "; rapc: ignore[unknown-rap]\n(define-rap (a))"
    loaded = load_text(text)
    assert check_library(loaded).findings
    chosen = Selection(frozenset({"unused-suppression"}))
    assert not check_library(loaded, chosen).findings


PROGRAMS = sorted(Path(__file__).parent.glob("*.rap"))


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: str(path.stem))
def test_passes_that_find_no_errors_are_left_out_where_only_errors_count(
    path: Path,
) -> None:
    loaded = load([str(path)])
    every = check_library(loaded, Selection(frozenset(suite.rules()))).findings
    grave = [one for one in every if one.severity is Severity.ERROR]
    assert list(check_library(loaded, errors()).findings) == grave


def test_the_passes_for_errors_are_those_that_find_some_and_what_they_need() -> None:
    every = suite.rules().values()
    names = {r.name for r in every if r.severity is Severity.ERROR and not r.opt_in}
    assert grave.errors() == names
    wanted = [one for one in passes() if any(r.name in names for r in one.rules)]
    needed = dict.fromkeys(wanted)
    for one in wanted:  # it grows meanwhile, and so it ends with all that is needed
        wanted += [need for need in one.needs if need not in needed]
        needed |= dict.fromkeys(one.needs)
    assert set(grave.ANALYZERS) == set(needed)


def test_errors_are_silenced_beside_rules_that_are_not_known_then() -> None:
    text = (
        "; rapc: ignore[singleton-variable, unknown-rap] later\n(define-rap (a ?x) {})"
    )
    loaded = load_text(text.format("(method (task-net (t1 (gone))))"))
    assert not check_library(loaded, errors()).findings


def test_a_pass_runs_if_one_of_its_rules_is_enabled_or_its_result_is_asked_for() -> (
    None
):
    wanted = reporting({"age-in-monitor"})
    assert [one.name for one in wanted] == ["age-in-monitor"]
    analysis = Analysis(load_text("").library, True, never, {}).run(wanted)
    ran = [one.name for one in passes() if analysis.has_run(one)]
    assert ran == ["task-nets", "bindings", "age-in-monitor"]
    assert reporting(suite.rules()) == [one for one in passes() if one.rules]


def test_a_pass_runs_once_however_many_ask_for_it() -> None:
    runs: list[str] = []
    one = Analyzer("one", "A page.", lambda run: runs.append("one"))
    asking = [
        Analyzer(name, "A page.", lambda run: run.result(one), (one,)) for name in "ab"
    ]
    Analysis(load_text("").library, True, never, {}).run([*asking, one])
    assert runs == ["one"]


def test_report_knows_its_worst_and_its_size() -> None:
    assert check_library(load_text("")).worst() is None
    report = check_library(load_text("(define-rap (a) (succeed (b)))"))
    assert report.worst() is Severity.ERROR
    assert report.raps == 1
    assert list(report.files) == ["<text>"]


def test_checking_is_offered_to_programs(tmp_path: Path) -> None:
    path = tmp_path / "a.rap"
    path.write_text("(define-rap (a) (succeed (b)))")
    (finding,) = rapc.check(path).findings
    assert finding.rule.name == "undeclared-predicate"
    with pytest.raises(rapc.CheckError, match=r"a.rap:1:27: .*`b`"):
        rapc.load(path)


def test_a_rap_defined_twice_with_other_inputs_is_told_of_only() -> None:
    """What kinds the second has learned is more than the first has inputs."""
    assert _found(
        """
        (declare-kind door)
        (declare-primitive look ((?x door)) (okay))
        (define-rap (a ?x) (method (primitive (look ?x))))
        (define-rap (a ?x ?y) (method (task-net (t1 (b ?x ?y)))))
        (define-rap (b (?x door) (?y door)) (method (primitive (look ?y))))
        (define-rap (c ?z) (method (task-net (t1 (a ?z)))))
        """
    ) == ["duplicate-definition"]
