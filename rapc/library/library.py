"""The linked library: all definitions of a set of files by name, immutable.

Linking collects the definitions and reports duplicate and reserved names.
Not here: the check of references (`rapc.analysis`), and reading files
(`rapc.library.loader`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from rapc.base.diagnostics import Diagnostic, Label, Rule
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.ir.walk import steps
from rapc.language.heads import ALONE, CALLS, QUERIES
from rapc.library.kinds import KNOWN_KINDS
from rapc.parser.unit import SourceUnit

BUILTIN_NAMES = frozenset((*ALONE, *QUERIES, *CALLS))
"""The reserved first words of formulas and terms [L 2.69]."""

DUPLICATE = Rule(
    code="RAP060",
    name="duplicate-definition",
    summary="two definitions of the same kind have the same name",
    source="T 3.1.1",
)

BUILTIN = Rule(
    code="RAP061",
    name="builtin-name",
    summary="a declaration uses a reserved name",
    source="T 4.1",
)

_RESERVED = {"predicate": BUILTIN_NAMES, "kind": frozenset(KNOWN_KINDS)}
"""The reserved names, by name space."""

RULES = (DUPLICATE, BUILTIN)
"""The rules that linking reports."""


Named = nodes.TopForm | DefineTest
"""The forms that may have a name in a library."""


class Library(msgspec.Struct, frozen=True):
    """All definitions by name, in the order of the text, immutable.

    `files` has every file read, by its name in spans. `forms` has every top-level form,
    also forms with duplicate names, and is empty in a library read from a compiled
    file. `tests` has the tests of all files.

    `methods` has the `define-method` forms, which are not among `forms`: their methods
    are among the methods of their RAPs, in `raps` and in `forms`.
    """

    raps: Mapping[str, nodes.DefineRap]
    propositions: Mapping[str, nodes.DeclareProposition]
    properties: Mapping[str, nodes.DeclareProperty]
    functions: Mapping[str, nodes.DeclareFunction]
    primitives: Mapping[str, nodes.DeclarePrimitive]
    data: Mapping[str, nodes.DeclareDatum]
    skills: Mapping[str, nodes.DeclareSkill]
    events: Mapping[str, nodes.DeclareEvent]
    queries: Mapping[str, nodes.DefineQuery]
    kinds: Mapping[str, nodes.DeclareKind]
    agendas: Mapping[str, nodes.DefineAgenda]
    indistinct: Mapping[str, nodes.DeclareIndistinctClass]
    comparators: tuple[nodes.DeclareComparator, ...]
    memory_rules: tuple[nodes.MemoryRule, ...]
    event_rules: tuple[nodes.EventRule, ...]
    methods: tuple[nodes.DefineMethod, ...]
    files: Mapping[str, SourceFile]
    forms: tuple[nodes.TopForm, ...] = ()
    tests: tuple[DefineTest, ...] = ()


def usable_in_plans(
    raps: Mapping[str, nodes.DefineRap], rap: nodes.DefineRap
) -> tuple[str, ...]:
    """Return the names of the RAPs that the plans of a RAP may use."""
    if rap.plan is None:
        return ()
    return rap.plan.raps or tuple([one.name for one in raps.values() if one.effects])


def calls_of(
    rap: nodes.DefineRap, raps: Mapping[str, nodes.DefineRap]
) -> tuple[str, ...]:
    """Return the RAPs that the steps of a RAP and of its plans may call, each once."""
    called = [step.goal.name for method in rap.methods for step in steps(method)]
    return tuple(dict.fromkeys([*called, *usable_in_plans(raps, rap)]))


KINDS: Mapping[type[nodes.Node], tuple[str, str, str]] = {
    nodes.DefineRap: ("raps", "RAP", "RAP"),
    nodes.DeclareProposition: ("propositions", "predicate", "proposition"),
    nodes.DeclareProperty: ("properties", "predicate", "property"),
    nodes.DeclareFunction: ("functions", "predicate", "function"),
    nodes.DeclarePrimitive: ("primitives", "primitive", "primitive"),
    nodes.DeclareDatum: ("data", "datum", "sensor datum"),
    nodes.DeclareSkill: ("skills", "skill", "skill"),
    nodes.DeclareEvent: ("events", "event", "event"),
    nodes.DefineQuery: ("queries", "predicate", "query"),
    nodes.DeclareKind: ("kinds", "kind", "kind"),
    nodes.DefineAgenda: ("agendas", "agenda", "agenda"),
    nodes.DeclareIndistinctClass: ("indistinct", "class", "indistinct class"),
}
"""For each kind of definition: its field, its name space, its word in messages."""

SEQUENCES: Mapping[type[nodes.Node], str] = {
    nodes.DeclareComparator: "comparators",
    nodes.MemoryRule: "memory_rules",
    nodes.EventRule: "event_rules",
    nodes.DefineMethod: "methods",
}


def link(units: Sequence[SourceUnit]) -> tuple[Library, tuple[Diagnostic, ...]]:
    """Link parsed files into a library; of duplicate definitions the first stays.

    Returns the library and the findings about its names, without the findings of the
    parser.
    """
    files = {unit.file.name: unit.file for unit in units}
    forms = tuple(form for unit in units for form in unit.forms)
    tests = tuple(test for unit in units for test in unit.tests)
    fields: dict[str, Any] = {field: {} for field, _, _ in KINDS.values()}
    sequences: dict[str, list[Named]] = {field: [] for field in SEQUENCES.values()}
    taken: dict[tuple[str, ...], Named] = {}
    found: list[Diagnostic] = []
    for form in (*forms, *tests):
        key = _key(form)
        first = form if key is None else taken.setdefault(key, form)
        if first is not form:
            found.append(_duplicate(files, first, form))
        elif (kind := KINDS.get(type(form))) is not None:
            field, space, _ = kind
            name = _name(form)
            fields[field][name] = form
            if name in _RESERVED.get(space, ()):
                found.append(_builtin(files, form))
        elif (field_ := SEQUENCES.get(type(form))) is not None:
            sequences[field_].append(form)
    if sequences["methods"]:
        added = [one for one in forms if isinstance(one, nodes.DefineMethod)]
        raps, duplicates = _with_methods(files, fields["raps"], added)
        others = (one for one in forms if not isinstance(one, nodes.DefineMethod))
        forms = tuple([raps.get(id(form), form) for form in others])
        fields["raps"] = {name: raps[id(rap)] for name, rap in fields["raps"].items()}
        found += duplicates
    fields.update((field, tuple(rows)) for field, rows in sequences.items())
    return Library(**fields, files=files, forms=forms, tests=tests), tuple(found)


def _with_methods(
    files: Mapping[str, SourceFile],
    raps: Mapping[str, nodes.DefineRap],
    forms: Iterable[nodes.DefineMethod],
) -> tuple[dict[int, nodes.DefineRap], list[Diagnostic]]:
    """Return the RAPs with their added methods, by the `id` of the RAP without them.

    Duplicate methods are reported and left out. The checker reports unknown RAPs.
    """
    added: dict[str, list[nodes.DefineMethod]] = {}
    for form in forms:
        added.setdefault(form.rap, []).append(form)
    found: list[Diagnostic] = []
    made: dict[int, nodes.DefineRap] = {}
    for name, rap in raps.items():
        made[id(rap)], duplicates = with_methods(rap, added.get(name, ()))
        found += [_duplicate_method(files, rap, *pair) for pair in duplicates]
    return made, found


def with_methods(
    rap: nodes.DefineRap, added: Iterable[nodes.DefineMethod]
) -> tuple[nodes.DefineRap, list[tuple[nodes.Method, nodes.DefineMethod]]]:
    """Return a RAP with added methods after its own, and the duplicate methods.

    A duplicate method has the name of another method, which comes first in its pair,
    and is left out.
    """
    methods = list(rap.methods)
    first = {one.name: one for one in methods if one.name is not None}
    duplicates = []
    for form in added:
        made = msgspec.structs.replace(form.method, position=len(methods) + 1)
        other = first.setdefault(made.name, made) if made.name is not None else made
        if other is made:
            methods.append(made)
        else:
            duplicates.append((other, form))
    if len(methods) == len(rap.methods):
        return rap, duplicates
    return msgspec.structs.replace(rap, methods=tuple(methods)), duplicates


def own_methods(rap: nodes.DefineRap) -> tuple[nodes.Method, ...]:
    """Return the methods of a RAP that are not added by `define-method`."""
    return tuple([one for one in rap.methods if rap.span.contains(one.span)])


def digest(library: Library) -> str:
    """Return a digest of the texts of a library, in order.

    The digest does not depend on the paths of the sources.
    """
    import hashlib  # noqa: PLC0415  # a check needs no digest

    found = hashlib.sha256()
    for source in library.files.values():
        text = source.text.encode("utf-8", "surrogatepass")
        found.update(b"%d\n" % len(text))
        found.update(text)
    found.update(" ".join(library.raps).encode("utf-8", "surrogatepass"))
    return found.hexdigest()


def name_span(files: Mapping[str, SourceFile], form: Named) -> Span:
    """Return the span of the name in a definition; if unknown, of the whole form."""
    found: Span | None = getattr(form, "name_span", None)
    return found or word_span(files, form.span, 1)


def word_span(files: Mapping[str, SourceFile], span: Span, position: int) -> Span:
    """Return the span of a word at the front of a list; its head is word 0."""
    source = files.get(span.file)
    return span if source is None else source.word(span, position)


def _key(form: Named) -> tuple[str, ...] | None:
    """Return the key that makes a form unique; None if duplicates are allowed."""
    if isinstance(form, nodes.DeclareComparator):
        return ("comparator", form.class_name, form.place or "")
    if isinstance(form, DefineTest):
        return ("test", form.span.file, form.name)
    kind = KINDS.get(type(form))
    return None if kind is None else (kind[1], _name(form))


def _name(form: Named) -> str:
    name = getattr(form, "name", "")
    assert isinstance(name, str)
    return name


def _duplicate(
    files: Mapping[str, SourceFile], first: Named, second: Named
) -> Diagnostic:
    help = "rename or remove one of the two definitions"
    if isinstance(second, DefineTest):
        what = f"test `{second.name}`"
    elif isinstance(second, nodes.DeclareComparator):
        what = f"a comparator for class `{second.class_name}`"
        what += f" at `{second.place}`" if second.place else ""
    else:
        what = f"{KINDS[type(second)][2]} `{_name(second)}`"
    if first == second and not isinstance(second, DefineTest):
        help = (
            "the two definitions are equal: keep one, and `require` its "
            "file from the other file"
        )
    elif type(first) is not type(second):
        help = "propositions, properties, functions and queries share one namespace: "
        help += "rename one of them"
    return DUPLICATE.at(
        name_span(files, second),
        f"duplicate definition of {what}",
        labels=(Label(name_span(files, first), "first defined here"),),
        help=help,
    )


def _duplicate_method(
    files: Mapping[str, SourceFile],
    rap: nodes.DefineRap,
    first: nodes.Method,
    second: nodes.DefineMethod,
) -> Diagnostic:
    word = 1 if rap.span.contains(first.span) else 2
    return Diagnostic(
        "duplicate-method",
        f"duplicate method name `{second.method.name}` of `{rap.name}`",
        word_span(files, second.span, 2),
        labels=(Label(word_span(files, first.span, word), "the first is here"),),
        help="`method-tried` and `result-with-method` identify methods by name",
    )


def _builtin(files: Mapping[str, SourceFile], form: Named) -> Diagnostic:
    return BUILTIN.at(
        name_span(files, form),
        f"`{_name(form)}` is a reserved name",
        help="choose another name",
    )
