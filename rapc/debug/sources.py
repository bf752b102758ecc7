"""Sources of facts: requests, data, rules, notations and the user."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import msgspec

from rapc import events
from rapc.base.values import Fact, format_list, number, readable
from rapc.compiler.program import Program
from rapc.debug.history import History
from rapc.debug.log import ToldEvent, Want
from rapc.debug.names import program_of
from rapc.ir import nodes
from rapc.runtime.memory.access import Evidence
from rapc.world import Time

FACTS = (events.FactAsserted, events.FactErased)

CAUSES = (
    *(events.PrimitiveEnded, events.DataReceived),
    *(events.TaskSelected, events.RuleRun, events.SignalReceived),
)
"""The kinds of events that show the sources of changes."""


_HANDLER = "handler"
"""The source of a change by a handler, until the event of its request or datum."""


class Source(NamedTuple):
    """The source of a change of memory."""

    #: A request with its task, a datum, a rule, a notation, `user`, ...
    by: str
    #: The file and line of the action of a rule; empty for other sources.
    where: str = ""
    #: The event of a rule; None for other sources.
    rule: ToldEvent | None = None

    def __str__(self) -> str:
        return f"{self.by} at {self.where}" if self.where else self.by


class Origin(msgspec.Struct, frozen=True):
    """A supporting fact and the source of its assertion."""

    fact: Fact
    #: The time of the last assertion; None if the events do not contain one.
    time: Time | None
    cycle: int | None
    #: The source: a primitive of a task, a datum, a rule, a notation, or the user.
    by: str
    #: The file and line of a rule; empty for other sources.
    where: str = ""

    def __str__(self) -> str:
        told = f"because of {format_list(self.fact)}"
        if self.time is not None:
            told += f", asserted at {readable(self.time)}"
        if self.cycle is not None:
            told += f" in cycle {self.cycle}"
        return f"{told} by {self.source}" if self.by else told

    @property
    def source(self) -> str:
        """The source with the file and line of a rule."""
        return f"{self.by} at {self.where}" if self.where else self.by


Change = tuple[ToldEvent, Source]
"""A change of memory with its source."""


def changes(history: History, told: Iterable[ToldEvent], want: Want) -> list[Change]:
    """Return the wanted changes among events, each with its source.

    Args:
        history: the run.
        told: events in order, with those of `CAUSES`, from the start of a cycle.
        want: selects the changes.
    """
    found: list[Change] = []
    #: The index of the first change whose handler may still be unknown.
    open_since = 0
    chooser: int | None = None
    rule: ToldEvent | None = None
    signal: ToldEvent | None = None
    signals: dict[int, ToldEvent] = {}
    program = program_of(history)
    for one in told:
        if one.kind is events.TaskSelected:
            chooser, open_since = one.keys["task"], len(found)
        elif one.kind is events.RuleRun:
            rule = one
            if signal is not None and signal.keys["what"] == one.keys["what"]:
                signals[one.serial] = signal
        elif one.kind is events.SignalReceived:
            signal = one
        elif one.kind in CAUSES:
            # The changes of a handler precede the event of its request or datum.
            by = Source(_cause(one))
            for at in range(open_since, len(found)):
                change, source = found[at]
                if source.by == _HANDLER:
                    found[at] = change, by
            open_since = len(found)
        elif want(one):
            found.append((one, _source(program, one, chooser, rule)))
    return _with_senders(history, program, found, signals)


def _with_senders(
    history: History,
    program: Program | None,
    found: list[Change],
    signals: Mapping[int, ToldEvent],
) -> list[Change]:
    """Add to the rules of no task the skill and the task of their signal.

    The skill is omitted if the log has dropped the event of its start.

    Args:
        history: the run.
        program: the library; None if it is unknown.
        found: the changes.
        signals: the signal of each rule, by the serial of the rule.
    """
    known = {
        one.rule.serial: signals[one.rule.serial]
        for _, one in found
        if one.rule is not None
        and one.rule.keys["task"] is None
        and one.rule.serial in signals
        and signals[one.rule.serial].keys["task"] is not None
    }
    if not known:
        return found
    begun = list(history.log.backwards(events.SkillEnabled, events.MethodChosen))
    enabled = [one for one in begun if one.kind is events.SkillEnabled]
    senders: dict[int, str] = {}
    for serial, signal in known.items():
        task, name = signal.keys["task"], signal.keys["what"][0]
        skill = next(
            (
                f"{format_list(one.keys['what'])} {_enabled_at(program, one, begun)}"
                for one in enabled
                if one.serial < signal.serial
                and one.keys["task"] == task
                and _sends(program, one.keys["what"][0], name)
            ),
            "",
        )
        senders[serial] = f" of {skill}[{task}]"
    return [
        (told, one._replace(by=one.by + senders.get(one.rule.serial, "")))
        if one.rule is not None
        else (told, one)
        for told, one in found
    ]


def _enabled_at(
    program: Program | None, enabled: ToldEvent, begun: Iterable[ToldEvent]
) -> str:
    """Return the file and line of an enabled skill, with `at` before it and a blank.

    Args:
        program: the library; None if it is unknown.
        enabled: the event of the start of the skill.
        begun: events with the choice of the method, latest first.
    """
    task, name = enabled.keys["task"], enabled.keys["what"][0]
    chosen = (
        one
        for one in begun
        if one.kind is events.MethodChosen
        and one.serial < enabled.serial
        and one.keys["task"] == task
    )
    last = next(chosen, None)
    if program is None or last is None:
        return ""
    plan = program.rap(last.keys["rap"])
    methods = () if plan is None else plan.methods
    node = next((m.node for m in methods if m.name == last.keys["method"]), None)
    if node is None:
        return ""
    skills = node.body.enable if isinstance(node.body, nodes.Skills) else node.skills
    places = (program.compiler.row(one.span) for one in skills if one.name == name)
    return next((f"at {place} " for place in places), "")


def _sends(program: Program | None, skill: str, event: str) -> bool:
    """Return whether a skill declares an event."""
    declared = None if program is None else program.library.skills.get(skill)
    return declared is not None and event in (declared.events or ())


def sources(history: History, told: Iterable[ToldEvent]) -> dict[int, Source]:
    """Return the source of each given change of a fact, by the serial of its event."""
    cycles = {one.serial: one.cycle for one in told}
    wanted = set(cycles.values())
    scanned = history.scan(
        *(*FACTS, *CAUSES),
        first=min(wanted, default=0),
        want=lambda one: one.cycle in wanted,
    )
    found = changes(history, scanned, lambda one: one.serial in cycles)
    return {one.serial: source for one, source in found}


def origins(
    history: History, found: Evidence, before: tuple[int, int]
) -> tuple[Origin, ...]:
    """Return the last assertion of each fact before a cycle and serial number."""

    def want(told: ToldEvent) -> bool:
        return told.keys["fact"] in found and (told.cycle, told.serial) < before

    last: dict[Fact, ToldEvent] = {}
    for told in history.log.backwards(events.FactAsserted):
        if len(last) == len(found):
            break
        if want(told):
            last.setdefault(told.keys["fact"], told)
    if len(last) < len(found) and not history.log.has(0):
        for told in history.scan(events.FactAsserted, want=want):
            last[told.keys["fact"]] = told
    known = sources(history, last.values())
    return tuple(_origin(fact, found[fact], last.get(fact), known) for fact in found)


def _origin(
    fact: Fact, since: Time | None, told: ToldEvent | None, known: dict[int, Source]
) -> Origin:
    if told is None:
        return Origin(fact, None if since is None else number(since), None, "")
    by, where, _ = known[told.serial]
    return Origin(fact, told.time, told.cycle, by, where)


def _source(
    program: Program | None,
    change: ToldEvent,
    chooser: int | None,
    rule: ToldEvent | None,
) -> Source:
    """Return the source of a change; `_HANDLER` if its cause follows later."""
    by = change.keys.get("by", _HANDLER)
    if by == "notation" and chooser is not None:
        return Source(f"notation [{chooser}]")
    if by != "rule" or rule is None:
        return Source(by)
    where = rule.keys["at"]
    if program is not None:
        where = _action_at(program, where, change) or where
    return Source(rule_in_words(rule), where, rule)


def rule_in_words(rule: ToldEvent) -> str:
    """Return a run of a rule as text: its task, and its signal or result."""
    what, task = rule.keys["what"], rule.keys["task"]
    text = what if isinstance(what, str) else format_list(what)
    return f"rule for {text}" if task is None else f"rule of [{task}] for {text}"


def _cause(told: ToldEvent) -> str:
    """Return as text a request that has ended, with its task, or a datum."""
    if told.kind is events.DataReceived:
        return f"datum {format_list(told.keys['data'])}"
    task = told.keys["task"]
    return format_list(told.keys["request"]) + ("" if task is None else f" [{task}]")


# --- rules in the text ----------------------------------------------------------------


def alternative_at(program: Program, row: str) -> nodes.Alternative | None:
    """Return the alternative of a rule at a file and line; see `events.RuleRun`."""
    library, row_of = program.library, program.compiler.row
    rules = [one for rule in library.memory_rules for one in alternatives(rule)]
    rules += [one for rule in library.event_rules for one in alternatives(rule)]
    return next((one for one in rules if row_of(one.span) == row), None)


def alternatives(
    rule: nodes.MemoryRule | nodes.EventRule,
) -> Iterator[nodes.Alternative]:
    """Yield the alternatives of a rule, in the order of the text."""
    owners = rule.cases if isinstance(rule, nodes.MemoryRule) else (rule,)
    for owner in owners:
        for one in owner.rules:
            yield from one.alternatives


def _action_at(program: Program, row: str, change: ToldEvent) -> str:
    """Return the file and line of the action of a rule that made a change."""
    alternative = alternative_at(program, row)
    fact: Fact = change.keys["fact"]
    # The assertion of a property erases the old value of the property.
    is_erased = change.kind is events.FactErased
    actions = () if alternative is None else alternative.actions
    for action in actions:
        if action.pattern.name == fact[0] and (is_erased or action.op == "mem-add"):
            return program.compiler.row(action.span)
    return ""
