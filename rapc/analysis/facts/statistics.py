"""Thresholds of checks that compare a form with the rest of the library, and limits.

The thresholds are tuned on the mutants of `bench.mutation`: they decide what is taken
for a slip. A false alarm is traced to one of them. The limits decide nothing of that
kind: they keep the time in proportion to the text where a text is unlike any library.
"""

from __future__ import annotations

import msgspec


class Thresholds(msgspec.Struct, frozen=True):
    """How much of a library has to speak for a finding."""

    #: Letters of a word, at least, for another word to be close to it.
    close_word: int = 5
    #: Letters of a variable with its mark, at least, for another to be close to it: one
    #: that lacks a letter may be shorter by that.
    close_variable: int = 5
    #: Letters of a thing, at least, for another thing to be close to it.
    close_thing: int = 3
    #: Other constants at a place that make it a place of their sort, if a number or a
    #: text is among the two sorts.
    same_sort: int = 2
    #: The same for words and truth values: a property may have a word or none.
    same_sort_of_words: int = 4
    #: Forms in which a constant beside a bare `?` has to stand in the place of that.
    swapped_beside_any: int = 3
    #: Uses of one declared name, none of them as declared, that make one finding.
    all_misused: int = 3
    #: Failures that are worth telling apart, and methods that are a choice.
    failures_alike: int = 2
    #: The share of primitives that have to say what they do, as a fraction.
    described: tuple[int, int] = (3, 4)
    #: Methods of a RAP; if more ask for the name of an item, all of them should.
    unnamed_item: int = 3


class Limits(msgspec.Struct, frozen=True):
    """How far a check looks."""

    #: Pairs of literals that are compared for one entailment.
    entailment_pairs: int = 300
    #: Literals of a conjunction that hold by themselves.
    true_literals: int = 8
    #: Literals of a conjunction in which contradictions are looked for.
    conjunction: int = 24
    #: Inputs to which a resource is followed.
    resource_inputs: int = 200
    #: Callers that what is learned of an input is handed on to, one above another.
    kind_rounds: int = 3
    #: RAPs that priorities of steps are added up for, one below another.
    priority_depth: int = 20
    #: Places of a variable in one form.
    places: int = 12
    #: Arguments of a name that are compared with each other.
    arguments: int = 6
    #: Constants of a place that are compared with a variable's name.
    constants_of_place: int = 4
    #: Steps that change or need one fact.
    steps_of_fact: int = 20
    #: Calls that a constraint is followed down.
    constraint_depth: int = 5
    #: Goals below the steps of one method.
    goals_below: int = 200
    #: Standing tasks of an agenda that are compared with each other.
    standing_tasks: int = 40
    #: RAPs, with what is held above them, below a task.
    claims_below: int = 400
    #: RAPs that a walk leads through back to its start, and steps that it takes.
    walk_depth: int = 6
    walk_steps: int = 80


THRESHOLDS = Thresholds()
LIMITS = Limits()
