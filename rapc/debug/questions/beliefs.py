"""Questions about beliefs and truth, in worlds that are a `Truth`."""

from __future__ import annotations

from rapc.base.values import format_list, match_pattern, number
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.history import History
from rapc.debug.questions.why import origins
from rapc.errors import ArgumentError

_COLUMNS = ("believed", "since", "by", "truth", "wrong from", "cycle", "to")


@question("[FACT]", ":belief", ":belief (robot-at ?)")
def belief(history: History, args: Arguments) -> Answer:
    """List the present wrong beliefs, or all wrong beliefs of a fact.

    The beliefs are compared with the truth at each cycle. The columns show the
    assertion of the belief and its source, the truth, the time and the cycle at which
    the belief became wrong, and the time at which it was true or erased.
    """
    history.check_knows_truth()
    pattern = read_pattern(args.word("fact")) if args else None
    if pattern is not None:
        signatures = history.library.program.signatures
        if str(pattern[0]) not in signatures.relations:
            raise ArgumentError(str(signatures.unknown("test", str(pattern[0]))))
    rows = []
    for one in history.branch.discrepancies.up_to(history.serial).all:
        fact, since, truth = one.belief
        if pattern is None:
            wanted = one.ended is None
        else:
            wanted = match_pattern(pattern, fact[: len(pattern)]) is not None
        if wanted:
            (origin,) = origins(history, {fact: since}, (one.cycle + 1, 0))
            true = " or ".join(map(format_list, truth)) or "not so"
            ended = None if one.ended is None else number(one.ended)
            asserted = None if since is None else number(since)
            belief = (format_list(fact), asserted, origin.source, true)
            rows.append((*belief, number(one.time), one.cycle, ended))
    return table(_COLUMNS, rows, none="no wrong beliefs")
