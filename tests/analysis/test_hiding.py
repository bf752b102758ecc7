"""One slip, one finding: the table of findings that hide others."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

from rapc import analysis
from rapc.analysis.driver import check_library
from rapc.analysis.hiding import HIDES, visible, with_hiders
from rapc.analysis.registry import rules
from rapc.base.diagnostics import Diagnostic, Subject
from rapc.base.source import Span
from rapc.library.loader import load_text

FORM, OTHER = Span("a.rap", 0, 50), Span("a.rap", 50, 99)
FORMS = ((OTHER, OTHER), (FORM, FORM))


def _found(rule: str, start: int, *about: Subject) -> Diagnostic:
    return Diagnostic(rule, "message", Span("a.rap", start, start + 5), about=about)


def _visible(*found: Diagnostic) -> list[str]:
    return [one.rule for one in visible(found, FORMS)]


def test_rows_name_rules() -> None:
    named = {name for row in HIDES for name in (*row.by, *row.hidden)}
    assert named <= rules().keys()


def test_no_two_rules_hide_each_other() -> None:
    graph: dict[str, set[str]] = {}
    for row in HIDES:
        for name in row.hidden:
            graph.setdefault(name, set()).update(row.by)
    assert list(TopologicalSorter(graph).static_order())


def test_a_finding_hides_others_in_its_form_only() -> None:
    mixed = _found("kinds-apart", 10)
    near, far = _found("swapped-arguments", 30), _found("swapped-arguments", 60)
    assert _visible(mixed, near, far) == ["kinds-apart", "swapped-arguments"]


def test_a_finding_hides_others_about_the_same_name() -> None:
    wrong = _found("misspelt-constant", 10, Subject(FORM, "?cup"))
    cup = _found("unbound-variable", 20, Subject(FORM, "?cup"))
    box = _found("unbound-variable", 30, Subject(FORM, "?box"))
    assert visible([wrong, cup, box], FORMS) == [wrong, box]


def test_each_output_that_is_left_out_hides_one_variable() -> None:
    taken = _found("output-is-input", 10, Subject(FORM))
    lost = [
        _found("unbound-variable", 20 + at, Subject(FORM, name), Subject(FORM))
        for at, name in enumerate(("?cup", "?box"))
    ]
    assert visible([taken, *lost], FORMS) == [taken, lost[1]]


def test_rules_that_are_not_wanted_hide_all_the_same() -> None:
    assert "kinds-apart" in with_hiders({"swapped-arguments"})
    assert with_hiders({"kinds-apart"}) == {"kinds-apart"}


def test_a_hidden_finding_is_found_when_its_cause_is_gone() -> None:
    text = """
    (define-rap (find ?thing => ?place))
    (define-rap (go ?place))
    (define-rap (fetch ?thing)
      (method (task-net (t1 (find ?thing => {}) (for t2)) (t2 (go ?place)))))
    """
    for output, rule in (("?thing", "output-is-input"), ("?", "unbound-variable")):
        findings = check_library(load_text(text.format(output))).findings
        assert [one.rule.name for one in findings] == [rule]


def test_checks_hand_each_other_no_findings() -> None:
    """A fact that is made of findings, or of the nodes they are about, is a truce."""
    for path in Path(analysis.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.returns is not None:
                result = ast.unparse(node.returns)
                if node.name == "_run":
                    assert "Diagnostic" not in result, path
                    assert "set[int]" not in result, path
                    assert "Container[int]" not in result, path
