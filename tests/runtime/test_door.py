"""Other packages use only the documented members of a run."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import rapc
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.run import Run
from tests.runtime.helpers import Play, row

ROOT = Path(rapc.__file__).parent

FRONT = ("host.py", "debug", "experiments", "testing", "console", "repl", "cli")
"""The modules and packages that may import the interpreter."""

ACTING = ("run", "tasks", "monitors", "query_context")
"""The modules of `rapc.runtime` whose functions act on a run."""

_NAMES = ("run", "interpreter", "ready", "going", "played")
"""The names of variables and attributes that hold a run."""


def _documented() -> set[str]:
    """Return the members of a run in the reference of the Python API."""
    page = Path(__file__).parents[2] / "docs" / "reference" / "python-api.md"
    text = page.read_text(encoding="utf-8")
    entry = text[text.index("\n### Interpreter\n") :].split("\n### ")[1]
    found = set(re.findall(r"^#### Interpreter\.(\w+)$", entry, re.M))
    attributes = entry.partition("Attributes:\n")[2].partition("\n\nRaises:")[0]
    found |= set(re.findall(r"^- `(\w+)`:", attributes, re.M))
    return found | set(re.findall(r"^\| `(\w+)` \|", entry, re.M))


def _members() -> set[str]:
    """Return all members of a run: methods, and attributes set in methods."""
    found = {name for cls in (Run, Interpreter) for name in vars(cls)}
    for cls in (Run, Interpreter):
        for node in ast.walk(ast.parse(inspect.getsource(cls))):
            if (
                isinstance(node, ast.Attribute)
                and isinstance(node.ctx, ast.Store)
                and ast.unparse(node.value) == "self"
            ):
                found.add(node.attr)
    return {name for name in found if not name.startswith("__")}


def _is_a_run(note: ast.expr | None) -> bool:
    if note is None:
        return False
    return re.search(r"\b(Interpreter|Run)\b", ast.unparse(note)) is not None


def _runs(tree: ast.AST) -> set[str]:
    """Return the names of variables and attributes that hold a run."""
    found = {*_NAMES, *(f"_{name}" for name in _NAMES)}
    for node in ast.walk(tree):
        if isinstance(node, ast.arg) and _is_a_run(node.annotation):
            found.add(node.arg)
        elif isinstance(node, ast.AnnAssign) and _is_a_run(node.annotation):
            found.add(ast.unparse(node.target).rpartition(".")[2])
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
            made = ast.unparse(node.value.func).rpartition(".")[2]
            if made in ("Interpreter", "prepared", "start", "fork", "remade"):
                found |= {
                    ast.unparse(target).rpartition(".")[2] for target in node.targets
                }
    return found


def _reads(text: str) -> Iterator[tuple[int, str]]:
    """Yield the members of runs that a module reads, with their lines."""
    tree = ast.parse(text)
    runs = _runs(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            holder = ast.unparse(node.value).removesuffix("()").rpartition(".")[2]
            if holder in runs:
                yield node.lineno, node.attr


def _front() -> Iterator[Path]:
    for name in FRONT:
        path = ROOT / name
        yield from [path] if path.is_file() else sorted(path.rglob("*.py"))


def test_other_packages_read_only_documented_members_of_a_run() -> None:
    behind = _members() - _documented()
    assert {"state", "beliefs", "recorder"} <= behind
    found = [
        f"{path.relative_to(ROOT)}:{line} {name}"
        for path in _front()
        for line, name in _reads(path.read_text(encoding="utf-8"))
        if name in behind
    ]
    assert found == []


def test_reads_of_a_run_are_found_under_any_name() -> None:
    text = """
def f(one: Interpreter, history: History) -> None:
    one.state.over
    history.run.beliefs
    other = one.fork()
    other.recorder.on
    history.run.now
"""
    found = {name for _, name in _reads(text)}
    assert found == {"state", "fork", "beliefs", "recorder", "now"}


def test_other_packages_import_no_functions_on_runs() -> None:
    modules = "|".join(ACTING)
    acting = re.compile(rf"^\s*(?:from|import) rapc\.runtime\.({modules})\b", re.M)
    for path in _front():
        assert acting.search(path.read_text(encoding="utf-8")) is None, path


BODY = """
(declare-primitive go (?where) (okay) :atomic false :uses (wheels))
(define-rap (drive ?where)
  (preconditions (p fuel))
  (method far (context (and (p fuel) (q ?where ?road))) (primitive (go ?where)))
  (method near (primitive (go ?where))))
"""


def _driving() -> Interpreter:
    """Return a run with a task that drives and a task that waits for the wheels."""
    rows = [row("(go ?)", after=5)]
    tasks = ("(drive lab) :priority 2", "(drive hall)", "(drive yard) :priority -1")
    run = Play(BODY, *tasks, rows=rows, facts=("(p fuel)",)).interpreter
    run.step()
    run.step()
    return run


def test_observers_see_tasks_requests_and_claims() -> None:
    run = _driving()
    assert (run.cycle, run.created) == (2, 3)
    assert [task.number for task in run.tasks()] == [1, 2, 3]
    requests = [
        (task and task.number, asked) for task, asked in run.requests().values()
    ]
    assert requests == [(1, ("go", "lab"))]
    [claim] = run.claims()
    assert (claim.thing, claim.said, claim.used) == (("wheels",), "wheels", True)
    assert (claim.task.number, claim.waiting) == (1, (2,))
    assert run.deadlocks() == ()
    assert run.skills() == ()


def test_observers_see_the_rules_of_choice() -> None:
    run = _driving()
    candidates = run.candidates()
    assert list(candidates) == [3]
    assert candidates[3].priority == -1
    assert not candidates[3].failed
    assert run.families()[0] == (0, 2)


def test_observers_see_why_a_method_is_not_chosen() -> None:
    run = _driving()
    task = run.task(3)
    far, near = run.methods(task.plan)
    assert far.choice is not None
    found = run.obstacle(task, near, task.env)
    assert found is not None
    assert found.task.number == 1
    parts = [*run.explain(far.choice, task, task.env, 5)]
    assert [(one.text, len(one.solutions)) for one in parts] == [
        ("(p fuel)", 1),
        ("(q ?where ?road)", 0),
    ]
    [(words, query, asker, env)] = run.conditions(task)
    assert words == "preconditions of `drive`"
    assert run.solution(query, asker, env) == {}
    run.assert_fact("q", "yard", "a1")
    assert run.solution(far.choice, task, task.env) == {"?road": "a1"}


def test_memory_lists_facts_with_the_times_of_their_assertions() -> None:
    run = _driving()
    memory = run.memory
    assert memory.names() == ["p"]
    assert memory.facts("p") == {("p", "fuel"): 0}
    assert ("p", "fuel") in memory
    assert [*memory] == [("p", "fuel")]
    assert memory.since(("p", "food")) is None


def test_a_request_without_a_task_is_sent_and_ends() -> None:
    run = _driving()
    ticket, answer = run.send(("act", "a"))
    assert answer is not None
    assert ticket not in run.requests()
    ticket, answer = run.send(("go", "moon"))
    assert answer is None
    assert run.requests()[ticket] == (None, ("go", "moon"))
    run.port.advance(5)
    assert len(run.receive()) == 2
    assert run.requests() == {}


def test_all_members_of_the_reference_are_members_of_a_run() -> None:
    assert _documented() <= _members()
