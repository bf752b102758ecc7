"""Write the parts of the manual that have a source in the code.

    python docs/generate.py            write all stale pages
    python docs/generate.py --check    list the stale pages; exit status 1 if any
    python docs/generate.py --words    count the words written by hand, code included

A page may have generated parts:

    <!-- generated: NAME WORD... -->
    ...
    <!-- end -->

`PARTS` lists the names. Graphviz draws the figures (`FIGURES`). The front page and the
page of each rule are generated as a whole (`pages`), and so is the navigation of the
site in mkdocs.yml.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import inspect
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from html import escape
from importlib import import_module
from itertools import pairwise, takewhile
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import msgspec
from click.testing import CliRunner
from cycle import cycle

from rapc import events
from rapc.analysis.registry import rules
from rapc.base.diagnostics import Rule
from rapc.cli.main import COMMANDS, cli
from rapc.cli.options import HELP
from rapc.cli.rule import advice
from rapc.debug.breakpoints import KINDS
from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import heads, rules_by_head, spelling
from rapc.language.shapes import leaves
from rapc.repl.commands.table import commands
from rapc.runtime.settings import Settings
from rapc.worlds import registry

DOCS = Path(__file__).parent
ROOT = DOCS.parent
CONFIG = ROOT / "mkdocs.yml"

# --- Markdown -----------------------------------------------------------------------


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table; line ends and `|` in cells are replaced."""
    titles = [*head]
    lines = [titles, ["---"] * len(titles), *rows]
    return "".join(f"| {' | '.join(map(_cell, cells))} |\n" for cells in lines).replace(
        "| --- ", "|---"
    )


def _cell(text: str) -> str:
    """Return the text of a cell; code with `|` becomes HTML, which all sites read."""

    def code(found: re.Match[str]) -> str:
        plain = escape(found[1].replace("\\|", "|"), quote=False)
        return f"<code>{plain.replace('|', '&#124;')}</code>"

    return re.sub(r"`([^`|]*\|[^`]*)`", code, " ".join(text.split()))


def _code(text: str) -> str:
    return f"`{text}`" if text else ""


def block(language: str, text: str) -> str:
    """Return a fenced block of code."""
    return f"```{language}\n{text.rstrip()}\n```\n"


def sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop."""
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


# --- Sources ------------------------------------------------------------------------


class Notes(dict[str, str]):
    """The comments and docstrings of the fields or names in a class or module."""

    @classmethod
    def of(cls, owner: type | ModuleType) -> Notes:
        """Return the notes of a class, with its constructor, or of a module."""
        text = inspect.cleandoc("\n" + inspect.getsource(owner))
        lines, body = text.splitlines(), ast.parse(text).body
        bodies = [body]
        if isinstance(owner, type) and isinstance(body[0], ast.ClassDef):
            made = [s for s in body[0].body if isinstance(s, ast.FunctionDef)]
            bodies = [body[0].body, *(s.body for s in made if s.name == "__init__")]
        found = cls()
        for statements in bodies:
            for one, after in pairwise([*statements, ast.Pass()]):
                if name := _assigned(one):
                    note = _above(lines[: one.lineno - 1]) or _below(after)
                    found[name] = note or found.get(name, "")
        return found


def _above(lines: list[str]) -> str:
    """Return the comment of the kind `#:` at the end of some lines."""
    stripped = [line.strip() for line in reversed(lines)]
    said = takewhile(lambda line: line.startswith("#:"), stripped)
    return " ".join(line[2:].strip() for line in [*said][::-1])


def _below(after: ast.stmt) -> str:
    """Return the docstring after an assignment."""
    if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
        return str(after.value.value)
    return ""


def _assigned(statement: ast.stmt) -> str | None:
    """Return the name of the field or the attribute that a statement assigns."""
    if isinstance(statement, ast.AnnAssign):
        target: ast.expr = statement.target
    elif isinstance(statement, ast.Assign):
        target = statement.targets[0]
    else:
        return None
    if isinstance(target, ast.Attribute):
        return target.attr
    return target.id if isinstance(target, ast.Name) else None


# --- Command line -------------------------------------------------------------------


def _context(name: str) -> click.Context:
    top = click.Context(cli, info_name="rapc")
    if name == "rapc":
        return top
    found = cli.get_command(top, name)
    assert found is not None, name
    return click.Context(found, info_name=name, parent=top, **HELP)


def _options(name: str) -> dict[str, str]:
    """Return the options of a command with their help."""
    context = _context(name)
    options = [
        option
        for option in context.command.get_params(context)
        if isinstance(option, click.Option)
    ]
    records = [option.get_help_record(context) for option in options]
    return {f"`{record[0]}`": record[1] for record in records if record}


def common_options() -> str:
    """Return the table of the options that all commands have."""
    shared = [_options(name) for name in COMMANDS]
    return table(
        ("option", "meaning"),
        [row for row in shared[0].items() if all(row in one.items() for one in shared)],
    )


def command(name: str) -> str:
    """Return usage, help, options and examples of a command."""
    context = _context(name)
    help_ = inspect.cleandoc(context.command.help or "").replace("\b\n", "")
    epilog = (context.command.epilog or "").replace("\b", "").replace("Examples:", "")
    examples = inspect.cleandoc(epilog)
    common = {
        row
        for row in _options(name).items()
        if all(row in _options(other).items() for other in COMMANDS)
    }
    rows = [row for row in _options(name).items() if row not in common]
    usage = " ".join(context.get_usage().removeprefix("Usage:").split())
    parts = [
        block("text", usage),
        "\n".join(line.strip() for line in help_.splitlines()) + "\n",
        table(("option", "meaning"), rows) if rows else "",
        block("sh", examples) if examples else "",
    ]
    return "\n".join(filter(None, parts))


LIMITS: Mapping[str, tuple[str, str]] = {
    "bytes of a file of RAP text": ("rapc.base.limits", "MAX_BYTES"),
    "characters of a name": ("rapc.base.limits", "MAX_NAME"),
    "characters of a number": ("rapc.base.limits", "MAX_NUMBER"),
    "levels of lists in a text": ("rapc.base.limits", "MAX_DEPTH"),
    "propositions and tests in a formula": ("rapc.base.limits", "MAX_LEAVES"),
    "findings reported for a file": ("rapc.base.limits", "MAX_FINDINGS"),
    "initial facts of a world": ("rapc.runtime.held_world", "MOST_FACTS"),
    "time of the clock": ("rapc.runtime.held_world", "LATEST"),
    "cycles of a test without `until`": ("rapc.testing.run", "MOST_CYCLES"),
    "time of a test without `until`": ("rapc.testing.run", "LATEST"),
    "seeds of an experiment": ("rapc.experiments.definition", "MOST_SEEDS"),
}
"""The limits that a user can reach, each with the module and name of its value."""


def limits() -> str:
    """Return the table of limits."""
    values = {
        what: getattr(import_module(module), name)
        for what, (module, name) in LIMITS.items()
    }
    rows = [(what, f"{value:,}") for what, value in values.items()]
    return table(("limit", "highest value"), rows)


def formats() -> str:
    """Return the table of the versions of file formats."""
    homes = {
        "compiled library": ("rapc.library.saved", "FORMAT"),
        "saved run": ("rapc.runtime.saving.format", "FORMAT"),
        "trace": ("rapc.runtime.interpreter", "TRACE_FORMAT"),
        "results of experiments": ("rapc.experiments.store", "FORMAT"),
    }
    rows = [
        (what, str(getattr(import_module(module), name)))
        for what, (module, name) in homes.items()
    ]
    return table(("format", "version"), rows)


def settings() -> str:
    """Return the table of the settings of the interpreter."""
    notes = Notes.of(Settings)
    rows = [
        (f"`rapc.{name}`", f"`{str(value).lower()}`", notes[name.replace("-", "_")])
        for name, value in Settings().named().items()
    ]
    return table(("setting", "default", "meaning"), rows)


# --- Python -------------------------------------------------------------------------

_REFERENCE = re.compile(r" ?\[[TSL] [^\]]*\]")
"""A reference to a source: `[T 3.3]`."""

_PART = re.compile(r"^(Args|Returns|Yields|Raises):$", re.M)


def api(module: str) -> str:
    """Return the reference of the public names of a module."""
    home = import_module(module)
    names = [name for name in home.__all__ if name != "__version__"]
    names.sort(key=lambda name: _order(getattr(home, name)))
    return "\n".join(filter(None, [_name(home, name) for name in names]))


def _order(found: object) -> int:
    """Return the position of functions, classes, errors and other names."""
    if isinstance(found, type):
        return 2 if issubclass(found, Exception) else 1
    return 0 if inspect.isfunction(found) else 3


def _name(home: ModuleType, name: str) -> str:
    found = getattr(home, name)
    if isinstance(found, ModuleType):
        return ""
    title = f"### {name}\n\n"
    if not isinstance(found, type):
        return title + (
            _function(name, found) if inspect.isfunction(found) else _value(home, name)
        )
    if found.__module__ == "builtins" or not found.__module__.startswith("rapc"):
        return title + _value(home, name)
    if found.__name__ != name:
        return title + _value(home, name)
    return title + _class(found)


def _value(home: ModuleType, name: str) -> str:
    """Return the note of a name that is no function and no class."""
    for statement in ast.parse(inspect.getsource(home)).body:
        if isinstance(statement, ast.ImportFrom) and any(
            alias.name == name for alias in statement.names
        ):
            home = import_module(str(statement.module))
    return f"{_plain(Notes.of(home).get(name, ''))}\n"


def _class(found: type) -> str:
    parts = [_doc(inspect.cleandoc(found.__doc__ or ""))]
    notes = Notes.of(found)
    fields = getattr(found, "__struct_fields__", notes)
    structured = hasattr(found, "__struct_fields__")
    types = getattr(found, "__annotations__", {})
    rows = [
        (f"`{name}`", _code(types.get(name, "")), _plain(notes.get(name, "")))
        for name in fields
        if name[0] != "_" and (structured or notes[name])
    ]
    base = issubclass(found, BaseException)
    if rows and not base:
        parts.append(table(("field", "type", "meaning"), rows))
    for name, own in vars(found).items():
        member = own.__func__ if isinstance(own, classmethod) else own
        if name.startswith("_") or not getattr(member, "__doc__", None):
            continue
        if inspect.isfunction(member):
            parts.append(f"#### {found.__name__}.{name}\n\n{_function(name, member)}")
        elif isinstance(member, property):
            text = _doc(inspect.cleandoc(member.__doc__ or ""))
            parts.append(f"#### {found.__name__}.{name}\n\n{text}")
    return "\n".join(filter(None, parts))


class _Annotation(str):
    """An annotation that a signature shows without quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def _function(name: str, function: Callable[..., Any]) -> str:
    signature = inspect.signature(function)
    parameters = [
        parameter.replace(annotation=_annotation(parameter.annotation))
        for parameter in signature.parameters.values()
        if parameter.name not in ("self", "cls")
    ]
    returned = _annotation(signature.return_annotation)
    signature = signature.replace(parameters=parameters, return_annotation=returned)
    text = block("py", _folded(name, str(signature)))
    return f"{text}\n{_doc(inspect.cleandoc(function.__doc__ or ''))}"


