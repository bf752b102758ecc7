"""Checks, before the first cycle, that library and world fit.

The checks find names that a library declares and the world does not offer, and
callables that are not registered. Not here: whether a task can be run
(`rapc.runtime.task_request`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rapc.base.source import Span
from rapc.base.values import Fact, format_list
from rapc.compiler.program import Program
from rapc.errors import RefusedError
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.signatures import Signatures, Use
from rapc.runtime.authors import takes, wrong_arities
from rapc.runtime.held_world import HeldWorld
from rapc.world import Skilled, World, innermost, methods_of

_Offered = (
    nodes.DeclarePrimitive
    | nodes.DeclareDatum
    | nodes.DeclareSkill
    | nodes.DeclareEvent
)

_EXAMPLES = 3
"""The number of example names in the report of a world that does not fit."""


def refuse_other_world(program: Program, world: World) -> None:
    """Refuse a world that lacks most of the names that a library declares.

    Raises:
        RefusedError: with one line for all missing names, and the names.
    """
    library = program.library
    offered = Signatures.offered(world.kit.offer)
    declared = [(use, one) for use, forms in _offers(library) for one in forms.values()]
    lacking = [
        (use, one)
        for use, one in declared
        if (fault := offered.fault(use, one.name, len(one.args))) is not None
        and fault.declared is None
    ]
    if len(lacking) > _EXAMPLES and 2 * len(lacking) > len(declared):
        shown = _listed([one.name for _, one in lacking[:_EXAMPLES]])
        *kinds, last = dict.fromkeys(_PLURAL[use] for use, _ in lacking)
        whole = f"{', '.join(kinds)} and {last}" if kinds else last
        place = _place(library, lacking[0][1].span)
        line = (
            f"{place}the library is not for the world `{world.name}`: "
            f"{len(lacking)} of its {len(declared)} {whole} are missing: {shown} "
            f"and {len(lacking) - _EXAMPLES} more"
        )
        raise RefusedError([line], [one.name for _, one in lacking])


_PLURAL: Mapping[Use, str] = {
    "primitive": "primitives",
    "datum": "sensor data",
    "skill": "skills",
    "event": "events",
}


def _offers(library: Library) -> tuple[tuple[Use, Mapping[str, _Offered]], ...]:
    """Return the library's declarations about the world, by kind."""
    return (
        ("primitive", library.primitives),
        ("datum", library.data),
        ("skill", library.skills),
        ("event", library.events),
    )


def refusals(program: Program, world: HeldWorld) -> list[str]:
    """Return the reasons why a library cannot be run in a world, one line each."""
    library = program.library
    return [
        *_lacking(library, world),
        *_untellable(library, program.signatures, world, world.facts()),
        *_unregistered(library, world.code["the function"]),
        *_uncompared(library, world.code["the comparator"]),
        *_unskilled(library, world),
    ]


def misfitting(program: Program, world: HeldWorld) -> list[str]:
    """Return a line for each callable of an author with a wrong number of arguments."""
    code, own = world.code, innermost(world)
    found = [
        line
        for protocol in (World, Skilled)
        if isinstance(own, protocol)
        for name in methods_of(protocol)
        for line in wrong_arities(
            f"the world `{world.name}`:",
            {name: getattr(own, name)},
            getattr(protocol, name).__code__.co_argcount - 1,
        )
    ]
    counts = (
        ("the handler of", 3),
        ("the handler of the datum", 2),
        ("the solver of", 2),
    )
    for what, given in counts:
        found += wrong_arities(what, code[what], given)
    comparators = code["the comparator"].items()
    with_memory = {name for name, call in comparators if _takes_memory(call)}
    without = {name: call for name, call in comparators if name not in with_memory}
    found += wrong_arities("the comparator", without, 2)
    functions, library = code["the function"], program.library
    for declared in library.functions.values():
        if declared.name in functions and declared.args is not None:
            one = {declared.name: functions[declared.name]}
            found += wrong_arities("the function", one, 1 + len(declared.args))
    return list(dict.fromkeys(found))


