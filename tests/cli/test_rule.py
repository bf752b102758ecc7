"""`rapc rule`: pages, the list and JSON."""

from __future__ import annotations

import json

import pytest

from rapc.analysis.registry import rules

from .command import rapc


@pytest.mark.parametrize("name", ["unbound-variable", "RAP012", "rap012"])
def test_page_is_found_by_name_and_code(name: str) -> None:
    done = rapc("rule", name)
    rule = rules()["unbound-variable"]
    assert done.returncode == 0
    assert done.stdout.startswith("## unbound-variable\n\nRAP012, error: ")
    assert rule.page.why in done.stdout
    assert rule.page.example in done.stdout
    assert rule.page.better in done.stdout


def test_list_has_a_line_for_each_rule() -> None:
    lines = rapc("rule").stdout.splitlines()
    assert [line.split()[:2] for line in lines] == [
        [rule.code, rule.name] for rule in rules().values()
    ]


def test_list_marks_opt_in_rules() -> None:
    lines = rapc("rule").stdout.splitlines()
    marked = [line.split()[1] for line in lines if line.endswith(" (opt-in)")]
    assert marked == [rule.name for rule in rules().values() if rule.opt_in]
    assert marked


def test_json_is_one_rule_or_all() -> None:
    one = json.loads(rapc("rule", "unknown-rap", "--format", "json").stdout)
    everything = json.loads(rapc("rule", "--all", "--format", "json").stdout)
    assert one["code"] == "RAP013"
    assert one["severity"] == "error"
    assert one in everything
    assert [page["name"] for page in everything] == list(rules())


def test_unknown_rule_is_a_usage_error() -> None:
    done = rapc("rule", "unknown-rup")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "error: unknown rule `unknown-rup`; did you mean `unknown-rap`?\n"
    )
    assert rapc("rule", "unknown-rap", "--all").returncode == 2
