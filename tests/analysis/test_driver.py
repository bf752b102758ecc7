"""The driver: order and validation of passes, what becomes of findings."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path

import pytest

import rapc
from rapc.analysis import checks, registry
from rapc.analysis.check import Fact, Pass
from rapc.analysis.driver import check_libraries, check_library
from rapc.analysis.selection import Selection, errors
from rapc.base.diagnostics import Severity
from rapc.library.loader import load, load_text

ROOT = Path(__file__).parents[2]


def _found(text: str) -> list[str]:
    return [f.rule.name for f in check_library(load_text(text)).findings]


@pytest.mark.parametrize("library", ["stdlib/hallway", "examples/courier"])
def test_facts_of_a_check_are_in_no_cycle(library: str) -> None:
    """The language server rarely collects cycles."""
    runs: list[weakref.ref[Pass]] = []
    gc.disable()
    try:
        loaded = load([str(ROOT / library)])
        check_libraries([loaded], None, None, lambda run: runs.append(weakref.ref(run)))
        assert runs
        assert not any(run() for run in runs)
    finally:
        gc.enable()


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
    every = check_library(loaded, Selection(frozenset(registry.rules()))).findings
    grave = [one for one in every if one.severity is Severity.ERROR]
    assert list(check_library(loaded, errors()).findings) == grave


def test_modules_imported_for_a_run_find_errors() -> None:
    every = registry.rules().values()
    names = {r.name for r in every if r.severity is Severity.ERROR and not r.opt_in}
    assert registry.errors() == names
    for module in {one.find.__module__ for one in registry.checks(errors_only=True)}:
        own = [one for one in registry.checks() if one.find.__module__ == module]
        owned = {rule.name for one in own for rule in one.rules}
        assert not owned.isdisjoint(names)


def test_each_module_of_checks_is_registered() -> None:
    folder = Path(checks.__file__).parent
    registered = {one.find.__module__.rpartition(".")[2] for one in registry.checks()}
    facts = {"__init__", "bindings"}
    assert registered == {path.stem for path in folder.glob("*.py")} - facts


def test_a_rule_belongs_to_one_check_which_yields_no_other() -> None:
    every = [rule.name for one in registry.checks() for rule in one.rules]
    assert len(every) == len(set(every))


def test_errors_are_silenced_beside_rules_that_are_not_known_then() -> None:
    text = (
        "; rapc: ignore[singleton-variable, unknown-rap] later\n(define-rap (a ?x) {})"
    )
    loaded = load_text(text.format("(method (task-net (t1 (gone))))"))
    assert not check_library(loaded, errors()).findings


def test_a_check_runs_if_one_of_its_rules_is_enabled() -> None:
    wanted = registry.checks_for({"age-in-monitor"})
    assert [one.name for one in wanted] == ["age_in_monitor"]
    assert registry.checks_for(registry.rules()) == list(registry.checks())


def test_a_fact_is_computed_once_however_many_checks_ask_for_it() -> None:
    computed: list[str] = []
    fact: Fact[None] = Fact(lambda run: computed.append("once"))
    run = Pass(load_text("").library)
    for _ in range(2):
        run.result(fact)
    assert computed == ["once"]


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


def test_equal_findings_are_reported_once() -> None:
    """Both tests require the file of the defaults."""
    text = '(define-test-defaults (require "apart")) (define-test a) (define-test b)'
    assert _found(text) == ["unresolved-require"]
