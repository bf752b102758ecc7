"""RAP178 and RAP179: invisible control characters, and words of several scripts."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.source import Span

BIDIRECTIONAL = Rule(
    code="RAP178",
    name="bidirectional-control",
    severity=Severity.WARNING,
    summary="a control character changes the direction of the text that follows",
    ignore="in a doc string in a language that is written from right to left",
    source="L 1",
)

MIXED_SCRIPTS = Rule(
    code="RAP179",
    name="mixed-scripts",
    severity=Severity.WARNING,
    summary="a word has letters of several scripts that look alike",
    ignore="never: rename the word",
    source="L 1",
)

_CONTROLS = re.compile("[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
_TOKENS = re.compile(r'"(?:[^"\\]|\\.)*"|;[^\n]*|[^\s()";]+')
_ALIKE = ("LATIN", "CYRILLIC", "GREEK", "ARMENIAN", "CHEROKEE")
"""The scripts with letters that look like those of another script."""


@check(BIDIRECTIONAL, MIXED_SCRIPTS)
def letters(run: Pass) -> Iterator[Diagnostic]:
    """Find control characters of direction, and words of several scripts."""
    for name, file in run.library.files.items():
        if file.text.isascii():
            continue
        for found in _CONTROLS.finditer(file.text):
            code = f"U+{ord(found[0]):04X}"
            yield BIDIRECTIONAL.at(
                Span(name, found.start(), found.end()),
                f"the control character {code} changes the direction of text",
                help="remove the character",
            )
        for token in _TOKENS.finditer(file.text):
            if token[0][0] not in '";' and not token[0].isascii():
                yield from _mixed(name, token)


def _mixed(file: str, token: re.Match[str]) -> Iterator[Diagnostic]:
    for part in re.finditer(r"[^\W\d_]+", token[0]):
        scripts = {_script(letter): letter for letter in part[0]}
        alike = [script for script in _ALIKE if script in scripts]
        if len(alike) > 1:
            said = " and ".join(script.capitalize() for script in alike)
            start = token.start() + part.start()
            yield MIXED_SCRIPTS.at(
                Span(file, start, start + len(part[0])),
                f"`{part[0]}` mixes letters of the scripts {said}",
                help="write the word in one script",
            )


def _script(letter: str) -> str:
    return unicodedata.name(letter, "").split(" ")[0]
