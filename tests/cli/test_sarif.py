"""SARIF as its readers take it: held against what SARIF 2.1.0 asks of these objects."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import jsonschema
import pytest
from hypothesis import given

from rapc.analysis import registry
from rapc.analysis.driver import CheckReport, check_library
from rapc.base.diagnostics import Applicability, Rule
from rapc.console import formats
from rapc.library.loader import load_text
from tests.analysis.test_robust import damaged
from tests.effort import examples

SCHEMA = json.loads(Path(__file__).with_name("sarif.schema.json").read_text())
RULES = [rule for rule in registry.rules().values() if not rule.opt_in]


def _held(report: CheckReport, *, rules: bool = False) -> dict[str, Any]:
    """Return the run of a log that keeps to the schema, its rules too if asked for."""
    log = json.loads(formats.sarif(report))
    (run,) = log["runs"]
    assert isinstance(run, dict)
    if not rules:
        run["tool"]["driver"]["rules"].clear()
    jsonschema.Draft7Validator(SCHEMA).validate(log)
    assert len(run["results"]) == len(report.findings)
    return run


def test_schema_is_valid_and_refuses_invalid_files() -> None:
    jsonschema.Draft7Validator.check_schema(SCHEMA)
    report = check_library(load_text("(define-rap (a) (b))"))
    assert _held(report, rules=True)["tool"]["driver"]["rules"]
    log = json.loads(formats.sarif(report))
    place = log["runs"][0]["results"][0]["locations"][0]["physicalLocation"]
    place["region"]["startLine"] = 0
    with pytest.raises(jsonschema.ValidationError, match="minimum"):
        jsonschema.Draft7Validator(SCHEMA).validate(log)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_every_rule_can_be_told(rule: Rule) -> None:
    report = check_library(load_text(rule.page.example))
    run = _held(report)
    codes = [rule.code for rule in registry.rules().values()]
    told = [(codes[r["ruleIndex"]], r["ruleId"]) for r in run["results"]]
    assert told == [(f.rule.code, f.rule.code) for f in report.findings]
    safe = [
        finding.diagnostic.fix is not None
        and finding.diagnostic.fix.applicability is Applicability.SAFE
        for finding in report.findings
    ]
    assert ["fixes" in result for result in run["results"]] == safe


@examples(120)
@given(damaged())
def test_each_finding_can_be_reported(text: str) -> None:
    report = check_library(load_text(text))
    _held(report)
    assert len(formats.github(report).splitlines()) == len(report.findings)
    top = ElementTree.fromstring(formats.junit(report))  # noqa: S314  # rapc's own
    assert len(top.findall(".//failure")) == len(report.findings)
    lines = formats.json_lines(report).splitlines()
    assert [json.loads(line) for line in lines] == json.loads(formats.json_text(report))