def _lacking(library: Library, world: World) -> Iterator[str]:
    """Yield the declarations of the library that the world's offer does not match."""
    offered = Signatures.offered(world.kit.offer)
    for use, declared in _offers(library):
        for form in declared.values():
            fault = offered.fault(use, form.name, len(form.args))
            place = _place(library, form.span)
            if fault is not None:
                yield f"{place}in the world `{world.name}` {fault}"
            elif isinstance(form, nodes.DeclarePrimitive):
                if form.atomic and form.name in world.kit.offer.not_atomic:
                    yield (
                        f"{place}`{form.name}` is not atomic in the world "
                        f"`{world.name}`; declare it with `:atomic false`"
                    )
                offers = offered.primitives[form.name].results
                more = [result for result in offers if result not in form.results]
                if more:
                    yield (
                        f"{place}the world `{world.name}` may answer `{form.name}` "
                        f"with {_listed(more)}, not declared here; add what it answers"
                    )


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _untellable(
    library: Library, signatures: Signatures, world: World, facts: Iterable[Fact]
) -> Iterator[str]:
    """Yield the first facts of the world that the library does not declare."""
    unknown: dict[str, None] = {}
    told: set[str] = set()
    for fact in facts:
        name = str(fact[0])
        fault = signatures.fault("asserted", name, len(fact) - 1)
        known = signatures.relations.get(name)
        short = known is not None and known.leaves_value_out(len(fact) - 1)
        if (fault is None and not short) or name in told:
            continue
        told.add(name)
        telling = f"the world `{world.name}` has the initial fact {format_list(fact)}"
        if known is not None and fault is None:
            said = f"`{known.written}` takes all of its arguments from a world"
            yield f"{_place(library, known.span)}{said}: {telling}"
        elif fault is not None and fault.declared is not None:
            place = _place(library, fault.declared.span)
            yield f"{place}{fault.message}: {telling}"
        else:
            unknown[f"`{name}`"] = None
    if unknown:
        yield (
            f"the world `{world.name}` has initial facts of {', '.join(unknown)}, not "
            "declared in the library; `require` the declarations of the world"
        )


def _unregistered(library: Library, functions: Mapping[str, object]) -> Iterator[str]:
    for declared in library.properties.values():
        default = declared.default
        if default in functions and default not in library.functions:
            place = _place(library, declared.span)
            yield (
                f"{place}the default `{default}` of `{declared.name}` is a constant, "
                "but a function has the same name: add "
                f"`(declare-memory-function {default} (?index))`"
            )
    for function in library.functions.values():
        if function.name not in functions:
            place = _place(library, function.span)
            yield f"{place}unknown function `{function.name}`"


def _takes_memory(comparator: object) -> bool:
    return callable(comparator) and takes(comparator, 3)


def _uncompared(library: Library, comparators: Mapping[str, object]) -> Iterator[str]:
    named = [(node.comparator, node.span) for node in library.indistinct.values()]
    named.extend((node.function, node.span) for node in library.comparators)
    for name, span in named:
        if name is not None and name not in comparators:
            place = _place(library, span)
            yield f"{place}unknown comparator `{name}`"


def _unskilled(library: Library, world: World) -> Iterator[str]:
    """Yield the reasons why a world cannot run the skills of a library."""
    if library.skills and not isinstance(world, Skilled):
        yield (
            f"the world `{world.name}` cannot run skills: it has no `activate` or no "
            "`deactivate` method"
        )


def refuse_extension(old: Library, new: Library) -> None:
    """Refuse a library that differs from `old` in more than added RAPs.

    Raises:
        RefusedError: with one line for each difference.
    """
    reasons = [
        f"the RAP `{name}` differs from the RAP in the run"
        for name, rap in old.raps.items()
        if new.raps.get(name) != rap
    ]
    for field in old.__struct_fields__:
        same = field in ("raps", "methods", "forms", "files", "tests")
        if not same and getattr(old, field) != getattr(new, field):
            reasons.append(f"a run accepts new RAPs, but no changed {field}")
    if reasons:
        raise RefusedError(reasons)


def _place(library: Library, span: Span) -> str:
    source = library.files.get(span.file)
    if source is None:
        return ""
    position = source.position(span.start)
    return f"{span.file}:{position.row}:{position.column}: "
