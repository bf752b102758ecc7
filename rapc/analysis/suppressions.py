"""Comments that silence findings: `; rapc: ignore[name] reason`, `file-ignore`.

An `ignore` before a form, or at the end of the form's first line, covers that form; a
`file-ignore` covers its file. A suppression that silences no finding, or that names an
unknown rule, is itself a finding.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import accumulate

import msgspec

from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Rule,
    Severity,
)
from rapc.base.names import Suggestions
from rapc.base.source import SourceFile, Span
from rapc.parser.syntax import Comment, lists
from rapc.parser.unit import SourceUnit

UNUSED = Rule(
    code="RAP071",
    name="unused-suppression",
    severity=Severity.WARNING,
    summary="a suppression silences no finding",
    fix="safe: removes the comment",
    ignore="where the finding depends on the other checked files",
    source="L 1",
)

BAD = Rule(
    code="RAP072",
    name="bad-suppression",
    severity=Severity.WARNING,
    summary="a comment looks like a suppression but names no rule",
    ignore="never: correct the name, or remove the comment",
    source="L 1",
)

RULES = (UNUSED, BAD)
"""The rules about suppressions."""


@cache
def _meant() -> re.Pattern[str]:
    """Return the pattern of comments that are meant as suppressions."""
    return re.compile(r";+\s*rapc:\s*(?P<what>.*)", re.IGNORECASE | re.DOTALL)


@cache
def _form() -> re.Pattern[str]:
    """Return the pattern of the parts of a suppression."""
    form = r"(?P<kind>ignore|file-ignore)\[(?P<rules>[^\]]*)\]"
    return re.compile(form, re.IGNORECASE)


class Suppression(msgspec.Struct, frozen=True):
    """A rule name in a suppression comment.

    `rule` is the name of the rule; `comment` is the span of the comment; `covers` is
    the span of silenced findings; `alone` is true if the comment names no other rule.
    """

    rule: str
    comment: Span
    covers: Span
    alone: bool


def find_suppressions(
    unit: SourceUnit, rules: Mapping[str, Rule]
) -> tuple[list[Suppression], list[Diagnostic]]:
    """Return the suppressions of a file, and the findings about suppressions.

    Args:
        unit: the file.
        rules: the known rules by name. Without the rules about suppressions, an unknown
            name is not reported.
    """
    source = unit.file
    if not unit.comments:
        return [], []
    match = _meant().match
    meant = [(c, m["what"]) for c in unit.comments if (m := match(c.text))]
    if not meant:
        return [], []
    by_word = {word: rule for rule in rules.values() for word in (rule.name, rule.code)}
    starts, below = _first_forms(unit), _rows_with_text(source)
    names = Suggestions(rules)
    found: list[Suppression] = []
    wrong: list[Diagnostic] = []
    told = BAD.name in rules
    for comment, what in meant:
        form = _form().match(what)
        words = [w.strip() for w in form["rules"].split(",")] if form else []
        if form is None or not any(words):
            wrong.append(_malformed(comment))
            continue
        whole = form["kind"].lower() == "file-ignore"
        covers = source.span(0, len(source.text) + 1)
        covers = covers if whole else _covered(source, comment, starts, below)
        for word in words:
            rule = by_word.get(word) or by_word.get(word.upper())
            if rule is None and told:
                wrong.append(_unknown(comment, word, names))
            elif rule is not None:
                found.append(
                    Suppression(rule.name, comment.span, covers, len(words) == 1)
                )
    return found, wrong


def apply(
    found: Iterable[Diagnostic], suppressions: Sequence[Suppression]
) -> tuple[list[Diagnostic], list[Suppression]]:
    """Return the findings left, and the suppressions that silenced no finding.

    The time is proportional to the number of findings and suppressions.
    """
    covers: dict[tuple[str, str], list[Span]] = {}
    for one in sorted(suppressions, key=lambda one: one.covers.start):
        covers.setdefault((one.covers.file, one.rule), []).append(one.covers)
    ends = {k: list(accumulate((c.end for c in v), max)) for k, v in covers.items()}
    places: dict[tuple[str, str], list[int]] = {}
    left = []
    for diagnostic in found:
        key, start = (diagnostic.span.file, diagnostic.rule), diagnostic.span.start
        places.setdefault(key, []).append(start)
        before = bisect_right(covers.get(key, ()), start, key=lambda span: span.start)
        if not before or ends[key][before - 1] <= start:
            left.append(diagnostic)
    for starts in places.values():
        starts.sort()
    return left, [one for one in suppressions if not _silences(one, places)]


def _silences(one: Suppression, places: Mapping[tuple[str, str], list[int]]) -> bool:
    """Return whether a suppression covers one of the findings at some positions."""
    starts = places.get((one.covers.file, one.rule), [])
    at = bisect_left(starts, one.covers.start)
    return at < len(starts) and starts[at] < one.covers.end


def unused(suppression: Suppression, source: SourceFile) -> Diagnostic:
    """Return the finding about a suppression that silences no finding."""
    text, comment = source.text, suppression.comment
    start, end = comment.start, comment.end
    while start > 0 and text[start - 1] in " \t":
        start -= 1
    if (start == 0 or text[start - 1] == "\n") and text.startswith("\n", end):
        end += 1  # the comment is alone in its line
    edit = Edit(source.span(start, end), "")
    fix = Fix(Applicability.SAFE, "remove the comment", (edit,))
    return Diagnostic(
        rule=UNUSED.name,
        message=f"no finding of `{suppression.rule}` to ignore here",
        span=comment,
        help="remove the comment" if suppression.alone else "remove this name",
        fix=fix if suppression.alone else None,
    )


# --- spans of suppressions ------------------------------------------------------------


def _first_forms(unit: SourceUnit) -> Mapping[int, Span]:
    """Return, for each row that a list begins on, the outermost of those lists."""
    source = unit.file
    starts: dict[int, Span] = {}
    for one in lists(unit.data):
        row = source.position(one.start).row
        starts.setdefault(row, source.span(one.start, one.end))
    return starts


def _rows_with_text(source: SourceFile) -> Sequence[int]:
    """Return for each row, from 0, the first row from that row on with code."""
    last = len(source.line_starts)
    found = [last + 1] * (last + 2)
    for row in range(last, 0, -1):
        found[row] = found[row + 1] if _is_blank(source.line(row)) else row
    return found


def _covered(
    source: SourceFile,
    comment: Comment,
    starts: Mapping[int, Span],
    below: Sequence[int],
) -> Span:
    """Return the form on the line of the comment, or on the next line with text."""
    at = source.position(comment.span.start)
    before = source.line(at.row)[: at.column - 1]
    row = at.row if before.strip() else below[at.row + 1]
    return starts.get(row, source.span(0, 0))


def _is_blank(line: str) -> bool:
    text = line.strip()
    return not text or text.startswith(";")


# --- messages -----------------------------------------------------------------------


def _malformed(comment: Comment) -> Diagnostic:
    return Diagnostic(
        rule=BAD.name,
        message="invalid suppression",
        span=comment.span,
        help="write `; rapc: ignore[rule-name] reason`, "
        "or `file-ignore` for the whole file",
    )


def _unknown(comment: Comment, word: str, names: Suggestions) -> Diagnostic:
    return Diagnostic(
        rule=BAD.name,
        message=f"unknown rule `{word}`",
        span=comment.span,
        help=names.did_you_mean(word, "`rapc rule` lists all rules"),
    )
