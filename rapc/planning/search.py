"""The search for a sequence of actions: best first, guided by relaxed plans.

A relaxed plan ignores what actions spoil; its cost estimates the distance to the goal,
and its first actions are tried before all others. A state is a number with a bit for
each atom that can change.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from heapq import heappop, heappush
from typing import Literal, NamedTuple

from rapc.base.values import Atom, Fact, Number
from rapc.ir import nodes
from rapc.planning.ground import Action, Problem, Way

Outcome = Literal["solved", "unsolvable", "limit"]

MOST_ORDERS = 40_000
"""The greatest number of states to look at for a cheaper order, approximately."""


class Found(NamedTuple):
    """The result of a search."""

    outcome: Outcome
    actions: tuple[Action, ...] = ()
    #: The number of states whose distance to the goal was estimated.
    expanded: int = 0


class _Operation(NamedTuple):
    """An action over bits."""

    action: Action
    needs: int
    adds: int
    keeps: int
    cost: Number
    #: The facts with a greatest number of which the action brings some about.
    limits: tuple[tuple[int, int], ...]


class _Node(NamedTuple):
    state: int
    cost: Number
    before: _Node | None
    operation: int


_Cost = tuple[int, Number]
"""How early the late steps come, and the cost beyond the least cost of the steps."""

_Order = tuple[_Cost, int, int, tuple[int, ...]]
"""The beginning of an order: its cost, the steps as bits, its state and its actions."""


class _Estimate(NamedTuple):
    """The cost of a relaxed plan, and the operations that it begins with."""

    cost: Number
    helpful: tuple[int, ...]


Goal = Sequence[Sequence[Sequence[Way]]]


class Search:
    """The search in one problem.

    Args:
        problem: the problem.
        limit: the greatest number of states to estimate.
        steps: the steps of an earlier plan, which are used where they apply.
        late: the goals of steps that come as late as possible.
    """

    def __init__(
        self,
        problem: Problem,
        limit: int,
        steps: Sequence[nodes.Goal] = (),
        late: Collection[Fact] = (),
    ) -> None:
        self._limit = limit
        self._late = late
        self.expanded = 0
        self._goal, actions, always = reduced(problem)
        atoms = [at for part in self._goal for ways in part for w in ways for at in w]
        needed = [at for one in actions for at in one.needs if at not in always]
        counted = [at for limit in problem.limits for at in sorted(limit.atoms)]
        known = dict.fromkeys([*atoms, *needed, *counted])
        numbers = {at: n for n, at in enumerate(known)}
        limits = [
            (_bits([numbers[at] for at in one.atoms]), one.most)
            for one in problem.limits
        ]
        self._size = len(numbers)
        self._operations: list[_Operation] = []
        self._needs: list[tuple[int, ...]] = []
        self._adds: list[tuple[int, ...]] = []
        for one in actions:
            needs = [numbers[at] for at in one.needs if at in numbers]
            adds = [numbers[at] for at in one.adds if at in numbers]
            gone = [numbers[at] for at in one.deletes if at in numbers]
            self._needs.append(tuple(needs))
            self._adds.append(tuple(adds))
            bits = _bits(needs), _bits(adds), ~_bits(gone)
            counts = tuple([row for row in limits if row[0] & bits[1]])
            self._operations.append(_Operation(one, *bits, one.cost, counts))
        self._users: list[list[int]] = [[] for _ in numbers]
        for at, own in enumerate(self._needs):
            for atom in own:
                self._users[atom].append(at)
        self._free = [at for at, own in enumerate(self._needs) if not own]
        self._start = _bits([numbers[at] for at in problem.state if at in numbers])
        self._goal = tuple(
            [
                tuple(
                    [
                        tuple([tuple([numbers[a] for a in w]) for w in ways])
                        for ways in part
                    ]
                )
                for part in self._goal
            ]
        )
        self._masks = [
            [[_bits(way) for way in ways] for ways in part] for part in self._goal
        ]
        self._earlier = [self._instances_of(step) for step in steps]

    def run(self, tries: int = 0) -> Found:
        """Return a plan; spend `tries` further states on a cheaper one."""
        if not self._goal:
            return Found("unsolvable")
        try:
            node = self._greedy()
        except _LimitReached:
            return Found("limit", (), self.expanded)
        if node is None:
            return Found("unsolvable", (), self.expanded)
        rest = self._finished(node.state) or []
        path = self._ordered(self._shortened([*_path(node), *rest]))
        if tries:
            path = self._cheaper(path, tries)
        actions = tuple([self._operations[at].action for at in path])
        return Found("solved", actions, self.expanded)

    # --- states ----------------------------------------------------------------------

    def _reached(self, state: int) -> bool:
        """Return whether the goal holds in a state."""
        return any(
            all(any(way & state == way for way in ways) for ways in part)
            for part in self._masks
        )

    def _instances_of(self, step: nodes.Goal) -> list[int]:
        """Return the operations that a step of an earlier plan may stand for."""
        return [
            at
            for at, one in enumerate(self._operations)
            if one.action.goal[0] == step.name
            and all(
                not isinstance(arg, nodes.Const) or arg.value == value
                for arg, value in zip(step.args, one.action.goal[1:], strict=False)
            )
        ]

    def _finished(self, state: int) -> list[int] | None:
        """Return the steps of the earlier plan that lead from a state to the goal."""
        taken: list[int] = []
        for instances in self._earlier:
            for at in instances:
                if self._is_applicable(at, state):
                    state = self._after(state, at)
                    taken.append(at)
                    break
        return taken if self._reached(state) else None

    def _applicable(self, state: int) -> Iterator[int]:
        for at in range(len(self._operations)):
            if self._is_applicable(at, state):
                yield at

    def _after(self, state: int, at: int) -> int:
        one = self._operations[at]
        return state & one.keeps | one.adds

    # --- relaxed plans ---------------------------------------------------------------

    def _estimate(self, state: int) -> _Estimate | None:
        """Return the cost of a relaxed plan from a state; None if there is none.

        Raises:
            _LimitReached: after the greatest number of estimates.
        """
        if self.expanded >= self._limit:
            raise _LimitReached
        self.expanded += 1
        costs, reasons = self._relaxed_costs(state)
        wanted = self._cheapest_goal(costs)
        if wanted is None:
            return None
        total: Number = 0
        chosen: dict[int, None] = {}
        seen = set[int]()
        stack = list(wanted)
        while stack:
            atom = stack.pop()
            if atom in seen:
                continue
            seen.add(atom)
            at = reasons[atom]
            if at is None:
                continue
            if at not in chosen:
                chosen[at] = None
                total += self._operations[at].cost
                stack.extend(self._needs[at])
        begun = [at for at in chosen if self._is_applicable(at, state)]
        return _Estimate(total, tuple(sorted(begun)))

    def _is_applicable(self, at: int, state: int) -> bool:
        one = self._operations[at]
        if one.needs & state != one.needs:
            return False
        return not one.limits or self._is_allowed(one, state)

    def _is_allowed(self, one: _Operation, state: int) -> bool:
        """Return whether there are not too many facts after an action."""
        after = state & one.keeps | one.adds
        return all(
            (after & mask).bit_count() <= max(most, (state & mask).bit_count())
            for mask, most in one.limits
        )

    def _relaxed_costs(self, state: int) -> tuple[list[Number], list[int | None]]:
        """Return the cost of each atom, and the operation that brings it about.

        The cost is -1 for an atom that cannot be reached; an atom of the state has no
        operation.
        """
        costs: list[Number] = [-1] * self._size
        reasons: list[int | None] = [None] * self._size
        missing = [len(needs) for needs in self._needs]
        sums = [one.cost for one in self._operations]
        queue: list[tuple[Number, int]] = []
        rest = state
        while rest:
            low = rest & -rest
            atom = low.bit_length() - 1
            rest ^= low
            costs[atom] = 0
            queue.append((0, atom))
        adds, users = self._adds, self._users

        def done(at: int) -> None:
            cost = sums[at]
            for atom in adds[at]:
                known = costs[atom]
                if known < 0 or cost < known:
                    costs[atom] = cost
                    reasons[atom] = at
                    heappush(queue, (cost, atom))

        for at in self._free:
            done(at)
        while queue:
            cost, atom = heappop(queue)
            if cost != costs[atom]:
                continue
            for at in users[atom]:
                missing[at] -= 1
                sums[at] += cost
                if not missing[at]:
                    done(at)
        return costs, reasons

    def _cheapest_goal(self, costs: Sequence[Number]) -> list[int] | None:
        """Return the atoms of the cheapest way to the goal."""
        best: tuple[Number, list[int]] | None = None
        for part in self._goal:
            total: Number = 0
            atoms: list[int] = []
            for ways in part:
                cheapest: tuple[Number, Way] | None = None
                for way in ways:
                    own = [costs[atom] for atom in way]
                    if all(one >= 0 for one in own):
                        cost = sum(own)
                        if cheapest is None or cost < cheapest[0]:
                            cheapest = cost, way
                if cheapest is None:
                    break
                total += cheapest[0]
                atoms.extend(cheapest[1])
            else:
                if best is None or total < best[0]:
                    best = total, atoms
        return None if best is None else best[1]

    # --- best first ------------------------------------------------------------------

    def _greedy(self) -> _Node | None:
        """Return a node from which the earlier plan leads to the goal, or None.

        Without an earlier plan the goal holds in the node.

        A node that comes nearer to the goal is followed at once. The actions outside
        the relaxed plan are tried after those in it.
        """
        root = _Node(self._start, 0, None, -1)
        if self._finished(root.state) is not None:
            return root
        estimate = self._estimate(root.state)
        if estimate is None:
            return None
        order = 0
        waiting = [(estimate.cost, 0, order, root, iter(estimate.helpful))]
        seen = {root.state}
        while waiting:
            near, phase, _, node, left = heappop(waiting)
            for at in left:
                if phase and not self._is_applicable(at, node.state):
                    continue
                state = self._after(node.state, at)
                if state in seen:
                    continue
                seen.add(state)
                child = _Node(state, node.cost + self._operations[at].cost, node, at)
                if self._finished(state) is not None:
                    return child
                estimate = self._estimate(state)
                if estimate is None:
                    continue
                order += 1
                row = (estimate.cost, 0, order, child, iter(estimate.helpful))
                heappush(waiting, row)
                if estimate.cost < near:
                    order += 1
                    heappush(waiting, (near, phase, order, node, left))
                    break
            else:
                if not phase:
                    order += 1
                    rest = iter(range(len(self._operations)))
                    heappush(waiting, (near, 1, order, node, rest))
        return None

    def _cheaper(self, path: list[int], tries: int) -> list[int]:
        """Return a cheaper path, if weighted A* finds one with so many estimates."""
        limit, self._limit = self._limit, min(self._limit, self.expanded + tries)
        best = sum(self._operations[at].cost for at in path)
        root = _Node(self._start, 0, None, -1)
        waiting: list[tuple[Number, int, _Node]] = [(0, 0, root)]
        costs: dict[int, Number] = {root.state: 0}
        order = 0
        try:
            while waiting:
                _, _, node = heappop(waiting)
                if node.cost > costs[node.state]:
                    continue
                for at in self._applicable(node.state):
                    state = self._after(node.state, at)
                    cost = node.cost + self._operations[at].cost
                    if cost >= best or cost >= costs.get(state, best):
                        continue
                    costs[state] = cost
                    child = _Node(state, cost, node, at)
                    if self._reached(state):
                        best, path = cost, _path(child)
                        continue
                    estimate = self._estimate(state)
                    if estimate is not None:
                        order += 1
                        row = (cost + 3 * estimate.cost, order, child)
                        heappush(waiting, row)
        except _LimitReached:
            pass
        self._limit = limit
        return path

    def _shortened(self, path: list[int]) -> list[int]:
        """Return a path without the actions that the goal does not need."""
        at = 0
        while at < len(path):
            kept = path[:at]
            state = self._start
            for operation in kept:
                state = self._after(state, operation)
            for operation in path[at + 1 :]:
                alike = self._alike(operation)
                for instance in (operation, *alike):
                    if self._is_applicable(instance, state):
                        state = self._after(state, instance)
                        kept.append(instance)
                        break
            if self._reached(state):
                path = kept
            else:
                at += 1
        return path

    def _alike(self, at: int) -> list[int]:
        """Return the instances of a step whose cost depends on the state."""
        action = self._operations[at].action
        return self._families[action.step] if action.weighed else []

    @cached_property
    def _families(self) -> dict[tuple[Fact, tuple[Atom, ...]], list[int]]:
        """Return the instances of each step whose cost depends on the state."""
        found: dict[tuple[Fact, tuple[Atom, ...]], list[int]] = {}
        for at, one in enumerate(self._operations):
            if one.action.weighed:
                found.setdefault(one.action.step, []).append(at)
        return found

    def _ordered(self, path: list[int]) -> list[int]:
        """Return the steps of a path in a cheaper order, if there is one.

        An order with late steps near its end is cheaper than any other.
        The orders are built step by step; of the beginnings with the same length those
        are kept that have cost least beyond the least cost of their steps.
        """
        families = [self._alike(at) or [at] for at in path]
        late = [self._operations[at].action.goal in self._late for at in path]
        limited = any(late) and any(self._operations[at].limits for at in path)
        if not limited and all(len(family) == 1 for family in families):
            return path
        costs = [one.cost for one in self._operations]
        least = [min([costs[at] for at in family]) for family in families]
        width = max(1, MOST_ORDERS // len(path) ** 2)
        rows: list[_Order] = [((0, 0), 0, self._start, ())]
        for left in reversed(range(len(path))):
            found: dict[tuple[int, int], tuple[_Cost, tuple[int, ...]]] = {}
            for cost, done, state, taken in rows:
                for number, family in enumerate(families):
                    if done >> number & 1:
                        continue
                    for at in family:
                        if not self._is_applicable(at, state):
                            continue
                        key = done | 1 << number, self._after(state, at)
                        early = cost[0] + (left if late[number] else 0)
                        more = early, cost[1] + costs[at] - least[number]
                        if key not in found or more < found[key][0]:
                            found[key] = more, (*taken, at)
            ranked = sorted(found.items(), key=lambda row: row[1][0])[:width]
            rows = [(cost, *key, taken) for key, (cost, taken) in ranked]
        early = sum([left for left, one in enumerate(reversed(late)) if one])
        best = early, sum([costs[at] for at in path]) - sum(least)
        for cost, _, state, taken in rows:
            if cost < best and self._reached(state):
                return list(taken)
        return path


class _LimitReached(Exception):
    """The greatest number of estimates is reached."""


def _path(node: _Node) -> list[int]:
    found = []
    here: _Node | None = node
    while here is not None and here.before is not None:
        found.append(here.operation)
        here = here.before
    return found[::-1]


def _bits(atoms: Sequence[int]) -> int:
    found = 0
    for atom in atoms:
        found |= 1 << atom
    return found


def reduced(problem: Problem) -> tuple[Goal, list[Action], frozenset[int]]:
    """Return the goal and the actions that matter, and the atoms that always hold."""
    added = {at for action in problem.actions for at in action.adds}
    lost = {at for action in problem.actions for at in action.deletes}
    always = problem.state - lost
    never = frozenset(range(len(problem.literals))) - problem.state - added
    goal = _simplified(problem.goal, always, never)
    actions = [one for one in problem.actions if never.isdisjoint(one.needs)]
    return goal, _relevant(actions, goal, always, problem), always


def _simplified(goal: Goal, always: frozenset[int], never: frozenset[int]) -> Goal:
    """Return a goal without atoms that always hold, and ways that never do."""
    branches = []
    for branch in goal:
        parts = []
        for ways in branch:
            left = {
                tuple([at for at in way if at not in always]): None
                for way in ways
                if never.isdisjoint(way)
            }
            if () not in left:
                parts.append(tuple(left))
        if all(parts):
            branches.append(tuple(parts))
    return tuple(branches)


def _relevant(
    actions: Sequence[Action], goal: Goal, always: frozenset[int], problem: Problem
) -> list[Action]:
    """Return the actions that bring about anything on a way to the goal.

    An action that erases a fact with a greatest number makes room for another one.
    """
    limited = {at for limit in problem.limits for at in limit.atoms}
    makers: dict[int, list[int]] = {}
    erasers: dict[int, list[int]] = {}
    for number, action in enumerate(actions):
        for at in action.adds:
            makers.setdefault(at, []).append(number)
        for at in limited.intersection(action.deletes):
            erasers.setdefault(at, []).append(number)
    kept = dict[int, None]()
    seen = set[int]()

    def keep(atoms: Iterable[int], causes: Mapping[int, list[int]]) -> None:
        for at in atoms:
            kept.update(dict.fromkeys(causes.get(at, ())))

    keep([at for branch in goal for ways in branch for w in ways for at in w], makers)
    keep(sorted(limited & problem.state) if kept else (), erasers)
    while len(seen) < len(kept):
        for number in [one for one in kept if one not in seen]:
            seen.add(number)
            action = actions[number]
            new = [at for at in action.needs if at not in always]
            keep([at for at in new if at not in action.weighed], makers)
            keep([at for at in action.adds if at in limited], erasers)
    return [actions[number] for number in sorted(kept)]
