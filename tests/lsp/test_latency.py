"""Times of the language server, process and wire included, beyond the delays.

`python -m pytest -n 0 -m nightly tests/lsp/test_latency.py -s` prints the figures: the
distribution of each time, the processor time of the server, and its memory. On an idle
machine the limits hold for the medians, and for 99 of 100 answers to requests. On a
busy machine, `chrt -r 10` before the command runs the test before other processes.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import pytest

from tests.lsp.client import NOW, Editor  # before lsprotocol: it skips without it

from lsprotocol import types  # isort: skip

from tests.lsp.edits import assert_findings_are_fresh, type_keys

pytestmark = pytest.mark.nightly

FILES = 50

LIMITS = {
    500: {"syntax": 0.060, "errors": 0.060, "all": 0.250, "asked": 0.020},
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


class Server:
    """The process of a server: its processor time and memory."""

    def __init__(self, editor: Editor) -> None:
        self._proc = Path(f"/proc/{editor.client._server.pid}")

    def seconds(self) -> float:
        """Return the processor time so far."""
        fields = (self._proc / "stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def memory(self) -> float:
        """Return the resident memory, in MB."""
        status = (self._proc / "status").read_text()
        return int(status.partition("VmRSS:")[2].split()[0]) / 1024


def seconds(does: Callable[[], object]) -> float:
    start = time.perf_counter()
    does()
    return time.perf_counter() - start


def told(name: str, size: int, times: Sequence[float]) -> Mapping[str, float]:
    """Print the distribution of some values, and return it by the names of `SHARES`."""
    ordered, last = sorted(times), len(times) - 1
    found = {name: ordered[int(share * last)] for name, share in SHARES.items()}
    shown = "  ".join(f"{name} {1000 * one:6.1f}" for name, one in found.items())
    print(f"{size:5} RAPs  {name:26} {shown} ms  ({len(times)} times)")
    return found


SHARES = {"min": 0.0, "median": 0.5, "p95": 0.95, "p99": 0.99, "max": 1.0}
"""By name, the share of the times that are lower."""


SLIPS = {
    "unknown-rap": ("t1 (task", "t1 (tusk"),
    "missing-parenthesis": ("?place))\n  (pre", "?place)\n  (pre"),
}
"""By rule, a text of each program, and the text with the fault."""


def edit_and_wait(editor: Editor, uri: str, rule: str, count: int) -> list[float]:
    """Return the times of edits to the finding of a slip, and to its end."""
    times = []
    for at in range(count):
        right, wrong = SLIPS[rule]
        old, new, wanted = (wrong, right, None) if at % 2 else (right, wrong, rule)
        start = time.perf_counter()
        editor.edit(uri, old, new)
        editor.until(uri, wanted)
        times.append(time.perf_counter() - start)
        if rule == "missing-parenthesis":
            time.sleep(SETTLE)
    return times


SETTLE = 2.0
"""The seconds after which no check is under way."""


def opened(folder: Path, options: Mapping[str, float]) -> tuple[Editor, str]:
    editor = Editor(folder, options=options)
    uri = editor.open(folder / "raps-5.rap")
    document = types.DocumentSymbolParams(types.TextDocumentIdentifier(uri))
    while not editor.ask(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, document):
        pass  # the answer waits for the first check, for a while
    return editor, uri


ERRORS = {"errorDelay": 0, "delay": 60_000}
"""The options of a server that only finds errors."""


def test_syntax_errors_follow_an_edit(folder: Path, size: int) -> None:
    editor, uri = opened(folder, ERRORS)
    time.sleep(SETTLE)
    times = edit_and_wait(editor, uri, "missing-parenthesis", 8)
    editor.close()
    found = told("edit to syntax errors", size, times)
    assert found["median"] <= LIMITS[size]["syntax"]


def test_errors_follow_an_edit(folder: Path, size: int) -> None:
    editor, uri = opened(folder, ERRORS)
    time.sleep(SETTLE)
    times = edit_and_wait(editor, uri, "unknown-rap", 10)
    editor.close()
    assert told("edit to errors", size, times)["median"] <= LIMITS[size]["errors"]


def test_all_findings_follow_an_edit(folder: Path, size: int) -> None:
    editor, uri = opened(folder, NOW)
    editor.findings(uri)
    server = Server(editor)
    times, used = [], []
    for at in range(10):
        right, wrong = SLIPS["unknown-rap"]
        before, start = server.seconds(), time.perf_counter()
        editor.edit(uri, *((wrong, right) if at % 2 else (right, wrong)))
        editor.findings(uri)
        times.append(time.perf_counter() - start)
        used.append(server.seconds() - before)
    found = told("edit to all findings", size, times)
    told("processor time of these", size, used)
    memory = server.memory()
    print(f"{size:5} RAPs  memory {memory:.0f} MB")
    editor.close()
    assert found["median"] <= LIMITS[size]["all"]
    assert memory <= MEMORY


QUESTIONS = {
    "hover": (types.TEXT_DOCUMENT_HOVER, types.HoverParams),
    "definition": (types.TEXT_DOCUMENT_DEFINITION, types.DefinitionParams),
    "completion": (types.TEXT_DOCUMENT_COMPLETION, types.CompletionParams),
}


def test_questions_are_answered_while_checks_run(folder: Path, size: int) -> None:
    editor, uri = opened(folder, NOW)
    editor.findings(uri)
    times: dict[str, list[float]] = {name: [] for name in QUESTIONS}
    while min(map(len, times.values())) < 200:
        editor.edit(uri, "; Bring", "; Bring")
        while not editor.is_checked(uri):
            for name, (method, params) in QUESTIONS.items():
                where = params(**editor.of(uri, "task-", len(times[name]) % 9))
                times[name].append(seconds(partial(editor.ask, method, where)))
    editor.close()
    found = [told(f"{name} during a check", size, of) for name, of in times.items()]
    assert max(one["p99"] for one in found) <= LIMITS[size]["asked"]


def test_no_answer_is_lost_at_20_keystrokes_a_second(folder: Path, size: int) -> None:
    editor, uri = opened(folder, {})
    times = type_keys(editor, uri, f"task-{size // 10}", 20 * 60, pause=0.05)
    assert_findings_are_fresh(editor, {uri: folder / "raps-5.rap"})
    editor.close()
    assert told("hover while typing", size, times)["p99"] <= LIMITS[size]["asked"]
