"""Thresholds and limits of checks that compare a form with the rest of the library.

The thresholds are tuned on the mutants of `bench.mutation` and decide which differences
count as faults. A false positive is traced to a threshold. The limits do not decide
about faults: the limits keep the running time proportional to the size of the text,
even for unusual texts.
"""

from __future__ import annotations

import msgspec


class Thresholds(msgspec.Struct, frozen=True):
    """The evidence in a library that a finding requires."""

    #: Minimum number of letters of a word that may be close to another word.
    close_word: int = 5
    #: Minimum number of letters of a variable, with its mark, that may be close to
    #: another variable; a variable that lacks a letter may be shorter by one.
    close_variable: int = 5
    #: Minimum number of letters of a thing that may be close to another thing.
    close_thing: int = 3
    #: Minimum number of other constants of one sort at a place for the sort to be
    #: expected there, if one of the two sorts is a number or a text.
    same_sort: int = 2
    #: The same for words and truth values: a property may have a word or none.
    same_sort_of_words: int = 4
    #: Minimum number of forms in which a constant beside a bare `?` stands at the place
    #: of the `?`.
    swapped_beside_any: int = 3
    #: Minimum number of uses of a declared name, all different from the declaration,
    #: that are reported in one finding.
    all_misused: int = 3
    #: Minimum number of failures that are worth distinguishing, and of methods that are
    #: a choice.
    failures_alike: int = 2
    #: Minimum share of primitives that must declare effects, as a fraction.
    described: tuple[int, int] = (3, 4)
    #: Minimum number of RAPs that wait for a state, so that one RAP that waits for the
    #: contrary counts as a fault.
    same_wait: int = 3
    #: Minimum number of other forms in which one variable stands at two places, so that
    #: a variable of one place may stand for an input of the other.
    same_variable: int = 2
    #: Number of methods of a RAP; if more methods query the name of an item, all
    #: should.
    unnamed_item: int = 3
    #: Minimum number of RAPs that the tasks of agendas reach for the only other RAP
    #: to be forgotten.
    all_reached: int = 8
    #: Minimum number of primitives with an argument of one kind that all use a thing
    #: named by this argument.
    uses_alike: int = 3


class Limits(msgspec.Struct, frozen=True):
    """Upper limits for the search of a check."""

    #: Pairs of literals compared for one entailment.
    entailment_pairs: int = 300
    #: Literals of a conjunction that are always true.
    true_literals: int = 8
    #: Literals of a conjunction that are searched for contradictions.
    conjunction: int = 24
    #: Levels of queries that are replaced by their formulas.
    query_depth: int = 3
    #: Inputs through which a resource is followed.
    resource_inputs: int = 200
    #: Levels of callers that receive the knowledge about an input.
    kind_rounds: int = 3
    #: Levels of RAPs for which priorities of steps are added.
    priority_depth: int = 20
    #: Places of a variable in one form.
    places: int = 12
    #: Arguments of a name that are compared with each other.
    arguments: int = 6
    #: Constants of a place that are compared with the name of a variable.
    constants_of_place: int = 4
    #: Steps that change or need one fact.
    steps_of_fact: int = 20
    #: Levels of calls through which a constraint is followed.
    constraint_depth: int = 5
    #: Steps of a net that a search from a calling step looks into.
    steps_below: int = 30
    #: Levels of first steps whose needs are needs of a goal.
    need_depth: int = 3
    #: Goals below the steps of one method.
    goals_below: int = 200
    #: Standing tasks of an agenda that are compared with each other.
    standing_tasks: int = 40
    #: RAPs below a task, counted with the conditions of their ancestors.
    claims_below: int = 400
    #: RAPs on a path that returns to its start, and steps of that path.
    walk_depth: int = 6
    walk_steps: int = 80


THRESHOLDS = Thresholds()
LIMITS = Limits()
