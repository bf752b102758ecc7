"""Limits that keep time and memory in proportion to the length of a text.

Input over a limit is refused, left out or ignored, with a message to the user.
"""

from __future__ import annotations

MAX_BYTES = 200_000_000
"""Bytes of a file; the largest known library has a thousandth of the limit."""

MAX_NAME = 1000
"""Characters of a symbol, variable or keyword: names are repeated in messages."""

MAX_NUMBER = 100
"""Characters of a number: well within the range of floats."""

LARGEST_NUMBER = 10**MAX_NUMBER
"""The bound that the absolute value of each number read is below."""

MAX_DEPTH = 100
"""Levels of lists: functions that walk over nodes may recurse."""

MAX_NODE_DEPTH = 150
"""Levels of nodes in a compiled library; a text has fewer."""

MAX_LEAVES = 200
"""Propositions and tests of a formula: queries become nested code."""

MAX_BRANCHES = 64
"""Branches into which the formulas of an operator of the planner are divided."""

MAX_PARTS = 1000
"""Parts of a formula built by a program; a formula from a text has fewer."""

MAX_FINDINGS = 1000
"""Findings in a file's text."""

MAX_SUGGESTIONS = 50
"""Unknown names with a search for a similar name, which takes milliseconds."""

MAX_COMPARED = 60
"""Characters of names compared for slips."""

MAX_TIMES = 100_000
"""Times of a repeated `at` in a test."""

MAX_REASON = 200
"""Characters of the reason why a compiled library cannot be decoded."""

MAX_QUOTED = 200
"""Characters of a fact, formula or task that a message repeats."""
