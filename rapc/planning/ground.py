"""The instances of operators that a situation can lead to.

Facts are joined with the conditions of the operators until no new fact is reachable;
effects only add facts in this reckoning. The result is a problem over numbered atoms:
an atom is a fact that is present, or a fact that is absent.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any, NamedTuple

from rapc.base.values import Atom, Fact, Number, format_atom, format_list
from rapc.ir import nodes
from rapc.ir.walk import variable_names
from rapc.library.kinds import UNKNOWN
from rapc.library.library import Library
from rapc.library.operators import (
    FRESH,
    Conjunction,
    Effect,
    Model,
    Name,
    Operator,
    Pattern,
    Term,
    variables_of,
)

MOST_ACTIONS = 20_000
"""The greatest number of instances; a larger problem is not solved."""

MOST_ALTERNATIVES = 1_000
"""The greatest number of ways to bring about a part of the goal."""

Bindings = dict[str, Atom]

Key = tuple[Any, ...]
"""A fact whose name may have an age, see `Name`."""

Situation = Mapping[Fact, Number | None]
"""The facts in memory, each with its age; None for an unknown age."""

Computing = Callable[[nodes.Term, Bindings], Number | None]
"""A function that computes a term in memory; None for a value that is no number."""


class TooLargeError(Exception):
    """A problem with too many instances."""


class Placeholder(str):
    """An item that a step will find: the value of an output until then."""

    kind: str | None
    #: The placeholder that is used before this one.
    before: str | None

    def __new__(cls, name: str, number: int, kinds: Mapping[str, str]) -> Placeholder:
        """Return a placeholder; its name begins with that of the output."""
        made = super().__new__(cls, f"{name} {number}")
        made.kind = kinds.get(name.partition(" ")[0])
        made.before = f"{name} {number - 1}" if number else None
        return made


class Action(NamedTuple):
    """An instance of an operator, with the numbers of atoms."""

    operator: Operator
    values: Bindings
    needs: tuple[int, ...]
    adds: tuple[int, ...]
    #: The atoms that do not hold afterwards, or are uncertain.
    deletes: tuple[int, ...]
    cost: Number = 1
    #: The needed atoms that only give the cost a value.
    weighed: frozenset[int] = frozenset()

    @property
    def goal(self) -> Fact:
        """Return the name of the RAP and the inputs."""
        rap = self.operator.rap
        return (rap.name, *[self.values[one.name] for one in rap.inputs])

    @property
    def step(self) -> tuple[Fact, tuple[Atom, ...]]:
        """Return the goal and the outputs: what a plan says of the action."""
        outputs = self.operator.rap.outputs
        return self.goal, tuple([self.values[one.name] for one in outputs])


class Literal(NamedTuple):
    """A fact that is present or absent."""

    present: bool
    fact: Key

    @property
    def plain(self) -> Fact:
        """Return the fact without an age."""
        return tuple([n[0] if isinstance(n, tuple) else n for n in self.fact])

    def __str__(self) -> str:
        text = format_list(self.plain)
        return text if self.present else f"(not {text})"


class Limit(NamedTuple):
    """The greatest number of facts of a proposition with `:at-most`."""

    #: The atoms of the facts that a plan can bring about or erase.
    atoms: frozenset[int]
    #: The greatest number of these atoms that may hold.
    most: int

    def allows(self, before: Collection[int], after: Collection[int]) -> bool:
        """Return whether an action may lead from one state to another."""
        count = len(self.atoms.intersection(after))
        return count <= max(self.most, len(self.atoms.intersection(before)))


Way = tuple[int, ...]
"""The atoms that together bring about a part of the goal."""


class Problem(NamedTuple):
    """A planning problem over numbered atoms."""

    literals: Sequence[Literal]
    actions: Sequence[Action]
    #: The atoms that hold at the beginning.
    state: frozenset[int]
    #: The branches of the goal: all parts of a branch must hold, each in one way.
    goal: tuple[tuple[tuple[Way, ...], ...], ...]
    #: The patterns of the goal that are not reachable.
    unreachable: tuple[str, ...]
    #: The atoms that an action brings about or spoils.
    changing: frozenset[int]
    #: The atoms that only give the placeholders an order.
    counters: frozenset[int]
    limits: tuple[Limit, ...] = ()


class _Table:
    """The reachable facts of a name, indexed by the value of each argument."""

    def __init__(self) -> None:
        self.facts: dict[Key, None] = {}
        self.index: dict[tuple[int, object], list[Key]] = {}

    def add(self, fact: Key) -> None:
        self.facts[fact] = None
        for at, value in enumerate(fact):
            self.index.setdefault((at, value), []).append(fact)

    def narrowest(self, values: Sequence[Atom | None]) -> Collection[Key]:
        """Return the facts that share the rarest known argument (None: unknown)."""
        found: Collection[Key] = self.facts
        for at, value in enumerate(values, 1):
            if value is not None:
                narrowed = self.index.get((at, value), ())
                found = narrowed if len(narrowed) < len(found) else found
        return found


_NO_FACTS = _Table()
_USED = "placeholder used"
"""The name of the counters of placeholders, which no text can contain."""


class Grounding:
    """The grounding of a model for a situation and a goal.

    Args:
        model: the operators.
        situation: the facts.
        goal: the branches of the goal.
        excluded: the goals of steps that must not be used.
        compute: computes the costs of steps in memory.

    Raises:
        TooLargeError: for more than `MOST_ACTIONS` instances.
    """

    def __init__(
        self,
        model: Model,
        situation: Situation,
        goal: Sequence[Conjunction],
        excluded: Collection[Fact] = (),
        compute: Computing | None = None,
    ) -> None:
        self._compute = compute
        self._model, self._kinds, self._goal = model, model.signatures.kinds, goal
        self._library: Library = model.library
        self._excluded = excluded
        self._tables: dict[Name, _Table] = {}
        self._queue: deque[Key] = deque()
        #: Whether all instances are known; later facts are defaults that are asked.
        self._reached = False
        self._initial: dict[Key, None] = {}
        #: The indexes of properties with a value at the beginning.
        self._valued: set[Key] = set()
        self._known: set[Key] = set()
        self._instances: dict[tuple[object, ...], tuple[Operator, Bindings]] = {}
        conditions = [one.conditions for one in model.operators]
        patterns = [*_patterns([*conditions, *goal])]
        self._asked = {_plain(pattern.name) for pattern in patterns}
        #: The ages at which a name is asked.
        self._ages: dict[str, dict[Number, None]] = {}
        for pattern in patterns:
            if isinstance(pattern.name, tuple):
                name, age = pattern.name
                self._ages.setdefault(name, {})[age] = None
        self._begin(situation)
        self._objects = self._known_objects(situation, patterns)
        wanted = {name for branch in goal for name in variables_of(branch)}
        self._copies = max(2, len(wanted))
        self._reach()

    # --- the beginning ---------------------------------------------------------------

    def _begin(self, situation: Situation) -> None:
        """Take in the facts of the names that a condition asks."""
        for fact, age in situation.items():
            name = str(fact[0])
            if name not in self._asked:
                continue
            if name in self._library.properties:
                self._valued.add(fact[:-1])
            self._first(fact)
            for limit in self._ages.get(name, ()):
                if age is not None and age < limit:
                    self._first(((name, limit), *fact[1:]))

    def _first(self, fact: Key) -> None:
        self._initial[fact] = None
        self._arrive(fact)

    def _arrive(self, fact: Key) -> None:
        if fact in self._known:
            return
        self._known.add(fact)
        if self._reached:
            self._table(fact[0]).add(fact)
        else:
            self._queue.append(fact)

    def _take_default(self, index: Key) -> None:
        """Take in the default of a property without a value for an index."""
        name = _plain(index[0])
        plain = (name, *index[1:])
        if name in self._model.defaults and plain not in self._valued:
            self._first((*index, self._model.defaults[name]))

    def _take_defaults(self, operator: Operator, pattern: Pattern) -> None:
        """Take in the defaults of a property that a condition asks of any inputs.

        Other defaults are taken in when a join has values for the index, and so are
        those of more than `MOST_ALTERNATIVES` inputs.
        """
        default = self._model.defaults.get(_plain(pattern.name))
        value = pattern.args[-1] if pattern.args else None
        if default is None or not (isinstance(value, nodes.Var) or value == default):
            return
        inputs = {one.name for one in operator.rap.inputs}
        choices: list[Sequence[Atom]] = []
        for arg in pattern.args[:-1]:
            if not isinstance(arg, nodes.Var):
                choices.append([arg])
            elif arg.name in inputs:
                choices.append(self._of_kind(operator.kinds.get(arg.name)))
            else:
                return
        if prod(map(len, choices)) <= MOST_ALTERNATIVES:
            for index in product(*choices):
                self._take_default((pattern.name, *index))

    def _known_objects(
        self, situation: Situation, patterns: Iterable[Pattern]
    ) -> dict[str, dict[Atom, None]]:
        """Return the known values of each declared kind."""
        found: dict[str, dict[Atom, None]] = {}
        declared: dict[str, tuple[nodes.Argument, ...]] = {
            name: form.args or ()
            for table in (self._library.propositions, self._library.properties)
            for name, form in table.items()
        }

        def see(name: str, args: Sequence[object]) -> None:
            for arg, value in zip(declared.get(name, ()), args, strict=False):
                if type(value) is str and value != UNKNOWN:
                    found.setdefault(arg.kind or "symbol", {})[value] = None

        for fact in situation:
            see(str(fact[0]), fact[1:])
        for pattern in patterns:
            see(_plain(pattern.name), pattern.args)
        for operator in self._model.operators:
            for effect in operator.effects:
                see(effect.name, effect.args)
        return found

    def _of_kind(self, kind: str | None) -> list[Atom]:
        """Return the known values of a kind, in the order of their names."""
        found: dict[Atom, None] = {}
        closed = None if kind is None else self._kinds.values(kind)
        if closed is not None and kind in self._library.kinds:
            return list(closed)
        for name, values in self._objects.items():
            if kind in (None, "item", "symbol", name, *self._kinds.above(name)):
                found.update(values)
        return sorted(found, key=format_atom)

    def _placeholders(self, operator: Operator, values: Bindings) -> list[Bindings]:
        """Return the placeholders that a goal may have for its outputs.

        Each goal has its own, as many as the goal of the plan has variables, and at
        least two: items of different goals are different.
        """
        rap = operator.rap
        if not rap.outputs:
            return [{}]
        inputs = " ".join([format_atom(values[one.name]) for one in rap.inputs])
        return [
            {
                one.name: Placeholder(
                    f"{one.name} {rap.name} {inputs}", number, operator.kinds
                )
                for one in rap.outputs
                if one.name not in values
            }
            for number in range(self._copies)
        ]

    # --- reachability ----------------------------------------------------------------

    def _reach(self) -> None:
        """Find all instances: join each new fact with the facts before it."""
        users: dict[Name, list[tuple[Operator, int]]] = {}
        for operator in self._model.operators:
            for at, pattern in enumerate(operator.conditions.present):
                users.setdefault(pattern.name, []).append((operator, at))
                self._take_defaults(operator, pattern)
            if not operator.conditions.present:
                self._join(operator, [], {})
        while self._queue:
            fact = self._queue.popleft()
            self._table(fact[0]).add(fact)
            for operator, at in users.get(fact[0], ()):
                present = operator.conditions.present
                bindings = _matched(present[at], fact, {})
                if bindings is not None:
                    rest = [*present[:at], *present[at + 1 :]]
                    self._join(operator, rest, bindings)
        self._reached = True

    def _table(self, name: Name) -> _Table:
        return self._tables.setdefault(name, _Table())

    def _join(
        self, operator: Operator, rest: list[Pattern], bindings: Bindings
    ) -> None:
        for found in self._solutions(rest, bindings):
            if self._bind_equal(operator.conditions, found):
                self._complete(operator, found)

    def _solutions(
        self, rest: Sequence[Pattern], bindings: Bindings
    ) -> Iterator[Bindings]:
        """Yield the solutions of patterns, that with the fewest facts first."""
        if not rest:
            yield bindings
            return
        at = 0
        facts: Collection[Key] = ()
        for number, pattern in enumerate(rest):
            found = self._candidates(pattern, bindings)
            if not number or len(found) < len(facts):
                at, facts = number, found
            if not facts:
                return
        others = [*rest[:at], *rest[at + 1 :]]
        for fact in list(facts):
            matched = _matched(rest[at], fact, bindings)
            if matched is not None:
                yield from self._solutions(others, matched)

    def _candidates(self, pattern: Pattern, bindings: Bindings) -> Collection[Key]:
        """Return the facts that share the rarest known argument with a pattern."""
        values = [_value(arg, bindings) for arg in pattern.args]
        if _plain(pattern.name) in self._model.defaults and None not in values[:-1]:
            self._take_default((pattern.name, *values[:-1]))
        table = self._tables.get(pattern.name, _NO_FACTS)
        return table.narrowest(values)

    def _bind_equal(self, conditions: Conjunction, bindings: Bindings) -> bool:
        """Bind variables that equal a known value; return whether equalities hold."""
        for equal, left, right in conditions.equalities * 2:
            one, other = _value(left, bindings), _value(right, bindings)
            if one is None or other is None:
                if equal and isinstance(left, nodes.Var) and other is not None:
                    bindings[left.name] = other
                elif equal and isinstance(right, nodes.Var) and one is not None:
                    bindings[right.name] = one
            elif (one == other) != equal:
                return False
        return True

    def _complete(self, operator: Operator, bindings: Bindings) -> None:
        """Give a value to each input and output; take in the effects."""
        rap, kinds = operator.rap, operator.kinds
        for one in rap.inputs:
            value = bindings.get(one.name)
            if value is not None and not self._is_of(kinds.get(one.name), value):
                return
        free = [one.name for one in rap.inputs if one.name not in bindings]
        choices: list[Sequence[Atom]] = [self._of_kind(kinds.get(n)) for n in free]
        for values in product(*choices):
            inputs = {**bindings, **dict(zip(free, values, strict=True))}
            for outputs in self._placeholders(operator, inputs):
                found = {**inputs, **outputs}
                if self._bind_equal(operator.conditions, found):
                    self._instance(operator, found)

    def _is_of(self, kind: str | None, value: Atom) -> bool:
        if kind is None:
            return True
        if isinstance(value, Placeholder):
            return value.kind is None or not self._kinds.apart(value.kind, kind)
        return self._kinds.holds(kind, value)

    def _instance(self, operator: Operator, bindings: Bindings) -> None:
        rap = operator.rap
        if (rap.name, *[bindings[one.name] for one in rap.inputs]) in self._excluded:
            return
        key = (id(operator), *sorted(bindings.items(), key=lambda item: item[0]))
        if key in self._instances:
            return
        if len(self._instances) >= MOST_ACTIONS:
            raise TooLargeError
        self._instances[key] = operator, bindings
        for effect in operator.effects:
            if effect.sort == "add" and effect.name in self._asked:
                fact = _instance_of(effect, bindings)
                if None not in fact:
                    for aged in self._all_ages(fact):
                        self._arrive(aged)

    def _all_ages(self, fact: tuple[Atom | None, ...]) -> Iterator[Key]:
        """Yield a fact that has just been brought about, for each asked age."""
        name = str(fact[0])
        yield fact
        for limit in self._ages.get(name, ()):
            yield ((name, limit), *fact[1:])

    # --- the problem -----------------------------------------------------------------

    def problem(self) -> Problem:
        """Return the problem over numbered atoms.

        Raises:
            TooLargeError: for a goal with more than `MOST_ALTERNATIVES` ways.
        """
        numbers: dict[Literal, int] = {}
        rows = sorted(
            self._instances.values(),
            key=lambda row: (row[0].rap.name, *_sort_key(row[1])),
        )
        goal, unreachable = self._goal_ways(numbers)
        needed = [self._needs(operator, values) for operator, values in rows]
        limited = self._limited(numbers)
        for literals in needed:
            for literal in literals or ():
                numbers.setdefault(literal, len(numbers))
        actions = []
        state = {at for literal, at in numbers.items() if self._holds(literal)}
        for (operator, values), literals in zip(rows, needed, strict=True):
            if literals is None:
                continue
            adds, deletes = self._changes(operator, values)
            needs = {numbers[one]: None for one in literals}
            added = {numbers[one]: None for one in adds if one in numbers}
            deleted = {numbers[one]: None for one in deletes if one in numbers}
            lost = tuple([at for at in deleted if at not in added])
            gained = tuple(added)
            for output in operator.rap.outputs:
                value = values[output.name]
                if not isinstance(value, Placeholder):
                    continue
                unused, used = (
                    numbers.setdefault(Literal(here, (_USED, value)), len(numbers))
                    for here in (False, True)
                )
                state.add(unused)
                needs[unused] = None
                lost, gained = (*lost, unused), (*gained, used)
                if value.before is not None:
                    before = Literal(True, (_USED, value.before))
                    needs[numbers.setdefault(before, len(numbers))] = None
            weighed = [_fact_of(one, values) for one in operator.weighed]
            rest = (
                self._cost(operator, values),
                frozenset([numbers[Literal(True, one)] for one in weighed]),
            )
            actions.append(Action(operator, values, tuple(needs), gained, lost, *rest))
        literals_found = list(numbers)
        counted = [at for at, one in enumerate(literals_found) if one.fact[0] == _USED]
        return Problem(
            literals_found,
            actions,
            frozenset(state),
            goal,
            unreachable,
            frozenset([at for one in actions for at in (*one.adds, *one.deletes)]),
            frozenset(counted),
            limited,
        )

    def _limited(self, numbers: dict[Literal, int]) -> tuple[Limit, ...]:
        """Return the limits of propositions; number the facts that can change."""
        found = []
        for name, form in self._library.propositions.items():
            if form.at_most is None or name not in self._tables:
                continue
            facts = self._tables[name].facts
            changing = [one for one in facts if self._can_change(one)]
            atoms = [
                numbers.setdefault(Literal(True, f), len(numbers)) for f in changing
            ]
            most = form.at_most - (len(facts) - len(changing))
            found.append(Limit(frozenset(atoms), most))
        return tuple(found)

    def _cost(self, operator: Operator, values: Bindings) -> Number:
        """Return the cost of an instance: 1 if it cannot be computed."""
        if isinstance(operator.cost, int | float):
            return operator.cost
        if self._compute is None:
            return 1
        names = variable_names(operator.cost)
        known = {name: values[name] for name in names if name in values}
        if any(isinstance(one, Placeholder) for one in known.values()):
            return 1
        found = self._compute(operator.cost, known)
        return 1 if found is None else max(found, 0)

    def _holds(self, literal: Literal) -> bool:
        return (literal.fact in self._initial) == literal.present

    def _needs(self, operator: Operator, values: Bindings) -> list[Literal] | None:
        """Return what an instance needs; None if that cannot be."""
        return self._literals(operator.conditions, values)

    def _literals(self, wanted: Conjunction, values: Bindings) -> list[Literal] | None:
        """Return the atoms of a conjunction with a value for each bound variable."""
        found = [Literal(True, _fact_of(one, values)) for one in wanted.present]
        for part in wanted.absent:
            absent = self._absent(part, values)
            if absent is None:
                return None
            found += absent
        return found

    def _absent(self, part: Conjunction, values: Bindings) -> list[Literal] | None:
        """Return the facts that must be absent so that a conjunction does not hold.

        A conjunction of several facts does not hold if its last fact that can change is
        absent; the facts that cannot change decide by themselves.
        """
        found: list[Literal] = []
        for bindings in list(self._solutions(part.present, dict(values))):
            if not self._bind_equal(part, bindings):
                continue
            facts = [_fact_of(one, bindings) for one in part.present]
            changing = [one for one in facts if self._can_change(one)]
            if changing:
                found.append(Literal(False, changing[-1]))
                continue
            required = [
                self._literals(one, bindings)
                for one in part.absent
                if set(variables_of(one)) <= bindings.keys()
            ]
            if not required or required[0] is None:
                return None
            found += required[0]  # not (fact and not other): the other must hold
        return found

    def _can_change(self, fact: Key) -> bool:
        """Return whether a fact is absent at first, or may be erased."""
        if fact not in self._initial:
            return True
        name = _plain(fact[0])
        return any(
            effect.name == name
            and (effect.sort != "add" or name in self._library.properties)
            for operator in self._model.operators
            for effect in operator.effects
        )

    def _changes(
        self, operator: Operator, values: Bindings
    ) -> tuple[list[Literal], list[Literal]]:
        """Return the atoms that an instance brings about, and those that it spoils."""
        adds: list[Literal] = []
        deletes: list[Literal] = []
        for effect in operator.effects:
            if effect.name not in self._asked:
                continue
            pattern = _instance_of(effect, values)
            known = None not in pattern
            if effect.sort == "add" and effect.name in self._library.properties:
                for fact in self._matching((*pattern[:-1], None)):
                    deletes.append(Literal(True, fact))
                    (adds if known else deletes).append(Literal(False, fact))
            if effect.sort == "add" and known:
                for fact in self._all_ages(pattern):
                    adds.append(Literal(True, fact))
                    deletes.append(Literal(False, fact))
                continue
            for fact in self._matching(pattern):
                if effect.sort == "erase":
                    deletes.append(Literal(True, fact))
                    adds.append(Literal(False, fact))
                else:
                    if effect.sort == "may":
                        deletes.append(Literal(True, fact))
                    deletes.append(Literal(False, fact))
        certain = {one.fact for one in adds if one.present}
        return [one for one in adds if one.present or one.fact not in certain], deletes

    def _matching(self, pattern: tuple[Atom | None, ...]) -> Iterator[Key]:
        """Yield the reachable facts of a pattern, for each asked age."""
        name = str(pattern[0])
        keys: list[Name] = [name, *[(name, age) for age in self._ages.get(name, ())]]
        for key in keys:
            table = self._tables.get(key, _NO_FACTS)
            for fact in table.narrowest(pattern[1:]):
                if len(fact) == len(pattern) and all(
                    value is None or fact[at] == value
                    for at, value in enumerate(pattern[1:], 1)
                ):
                    yield fact

    # --- the goal --------------------------------------------------------------------

    def _goal_ways(
        self, numbers: dict[Literal, int]
    ) -> tuple[tuple[tuple[tuple[Way, ...], ...], ...], tuple[str, ...]]:
        """Return the ways to bring about each part of each branch."""
        branches = []
        missing: dict[str, None] = {}
        for branch in self._goal:
            parts = []
            for part in _parts(branch):
                ways: dict[Way, None] = {}
                for solution in self._solutions(part.present, {}):
                    if self._bind_equal(part, solution):
                        literals = self._literals(part, solution)
                        if literals is not None:
                            way = [
                                numbers.setdefault(one, len(numbers))
                                for one in literals
                            ]
                            ways[tuple(dict.fromkeys(way))] = None
                    if len(ways) > MOST_ALTERNATIVES:
                        raise TooLargeError
                parts.append(tuple(ways))
                if not ways:
                    missing.update(dict.fromkeys(_texts(part)))
            if all(parts):
                branches.append(tuple(parts))
        return tuple(branches), tuple(missing)


def _parts(branch: Conjunction) -> list[Conjunction]:
    """Return the parts of a conjunction that have no common variable."""
    single = [
        *[Conjunction((one,), (), ()) for one in branch.present],
        *[Conjunction((), (one,), ()) for one in branch.absent],
        *[Conjunction((), (), (one,)) for one in branch.equalities],
    ]
    bound = {
        name for one in single[: len(branch.present)] for name in variables_of(one)
    }
    groups: list[tuple[set[str], Conjunction]] = []
    for one in single:
        names = set(variables_of(one)) & bound
        merged = one
        others = []
        for group in groups:
            if names & group[0]:
                names |= group[0]
                merged = group[1].and_also(merged)
            else:
                others.append(group)
        groups = [*others, (names, merged)]
    return [one for _, one in groups]


def _texts(part: Conjunction) -> Iterator[str]:
    """Yield the patterns of a part of a goal, as text."""
    for name, args in part.present:
        yield f"({' '.join([_plain(name), *map(_term_text, args)])})"
    for inner in part.absent:
        for text in _texts(inner):
            yield f"(not {text})"


def _term_text(term: Term) -> str:
    if not isinstance(term, nodes.Var):
        return format_atom(term)
    return "?" if term.name.startswith(FRESH) else term.name


def _patterns(found: Iterable[Conjunction]) -> Iterator[Pattern]:
    """Yield all patterns of conjunctions, also the absent ones."""
    for one in found:
        yield from one.present
        yield from _patterns(one.absent)


def _plain(name: object) -> str:
    return str(name[0] if isinstance(name, tuple) else name)


def _value(term: Term, bindings: Bindings) -> Atom | None:
    return bindings.get(term.name) if isinstance(term, nodes.Var) else term


def _matched(pattern: Pattern, fact: Key, bindings: Bindings) -> Bindings | None:
    """Return the bindings that make a pattern equal to a fact, or None."""
    if len(fact) != len(pattern.args) + 1:
        return None
    found = dict(bindings)
    for arg, value in zip(pattern.args, fact[1:], strict=True):
        if not isinstance(arg, nodes.Var):
            if arg != value:
                return None
        elif found.setdefault(arg.name, value) != value:
            return None
    return found


def _fact_of(pattern: Pattern, bindings: Bindings) -> Key:
    """Return a pattern with values; each variable of it is bound."""
    args = [bindings[a.name] if isinstance(a, nodes.Var) else a for a in pattern.args]
    return (pattern.name, *args)


def _instance_of(effect: Effect, bindings: Bindings) -> tuple[Atom | None, ...]:
    """Return an effect with values; None for each unknown value."""
    args = [
        bindings.get(arg.name) if isinstance(arg, nodes.Var) else arg
        for arg in effect.args
    ]
    return (effect.name, *args)


def _sort_key(bindings: Bindings) -> tuple[str, ...]:
    return tuple([f"{name} {format_atom(v)}" for name, v in sorted(bindings.items())])
