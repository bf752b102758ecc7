"""Questions about beliefs and truth, in worlds that tell the truth."""

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
    """List the wrong beliefs of the present, or all that a fact has been until now.

    A belief is compared with the truth at each cycle. The columns show the assertion
    of the belief and its source, the truth, and the times at which the two parted and
    agreed again.
    """
    history.check_knows_truth()
    pattern = read_pattern(args.word("fact")) if args else None
    if pattern is not None:
        signatures = history.library.program.signatures
        if str(pattern[0]) not in signatures.relations:
            raise ArgumentError(str(signatures.unknown("test", str(pattern[0]))))
    rows = []
    for one in history.branch.partings.up_to(history.serial).all:
        if pattern is None:
            wanted = one.end is None
        else:
            wanted = match_pattern(pattern, one.fact[: len(pattern)]) is not None
        if wanted:
            believed = {one.fact: one.believed}
            (origin,) = origins(history, believed, (one.cycle + 1, 0))
            since = None if one.believed is None else number(one.believed)
            truth = " or ".join(map(format_list, one.truth)) or "not so"
            ended = None if one.ended is None else number(one.ended)
            told = (format_list(one.fact), since, origin.source, truth)
            rows.append((*told, number(one.time), one.cycle, ended))
    return table(_COLUMNS, rows, none="no wrong beliefs")
