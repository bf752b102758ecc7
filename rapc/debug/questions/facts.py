"""Questions about facts and items: their changes and their uses.

Times and sources of changes come from the events of the run up to the present moment.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from typing import NamedTuple

from rapc import events
from rapc.analysis.facts.index import Index
from rapc.base.values import (
    Fact,
    format_atom,
    format_list,
    match_pattern,
    readable,
)
from rapc.compiler.watches import WatchKey
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.history import History
from rapc.debug.log import ToldEvent, Want
from rapc.debug.questions.why import Origin, origins, source
from rapc.errors import ArgumentError
from rapc.library.signatures import Use
from rapc.world import Time

_FACTS = (events.FactAsserted, events.FactErased)
_ITEMS = (
    events.ItemIntroduced,
    events.ItemMerged,
    events.ItemMoved,
    events.ItemLost,
)
_CAUSES = (events.PrimitiveEnded, events.DataReceived, events.TaskSelected)


class _Change(NamedTuple):
    """A change of a fact or of an item."""

    time: Time
    cycle: int
    #: `+`, `-`, or the change of the item.
    what: str
    said: str
    #: The source: a request of a task, a datum, a notation, or the user.
    by: str


@question(
    "ITEM [PREDICATE] | FACT",
    ":history item-1",
    ":history item-1 color",
    ":history (truck-location ?)",
    of_recordings=True,
)
def history_(history: History, args: Arguments) -> Answer:
    """List the changes of a fact or an item, with their causes."""
    said = args.word("item or a fact")
    none = f"no changes of {said}"
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
    return table(("time", "cycle", "", "what", "by"), found, none=none)


def _names_of(history: History, name: str) -> set[str]:
    """Return all present names of an item."""
    if not history.is_run:
        merged = history.scan(events.ItemMerged)
        pairs = [{told.keys["item"], told.keys["with_"]} for told in merged]
        return {name}.union(*(pair for pair in pairs if name in pair))
    return {name} | history.run.memory.names_of(name)


def _changes(history: History, of_fact: Want, of_item: Want) -> list[_Change]:
    """Return the selected changes, each with its source."""
    found: list[_Change] = []
    open_since = 0
    chooser: int | None = None
    for told in history.scan(*_FACTS, *_ITEMS, *_CAUSES):
        if told.kind is events.TaskSelected:
            chooser, open_since = told.keys["task"], len(found)
        elif told.kind in (events.PrimitiveEnded, events.DataReceived):
            by = source(told)
            for at in range(open_since, len(found)):
                if found[at].by == "handler":
                    found[at] = found[at]._replace(by=by)
            open_since = len(found)
        elif told.kind in _FACTS:
            if of_fact(told):
                found.append(_of_fact(told, chooser))
        elif of_item(told):
            found.append(_of_item(told))
    return found


def _of_fact(told: ToldEvent, chooser: int | None) -> _Change:
    by = told.keys["by"]
    if by == "notation" and chooser is not None:
        by = f"notation [{chooser}]"
    sign = "+" if told.kind is events.FactAsserted else "-"
    return _Change(told.time, told.cycle, sign, format_list(told.keys["fact"]), by)


def _of_item(told: ToldEvent) -> _Change:
    keys, tag = told.keys, str(told.kind.__struct_config__.tag)
    said = f"{keys['item']} at {format_atom(keys['location'])}"
    if keys.get("with_") is not None:
        said += f", also {keys['with_']}"
        if keys.get("score") is not None:
            said += f", score {readable(keys['score'])}"
    what = tag.removeprefix("item-")
    return _Change(told.time, told.cycle, what, said, "handler")


# --- uses of a fact -----------------------------------------------------------------

_USES: tuple[Use, ...] = ("test", "believed", "asserted", "erased")
"""The uses of facts in a library: queries and changes."""


@question("FACT", ":who (truck-location depot)", ":who (location ?item external)")
def who(history: History, args: Arguments) -> Answer:
    """List the uses of a fact: assertions, queries and waiting tasks."""
    pattern = read_pattern(args.word("fact"))
    run, name = history.run, str(pattern[0])
    if name not in run.library.signatures.relations:
        raise ArgumentError(str(run.library.signatures.unknown("test", name)))
    stamps = {
        fact: since
        for fact, since in run.memory.facts(name).items()
        if match_pattern(pattern, fact[: len(pattern)]) is not None
    }
    found = origins(history, stamps, history.cycle + 1)
    rows = [*map(_believed, found), *_noted_by(history, stamps.keys())]
    rows += [*_listening(history, pattern), *_places(history, name)]
    return table(("use", "by", "where"), rows, none="no uses")


_Row = tuple[str, str, str]


def _believed(origin: Origin) -> _Row:
    since = "the start" if origin.time is None else readable(origin.time)
    by = f", by {origin.by}" if origin.by else ""
    how = "noted" if origin.by == "notation" else "believed"
    return how, format_list(origin.fact), f"since {since}{by}"


def _noted_by(history: History, facts: Set[Fact]) -> Iterator[_Row]:
    """Yield the methods under way that have noted one of the facts, by task."""
    for task in history.run.tasks():
        if not facts.isdisjoint(history.run.notations(task)):
            yield "noted by", f"[{task.number}]", ""


def _listening(history: History, pattern: Fact) -> Iterator[_Row]:
    """Yield the tasks with a monitor registered for changes of the fact."""
    entries = {entry.task: entry for entry in history.run.agenda()}
    for task in history.run.tasks():
        keys = () if task.wait is None else task.wait.keys or ()
        if any(_hears(key, pattern) for key in keys):
            entry = entries[task.number]
            yield "monitored by", f"[{entry.task}] {entry.goal}", entry.state


def _hears(key: WatchKey, pattern: Fact) -> bool:
    """Return whether a matching fact may concern the key of a listener."""
    if not isinstance(key, tuple) or key[0] != pattern[0]:
        return False
    if len(key) == 1 or int(str(key[1])) >= len(pattern):
        return True
    wanted = pattern[int(str(key[1]))]
    return str(wanted).startswith("?") or wanted == key[2]


def _places(history: History, name: str) -> Iterator[_Row]:
    """Yield the positions where the library queries or changes facts of a name."""
    program = history.library.program
    index = Index(program.library)
    for use in _USES:
        for one in index.uses_of(use, name):
            words = _words(type(one.owner).__name__)
            form = f"{words} {getattr(one.owner, 'name', '')}".strip()
            yield use, form, program.compiler.row(one.span)


def _words(name: str) -> str:
    """Return the name of a node class in the notation of the language."""
    return "".join(f"-{c.lower()}" if c.isupper() else c for c in name).lstrip("-")
