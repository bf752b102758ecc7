"""Questions about beliefs and truth, in worlds that are a `Truth`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc import events
from rapc.base.names import plural
from rapc.base.values import Fact, format_list, match_pattern, number
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.discrepancies import Discrepancy
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.questions.facts import behind
from rapc.debug.sources import Origin, Source, origins, sources
from rapc.debug.symptoms import Symptom, at_place
from rapc.errors import ArgumentError

_COLUMNS = ("believed", "since", "by", "truth", "wrong from", "cycle", "to")


@question("[FACT]", ":belief", ":belief (robot-at ?)")
def belief(history: History, args: Arguments) -> Answer:
    """List the present wrong beliefs, or all wrong beliefs of a fact.

    Without a present wrong belief, the past wrong beliefs are listed, the latest last.
    The beliefs are compared with the truth at each cycle. The columns show the
    assertion of the belief and its source, the truth, the time and the cycle at which
    the belief became wrong, and the time at which it was true or erased. For the first
    belief of a rule, the facts are added from which the rule derived the belief.
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
    rows: list[tuple[object, ...]] = []
    explained: set[str] = set()
    for one, source in zip(found, _sources(history, found), strict=True):
        fact, since, truth = one.belief
        true = " or ".join(map(format_list, truth)) or "not so"
        ended = None if one.ended is None else number(one.ended)
        asserted = None if since is None else number(since)
        row = (format_list(fact), asserted, str(source), true)
        rows.append((*row, number(one.time), one.cycle, ended))
        if source.rule is None or source.where in explained:
            continue
        explained.add(source.where)
        if len(explained) <= _MOST_RULES:
            for origin in _supports(history, source):
                fact_behind = f"  because of {format_list(origin.fact)}"
                rows.append((fact_behind, origin.time, origin.source, *_NO_TRUTH))
    return table(_COLUMNS, rows, *lines, none="no wrong beliefs")


_NO_TRUTH = (None,) * 4
"""The last cells of the row of a fact behind a wrong belief."""

_MOST_RULES = 3
"""The number of rules for which the facts behind a wrong belief are listed."""


def _sources(history: History, found: Sequence[Discrepancy]) -> list[Source]:
    """Return the source of each wrong belief."""
    facts = {one.belief.fact for one in found}
    asserted: dict[Fact, list[ToldEvent]] = {}
    for told in history.scan(
        events.FactAsserted, want=lambda told: told.keys["fact"] in facts
    ):
        asserted.setdefault(told.keys["fact"], []).append(told)
    last = [
        next(
            (
                told
                for told in reversed(asserted.get(one.belief.fact, []))
                if told.cycle <= one.cycle
            ),
            None,
        )
        for one in found
    ]
    known = sources(history, [told for told in last if told is not None])
    return [Source("") if told is None else known[told.serial] for told in last]


def _supports(history: History, source: Source) -> tuple[Origin, ...]:
    """Return the facts from which a rule derived a belief, without initial facts."""
    rule = source.rule
    if rule is None or history.no_way_back:
        return ()
    found = origins(history, behind(history, rule), (rule.cycle, rule.serial))
    return tuple([one for one in found if one.cycle])


def wrong_beliefs(history: History) -> Iterator[Symptom]:
    """Yield the rules that made wrong beliefs, in the order of their first ones.

    For the first rule, the facts are added from which other rules had derived it.
    """
    if not history.is_run or not history.knows_truth:
        return
    found = history.branch.discrepancies.up_to(history.serial).all
    groups: dict[str, list[tuple[Discrepancy, Source]]] = {}
    for one, source in zip(found, _sources(history, found), strict=True):
        if source.rule is not None:
            groups.setdefault(source.where, []).append((one, source))
    for at, (where, made) in enumerate([*groups.items()][:_MOST_RULES]):
        one, source = made[0]
        said = f"{plural(len(made), 'wrong belief')} by {source.by}"
        said += f"; in cycle {one.cycle}: {format_list(one.belief.fact)}"
        derived = () if at else _supports(history, source)
        from_rules = (
            f"{format_list(origin.fact)} by {origin.by}{at_place(origin.where)}"
            for origin in derived
            if origin.where
        )
        said += "".join(f"; derived from {one}" for one in from_rules)
        yield Symptom(where, said)
