"""Tables of events, debugger commands, options of worlds, and the grammar."""

from __future__ import annotations

import inspect
from importlib import import_module

import msgspec

from generator.markdown import sentence, table
from generator.python import plain
from rapc import events
from rapc.base.values import typed
from rapc.debug.breakpoints import KINDS
from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import heads, rules_by_head, spelling
from rapc.language.shapes import leaves
from rapc.repl.commands.table import commands
from rapc.worlds import registry


def events_of(*names: str) -> str:
    """Return the table of some kinds of events, or of the keys that all have."""
    kinds = events.kinds()
    common = {field.encode_name for field in msgspec.structs.fields(events.Event)}
    rows = []
    for name in names:
        kind = kinds[name]
        keys = [f"`{key}`" for key in events.keys(kind) if key not in common]
        doc = inspect.cleandoc(kind.__doc__ or "").replace("\n\n", " ")
        rows.append((f'<a id="{name}"></a>`{name}`', ", ".join(keys), plain(doc)))
    return table(("event", "keys", "meaning"), rows)


def debugger_commands() -> str:
    """Return a table of the commands of the debugger for each group."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for one in commands():
        usage = f"`:{one.name}{' ' * bool(one.takes)}{one.takes}`"
        groups.setdefault(one.group, []).append((usage, f"{one.doc} {one.more}"))
    return "\n".join(
        f"### {sentence(group)[:-1]}\n\n{table(('command', 'meaning'), rows)}"
        for group, rows in groups.items()
    )


def breakpoints() -> str:
    """Return the table of the kinds of breakpoints."""
    return table(
        ("kind", "stops when"), [(f"`{name}`", doc) for name, doc in KINDS.items()]
    )


def world_options(name: str) -> str:
    """Return the table of the options of a world."""
    rows = []
    for option in registry.find_world(name).kit.options:
        said = f"{typed(option.default) or 'none'} {option.unit}".strip()
        rows.append((f"`{option.name}`", said, option.doc))
    return table(("option", "default", "meaning"), rows)


def skills(module: str) -> str:
    """Return the table of the skills in the catalogue of a module."""
    known = import_module(module).catalogue()
    rows = []
    for skill in map(known.describe, known.entries):
        units = [f"{p.name} ({p.unit})" if p.unit else p.name for p in skill.parameters]
        told = ", ".join(f"`{name}`" for name in skill.events)
        used = ", ".join(skill.uses)
        rows.append(
            (f"`{skill.name}`", ", ".join(units), sentence(skill.doc), told, used)
        )
    return table(("skill", "arguments", "effect", "events", "uses"), rows)


def skill_events(module: str) -> str:
    """Return the table of the events of these skills."""
    rows = []
    for name, event in import_module(module).catalogue().events.items():
        carried = ", ".join(parameter.name for parameter in event.carries)
        doc = inspect.cleandoc(event.__doc__ or "").partition("\n\n")[0]
        rows.append((f"`{name}`", carried, plain(doc)))
    return table(("event", "arguments", "meaning"), rows)


def grammar(group: str) -> str:
    """Return the table of the lists in a group of the grammar.

    Lists that may occur repeatedly beside others that occur once are marked *.
    """
    once = [rule for name in leaves(RULES[group]) for rule in _once(name)]
    rows = []
    for rule in _listed(group):
        row = GRAMMAR[rule]
        said = f"{row.says}; {row.more}" if row.more else row.says
        mark = " *" if once and rule not in once else ""
        rows.append((f"`{spelling(rule)}`{mark}", said))
    return table((group.rpartition("_")[2], "meaning"), rows)


def vocabulary(title: str, *groups: str) -> str:
    """Return a table of words of the language, with links to its chapters."""
    rows = []
    for rule in dict.fromkeys(rule for group in groups for rule in _listed(group)):
        [link] = GRAMMAR[rule].pages
        page, _, anchor = link.rpartition("/")[2].partition("#")
        chapter = page[0] if page[0].isdecimal() else page.removesuffix(".md")
        shown = anchor if anchor[:1].isdecimal() else chapter
        rows.append((f"`{spelling(rule)}`", GRAMMAR[rule].says, f"[{shown}]({link})"))
    return table((title, "meaning", "see"), rows)


def _listed(group: str) -> list[str]:
    """Return the lists in a group of the grammar; for another rule, the rule."""
    if RULES[group][0] != "or":
        return [group]
    return [*dict.fromkeys(rules_by_head(group).values()) | _headless(group)]


def _once(name: str) -> list[str]:
    """Return the rules of a group that occur once in a form."""
    return list(leaves(RULES[name])) if name.startswith("_once") else []


def _headless(group: str) -> dict[str, None]:
    """Return the lists of a group without a first word, for example `protect`."""
    lists = [rule for rule in leaves(RULES[group]) if rule[0] != "_"]
    return dict.fromkeys(rule for rule in lists if not heads(rule))
