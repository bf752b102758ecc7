"""Rules about the shape of forms, clauses, formulas, terms and steps."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

FORM_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP010",
        name="unknown-clause",
        summary="unknown clause or option",
        fix="safe if the name is a known misprint, else unsafe: writes the "
        "similar name",
        source="T 3.1, 4.10",
    ),
    Rule(
        code="RAP011",
        name="duplicate-clause",
        summary="duplicate clause or option",
        source="T 4.10",
    ),
    Rule(
        code="RAP030",
        name="malformed-form",
        summary="a declaration has a missing or an invalid part",
        fix="safe or unsafe, depending on the part: writes a name with its "
        "mark, or adds parentheses",
        source="T A.1",
    ),
    Rule(
        code="RAP031",
        name="malformed-clause",
        summary="a clause has invalid parts",
        fix="unsafe: adds parentheses",
        source="T 4.10",
    ),
    Rule(
        code="RAP032",
        name="malformed-formula",
        summary="invalid formula",
        fix="safe: writes `true` or `otherwise` without parentheses",
        source="T 4.1",
    ),
    Rule(
        code="RAP033",
        name="malformed-term",
        summary="invalid term",
        source="T 4.1",
    ),
    Rule(
        code="RAP034",
        name="malformed-proposition",
        summary="expected a plain proposition",
        fix="safe: writes the colon of an event or a skill",
        source="T 4.1",
    ),
    Rule(
        code="RAP035",
        name="malformed-goal",
        summary="a goal or an index is not a name with arguments",
        fix="safe if no other correction is possible, else unsafe: adds parentheses",
        source="T 4.2",
    ),
    Rule(
        code="RAP036",
        name="malformed-step",
        summary="a step of a task-net has no tag or no goal",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP037",
        name="unknown-annotation",
        summary="unknown annotation of a step",
        fix="safe for `counter-del`, else unsafe: writes the similar name",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP038",
        name="malformed-annotation",
        summary="an annotation of a step has invalid parts",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP039",
        name="repeated-variable",
        summary="duplicate variable in a declaration",
        source="T 4.2",
    ),
    Rule(
        code="RAP040",
        name="missing-index",
        summary="a RAP has no name",
        source="T 4.2",
    ),
    Rule(
        code="RAP041",
        name="duplicate-method",
        summary="two methods of a RAP have the same name",
        fix="unsafe: numbers the second method; queries about either "
        "method stay unchanged",
        source="T 4.5",
    ),
    Rule(
        code="RAP042",
        name="method-without-body",
        summary="a method has neither a task-net nor a primitive",
        source="T 4.5",
    ),
    Rule(
        code="RAP043",
        name="formula-too-large",
        summary="a formula has more than 200 parts",
        source="L 1",
    ),
    Rule(
        code="RAP044",
        name="misplaced-clause",
        summary="a clause is in the wrong kind of form",
        source="T 4.10",
    ),
    Rule(
        code="RAP045",
        name="malformed-rule",
        summary="a memory rule or event rule has invalid parts",
        source="S 4.2",
    ),
    Rule(
        code="RAP046",
        name="grouped-steps",
        summary="steps are grouped by a word such as `sequence`",
        source="T 4.5.2",
    ),
)
