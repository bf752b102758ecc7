"""Commands that tell what has been: of facts, items, failures, deadlines and time."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.values import Atom, Fact, format_atom, format_list, number, readable
from rapc.debug import facts, timeline
from rapc.debug.who import who
from rapc.repl.answer import ShownAnswer, table
from rapc.repl.arguments import Arguments, read_pattern
from rapc.repl.shell import Shell, command


@command(
    "ITEM [PREDICATE] | FACT",
    ":history item-1",
    ":history item-1 color",
    ":history (truck-location ?)",
)
def _history(shell: Shell, args: Arguments) -> ShownAnswer:
    """Tell when facts came and went, and what became of an item, with who did it."""
    said = args.word("an item or a fact")
    none = f"nothing has become of {said}"
    if said.startswith("("):
        found = facts.of_facts(shell.history, read_pattern(said))
    else:
        predicate = args.word("a predicate").lower() if args else ""
        found = facts.of_item(shell.history, said.lower(), predicate)
        none += f"; if it is no item but a fact, write ({said})"
    columns = ("time", "cycle", "", "what", "by")
    return table(columns, found, none=none)


@command("FACT", ":who (truck-location depot)", ":who (location ?item external)")
def _who(shell: Shell, args: Arguments) -> ShownAnswer:
    """Tell who asserted a fact, who asks for it, and who waits for it."""
    found = who(shell.history, read_pattern(args.word("a fact")))
    rows = [
        (
            "believed" if one.by != "notation" else "noted",
            format_list(one.fact),
            f"since {'the beginning' if one.time is None else readable(one.time)}"
            + (f", by {one.by}" if one.by else ""),
        )
        for one in found.believed
    ]
    rows += [("noted by", f"[{number}]", "") for number in found.noted_by]
    rows += [
        ("listened to by", f"[{one.task}] {one.goal}", one.state)
        for one in found.listeners
    ]
    rows += [(one.use, one.form, one.place) for one in found.places]
    return table(("how", "who", "where"), rows, none="nobody has to do with it")


@command("", ":retries")
def _retries(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the goals that have failed more than once, and why.

    Where `times` is 1, all of it happened with the clock standing still.
    """
    rows = [
        (
            one.goal,
            one.failed,
            one.times,
            f"{readable(one.first)} to {readable(one.last)}",
            ", ".join(f"{count} {result}" for result, count in one.results.items()),
            next(iter(one.causes)),
        )
        for one in facts.retries(shell.history)
    ]
    columns = ("goal", "failed", "times", "from", "results", "most often because of")
    return table(columns, rows, none="no goal has failed twice")


@command("", ":deadlines")
def _deadlines(shell: Shell, args: Arguments) -> ShownAnswer:
    """List the deadlines that were missed, by how much, and those ahead."""
    rows = [
        (
            one.task,
            one.goal,
            one.deadline,
            "missed" if one.missed else "ahead",
            one.ended,
            one.by,
        )
        for one in facts.deadlines(shell.history)
    ]
    columns = ("task", "goal", "deadline", "", "ended", "late or left")
    return table(columns, rows, none="no task has a deadline")


@command("[FROM [TO]]", ":timeline", ":timeline 200 240")
def _timeline(shell: Shell, args: Arguments) -> ShownAnswer:
    """Tell what the time went by with, and how much of it each family used.

    Requests and skills stand by the time at which they began, with the events heard
    of the skills. Of several at a time the last to begin is reckoned to have used
    it.
    """
    start = args.time("a time") if args else 0
    stop = args.time("a time") if args else None
    spells = timeline.timeline(shell.history, start, stop)
    rows = [
        (
            one.start,
            one.stop,
            None if one.family is None else f"[{one.family}]",
            None if one.task is None else f"[{one.task}]",
            one.doing or "waiting",
            _heard(one.heard),
        )
        for one in spells
    ]
    used = timeline.time_by_family(spells, start, stop)
    total = sum(used.values())
    notes = [
        f"{'waiting' if family is None else f'family [{family}]'}: "
        f"{format_atom(number(round(time, 2)))} of "
        f"{format_atom(number(round(total, 2)))}, {100 * time / total:.0f} %"
        for family, time in used.items()
    ]
    columns = ("from", "to", "family", "task", "what", "heard")
    return table(columns, rows, none="no time has passed", notes=notes)


def _heard(signals: Sequence[Fact]) -> str:
    """Return signals in words: one that came once whole, others by name and number."""
    by_name: dict[Atom, list[Fact]] = {}
    for one in signals:
        by_name.setdefault(one[0], []).append(one)
    return ", ".join(
        format_list(same[0]) if len(same) == 1 else f"{name} {len(same)} times"
        for name, same in by_name.items()
    )


REMEMBERING = (_history, _who, _retries, _deadlines, _timeline)
