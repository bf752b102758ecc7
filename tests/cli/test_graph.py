"""`rapc graph`: what is drawn of a library, and that every format holds it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import networkx
import pytest

import rapc as rapc_package

from .command import rapc

ROOT = Path(__file__).parents[2]

LIBRARY = """\
(declare-primitive drive (?to) (okay)
  :uses (wheels)
  :on (okay (at ?to) (may (parked))))
(declare-sensor-datum seen (?thing) :on ((close ?thing)))
(declare-memory-property at (?place) unknown)
(declare-memory-proposition parked ())
(declare-memory-proposition close (?thing))
(declare-memory-proposition busy ())
(define-query (arrived ?place) (and (at ?place) (not (busy))))

(define-agenda day (task (watch) :priority 3 :background true) (task (go home)))

(define-rap (watch)
  (monitor-state (or (arrived home) (close "a \\"wall\\"")))
  (method rest
    (notations (busy))
    (task-net (t1 (go dock)))))

(define-rap (go ?place)
  (succeed (at ?place))
  (method
    (claims wheels)
    (task-net
      (t1 (step ?place) ((at ?place) for t2) (wait-for (:clear) :proceed))
      (t2 (step ?place) (until-end t1)))))

(define-rap (step ?place)
  (succeed (at ?place))
  (method
    (primitive (drive ?place))))

