"""Questions about facts and items: their changes and their uses.

Times and sources of changes come from the events of the run up to the present moment.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence, Set
from contextlib import suppress
from typing import NamedTuple, get_args

from msgspec.structs import replace

from rapc import events
from rapc.analysis.facts.index import Index
from rapc.base.names import plural
from rapc.base.values import (
    Fact,
    format_atom,
    format_list,
    match_pattern,
    readable,
)
from rapc.compiler.watches import WatchKey
from rapc.debug.answer import Answer, in_pairs, question, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.history import History
from rapc.debug.log import ToldEvent, Want
from rapc.debug.names import (
    definition_in_words,
    definitions,
    names_of,
    predicates,
)
from rapc.debug.sources import (
    CAUSES,
    FACTS,
    alternative_at,
    alternatives,
    changes,
    origins,
    rule_in_words,
)
from rapc.errors import ArgumentError
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.library.library import Named
from rapc.library.signatures import Use
from rapc.runtime.memory.access import Evidence
from rapc.runtime.snapshot import AgendaEntry
from rapc.world import Time

_ITEMS = (
    events.ItemIntroduced,
    events.ItemMerged,
    events.ItemMoved,
    events.ItemLost,
)


class _Change(NamedTuple):
    """A change of a fact or of an item."""

    time: Time
    cycle: int
    #: `+`, `-`, or the change of the item.
    what: str
    said: str
    #: The source: a request of a task, a datum, a rule, a notation, or the user.
    by: str
    #: The file and line of a rule.
    where: str = ""


@question(
    "ITEM [PREDICATE] | FACT | QUERY | NAME | FILE:LINE",
    ":history item-1",
    ":history item-1 color",
    ":history (truck-location ?)",
    ":history fill-order",
    of_recordings=True,
)
def history_(history: History, args: Arguments) -> Answer:
    """List the changes of a fact or an item, with their causes.

    For a query, list the changes of the facts that the query reads; for a rule, its
    runs; for a RAP or an agenda, the creation and the end of its tasks.
    """
    said = args.word("item or a fact")
    none = f"no changes of {said}"
    forms = _defined(history, said)
    if forms:
        return _of_forms(history, forms, none)
    if said.startswith("("):
        pattern = read_pattern(said)
        size = len(pattern)

        def about(told: ToldEvent) -> bool:
            fact = told.keys["fact"]
            return len(fact) >= size and match_pattern(pattern, fact[:size]) is not None

        found = _changes(history, about, lambda told: False)
    else:
        predicate = args.word("predicate").lower() if args else ""
        names = _names_of(history, said.lower())

        def names_it(told: ToldEvent) -> bool:
            name, *values = told.keys["fact"]
            texts = [part for part in values if type(part) is str]
            return predicate in ("", name) and not names.isdisjoint(texts)

        found = _changes(
            history,
            names_it,
            lambda told: not predicate and told.keys["item"] in names,
        )
        none += f"; for a fact, use `:history ({said})`"
    return table(_CHANGED, found, none=none)


_CHANGED = ("time", "cycle", "", "what", "by", "where")

_TRACKED = (
    *(nodes.DefineQuery, nodes.DefineRap, nodes.DefineAgenda),
    *(nodes.MemoryRule, nodes.EventRule),
)
"""The definitions with a history of their own."""


def _defined(history: History, said: str) -> list[Named]:
    """Return the definitions with a history that a text names; none for a fact."""
    if not history.is_run:
        return []
    program, name = history.library.program, said.strip("()").partition(" ")[0]
    if name.lower() in program.signatures.relations:
        return []
    with suppress(ArgumentError):
        found = definitions(program, said)
        return [form for form in found if isinstance(form, _TRACKED)]
    return []


def _of_forms(history: History, forms: Sequence[Named], none: str) -> Answer:
    program = history.library.program
    found: list[_Change] = []
    for form in forms:
        if isinstance(form, nodes.DefineQuery):
            names = predicates(program.library, form.formula)

            def reads(told: ToldEvent, names: Container[object] = names) -> bool:
                return told.keys["fact"][0] in names

            found += _changes(history, reads, lambda told: False)
        elif isinstance(form, nodes.MemoryRule | nodes.EventRule):
            found += _runs_of(history, form)
        elif isinstance(form, nodes.DefineRap):
            found += _tasks_of(history, [form.name], top=False)
        elif isinstance(form, nodes.DefineAgenda):
            names_ = [task.goal.name for task in form.tasks]
            found += _tasks_of(history, names_, top=True)
    found.sort(key=lambda one: one.cycle)
    return table(_CHANGED, found, none=none)


def _runs_of(
    history: History, rule: nodes.MemoryRule | nodes.EventRule
) -> Iterator[_Change]:
    """Yield the runs of a rule, each with its bindings."""
    row = history.library.program.compiler.row
    places = {row(one.span) for one in alternatives(rule)}
    for told in history.scan(events.RuleRun):
        if told.keys["at"] in places:
            by, where = rule_in_words(told), told.keys["at"]
            said = in_pairs(told.keys["bindings"])
            yield _Change(told.time, told.cycle, "ran", said, by, where)


_OF_TASKS = (
    *(events.TaskCreated, events.TaskSucceeded),
    *(events.TaskFailed, events.TaskRemoved),
)


def _tasks_of(
    history: History, names: Container[str], *, top: bool
) -> Iterator[_Change]:
    """Yield the creation and the end of the tasks of some RAPs."""
    goals: dict[int, str] = {}
    for told in history.scan(*_OF_TASKS):
        keys, task, by = told.keys, told.keys["task"], ""
        if told.kind is events.TaskCreated:
            parent = keys["parent"]
            if keys["goal"].name not in names or (top and parent is not None):
                continue
            goals[task] = str(keys["goal"])
            by = "" if parent is None else f"[{parent}]"
        elif task not in goals:
            continue
        by = str(keys.get("result") or keys.get("cause") or by)
        what = str(told.kind.__struct_config__.tag).removeprefix("task-")
        said = f"[{task}] {goals[task]}"
        yield _Change(told.time, told.cycle, what, said, by)


def _names_of(history: History, name: str) -> set[str]:
    """Return all present names of an item."""
    if not history.is_run:
        merged = history.scan(events.ItemMerged)
        pairs = [{told.keys["item"], told.keys["with_"]} for told in merged]
        return {name}.union(*(pair for pair in pairs if name in pair))
    return {name} | history.run.memory.names_of(name)


def _changes(history: History, of_fact: Want, of_item: Want) -> list[_Change]:
    """Return the selected changes, each with its source."""

    def wanted(told: ToldEvent) -> bool:
        return of_fact(told) if told.kind in FACTS else of_item(told)

    scanned = history.scan(*FACTS, *_ITEMS, *CAUSES)
    return [
        _Change(told.time, told.cycle, *_change_in_words(told), source.by, source.where)
        for told, source in changes(history, scanned, wanted)
    ]


def _change_in_words(told: ToldEvent) -> tuple[str, str]:
    """Return the kind and the text of a change of a fact or of an item."""
    keys = told.keys
    if told.kind in FACTS:
        sign = "+" if told.kind is events.FactAsserted else "-"
        return sign, format_list(keys["fact"])
    said = f"{keys['item']} at {format_atom(keys['location'])}"
    if keys.get("with_") is not None:
        said += f", also {keys['with_']}"
        if keys.get("score") is not None:
            said += f", score {readable(keys['score'])}"
    tag = str(told.kind.__struct_config__.tag)
    return tag.removeprefix("item-"), said


# --- uses of a fact -----------------------------------------------------------------

_USES: tuple[Use, ...] = ("test", "believed", "asserted", "erased")
"""The uses of facts in a library: queries and changes."""


@question(
    "FACT [in CYCLE] | QUERY | NAME | FILE:LINE",
    ":who (truck-location depot)",
    ":who (truck-location ?) in 40",
    ":who (location ?item external)",
    ":who fill-order",
)
def who(history: History, args: Arguments) -> Answer:
    """List the uses of a fact: assertions, queries and waiting tasks.

    With a cycle, list only the changes in this cycle, with the rule, the request or the
    task that made each change and the facts behind a rule. For a query, a RAP, a rule
    or an agenda, list its uses.
    """
    said = args.word("fact or name")
    program = history.run.library
    if said.startswith("("):
        pattern = read_pattern(said)
        name = str(pattern[0])
        if name in program.signatures.relations:
            if args.takes("in"):
                return _changed_in(history, pattern, args.count("cycle"))
            return table(_USED, _of_fact(history, pattern), none="no uses")
        if name not in program.library.queries:
            raise ArgumentError(str(program.signatures.unknown("test", name)))
    rows = [
        row
        for form in definitions(program, said)
        for row in _of_definition(history, form)
    ]
    return table(_USED, rows, none="no uses")


_USED = ("use", "what", "since", "by", "where")

_Row = tuple[str, str, Time | str | None, str, str]


def _of_fact(history: History, pattern: Fact) -> Iterator[_Row]:
    run, name = history.run, str(pattern[0])
    stamps = {
        fact: since
        for fact, since in run.memory.facts(name).items()
        if match_pattern(pattern, fact[: len(pattern)]) is not None
    }
    for origin in origins(history, stamps, (history.cycle + 1, 0)):
        use = "noted" if origin.by.startswith("notation") else "believed"
        since = "the start" if origin.time is None else origin.time
        yield use, format_list(origin.fact), since, origin.by, origin.where
    yield from _noted_by(history, stamps.keys())
    yield from _listening(history, pattern)
    yield from _places(history, _USES, name)


def _noted_by(history: History, facts: Set[Fact]) -> Iterator[_Row]:
    """Yield the methods under way that have noted one of the facts, by task."""
    for task in history.run.tasks():
        if not facts.isdisjoint(history.run.notations(task)):
            yield "noted by", f"[{task.number}]", None, "", ""


def _listening(history: History, pattern: Fact) -> Iterator[_Row]:
    """Yield the tasks with a monitor registered for changes of the fact."""
    entries = {entry.task: entry for entry in history.run.agenda()}
    for task in history.run.tasks():
        keys = () if task.wait is None else task.wait.keys or ()
        if any(_hears(key, pattern) for key in keys):
            yield _monitoring(entries[task.number])


def _monitoring(entry: AgendaEntry) -> _Row:
    return "monitored by", f"[{entry.task}] {entry.goal}, {entry.state}", None, "", ""


def _hears(key: WatchKey, pattern: Fact) -> bool:
    """Return whether a matching fact may concern the key of a listener."""
    if not isinstance(key, tuple) or key[0] != pattern[0]:
        return False
    if len(key) == 1 or int(str(key[1])) >= len(pattern):
        return True
    wanted = pattern[int(str(key[1]))]
    return str(wanted).startswith("?") or wanted == key[2]


def _places(history: History, uses: Sequence[Use], name: str) -> Iterator[_Row]:
    """Yield the positions where the library uses a name in some ways."""
    program = history.library.program
    index = Index(program.library)
    for use in uses:
        for one in index.uses_of(use, name):
            form = definition_in_words(one.owner)
            yield use, form, None, "", program.compiler.row(one.span)


# --- changes in a cycle -------------------------------------------------------------


def _changed_in(history: History, pattern: Fact, cycle: int) -> Answer:
    """Return the changes of matching facts in a cycle, with the facts behind rules."""

    def wanted(told: ToldEvent) -> bool:
        if told.kind not in FACTS:
            return False
        return match_pattern(pattern, told.keys["fact"][: len(pattern)]) is not None

    scanned = history.scan(
        *(*FACTS, *CAUSES), first=cycle, want=lambda one: one.cycle == cycle
    )
    rows: list[tuple[object, ...]] = []
    found = changes(history, scanned, wanted)
    for at, (told, source) in enumerate(found, 1):
        sign, fact = _change_in_words(told)
        rows.append((sign, fact, told.time, source.by, source.where))
        rule = source.rule
        if rule is not None and all(one.rule is not rule for _, one in found[at:]):
            supports = behind(history, rule)
            for one in origins(history, supports, (cycle, rule.serial)):
                fact = f"  {format_list(one.fact)}"
                rows.append(("", fact, one.time, one.by, one.where))
    none = f"no change in cycle {cycle}"
    if not rows:
        last = history.last(
            *FACTS, want=lambda told: told.cycle < cycle and wanted(told)
        )
        if last is not None:
            found_before = _changed_in(history, pattern, last.cycle)
            lines = (f"{none}; the last change was in cycle {last.cycle}:",)
            return replace(found_before, lines=lines)
    return table(("", "what", "since", "by", "where"), rows, none=none)


def behind(history: History, rule: ToldEvent) -> Evidence:
    """Return the facts that made the query of a rule true, as the rule ran."""
    found: Evidence = {}
    alternative = alternative_at(history.library.program, rule.keys["at"])

    def hear(told: ToldEvent) -> None:
        if told.serial == rule.serial and alternative is not None:
            bound = rule.keys["bindings"]
            found.update(history.run.supporting(alternative.query, bound))

    history.repeat(rule.cycle, hear)
    return found


# --- uses of a definition -------------------------------------------------------------


def _of_definition(history: History, form: Named) -> Iterator[_Row]:
    program, name = history.library.program, names_of(form)[0]
    where = program.compiler.row(form.span)
    yield "defined", definition_in_words(form), None, "", where
    if isinstance(form, nodes.DefineQuery):
        yield from _monitoring_query(history, name)
        yield from _places(history, ("test",), name)
    elif isinstance(form, nodes.DefineRap):
        yield from _live(history, [name])
        yield from _places(history, ("goal",), name)
    elif isinstance(form, nodes.DefineAgenda):
        yield from _live(history, [task.goal.name for task in form.tasks], top=True)
        for task in form.tasks:
            where = program.compiler.row(task.span)
            yield "submits", format_node(task), None, "", where
    elif isinstance(form, nodes.MemoryRule | nodes.EventRule):
        yield from _runs(history, form)
    else:
        yield from _places(history, get_args(Use), name)


def _monitoring_query(history: History, name: str) -> Iterator[_Row]:
    """Yield the tasks with a monitor that uses a named query."""
    library = history.library.program.library
    entries = {entry.task: entry for entry in history.run.agenda()}
    for task in history.run.tasks():
        monitor = task.plan.clauses.get("monitor-state")
        if monitor is not None and name in predicates(library, monitor.formula):
            yield _monitoring(entries[task.number])


def _live(history: History, names: list[str], *, top: bool = False) -> Iterator[_Row]:
    """Yield the live tasks of some RAPs."""
    for entry in history.run.agenda():
        if entry.goal.name in names and not (top and entry.parent is not None):
            yield "task", f"[{entry.task}] {entry.goal}, {entry.state}", None, "", ""


def _runs(history: History, rule: nodes.MemoryRule | nodes.EventRule) -> Iterator[_Row]:
    """Yield each alternative of a rule with the number and the last of its runs."""
    row = history.library.program.compiler.row
    ran: dict[str, list[ToldEvent]] = {}
    for told in history.scan(events.RuleRun):
        ran.setdefault(told.keys["at"], []).append(told)
    for alternative in alternatives(rule):
        where = row(alternative.span)
        found = ran.get(where, [])
        last = found[-1].time if found else None
        actions = " ".join(format_node(action) for action in alternative.actions)
        yield f"ran {plural(len(found), 'time')}", actions, last, "", where
