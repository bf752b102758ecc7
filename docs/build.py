"""Build the site into the folder `site`, with warnings as errors.

    python docs/build.py

The pages must be fresh (`docs/generate.py --check`). After the build, a page at each
former address sends the reader to the new address, the page of `rapc view` without a
run is added, and the site is searched for parts that a browser would request from
another host.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path

from pygments.lexers import find_lexer_class_by_name

from rapc.view.page import page as viewer_page

DOCS = Path(__file__).parent
ROOT = DOCS.parent
SITE = ROOT / "site"

MOVED: Mapping[str, str] = {
    "architecture": "developers/architecture",
    "ci": "how-to/ci",
    "cli": "reference/cli",
    "compile": "how-to/compile",
    "cookbook": "how-to/behaviour-trees",
    "courier": "reference/courier",
    "experiments": "how-to/experiments",
    "glossary": "reference/glossary",
    "hallway": "reference/hallway",
    "idioms": "how-to/index",
    "library-hallway": "libraries/hallway",
    "library-truck": "libraries/truck",
    "library-truck-beyond": "libraries/truck-beyond",
    "memory": "explanation/memory",
    "performance": "developers/performance",
    "python": "how-to/embed",
    "repl": "reference/repl",
    "rules": "reference/rules",
    "slips": "developers/slips",
    "testing": "reference/tests",
    "trace": "reference/trace",
    "truck": "reference/truck",
    "tutorial": "tutorials/standard-library",
    "tutorial/repl": "tutorials/debugger",
    "tutorial/skill-world": "tutorials/skills",
    "tutorial/skills": "tutorials/skills",
    "tutorials/skill-world": "tutorials/skills",
    "worlds": "how-to/write-a-world",
}
"""The former addresses of pages with their new addresses."""

VIEWER = "viewer"
"""The address of the page into which a reader drops a trace."""

REDIRECT = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>This page has moved</title>
<link rel="canonical" href="{target}">
<script>location.replace("{target}" + location.hash)</script>
<meta http-equiv="refresh" content="0; url={target}">
</head>
<body><p>This page has moved to <a href="{target}">{name}</a>.</p></body>
</html>
"""


class _Requests(HTMLParser):
    """The addresses that a browser requests to show a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect sources, and the links to styles, icons and fonts."""
        values = {name: value or "" for name, value in attrs}
        self.found += [values[name] for name in ("src", "srcset") if name in values]
        if tag == "link" and values.get("rel") not in ("canonical", "prev", "next"):
            self.found.append(values.get("href", ""))


def foreign() -> Iterator[str]:
    """Yield the addresses on other hosts that pages and styles request."""
    for page in sorted(SITE.rglob("*.html")):
        requests = _Requests()
        requests.feed(page.read_text(encoding="utf-8"))
        for address in requests.found:
            if re.match(r"(https?:)?//", address):
                yield f"{page.relative_to(SITE)}: {address}"
    for style in sorted(SITE.rglob("*.css")):
        text = style.read_text(encoding="utf-8")
        for address in re.findall(
            r"(?:url\(|@import )[\"']?((?:https?:)?//[^)\"']+)", text
        ):
            yield f"{style.relative_to(SITE)}: {address}"


def redirect() -> None:
    """Write a page at each former address, which leads to the new one.

    A new address that is gone again stands for the nearest folder with a page.
    """
    for former, new in MOVED.items():
        page = SITE / former / "index.html"
        name = new
        while name and not (SITE / name / "index.html").exists():
            name = name.rpartition("/")[0]
        target = "../" * (former.count("/") + 1) + name + "/" * bool(name)
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(REDIRECT.format(target=target, name=name), encoding="utf-8")


def main() -> int:
    """Build the site; return the exit status."""
    generate = [sys.executable, str(DOCS / "generate.py"), "--check"]
    if subprocess.run(generate, check=False).returncode:
        print("error: stale pages; run `python docs/generate.py`", file=sys.stderr)
        return 1
    find_lexer_class_by_name("rap")  # ClassNotFound: install rapc anew
    zensical = Path(sys.executable).parent / "zensical"
    env = {**os.environ, "NO_COLOR": "1"}
    build = [str(zensical), "build", "--strict", "--clean"]
    done = subprocess.run(build, cwd=ROOT, env=env, check=False)
    if done.returncode:
        return 1
    for script in SITE.rglob("*.py"):
        script.unlink()
    redirect()
    viewer = SITE / VIEWER / "index.html"
    viewer.parent.mkdir()
    viewer.write_text(viewer_page(), encoding="utf-8")
    requests = [*foreign()]
    for line in requests:
        print(f"error: request to another host: {line}", file=sys.stderr)
    return int(bool(requests))


if __name__ == "__main__":
    sys.exit(main())
