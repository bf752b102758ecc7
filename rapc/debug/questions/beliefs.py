"""Questions about beliefs and truth, in worlds that are a `Truth`."""

from __future__ import annotations

from rapc.base.values import format_list, match_pattern, number
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.history import History
from rapc.debug.sources import origins
from rapc.errors import ArgumentError

_COLUMNS = ("believed", "since", "by", "truth", "wrong from", "cycle", "to")


@question("[FACT]", ":belief", ":belief (robot-at ?)")
def belief(history: History, args: Arguments) -> Answer:
    """List the present wrong beliefs, or all wrong beliefs of a fact.

    Without a present wrong belief, the past wrong beliefs are listed, the latest last.
    The beliefs are compared with the truth at each cycle. The columns show the
    assertion of the belief and its source, the truth, the time and the cycle at which
    the belief became wrong, and the time at which it was true or erased.
    """
    history.check_knows_truth()
    pattern = None
    if args:
        said = args.word("fact")
        pattern = read_pattern(said if said.startswith("(") else f"({said})")
        signatures = history.library.program.signatures
        if str(pattern[0]) not in signatures.relations:
            raise ArgumentError(str(signatures.unknown("test", str(pattern[0]))))
    found, lines = history.branch.discrepancies.up_to(history.serial).all, []
    if pattern is not None:
        size = len(pattern)
        found = [
            one
            for one in found
            if match_pattern(pattern, one.belief.fact[:size]) is not None
        ]
    elif present := [one for one in found if one.ended is None]:
        found = present
    elif found:
        lines = ["no present wrong beliefs; wrong beliefs of the past:"]
    rows = []
    for one in found:
        fact, since, truth = one.belief
        (origin,) = origins(history, {fact: since}, (one.cycle + 1, 0))
        true = " or ".join(map(format_list, truth)) or "not so"
        ended = None if one.ended is None else number(one.ended)
        asserted = None if since is None else number(since)
        told = (format_list(fact), asserted, origin.source, true)
        rows.append((*told, number(one.time), one.cycle, ended))
    return table(_COLUMNS, rows, *lines, none="no wrong beliefs")
