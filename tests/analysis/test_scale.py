"""Large and odd programs: work stays linear, nothing runs into a limit."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rapc.analysis.driver import check_library
from rapc.ir import nodes
from rapc.ir.schema import CHILDREN
from rapc.library.loader import load_text
from tests.effort import first
from tests.work import lines


def _found(text: str) -> list[str]:
    return [f.rule.name for f in check_library(load_text(text)).findings]


def test_long_chain_of_steps_that_hand_on_variables() -> None:
    count = 5000
    steps = "\n".join(
        f"(t{n} (x ?v{n} => ?v{n + 1}) (for t{n + 1}))" for n in range(count)
    )
    text = f"(define-rap (x ?a => ?b))\n(define-rap (y ?v0) (method (task-net {steps}"
    assert _found(f"{text} (t{count} (x ?v{count} => ?)))))") == []
    assert _found(f"{text} (t{count} (x ?w{count} => ?)))))") == ["unbound-variable"]


def test_long_circle_is_one_finding() -> None:
    count = 3000
    steps = "\n".join(f"(t{n} (x) (for t{(n + 1) % count}))" for n in range(count))
    text = f"(define-rap (x))\n(define-rap (y) (method (task-net {steps})))"
    (finding,) = check_library(load_text(text)).findings
    assert finding.diagnostic.message.startswith(f"{count} steps wait for each other")
    assert len(finding.diagnostic.labels) < 10


def test_formula_nested_as_deeply_as_can_be() -> None:
    depth = 90
    text = "(and (p ?x) (not " * (depth // 2) + "(p deep)" + "))" * (depth // 2)
    program = f"(declare-memory-proposition p (?x))\n(define-rap (y) (succeed {text}))"
    assert _found(program) == []


def test_many_unknown_names_are_still_all_found() -> None:
    steps = "\n".join(f"(t{n} (unknown-{n}))" for n in range(2000))
    text = f"(define-rap (x))\n(define-rap (y) (method (task-net {steps})))"
    assert _found(text) == ["unknown-rap"] * 2000


def test_one_name_unknown_in_many_places_is_one_finding() -> None:
    steps = "\n".join(f"(t{n} (unknown))" for n in range(100))
    text = f"(define-rap (y) (method (task-net {steps})))"
    (finding,) = check_library(load_text(text)).findings
    assert len(finding.diagnostic.labels) == 2
    assert finding.diagnostic.notes == ("used in 97 other places",)


def test_the_index_knows_the_children_of_every_node() -> None:
    kinds = {
        kind
        for kind in vars(nodes).values()
        if isinstance(kind, type) and issubclass(kind, nodes.Node)
    }
    assert {nodes.Node, nodes.Pattern, *CHILDREN} == kinds
    scalars = ("str", "int", "bool", "Atom", "Span", "Literal", "tuple[str", "float")
    others = ("Number", "RowKind", "tuple[tuple[str", "tuple[Atom", "tuple[Number")
    for kind, children in CHILDREN.items():
        above = nodes.Pattern if issubclass(kind, nodes.Pattern) else kind
        holding = {
            name
            for name, said in above.__annotations__.items()
            if not said.startswith((*scalars, *others))
        }
        assert set(children) == holding, kind


# --- work in proportion to the text ---------------------------------------------------


def _rap(number: int, before: str = "") -> str:
    step = f"(t (gone-{number:04}))"
    return f"{before}\n(define-rap (r{number:04}) (method (task-net {step})))\n"


def _suppressed_steps(count: int) -> str:
    steps = "\n".join(
        f"(t{n} (x{n})) ; rapc: ignore[unknown-rap]" for n in range(count)
    )
    return f"(define-rap (r) (method (task-net\n{steps}\n)))"


def _methods_asked_for(count: int) -> str:
    rows = "\n".join(
        f"(method n{n} (context (method-tried m{n})) (task-net))" for n in range(count)
    )
    return f"(define-rap (r) {rows})"


def _tests(count: int) -> str:
    rows = "".join(
        f"(define-test t{n} (task (r{n})) (expect (never (p{n}))))\n"
        for n in range(count)
    )
    return f"(define-rap (r))\n{rows}"


WORLD = """\
(declare-memory-proposition p ())
(declare-primitive a () (okay) :uses (w) :on (okay (not (p))))
"""


def _chain(count: int, body: str, last: str) -> str:
    """RAPs each of which asks for the next, the first one given as a task."""
    rows = [
        f"(define-rap (r{n:04} ?s) {body} (method (task-net (t (r{n + 1:04} ?s)))))\n"
        for n in range(count)
    ]
    return f"{WORLD}{''.join(rows)}(define-rap (r{count:04} ?s) {last})\n"


def _nested(count: int) -> str:
    called = ["x", *(f"y{n}" for n in range(4))]
    nets = [
        f"(define-rap (y{n}) (method (task-net "
        + " ".join(f"(t{at} ({called[n]}))" for at in range(count))
        + ")))"
        for n in range(4)
    ]
    plain = "(define-rap (x) (method (primitive (a))))"
    return "\n".join((WORLD, plain, *nets))


def _protected(count: int) -> str:
    steps = "\n".join(f"(t{n} (x) ((p) for t{n + 1}))" for n in range(count))
    body = f"(method (task-net {steps} (t{count} (x))))"
    return f"{WORLD}(define-rap (x) (method (primitive (a))))\n(define-rap (y) {body})"


def _results(count: int) -> str:
    rows = "\n".join(
        f"(method n{n} (context (result-with-method n{n} okay)) (primitive (a)))"
        for n in range(count)
    )
    return f"{WORLD}(define-rap (r) {rows})"


IGNORE, FILE_IGNORE = "; rapc: ignore[unknown-rap]", "; rapc: file-ignore[unknown-rap]"

TEXTS: dict[str, Callable[[int], str]] = {
    "a suppression at each RAP": lambda n: "".join(_rap(i, IGNORE) for i in range(n)),
    "comments in a row": lambda n: f"{IGNORE}\n" * n + _rap(0),
    "file-ignore at each RAP": lambda n: "".join(
        _rap(i, FILE_IGNORE) for i in range(n)
    ),
    "suppressed steps of one RAP": _suppressed_steps,
    "unknown methods of one RAP": _methods_asked_for,
    "tests with unknown names": _tests,
    "goals that never come": lambda n: _chain(
        n, "(succeed (p))", "(succeed (p)) (method (primitive (a)))"
    ),
    "what never ends below": lambda n: (
        _chain(n, "", "(succeed nil) (monitor-state (p)) (method (primitive (a)))")
        + "(define-agenda d (task (r0000 here)))"
    ),
    "a set handed on": lambda n: _chain(
        n, "(resources (set ?m))", "(method (context (member ?s x)) (primitive (a)))"
    ),
    "protections in a row": _protected,
    "nets in nets": _nested,
    "results of many methods": _results,
}


@pytest.mark.parametrize("size", first(1, [100, 200]))
@pytest.mark.parametrize("shape", TEXTS)
def test_work_of_a_check_is_in_proportion_to_its_text(shape: str, size: int) -> None:
    small, large = (_work(TEXTS[shape](count)) for count in (size, 4 * size))
    assert large < 5 * small


def _work(text: str) -> int:
    """How many lines of Python are run to check a text, once it is read."""
    loaded = load_text(text)
    return lines(lambda: check_library(loaded))
