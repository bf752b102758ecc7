"""What is said of each rule of the grammar: in findings, on the pages, while writing.

Only rules that a reader of a page or of a finding meets have a row. A test holds the
rows against the grammar.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec


class Words(msgspec.Struct, frozen=True):
    """A row: the words for one rule of the grammar."""

    #: What a list of this kind is for, as a phrase without a full stop.
    says: str
    #: The operands, as a finding names them: "`believe` takes ...".
    takes: str = ""
    #: Where it comes from.
    source: str = ""
    #: The pages that tell what it means, as links from docs/language.
    pages: tuple[str, ...] = ()
    #: What a page says besides, where it has a table and no text of its own.
    more: str = ""


WORDS: Mapping[str, Words] = {
    # RAPs
    "define_rap": Words("a way to bring something about", "", "[T 4]"),
    "index_clause": Words("name, inputs and outputs", "one list", "[T 4.2]"),
    "succeed": Words(
        "when a task is done, and what it hands out",
        "one formula",
        "[T 4.4.1]",
        pages=("3-tasks.md#success",),
    ),
    "preconditions": Words(
        "what must hold whenever it is selected",
        "one formula",
        "[T 4.4.2]",
        pages=("3-tasks.md#conditions",),
    ),
    "constraints": Words(
        "what must hold for it and for all below it",
        "one formula",
        "[T 4.4.3]",
        pages=("3-tasks.md#conditions",),
    ),
    "repeat_while": Words(
        "how long it goes on choosing methods",
        "one formula",
        "[T 4.6]",
        pages=("3-tasks.md#repeat-while",),
    ),
    "monitor_state": Words(
        "what it waits for",
        "one formula",
        "[T 4.7.1]",
        pages=("5-monitors.md#waiting-for-a-state",),
    ),
    "monitor_time": Words(
        "until when it waits",
        "`now` or `absolute` and two times",
        "[T 4.7.1]",
        pages=("5-monitors.md#waiting-for-a-time",),
    ),
    "duration": Words(
        "how long it takes, about",
        "one number or computed term",
        "[T 4.3]",
        pages=("4-agenda.md#choice",),
    ),
    "resources": Words(
        "what it remembers for itself",
        "",
        "[T 4.8.1]",
        pages=("6-resources.md#sets-and-counters",),
    ),
    "resource": Words(
        "a set or a counter",
        "a variable and at most one first value",
        "[T 4.8.1]",
    ),
    "effects": Words(
        "which facts it brings about", "", "", pages=("6-resources.md#effects",)
    ),
    "method": Words(
        "a way to do it", "", "[T 4.5]", pages=("3-tasks.md#choosing-a-method",)
    ),
    "context": Words(
        "when a method may be chosen",
        "one formula",
        "[T 4.5.1]",
        pages=("3-tasks.md#choosing-a-method",),
    ),
    "notations": Words(
        "facts that hold while it runs",
        "",
        "[T 4.9.1]",
        pages=("6-resources.md#notations",),
    ),
    "claims": Words("what nobody else may use while it runs", "", "[T 7.2.1]"),
    "skills": Words("what is switched on while it runs", "", "[S 3.2]"),
    "task_net": Words("steps, in an order as loose as wanted", "", "[T 4.5.2]"),
    "primitive": Words("a request to the world, or skills", "one request", "[T 4.5.3]"),
    "enable": Words("skills to be switched on", "", "[S 3.2]"),
    "disable": Words("skills to be switched off", "", "[S 3.2]"),
    # Annotations
    "order": Words(
        "which step comes behind this one",
        "the tag of one step",
        pages=("4-agenda.md#order",),
    ),
    "protect": Words(
        "what must hold until another step begins",
        "the tag of one step",
        pages=("3-tasks.md#conditions",),
    ),
    "until_start": Words(
        "which step ends this one by its start",
        "the tag of one step",
        pages=("4-agenda.md#until",),
    ),
    "until_end": Words(
        "which step ends this one by its end",
        "the tag of one step",
        pages=("4-agenda.md#until",),
    ),
    "window": Words(
        "from when, and by when",
        "a tag, `now` or `absolute`, and two times",
        pages=("4-agenda.md#windows",),
    ),
    "wait_for": Words(
        "which signal it waits for, and what that does to it",
        pages=("4-agenda.md#wait-for",),
    ),
    "set_add": Words(
        "puts something into a set as it succeeds",
        "a resource and one thing or amount",
        pages=("6-resources.md#effects",),
    ),
    "set_sub": Words(
        "takes something out of a set as it succeeds",
        "a resource and one thing or amount",
        pages=("6-resources.md#effects",),
    ),
    "counter_add": Words(
        "counts up as it succeeds",
        "a resource and one thing or amount",
        pages=("6-resources.md#effects",),
    ),
    "counter_sub": Words(
        "counts down as it succeeds",
        "a resource and one thing or amount",
        pages=("6-resources.md#effects",),
    ),
    # Formulas
    "and": Words("all of them hold", "", "[T 4.1.3]"),
    "or": Words("one of them holds", "", "[T 4.1.3]"),
    "not": Words("it cannot be shown", "one formula", "[T 4.1.3]"),
    "compare": Words("two values compared", "two terms", ""),
    "believe": Words("how fresh a belief is", "a proposition and an age", "[T 4.1.1]"),
    "member": Words("a set has it", "a set and a thing", ""),
    "empty": Words("a set has nothing", "a set", ""),
    "method_tried": Words(
        "a method has been tried", "the name of a method", "[T 4.1.2]"
    ),
    "last_result": Words("how the last method ended", "a result", "[T 4.1.2]"),
    "result_with_method": Words(
        "how a method ended", "the name of a method and a result", "[T 4.1.2]"
    ),
    "sensor_name": Words(
        "an item is in sight", "an item and, if wanted, `true` or `false`", "[T A.4]"
    ),
    "count": Words("how many there are", "a class, a place and a number", ""),
    "truth": Words("always holds, or never does", "", "[T 4.1]"),
    "otherwise": Words("in a context: no method before it holds"),
    "proposition": Words(
        "a fact, or a declared function that is a test", "", "[T 4.1]"
    ),
    # Terms
    "sum": Words("adds", "two or more arguments"),
    "product": Words("multiplies", "two or more arguments"),
    "quotient": Words("divides", "two or more arguments"),
    "difference": Words("subtracts, or changes the sign", "one or more arguments"),
    "size_of": Words("how many are in a set", "one argument"),
    "value_of": Words("the value of a counter", "one argument"),
    "applied": Words("what a declared function returns"),
    # Rules over memory
    "action": Words(
        "puts a fact into memory or takes it out", "one proposition", "[S 4.2]"
    ),
    # Named formulas, and what is to be done
    "define_query": Words("a formula with a name"),
    "define_agenda": Words("what a robot is to do from the start", "", "[T 5.4]"),
    # Tests
    "world": Words(
        "the world the test runs in",
        "the name of a world",
        more=(
            "its handlers, functions and problem solvers are those that the library "
            'needs: an installed one, or `"module:Class"` of a module that the user '
            "permits"
        ),
    ),
    "options": Words(
        "options of that world",
        more="as in `(options (fuel-capacity 20))`",
    ),
    "seed": Words(
        "the seed of all chance",
        "a whole number",
        more="it counts whatever `--seed` and `--seeds` say",
    ),
    "agenda": Words(
        "an agenda whose tasks are given",
        "the name of an agenda",
        more="they come before those of `task`",
    ),
    "answers": Words(
        "what memory functions return",
        more="of those that no world of the test registers",
    ),
    "facts": Words(
        "what memory holds at first",
        more="it holds them at time 0",
    ),
    "script": Words("what the world answers"),
    "script_row": Words("a request and its answer"),
    "at": Words("what happens at a time"),
    "task": Words(
        "what is asked for",
        "a goal and options",
        more=(
            "it is given at time 0; the deadline is absolute, a task in the "
            "background does not keep the test going"
        ),
    ),
    "until": Words(
        "when the test ends",
        "a time or `(cycles n)`",
        more=(
            "what is due then still happens, a primitive that ends later stays unended"
        ),
    ),
    "cycles": Words(
        "after how many cycles it ends",
        "a number of cycles, a whole one",
        more="also `(until (cycles n))`",
    ),
    "asserts": Words("facts that come"),
    "erases": Words("facts that go"),
    "moves": Words("items that are elsewhere now"),
    "loses": Words("items that are not where they were"),
    "signals": Words("signals that come"),
    "cancel": Words("a task is given up", "one goal"),
    "expect": Words("what is to be found afterwards"),
    "succeeds": Words(
        "a task succeeds, with these outputs",
        more="they may be left out; `(succeeds (locate mug) kitchen)` has one",
    ),
    "fails": Words(
        "a task fails, for this reason",
        more="it is what its parent sees, and may be left out",
    ),
    "active": Words(
        "a task is still at work",
        more="it is neither over nor removed",
    ),
    "primitives": Words("all requests, in order"),
    "primitives_include": Words("requests in order, others between"),
    "never": Words("a request that is never made"),
    "memory": Words(
        "what memory holds",
        "one formula",
        more="the formula has a solution",
    ),
    "method_chosen": Words(
        "which method was chosen, how often",
        more=(
            "tasks of the RAP chose it exactly so often in all (0 is legal); "
            "without a number, at least once; `#1` is the first method if it has "
            "no name"
        ),
    ),
    "selected_before": Words(
        "one task before another",
        more=(
            "the first was selected for the first time before the second was; both were"
        ),
    ),
    "ends_by": Words(
        "a task has ended by a time",
        more="it had succeeded by then",
    ),
    "trace": Words("events in order, others between"),
    # Declarations
    "require": Words("a file that this one needs", "the name of one file"),
    "declare_memory_proposition": Words("facts that are there or not", "", "[T A.1]"),
    "declare_memory_property": Words("facts with one value each", "", "[T A.1]"),
    "declare_memory_function": Words("what the world computes", "", "[T A.1]"),
    "declare_indistinct_class": Words("things that look alike", "", "[T A.5]"),
    "declare_class_comparator": Words("how things are told apart", "", "[T A.5]"),
    "declare_primitive": Words("what can be asked of the world", "", ""),
    "declare_sensor_datum": Words("what the world tells of itself", "", ""),
    "declare_skill": Words("what can be switched on and off", "", "[S 2]"),
    "declare_event": Words("what a skill may signal", "", "[S 2]"),
    "define_memory_rule": Words("what a task's end does to memory", "", "[S 4.2]"),
    "define_event_rule": Words("what a signal does to memory", "", "[S 4.3]"),
    "declare_kind": Words("values of one kind", "", ""),
    "define_test": Words("what a library is to do, tried", "", "docs/testing.md"),
    "define_test_defaults": Words(
        "what is said of all tests of a file", "", "docs/testing.md"
    ),
}
"""What is said of each rule, group by group in the order of the grammar."""
