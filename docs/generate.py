"""Write the parts of the manual that have a source in the code.

    python docs/generate.py            write all stale pages
    python docs/generate.py --check    list the stale pages; exit status 1 if any
    python docs/generate.py --words    count the words written by hand, code included

A page may have generated parts:

    <!-- generated: NAME WORD... -->
    ...
    <!-- end -->

`PARTS` lists the names. The front page and the page of each rule are generated as a
whole (`pages`), and so are the navigation of the site in mkdocs.yml and the colours of
VS Code in editors/vscode. Graphviz draws the
figures of graphs (`generator.figures`).
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from generator.command_line import command, common_options
from generator.cycle import cycle
from generator.figures import FIGURES, drawn, stale_figures
from generator.libraries import effects, library_files, memory
from generator.limits import formats, limits, settings
from generator.markdown import block, table
from generator.measurements import means, profiles, runs, slips, stored, targets
from generator.python import api
from generator.session import session
from generator.tables import (
    breakpoints,
    debugger_commands,
    events_of,
    grammar,
    skill_events,
    skills,
    vocabulary,
    world_options,
)
from generator.textmate import textmate
from generator.wire import schema, wire

from rapc.analysis.registry import rules
from rapc.base.diagnostics import Rule
from rapc.cli.rule import advice

DOCS = Path(__file__).parent
ROOT = DOCS.parent
CONFIG = ROOT / "mkdocs.yml"
TEXTMATE = ROOT / "editors" / "vscode" / "rap.tmLanguage.json"

# --- Whole pages ----------------------------------------------------------------------

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
    yield DOCS / "figures" / "repl.svg", session()
    yield DOCS / "reference" / "remote-worlds.schema.json", schema()
    for rule in rules().values():
        note = NOTE.format(f"rapc/rules/{rule.name}.md")
        yield DOCS / "reference" / "rules" / f"{rule.name}.md", note + rule_page(rule)


# --- Navigation -----------------------------------------------------------------------

SECTIONS: Mapping[str, str] = {
    "Tutorials": "first-robot standard-library debugger compare skills",
    "How-to": "index behaviour-trees claims sensing maintenance-goals choosing "
    "similar-items write-a-world worlds-in-any-language add-skills drive-a-machine "
    "test ci experiments embed compile",
    "Explanation": "index how-raps-work memory rap-or-tree checker determinism",
    "Language": "index words",
    "Reference": "index cli rules repl tests trace python-api worlds-api "
    "remote-worlds settings formats limits truck hallway courier laboratory glossary",
    "Libraries": "index truck truck-beyond hallway",
    "Research": "index chapter6 rounds hallway fidelity",
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


# --- Parts of pages -------------------------------------------------------------------

PARTS: Mapping[str, Callable[..., str]] = {
    "api": api,
    "breakpoints": breakpoints,
    "command": command,
    "common-options": common_options,
    "debugger-commands": debugger_commands,
    "effects": effects,
    "events": events_of,
    "formats": formats,
    "grammar": grammar,
    "library-files": library_files,
    "limits": limits,
    "means": means,
    "memory": memory,
    "profiles": profiles,
    "rules": rule_index,
    "runs": runs,
    "settings": settings,
    "skill-events": skill_events,
    "skills": skills,
    "slips": slips,
    "stored": stored,
    "targets": targets,
    "vocabulary": vocabulary,
    "wire": wire,
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
    whole = {**dict(pages()), CONFIG: configuration(), TEXTMATE: textmate()}
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
