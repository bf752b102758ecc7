"""Limits, so that no text takes more time or memory than its length accounts for.

What is beyond one of them is refused, left out or not looked at, and the user is told.
"""

from __future__ import annotations

MAX_BYTES = 200_000_000
"""Of a file; the largest library known has a thousandth of it."""

MAX_NAME = 1000
"""Characters of a symbol, variable or keyword: names are repeated in messages."""

MAX_NUMBER = 100
"""Characters of a number: well within the range of floats."""

LARGEST_NUMBER = 10**MAX_NUMBER
"""What a number that is read is below, whatever its sign."""

MAX_DEPTH = 100
"""Levels of lists: what walks over nodes may recurse."""

MAX_NODE_DEPTH = 150
"""Levels of nodes in a compiled library; those of a text lie less deep."""

MAX_LEAVES = 200
"""Propositions and tests of a formula: queries become nested code."""

MAX_PARTS = 1000
"""Parts of a formula that no text was read to; one from a text has fewer."""

MAX_FINDINGS = 1000
"""Findings in a file's text; more would help nobody."""

MAX_SUGGESTIONS = 50
"""Unknown names for which a similar one is looked up, which takes milliseconds."""

MAX_COMPARED = 60
"""Characters of names compared for slips: nobody compares longer ones by eye."""

MAX_REASON = 200
"""Characters of the reason why a compiled library cannot be decoded."""
