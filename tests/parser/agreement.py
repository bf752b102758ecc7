"""Whether the grammar and the front end agree about a text, and what excuses them.

`python -m tests.parser.agreement 5000` holds so many generated programs against both.
"""

from __future__ import annotations

import re
import sys
from collections import Counter

from lark import Token
from lark.exceptions import UnexpectedInput, UnexpectedToken

from rapc.base.diagnostics import Diagnostic
from rapc.language.build import parser, terminals, words
from rapc.language.comments import blanked
from tests.parser.programs import for_each_program
from tests.parser.reading import parsed

ATTRIBUTES = {
    "depth": (("nested-too-deeply",), ""),
    "length": (("too-long",), ""),
    "looks like a number": (("malformed-number",), ""),
    "clause twice": (("duplicate-clause",), ""),
    "variable twice": (("repeated-variable",), ""),
    "method twice": (("duplicate-method",), ""),
    "defaults twice": (("malformed-form",), "`define-test-defaults` must"),
    "too many parts": (("formula-too-large",), ""),
    "true or false": (("malformed-formula",), "the value of `know-sensor-name`"),
    "reserved word": (
        (
            *("malformed-proposition", "malformed-term", "malformed-formula"),
            *("misplaced-clause", "missing-index"),
        ),
        "cannot be the name of a proposition|is a test and|is not a test|"
        "must not have parentheses|is a clause of a method, not of `define-rap`|this "
        "RAP requires a name",
    ),
}
"""What the grammar allows and the front end does not.

Each with the rules that are then reported, and words in the message where a rule may
have other reasons.
"""


def excused(found: Diagnostic) -> str | None:
    """The attribute that a finding comes from, if there is one."""
    for name, (rules, message) in ATTRIBUTES.items():
        if found.rule in rules and re.search(message, found.message):
            return name
    return None


def accepted(text: str) -> bool:
    """Whether the grammar makes a program of a text."""
    code = blanked(text + "\n")
    try:
        parser().parse(
            text if code is None else code, start="start", on_error=_read_as_name
        )
    except UnexpectedInput:
        return False
    return True


def _read_as_name(error: UnexpectedInput) -> bool:
    """Go on with a word as the name that it can be where it stands.

    The lexer chooses by what may follow a list anywhere: of `false` in
    `(believe (p) false)` it thinks as of that in `(and (p) false)`.
    """
    if not isinstance(error, UnexpectedToken) or error.token.type not in words():
        return False
    names = [
        name
        for name in sorted(error.accepts & terminals().keys())
        if re.fullmatch(terminals()[name], error.token)
    ]
    if names:
        error.interactive_parser.feed_token(Token(names[0], error.token))
    return bool(names)


def disagreement(text: str) -> set[str]:
    """The rules about which grammar and front end do not agree; none if they do.

    A text that the grammar refuses and the front end does not gives `nothing`.
    """
    found = parsed(text).diagnostics
    if accepted(text):
        return {one.rule for one in found if excused(one) is None}
    return set() if found else {"nothing"}


def main(count: int) -> None:
    """Print how many generated programs there were, and those without agreement."""
    seen: Counter[str] = Counter()

    def hold(text: str) -> None:
        seen["programs"] += 1
        seen["accepted by the grammar"] += accepted(text)
        seen["without a finding"] += not parsed(text).diagnostics
        for rule in disagreement(text):
            seen[f"disagree: {rule}"] += 1
            print(text)

    for_each_program(count, hold)
    for what, number in sorted(seen.items()):
        print(f"{number:6} {what}")


if __name__ == "__main__":
    main(int(sys.argv[1]))
