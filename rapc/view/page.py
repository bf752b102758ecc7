"""The page: its sources in `page/`, joined, with the data of runs.

The data are compressed and in base64: no text of a run is part of the markup or of the
scripts. A policy in the page forbids every request and every other script.
"""

from __future__ import annotations

import gzip
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path

import msgspec

from rapc.runtime.interpreter import Interpreter
from rapc.view.viewed import Viewed, comparison, sources
from rapc.worlds.registry import OWN, find_world

_SOURCES = Path(__file__).parent / "page"

_SCRIPTS = (
    *("model.js", "dom.js", "timeline.js", "tasks.js", "plan.js", "why.js"),
    *("memory.js", "events.js", "map.js", "live.js", "main.js"),
)
"""The scripts, in the order in which they are joined."""

BEGINNING = "<!doctype html>\n<!-- a run, by rapc view -->\n"
EXPERIMENT = "<!doctype html>\n<!-- an experiment, by rapc view -->\n"
"""The first lines of a page of a run, and of the results of an experiment."""


def page(views: Sequence[Viewed] = ()) -> str:
    """Return a page of one or two runs; without runs, of traces that a reader drops.

    Two runs are compared.
    """
    return composed(BEGINNING, _SCRIPTS, "index.html", _data(views))


def live_page(
    run: Interpreter,
    name: str,
    commands: Sequence[Mapping[str, str]] = (),
    note: str = "",
) -> str:
    """Return the page of a run that goes on: it requests the events of the run.

    Args:
        run: the run.
        name: its name.
        commands: the commands for readers who control the run; see `Control.commands`.
        note: a note for readers.
    """
    sensors = sorted(run.world.kit.offer.sensors)
    given = {"name": name, "note": note, "sensors": sensors, "commands": commands}
    more = {**given, **sources(run.library)}
    data = (*_data(()), json_element("live", more))
    policy = "connect-src 'self'"
    return composed(BEGINNING, _SCRIPTS, "index.html", data, policy)


def unknown_start(cycle: int) -> str:
    """Return the note for a run whose events up to a cycle are unknown."""
    return f"what happened up to cycle {cycle} is unknown"


def composed(
    beginning: str,
    scripts: Sequence[str],
    body: str,
    data: Iterable[str],
    *policies: str,
) -> str:
    """Return a page.

    Args:
        beginning: the first lines.
        scripts: the files of the scripts.
        body: the file of the markup; the style of its name is added to that of pages.
        data: the elements with the data.
        policies: more parts of the policy.
    """
    own = {"index.html": "map.css"}.get(body, body.replace(".html", ".css"))
    style = _read("style.css") + _read(own)
    joined = "".join(_read(name) for name in scripts)
    script = f'(() => {{\n"use strict";\n{joined}}})();\n'
    policy = "; ".join(
        (
            "default-src 'none'",
            f"script-src '{_hash(script)}'",
            f"style-src '{_hash(style)}'",
            "base-uri 'none'",
            "form-action 'none'",
            *policies,
        )
    )
    return "".join(
        (
            beginning,
            '<html lang="en">\n<head>\n<meta charset="utf-8">\n',
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n',
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n',
            f"<title>rapc view</title>\n<style>{style}</style>\n</head>\n<body>\n",
            _read(body),
            *data,
            f"<script>{script}</script>\n</body>\n</html>\n",
        )
    )


def json_element(name: str, value: object) -> str:
    """Return the element of a page with data."""
    return _element(name, _json(value))


def _read(name: str) -> str:
    return (_SOURCES / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"


def _data(views: Sequence[Viewed]) -> Iterator[str]:
    """Yield the elements with the data."""
    yield _element("worlds", _json({name: _sensors(name) for name in OWN}))
    for at, view in enumerate(views):
        yield _element(f"trace-{at}", view.trace)
        yield _element(f"more-{at}", _json(view.more()))
    if len(views) > 1:
        yield _element("comparison", _json(comparison(*views)))


def _json(value: object) -> bytes:
    return msgspec.json.encode(value)


def _element(name: str, data: bytes) -> str:
    packed = b64encode(gzip.compress(data, 9, mtime=0)).decode()
    return (
        f'<script type="application/octet-stream" id="data-{name}">{packed}</script>\n'
    )


def _sensors(world: str) -> list[str]:
    return sorted(find_world(world).kit.offer.sensors)