(declare-event :clear ())
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a library."""
    (tmp_path / "lib.rap").write_text(LIBRARY)
    return tmp_path


def _drawn(folder: Path, *args: str) -> tuple[list[str], list[tuple[str, str, str]]]:
    done = rapc("graph", "lib.rap", "--format", "json", *args, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    graph: dict[str, Any] = json.loads(done.stdout)
    known = [vertex["id"] for vertex in graph["vertices"]]
    edges = [(e["source"], e["target"], e["label"]) for e in graph["edges"]]
    assert {end for edge in edges for end in edge[:2]} <= set(known)
    return known, edges


def test_calls(folder: Path) -> None:
    known, edges = _drawn(folder)
    assert known == ["agenda day", "rap watch", "rap go", "rap step", "primitive drive"]
    assert edges == [
        ("agenda day", "rap watch", "priority 3"),
        ("agenda day", "rap go", ""),
        ("rap watch", "rap go", "rest"),
        ("rap go", "rap step", ""),
        ("rap step", "primitive drive", ""),
    ]


def test_task_nets(folder: Path) -> None:
    known, edges = _drawn(folder, "--rap", "GO")
    assert known == ["step method/t1", "step method/t2"]
    assert edges == [
        ("step method/t1", "step method/t2", "(at ?place)"),
        ("step method/t1", "step method/t1", "wait for :clear"),
        ("step method/t1", "step method/t2", "end ends"),
    ]


def test_graph_shows_monitors_with_their_sources(folder: Path) -> None:
    _, edges = _drawn(folder, "--monitors")
    assert sorted(edges) == [
        ("datum seen", "fact close", "asserts"),
        ("fact at", "rap watch", "wakes"),
        ("fact busy", "rap watch", "wakes"),
        ("fact close", "rap watch", "wakes"),
        ("primitive drive", "fact at", "asserts"),
        ("rap watch", "fact busy", "notes"),
    ]


def test_claims_and_uses(folder: Path) -> None:
    _, edges = _drawn(folder, "--claims")
    assert edges == [
        ("rap go", "thing wheels", "claims"),
        ("primitive drive", "thing wheels", "uses"),
    ]


def test_claims_keep_arguments_of_things(folder: Path) -> None:
    text = LIBRARY.replace("(claims wheels)", "by-left (claims (arm left))", 1)
    (folder / "lib.rap").write_text(text)
    done = rapc("graph", "lib.rap", "--claims", "--format", "text", cwd=folder)
    assert done.stdout == "go\n  claims by-left (arm left)\ndrive\n  uses wheels\n"


def test_operators_are_shown_with_their_facts(folder: Path) -> None:
    (folder / "lib.rap").write_text(
        """(declare-memory-property at (?place) unknown)
        (declare-memory-proposition open (?door))
        (declare-memory-proposition held (?item))
        (declare-memory-proposition door (?door ?from ?to))
        (define-query (shut ?door) (not (open ?door)))
        (define-rap (go ?to)
          (preconditions (and (at ?from) (door ?door ?from ?to) (open ?door)))
          (effects (at ?to)))
        (define-rap (unlock ?door)
          (preconditions (shut ?door))
          (effects (open ?door) (may (held key)) (at ?)))
        (define-rap (drop ?item) (effects (not (held ?item))))
        (define-rap (wait))
        (define-rap (go-home) (succeed (and (at home) (not (held key)))) (plan))
        """
    )
    _, edges = _drawn(folder, "--operators")
    assert edges == [
        ("fact at", "rap go", "needed by"),
        ("fact door", "rap go", "needed by"),
        ("fact open", "rap go", "needed by"),
        ("rap go", "fact at", "asserts"),
        ("fact open", "rap unlock", "prevents"),
        ("rap unlock", "fact open", "asserts"),
        ("rap unlock", "fact held", "may change"),
        ("rap unlock", "fact at", "may change"),
        ("rap drop", "fact held", "erases"),
        ("fact at", "rap go-home", "needed by"),
        ("fact held", "rap go-home", "prevents"),
    ]
    _, calls = _drawn(folder)
    raps = ("go", "unlock", "drop")
    assert calls == [("rap go-home", f"rap {rap}", "plan") for rap in raps]


def test_effects_of_a_rap_include_its_steps(folder: Path) -> None:
    told = "watch\n"
    told += "  asserts (busy), (at ?), (parked)\n"
    told += "  erases (busy), (parked)\n"
    told += "  waits for close, at, busy, :clear\n"
    told += "  requests drive: okay\n"
    told += "  uses wheels\n"
    told += "  claims wheels\n"
    told += "  unknown effects of go\n"
    done = rapc(
        "graph", "lib.rap", "--effects", "watch", "--format", "text", cwd=folder
    )
    assert done.stdout == told
    done = rapc("graph", "lib.rap", "--effects", "step", "--format", "text", cwd=folder)
    told = "step\n  asserts (at ?), (parked)\n  erases (parked)\n"
    assert done.stdout == told + "  requests drive: okay\n  uses wheels\n"


def test_data_are_sensed_and_constants_stay(folder: Path) -> None:
    library = folder / "lib.rap"
    text = LIBRARY.replace(":uses (wheels)", ":tells (seen) :uses (wheels)")
    library.write_text(text.replace("(drive ?place)", "(drive home)"))
    _, edges = _drawn(folder, "--effects", "step")
    assert ("rap step", "datum senses seen", "senses") in edges
    assert ("rap step", "fact asserts (at home)", "asserts") in edges
    assert ("rap step", "fact asserts (close ?)", "asserts") in edges


def test_the_text_of_a_graph(folder: Path) -> None:
    done = rapc("graph", "lib.rap", "--format", "text", cwd=folder)
    assert done.stdout == (
        "day\n  priority 3 watch\n  -> go\nwatch\n  rest go\ngo\n  -> step\n"
        "step\n  -> drive\n"
    )


@pytest.mark.parametrize(
    "args",
    [(), ("--rap", "go"), ("--effects", "watch"), ("--monitors",), ("--claims",)],
)
def test_dot_and_mermaid_hold_the_same_graph(
    args: tuple[str, ...], folder: Path
) -> None:
    known, edges = _drawn(folder, *args)
    text = rapc("graph", "lib.rap", *args, cwd=folder).stdout
    assert text.startswith('digraph "')
    assert text.endswith("}\n")
    assert text.count("{") == text.count("}")
    assert len(re.findall(r"shape=", text)) == len(known)
    assert text.count(" -> ") == len(edges)
    assert all(f'"{one}" [label=' in text for one in known)
    text = rapc("graph", "lib.rap", "--format", "mermaid", *args, cwd=folder).stdout
    assert text.startswith("flowchart LR\n")
    assert len(re.findall(r"^ +n\d+\W", text, re.MULTILINE)) == len(known) + len(edges)
    assert text.count(" -->") == len(edges)


def test_every_rap_of_the_standard_library_is_drawn() -> None:
    done = rapc("graph", str(ROOT / "stdlib" / "truck"), "--format", "json")
    drawn = {v["label"] for v in json.loads(done.stdout)["vertices"]}
    assert {"fill-order", "handle-enemy-troops", "arm-move", "eye-scan"} <= drawn


def test_graph_of_networkx_answers_questions_about_a_library() -> None:
    graph = rapc_package.loads(LIBRARY).graph()
    assert graph.nodes["rap go"] == {
        "kind": "rap",
        "name": "go",
        "file": "<text>",
        "row": graph.nodes["rap go"]["row"],
    }
    assert LIBRARY.splitlines()[graph.nodes["rap go"]["row"] - 1].startswith(
        "(define-rap (go"
    )
    above = networkx.ancestors(graph, "fact busy")
    assert {"query arrived", "rap watch", "agenda day"} <= above
    found = {
        (source, target, data["relation"], data["label"])
        for source, target, data in graph.edges(data=True)
    }
    assert ("agenda day", "rap watch", "submits", "priority 3") in found
    assert ("rap watch", "fact busy", "notes", "rest") in found
    assert ("primitive drive", "fact parked", "may change", "") in found
    assert ("query arrived", "fact busy", "asks", "") in found


def test_dominators_are_on_all_paths(folder: Path) -> None:
    text = """\
