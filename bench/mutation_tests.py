"""Slips in tests, which hold no expectation, or one that cannot fail.

As in `bench.mutation_words`, a kind yields every place where the slip can be made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bench.mutation_base import Base, Edit, Kind
from rapc.ir import nodes


def _expectations_dropped(base: Base) -> Iterator[Edit]:
    for test in base.library.tests:
        spans = [one.span for one in test.expectations]
        later = [action for at in test.ats for action in at.actions]
        if spans and not any(isinstance(one, nodes.Expect) for one in later):
            whole = base.around(spans[0].to(spans[-1]))
            if base.text(whole).startswith("(expect"):
                yield Edit(whole, "")


def _never_of_another(base: Base) -> Iterator[Edit]:
    """A test expects that something never happens to a thing that is not there."""
    for one in base.index.of(nodes.Never):
        for term in one.node.request.args:
            if isinstance(term, nodes.Const) and isinstance(term.value, str):
                yield Edit(term.span, f"{term.value}1")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "expectations dropped": ("tests", _expectations_dropped),
    "`never` of a thing that is not there": ("tests", _never_of_another),
}
"""Every kind of slip here, with the group that it is of."""
