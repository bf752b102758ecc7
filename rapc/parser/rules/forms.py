"""Rules about the shape of forms, clauses, formulas, terms and steps."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

FORM_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP010",
        name="unknown-clause",
        summary="a clause or option has a name that does not exist",
        fix="safe for what print has had, else unsafe: writes the word that is meant",
        source="T 3.1, 4.10",
    ),
    Rule(
        code="RAP011",
        name="duplicate-clause",
        summary="a clause stands twice where it may stand once",
        source="T 4.10",
    ),
    Rule(
        code="RAP030",
        name="malformed-form",
        summary="a declaration lacks a part, or has one that does not fit",
        fix="safe or unsafe by the part: writes a name with its mark, or in "
        "parentheses",
        source="T A.1",
    ),
    Rule(
        code="RAP031",
        name="malformed-clause",
        summary="a clause has parts that do not fit it",
        fix="unsafe: puts parentheses around what lacks them",
        source="T 4.10",
    ),
    Rule(
        code="RAP032",
        name="malformed-formula",
        summary="something is no formula",
        fix="safe: writes a bare `true` or `otherwise` for one in parentheses",
        source="T 4.1",
    ),
    Rule(
        code="RAP033",
        name="malformed-term",
        summary="something is no term",
        source="T 4.1",
    ),
    Rule(
        code="RAP034",
        name="malformed-proposition",
        summary="a plain proposition is wanted",
        fix="safe: writes the colon of an event or a skill",
        source="T 4.1",
    ),
    Rule(
        code="RAP035",
        name="malformed-goal",
        summary="a goal or an index is not a name with arguments",
        fix="safe where nothing else can be meant, else unsafe: puts parentheses "
        "around it",
        source="T 4.2",
    ),
    Rule(
        code="RAP036",
        name="malformed-step",
        summary="a step of a task-net lacks its tag or its goal",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP037",
        name="unknown-annotation",
        summary="an annotation of a step does not exist",
        fix="safe for `counter-del`, else unsafe: writes the word that is meant",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP038",
        name="malformed-annotation",
        summary="an annotation of a step has parts that do not fit it",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP039",
        name="repeated-variable",
        summary="a variable is declared twice in one place",
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
        summary="two methods of a RAP have one name",
        fix="unsafe: numbers the second one, and leaves questions about either as "
        "they are",
        source="T 4.5",
    ),
    Rule(
        code="RAP042",
        name="method-without-body",
        summary="a method does not say what to do",
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
        summary="a clause stands in the wrong kind of form",
        source="T 4.10",
    ),
    Rule(
        code="RAP045",
        name="malformed-rule",
        summary="a rule over memory has parts that do not fit it",
        source="S 4.2",
    ),
    Rule(
        code="RAP046",
        name="grouped-steps",
        summary="steps are grouped by a word such as `sequence`",
        source="T 4.5.2",
    ),
)