(declare-primitive act () (okay))
(define-rap (top) (method (task-net (t1 (left)) (t2 (right)))))
(define-rap (left) (method (task-net (t1 (both)))))
(define-rap (right) (method (task-net (t1 (both)) (t2 (only)))))
(define-rap (both) (method (primitive (act))))
(define-rap (only) (method (task-net (t1 (both)))))
"""
    (folder / "lib.rap").write_text(text)
    done = rapc(
        "graph", "lib.rap", "--dominators", "top", "--format", "json", cwd=folder
    )
    edges = {(e["source"], e["target"]) for e in json.loads(done.stdout)["edges"]}
    assert edges == {
        ("rap top", "rap left"),
        ("rap top", "rap right"),
        ("rap top", "rap both"),
        ("rap right", "rap only"),
        ("rap both", "primitive act"),
    }


def test_recursive_raps_are_grouped_by_cycle(folder: Path) -> None:
    text = """\
(define-rap (one) (method (task-net (t1 (two)))))
(define-rap (two) (method (task-net (t1 (one)) (t2 (self)))))
(define-rap (self) (method stop (task-net)) (method on (task-net (t1 (self)))))
"""
    (folder / "lib.rap").write_text(text)
    done = rapc("graph", "lib.rap", "--recursive", "--format", "json", cwd=folder)
    groups = {(v["label"], v["group"]) for v in json.loads(done.stdout)["vertices"]}
    assert groups == {("one", "cycle 1"), ("two", "cycle 1"), ("self", "cycle 2")}


def test_graphml_holds_the_same_graph(folder: Path) -> None:
    done = rapc("graph", "lib.rap", "--all", "--format", "graphml", cwd=folder)
    graph = networkx.parse_graphml(done.stdout)
    known, edges = _drawn(folder, "--all")
    assert set(graph.nodes) == set(known)
    assert graph.number_of_edges() == len(edges)


def test_check_and_run_import_no_networkx() -> None:
    code = (
        "import sys; from rapc.cli.main import main\n"
        "try: main(sys.argv[1:])\n"
        "except SystemExit: pass\n"
        "sys.exit('networkx' in sys.modules)"
    )
    task = ("--world", "truck", "--task", "(fill-order red 1 factory-1)", "-q")
    library = str(ROOT / "stdlib" / "truck")
    for args in (("check", library), ("run", library, *task)):
        done = subprocess.run([sys.executable, "-c", code, *args], check=False)
        assert done.returncode == 0


def test_bad_usage(folder: Path) -> None:
    done = rapc("graph", "lib.rap", "--rap", "setp", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == ("error: unknown RAP `setp`\n  did you mean `step`?\n")
    done = rapc("graph", "lib.rap", "--rap", "go", "--claims", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    said = "cannot combine options that select a graph"
    assert done.stderr == f"error: {said}\n"
    done = rapc("graph", "lib.rap", "--dependents", "parkd", cwd=folder)
    assert done.stderr == "error: unknown name `parkd`\n  did you mean `parked`?\n"
    done = rapc("graph", "lib.rap", "--effects", "setp", cwd=folder)
    assert done.stderr == ("error: unknown RAP `setp`\n  did you mean `step`?\n")
    (folder / "lib.rap").write_text("(define-rap (a) (succeed (b)))")
    done = rapc("graph", "lib.rap", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert "RAP015 undeclared-predicate" in done.stderr


# --- skills -------------------------------------------------------------------------


HALL = """\
(require "hallway/world")
(define-rap (follow-hall)
  (method
    (primitive
      (enable (:detect-obstacles) (:track-hallway) (:follow-trajectory))
      (wait-for (:end-o-hall) :succeed)
      (wait-for (:hall-blocked) :fail))))
