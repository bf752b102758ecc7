"""What a finding is known by while the text around it changes.

A fingerprint depends on the rule, the file as seen from the working folder, the line on
which the finding stands, without its indent, and how many findings with all this in
common stand before it: neither on its row nor on other lines.
"""

from __future__ import annotations

import hashlib
from collections import Counter

from rapc.analysis.driver import CheckReport
from rapc.base.files import seen_from

_LENGTH = 20
"""Hexadecimal digits of a fingerprint: 80 bits."""


def fingerprints(report: CheckReport, root: str = "") -> tuple[str, ...]:
    """Return a fingerprint for each finding of a report, in their order.

    Args:
        report: the report.
        root: the folder from which paths are seen; the working folder if empty.
    """
    seen: Counter[tuple[str, str, str]] = Counter()
    prints = []
    for finding in report.findings:
        span = finding.diagnostic.span
        source = report.files.get(span.file)
        line = source.line(source.row(span.start)).strip() if source else ""
        key = (finding.rule.name, seen_from(root, span.file), line)
        text = "\0".join((*key, str(seen[key])))
        seen[key] += 1
        prints.append(hashlib.sha256(text.encode()).hexdigest()[:_LENGTH])
    return tuple(prints)
