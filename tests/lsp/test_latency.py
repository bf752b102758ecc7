"""Times of the language server, process and wire included, beyond the delays.

`python -m pytest -m nightly tests/lsp/test_latency.py -s` prints the figures.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from statistics import median

import pytest

from tests.lsp.client import NOW, Editor  # before lsprotocol: it skips without it

from lsprotocol import types  # isort: skip

pytestmark = pytest.mark.nightly

FILES = 50

LIMITS = {
    500: {"errors": 0.060, "all": 0.250, "asked": 0.020},
    5000: {"syntax": 0.060, "errors": 0.600, "all": 1.500, "asked": 0.020},
}
"""The limits in seconds, by the number of RAPs."""

MEMORY = 200
"""The limit of the resident memory of the server, in MB."""

WORLD = """\
(declare-kind place)
(declare-memory-proposition at ((?who item) (?place place)) "Where a thing is.")
(declare-memory-property battery (?level) 100)
(declare-primitive drive ((?place place)) (okay blocked)
  :on (okay (at robot ?place)) :on (blocked (at robot corridor)) "Drive.")
(declare-primitive grip ((?what item)) (okay dropped) :on (okay (at ?what hand)))
"""


def rap(number: int, last: int) -> str:
    """Return a RAP with two methods, which calls two others."""
    one, other = 2 * number + 1, 2 * number + 2
    if other >= last:
        return f"""\
; Bring a thing to a place.
(define-rap (task-{number} ?what ?place)
  (succeed (at ?what ?place))
  (method by-hand
    (context (and (at robot ?from) (n= ?from ?place)))
    (primitive (grip ?what)))
  (method drive
    (context (at ?what hand))
    (primitive (drive ?place))))

"""
    return f"""\
; Bring a thing to a place by other tasks.
(define-rap (task-{number} ?what ?place)
  (succeed (at ?what ?place))
  (preconditions (and (battery ?level) (> ?level 10)))
  (method near
    (context (at robot ?place))
    (task-net
      (t1 (task-{one} ?what ?place) (for t2))
      (t2 (task-{other} ?what ?place))))
  (method far
    (context (not (at robot ?place)))
    (task-net
      (t1 (task-{other} ?what ?place)))))

"""


@pytest.fixture(params=LIMITS, ids=str)
def size(request: pytest.FixtureRequest) -> int:
    found: int = request.param
    return found


@pytest.fixture
def folder(tmp_path: Path, size: int) -> Path:
    (tmp_path / "world.rap").write_text(WORLD)
    names = [f"raps-{number}" for number in range(FILES)]
    each = size // FILES
    for at, name in enumerate(names):
        raps = "".join(rap(n, size) for n in range(at * each, (at + 1) * each))
        (tmp_path / f"{name}.rap").write_text(raps)
    (tmp_path / "rapc.toml").write_text('libraries = ["."]\n')
    return tmp_path


def seconds(does: Callable[[], object]) -> float:
    start = time.perf_counter()
    does()
    return time.perf_counter() - start


def told(name: str, size: int, value: float) -> None:
    print(f"{size:5} RAPs  {name:24} {1000 * value:7.1f} ms")


def opened(folder: Path, options: Mapping[str, float]) -> tuple[Editor, str]:
    editor = Editor(folder, options=options)
    uri = editor.open(folder / "raps-5.rap")
    editor.findings(uri)
    return editor, uri


def edits(editor: Editor, uri: str, options: Mapping[str, float]) -> Iterator[float]:
    """Yield the time of each of some edits to the findings, beyond the delay."""
    for at in range(9):
        old, new = ("t1 (task", "t1 (tusk") if at % 2 == 0 else ("t1 (tusk", "t1 (task")
        wanted = "unknown-rap" if at % 2 == 0 else None
        before = seconds(partial(editor.edit, uri, old, new))
        taken = seconds(partial(editor.until, uri, wanted))
        yield before + taken - options["errorDelay"] / 1000


def test_errors_follow_an_edit(folder: Path, size: int) -> None:
    options = {"errorDelay": 100, "delay": 60_000}
    editor = Editor(folder, options=options)
    uri = editor.open(folder / "raps-5.rap")
    editor.until(uri, None)
    times = list(edits(editor, uri, options))
    told("edit to errors", size, median(times))
    editor.close()
    assert median(times) <= LIMITS[size]["errors"]


def test_all_findings_follow_an_edit(folder: Path, size: int) -> None:
    editor, uri = opened(folder, NOW)
    times = []
    for at in range(9):
        old, new = ("t1 (task", "t1 (tusk") if at % 2 == 0 else ("t1 (tusk", "t1 (task")
        editor.edit(uri, old, new)
        times.append(seconds(lambda: editor.findings(uri)))
    told("edit to all findings", size, median(times))
    status = Path(f"/proc/{editor.client._server.pid}/status").read_text()
    memory = int(status.partition("VmRSS:")[2].split()[0]) / 1024
    print(f"{size:5} RAPs  memory {memory:.0f} MB")
    editor.close()
    assert median(times) <= LIMITS[size]["all"]
    assert memory <= MEMORY


def test_questions_are_answered_while_checks_run(folder: Path, size: int) -> None:
    editor, uri = opened(folder, NOW)
    asked = {
        "hover": (types.TEXT_DOCUMENT_HOVER, types.HoverParams),
        "definition": (types.TEXT_DOCUMENT_DEFINITION, types.DefinitionParams),
        "completion": (types.TEXT_DOCUMENT_COMPLETION, types.CompletionParams),
    }
    for name, (method, params) in asked.items():
        times = []
        for at in range(40):
            editor.edit(uri, "; Bring", "; Bring")
            where = params(**editor.of(uri, "task-", at % 9))
            times.append(seconds(partial(editor.ask, method, where)))
        told(name, size, median(times))
        told(f"{name}, slowest", size, max(times))
        assert median(times) <= LIMITS[size]["asked"]
    editor.close()


def test_no_answer_is_lost_at_20_keystrokes_a_second(folder: Path, size: int) -> None:
    editor, uri = opened(folder, {})
    for at in range(20 * 60):
        start = time.perf_counter()
        editor.edit(uri, "task-", "task-")
        where = types.HoverParams(**editor.of(uri, "task-", at % 20))
        assert editor.ask(types.TEXT_DOCUMENT_HOVER, where) is not None
        time.sleep(max(0.0, 0.05 - (time.perf_counter() - start)))
    editor.findings(uri)
    editor.close()