"""

WORLD = ("--world", "rapc.worlds.hallway:HallwayWorld")


def test_the_network_of_skills_at_a_moment_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "hall.rap").write_text(HALL, encoding="utf-8")
    on = ("graph", "hall.rap", "--skills", "0.5", *WORLD, "--task", "(follow-hall)")
    done = rapc(*on, "--format", "json", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    vertices = json.loads(done.stdout)["vertices"]
    boxes = {box["id"]: box["kind"] for box in vertices}
    assert boxes["track-hallway"] == boxes["detect-obstacles"] == "skill"
    assert boxes["end-o-hall of track-hallway"] == "event"
    assert "sensor" in boxes.values()
    assert rapc(*on, cwd=tmp_path).stdout.startswith('digraph "skills" {\n')
    done = rapc(*on, "--format", "mermaid", cwd=tmp_path)
    assert done.stdout.startswith("flowchart LR\n")
    done = rapc(*on, "--format", "text", cwd=tmp_path)
    assert "sonar\n  sonar detect-obstacles, track-hallway\n" in done.stdout


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--skills", "1"), "--skills requires --world"),
        (WORLD, "--skills requires --world; options of a run require --skills"),
        (("--task", "(follow-hall)"), "require --skills"),
        (("--skills", "1", *WORLD, "--claims"), "cannot combine options"),
        (("--skills", "-1", *WORLD), "-1"),
        (("--skills", "nan", *WORLD), "`nan` is not a finite number"),
        (("--skills", "inf", *WORLD), "`inf` is not a finite number"),
        (("--skills", "soon", *WORLD), "`soon` is not a valid number"),
        (("--skills", "1", *WORLD, "--task", "(gone)"), "unknown RAP `gone`"),
    ],
)
def test_options_incompatible_with_skills_are_refused(
    tmp_path: Path, options: tuple[str, ...], said: str
) -> None:
    (tmp_path / "hall.rap").write_text(HALL, encoding="utf-8")
    done = rapc("graph", "hall.rap", *options, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr


def test_a_moment_at_which_nothing_is_on_says_so(tmp_path: Path) -> None:
    (tmp_path / "hall.rap").write_text(HALL, encoding="utf-8")
    on = ("graph", "hall.rap", "--skills", "0.5", *WORLD)
    drawn = [rapc(*on, *form, cwd=tmp_path) for form in ((), ("--format", "mermaid"))]
    assert all(done.returncode == 0 for done in drawn)
    assert '  label="no active skills";\n' in drawn[0].stdout
    assert drawn[1].stdout == 'flowchart LR\n  n0["no active skills"]\n'
    done = rapc(*on, "--format", "json", cwd=tmp_path)
    nothing: dict[str, object] = {"title": "skills", "vertices": [], "edges": []}
    assert json.loads(done.stdout) == nothing
    done = rapc(*on, "--format", "text", cwd=tmp_path)
    assert done.stdout == "no active skills\n"


def test_the_network_is_drawn_behind_faults(tmp_path: Path) -> None:
    (tmp_path / "hall.rap").write_text(HALL, encoding="utf-8")
    on = ("graph", "hall.rap", "--skills", "0.5", *WORLD, "--task", "(follow-hall)")
    done = rapc(*on, "--fault", "(:end-o-hall) lost", cwd=tmp_path)
    assert done.stderr == ""
    assert '"track-hallway"' in done.stdout


def test_a_world_without_a_network_has_none_to_be_drawn() -> None:
    truck = ("stdlib/truck", "--world", "truck", "--skills", "1")
    done = rapc("graph", *truck, cwd=ROOT)
    assert done.returncode == 2
    assert "the world `truck` has no network of skills" in done.stderr


def test_unknown_tag_is_not_drawn(folder: Path) -> None:
    (folder / "lib.rap").write_text(
        "(define-rap (wait))\n; rapc: ignore[unknown-tag] to be written\n"
        "(define-rap (go) (method (task-net (t1 (wait) (for t2)))))\n"
    )
    known, edges = _drawn(folder, "--rap", "go")
    assert (known, edges) == (["step method/t1"], [])