def _annotation(found: object) -> object:
    return _Annotation(found) if isinstance(found, str) else found


def _folded(name: str, signature: str, width: int = 76) -> str:
    """Return a signature with a line for each parameter if it is long."""
    if len(name + signature) <= width:
        return name + signature
    inside, _, result = signature[1:].rpartition(")")
    depth = 0
    lines = [""]
    for letter in inside:
        depth += {"[": 1, "(": 1, "]": -1, ")": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            lines.append("")
        else:
            lines[-1] += letter
    return f"{name}(\n" + "".join(f"    {p.strip()},\n" for p in lines) + f"){result}"


def _doc(text: str) -> str:
    """Return a docstring as Markdown: its parts as lists."""
    before, *parts = _PART.split(_plain(text))
    found = [before.strip()]
    for title, part in zip(parts[::2], parts[1::2], strict=True):
        body, _, after = inspect.cleandoc(f"\n{part}").partition("\n\n")
        entries = [" ".join(e.split()) for e in re.split(r"\n(?=\S)", body)]
        items = [re.sub(r"^([\w*]+): ", r"`\1`: ", entry) for entry in entries if entry]
        found.append(f"{title}:\n\n" + "\n".join(f"- {item}" for item in items))
        if after:
            found.append(after)
    return "\n\n".join(filter(None, found)) + "\n"


def _plain(text: str) -> str:
    return _REFERENCE.sub("", text)


# --- Events, commands of the debugger, worlds, grammar ------------------------------


def events_of(*names: str) -> str:
    """Return the table of some kinds of events, or of the keys that all have."""
    kinds = events.kinds()
    common = {field.encode_name for field in msgspec.structs.fields(events.Event)}
    rows = []
    for name in names:
        kind = kinds[name]
        keys = [f"`{key}`" for key in events.keys(kind) if key not in common]
        doc = inspect.cleandoc(kind.__doc__ or "").replace("\n\n", " ")
        rows.append((f'<a id="{name}"></a>`{name}`', ", ".join(keys), _plain(doc)))
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
        default = str(option.default)
        if isinstance(option.default, bool):
            default = default.lower()
        said = f"{default or 'none'} {option.unit}".strip()
        rows.append((f"`{option.name}`", said, option.doc))
    return table(("option", "default", "meaning"), rows)


def grammar(group: str) -> str:
    """Return the table of the lists in a group of the grammar.

    Lists that may occur repeatedly beside others that occur once are marked *.
    """
    once = [rule for name in leaves(RULES[group]) for rule in _once(name)]
    listed = [*dict.fromkeys(rules_by_head(group).values()) | _headless(group)]
    titles = [group.rpartition("_")[2], "meaning"]
    paged = any(GRAMMAR[rule].pages for rule in listed)
    rows = []
    for rule in listed:
        row = GRAMMAR[rule]
        links = ", ".join(f"[{page[0]}]({page})" for page in row.pages)
        said = f"{row.says}; {row.more}" if row.more else row.says
        mark = " *" if once and rule not in once else ""
        rows.append([f"`{spelling(rule)}`{mark}", said] + [links] * paged)
    return table(titles + ["chapter"] * paged, rows)


def _once(name: str) -> list[str]:
    """Return the rules of a group that occur once in a form."""
    return list(leaves(RULES[name])) if name.startswith("_once") else []


def _headless(group: str) -> dict[str, None]:
    """Return the lists of a group without a first word, for example `protect`."""
    lists = [rule for rule in leaves(RULES[group]) if rule[0] != "_"]
    return dict.fromkeys(rule for rule in lists if not heads(rule))


# --- Measurements -------------------------------------------------------------------


def targets() -> str:
    """Return the place of the last measurement and the table of its targets."""
    beside = _bench("beside")
    return f"{beside.told(beside.read(beside.FIGURES / 'beside.json')).rstrip()}\n"


def profiles() -> str:
    """Return the profiles of the last measurement."""
    beside = _bench("beside")
    return block("text", beside.read(beside.FIGURES / "beside.json").profiles)


def _bench(name: str) -> ModuleType:
    """Return a module of the benches, which are not installed."""
    if str(ROOT) not in sys.path:
        sys.path.append(str(ROOT))
    return import_module(f"bench.{name}")


def slips() -> str:
    """Return the sums of slips and, for each group, the slips that are found."""
    counts = msgspec.json.decode((DOCS / "figures" / "slips.json").read_bytes())
    numbers = ("made", "found", "named", "single")
    groups: dict[str, list[tuple[str, ...]]] = {}
    for row in counts["kinds"]:
        remark = f" ({row['remark']})" if row["remark"] else ""
        links = [f"[{n}](../reference/rules/{n}.md)" for n in row["rules"]]
        cells = (*(str(row[number]) for number in numbers), ", ".join(links))
        groups.setdefault(row["group"], []).append((row["slip"] + remark, *cells))
    head = ("slip", "made", "found", "named", "single", "rules")
    tables = [
        f"### {sentence(group)[:-1]}\n\n{table(head, rows)}"
        for group, rows in groups.items()
    ]
    sure = [row for row in counts["kinds"] if not row["remark"]]
    made, found, named, single = (sum(r[n] for r in sure) for n in numbers)
    return (
        f"{counts['each']} slips at most of each kind. The {len(sure)} kinds without a "
        f"remark: {made} slips, {found} found; the cause is named for {named}, and "
        f"{single} have a single finding. {counts['idle']} further slips of all kinds "
        "were not found and changed no trace.\n\n" + "\n".join(tables)
    )


# --- Whole pages --------------------------------------------------------------------

NOTE = "<!-- written by docs/generate.py from {} -->\n\n"
"""The first line of a page that is generated as a whole."""


def rule_index() -> str:
    """Return the table of all rules; each row has the name of its rule as anchor."""
    rows = [
        (
            f'<a id="{rule.name}"></a>[{rule.name}](rules/{rule.name}.md)',
            f"{rule.code}, {rule.severity.word}{', opt-in' * rule.opt_in}",
            rule.summary,
        )
        for rule in rules().values()
    ]
    return table(("rule", "code, severity", "finding"), rows)


def rule_page(rule: Rule) -> str:
    """Return the page of a rule."""
    page = rule.page
    kind = rule.severity.word + ", opt-in" * rule.opt_in
    notes = "".join(f"- {name}: {said}.\n" for name, said in advice(rule).items())
    return (
        f"# {rule.name}\n\n{rule.code}, {kind}: {rule.summary}.\n\n{page.why}\n\n"
        f"## Example\n\n{block('rap', page.example)}\n"
        f"## Use instead\n\n{block('rap', page.better)}\n## Notes\n\n{notes}"
    )


def front_page() -> str:
    """Return README.md with the links that hold in `docs`."""

    def moved(link: re.Match[str]) -> str:
        mark, text, target = link.groups()
        if re.match(r"#|[a-z]+:", target):
            return link.group()
        if target.startswith("docs/"):
            return (
                f"{mark}[{text.removeprefix('docs/')}]({target.removeprefix('docs/')})"
            )
        return text

    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return re.sub(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)", moved, text)


def pages() -> Iterator[tuple[Path, str]]:
    """Yield the pages that are generated as a whole."""
    yield DOCS / "index.md", NOTE.format("README.md") + front_page()
    yield DOCS / "figures" / "cycle.svg", cycle()
    for rule in rules().values():
        note = NOTE.format(f"rapc/rules/{rule.name}.md")
        yield DOCS / "reference" / "rules" / f"{rule.name}.md", note + rule_page(rule)


# --- Figures ------------------------------------------------------------------------

FIGURES: Mapping[str, str] = {
    "fill-order.svg": "stdlib/truck --rap fill-order",
    "stay-charged.svg": "examples/courier --effects stay-charged",
    "s-figure2.svg": "s-figure2.dot",
}
"""The figures that Graphviz draws: a file, or arguments of `rapc graph`."""


def graph(source: str) -> str:
    """Return the graph that a figure shows, in the language of Graphviz."""
    if source.endswith(".dot"):
        return (DOCS / "figures" / source).read_text(encoding="utf-8")
    path, *options = shlex.split(source)
    done = CliRunner().invoke(cli, ["graph", str(ROOT / path), *options])
    if done.exit_code:
        raise ValueError(done.output)
    return done.stdout


def drawn(text: str) -> str:
    """Return a graph as SVG, with the digest of its text."""
    done = subprocess.run(
        ["dot", "-Tsvg"], input=text, text=True, capture_output=True, check=True
    )
    svg = re.sub(
        r"<!--.*?-->\n*", "", done.stdout[done.stdout.index("<svg") :], flags=re.S
    )
    return f"<!-- {digest(text)} -->\n{svg}"


def digest(text: str) -> str:
    """Return a digest of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


def stale_figures() -> Iterator[tuple[Path, str]]:
    """Yield the figures that show an old graph, with their new graphs."""
    for name, source in FIGURES.items():
        path = DOCS / "figures" / name
        text = graph(source)
        old = path.read_text(encoding="utf-8") if path.exists() else ""
        if not old.startswith(f"<!-- {digest(text)} -->"):
            yield path, text


# --- Navigation ---------------------------------------------------------------------

SECTIONS: Mapping[str, str] = {
    "Tutorials": "first-robot standard-library debugger skills",
    "How-to": "index behaviour-trees claims sensing maintenance-goals choosing "
    "similar-items write-a-world drive-a-machine test ci experiments embed compile",
    "Explanation": "index how-raps-work memory rap-or-tree checker determinism",
    "Language": "index words",
    "Reference": "index cli rules repl tests trace python-api worlds-api settings "
    "formats limits truck hallway courier glossary",
    "Libraries": "index truck truck-beyond hallway",
    "Research": "index",
    "Developers": "index architecture performance slips",
}
"""The sections of the site, each with the pages that come first; others follow."""


def navigation() -> str:
    """Return the navigation of the site: every page except the pages of rules."""
    lines = ["nav:", "  - rapc: index.md"]
    for title, first in SECTIONS.items():
        folder = title.lower()
        names = [path.stem for path in sorted((DOCS / folder).glob("*.md"))]
        order = {name: at for at, name in enumerate(first.split())}
        names.sort(key=lambda name: order.get(name, len(order)))
        lines += [f"  - {title}:"] * bool(names)
        lines += [f"      - {folder}/{name}.md" for name in names]
    return "\n".join(lines) + "\n"


def configuration() -> str:
    """Return mkdocs.yml with the navigation at its end."""
    before, _, _ = CONFIG.read_text(encoding="utf-8").partition("nav:\n")
    return before + navigation()


# --- Parts of pages -----------------------------------------------------------------

PARTS: Mapping[str, Callable[..., str]] = {
    "api": api,
    "breakpoints": breakpoints,
    "command": command,
    "common-options": common_options,
    "debugger-commands": debugger_commands,
    "events": events_of,
    "formats": formats,
    "grammar": grammar,
    "limits": limits,
    "profiles": profiles,
    "rules": rule_index,
    "settings": settings,
    "slips": slips,
    "targets": targets,
    "world-options": world_options,
}
"""The functions that write parts of pages, by the names in markers."""

_MARKED = re.compile(r"(<!-- generated: (.+?) -->\n).*?(<!-- end -->)", re.S)


def written(page: str) -> str:
    """Return a page with its generated parts."""

    def part(found: re.Match[str]) -> str:
        name, *words = found[2].split()
        return f"{found[1]}\n{PARTS[name](*words)}\n{found[3]}"

    return _MARKED.sub(part, page)


def stale() -> dict[Path, str | None]:
    """Return the new texts of stale pages; None for pages to remove."""
    found: dict[Path, str | None] = {}
    whole = {**dict(pages()), CONFIG: configuration()}
    for path in sorted({*DOCS.rglob("*.md"), *whole}):
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if path in whole:
            new: str | None = whole[path]
        else:
            new = None if text.startswith(NOTE[:20]) else written(text)
        if new != text:
            found[path] = new
    return found


USER = ("tutorials", "how-to", "explanation", "reference")
"""The folders of the user manual."""


def words() -> Iterator[tuple[int, str]]:
    """Yield the number of words by hand of each page, of the user manual and of all."""
    counts: dict[str, int] = {}
    for path in sorted({ROOT / "README.md", *DOCS.rglob("*.md")}):
        text = path.read_text(encoding="utf-8")
        if not text.startswith(NOTE[:20]):
            by_hand = _MARKED.sub("", text).split()
            counts[path.relative_to(ROOT).as_posix()] = len(by_hand)
    yield from ((count, name) for name, count in counts.items())
    user = ("README.md", *(f"docs/{folder}/" for folder in USER))
    yield sum(n for name, n in counts.items() if name.startswith(user)), "user manual"
    yield sum(counts.values()), "all"


def main() -> int:
    """Write all stale pages, or list them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="only list stale pages")
    parser.add_argument("--words", action="store_true", help="count words by hand")
    args = parser.parse_args()
    if args.words:
        for count, name in words():
            print(f"{count:7,}  {name}")
        return 0
    check = args.check
    found = {**stale(), **dict(stale_figures())}
    for path, text in found.items():
        print(path.relative_to(ROOT).as_posix())
        if check:
            continue
        if text is None:
            path.unlink()
        else:
            path.parent.mkdir(exist_ok=True)
            new = drawn(text) if path.name in FIGURES else text
            path.write_text(new, encoding="utf-8")
    return int(check and bool(found))


if __name__ == "__main__":
    sys.exit(main())
