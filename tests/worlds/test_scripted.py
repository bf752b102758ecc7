"""The scripted world: rows, their effects, and what happens at a time of its own."""

from __future__ import annotations

import pytest

from rapc.base.values import Text
from rapc.library.loader import load_text
from rapc.world import (
    Datum,
    Fact,
    Finished,
    HandlerMemory,
    Handlers,
    Kit,
    Reply,
    Signal,
)
from rapc.worlds.script import At, Row, mentioned
from rapc.worlds.scripted import ScriptedWorld, UnansweredRequest

from .robot import Robot

WORDS = load_text(
    """
(declare-primitive grasp (?arm ?item) (okay dropped))
(declare-primitive wait () (okay) :atomic false)
(declare-sensor-datum seen (?item ?size))
(declare-event :bump (?side))
(declare-memory-proposition holding (?arm ?item))
(declare-memory-proposition size (?item ?size))
(declare-memory-proposition foe (?where))
"""
).library


def answers(world: ScriptedWorld, *requests: str) -> list[str]:
    replies = [world.perform(1, tuple(request.split())) for request in requests]
    return [r.result if isinstance(r, Reply) else "" for r in replies]


def test_rows_are_tried_in_order_and_used_up() -> None:
    world = ScriptedWorld(
        [
            Row(("grasp", "?arm", "box"), "dropped", times=2),
            Row(("grasp", "?arm", "box")),
            Row(("grasp", "?", "?"), "dropped"),
        ]
    )
    box, cup = "grasp arm1 box", "grasp arm1 cup"
    assert answers(world, box, cup, box, box, box) == [
        *("dropped", "dropped", "dropped", "okay", "okay"),
    ]


def test_a_variable_stands_for_one_thing_in_a_row() -> None:
    world = ScriptedWorld(
        [Row(("grasp", "?x", "?x")), Row(("grasp", "?", "?"), "dropped")]
    )
    assert answers(world, "grasp a a", "grasp a b") == ["okay", "dropped"]


def test_numbers_and_strings_match_by_kind() -> None:
    world = ScriptedWorld([Row(("say", Text("hi"), 2)), Row(("say", "?", "?"), "no")])
    assert world.perform(0, ("say", Text("hi"), 2.0)) == Reply("okay")
    assert world.perform(0, ("say", "hi", 2)) == Reply("no")


def test_a_request_without_a_row_is_named() -> None:
    world = ScriptedWorld([Row(("grasp", "arm1", "box"), times=1)])
    answers(world, "grasp arm1 box")
    with pytest.raises(
        UnansweredRequest, match=r"answers \(grasp arm1 box\)$"
    ) as caught:
        answers(world, "grasp arm1 box")
    assert caught.value.request == ("grasp", "arm1", "box")


def _seen(memory: HandlerMemory, datum: Fact) -> None:
    memory.assert_fact("size", *datum[1:])


def test_effects_come_with_the_result_and_use_the_rows_variables() -> None:
    rows = [
        Row(
            ("grasp", "?arm", "?item"),
            takes=2,
            erases=(("holding", "?arm"),),
            asserts=(("holding", "?arm", "?item"),),
            data=(("seen", "?item", 3),),
        )
    ]
    world = ScriptedWorld(
        rows,
        declared=WORDS,
        kit=Kit(handlers=Handlers(data={"seen": _seen})),
    )
    robot = Robot(world, WORDS)
    robot.do("grasp arm1 box")
    assert robot.knows("holding arm1 box")
    assert robot.knows("size box 3")
    assert world.now() == 2
    robot.do("grasp arm1 cup")
    assert not robot.knows("holding arm1 box")
    assert robot.knows("holding arm1 cup")


def test_non_atomic_primitive_ends_later() -> None:
    rows = [
        Row(("wait",), takes=1, after=5, asserts=(("foe", "gone"),)),
        Row(("grasp", "?", "?"), takes=2, asserts=(("foe", "here"),)),
    ]
    world = ScriptedWorld(rows, declared=WORDS)
    robot = Robot(world, WORDS)
    assert world.perform(4, ("wait",)) is None
    assert (world.now(), world.next_time()) == (1, 6)
    robot.do("grasp arm1 box")
    assert robot.knows("foe here")
    assert not robot.knows("foe gone")
    world.advance(6)
    assert world.messages() == (Finished(4, Reply("okay")),)
    robot.digest(("wait",), "okay")
    assert robot.knows("foe gone")
    assert world.next_time() is None


def test_signals_come_with_a_result() -> None:
    world = ScriptedWorld(
        [Row(("wait",), signals=((":bump", "left"),))], declared=WORDS
    )
    world.perform(0, ("wait",))
    assert world.next_time() == 0
    assert world.messages() == (Signal((":bump", "left")),)


def test_timed_event_comes_as_a_message() -> None:
    world = ScriptedWorld(
        [],
        [
            At(30, asserts=(("foe", "north"),), signals=((":bump", "left"),)),
            At(10, asserts=(("foe", "south"),)),
            At(30, erases=(("foe", "north"),)),
        ],
        declared=WORDS,
    )
    robot = Robot(world, WORDS)
    assert world.next_time() == 10
    world.advance(10)
    assert robot.listen() == []
    assert robot.knows("foe south")
    assert world.next_time() == 30
    world.advance(50)
    assert robot.listen() == [Signal((":bump", "left"))]
    assert not robot.knows("foe north")
    assert (world.now(), world.next_time()) == (50, None)


def test_inside_a_primitive_it_happens_before_the_result() -> None:
    world = ScriptedWorld(
        [Row(("wait",), takes=20, erases=(("foe",),))],
        [At(10, asserts=(("foe", "south"),))],
        declared=WORDS,
    )
    robot = Robot(world, WORDS)
    robot.do("wait")
    assert not robot.knows("foe ?")  # asserted at 10, then erased with the result
    assert world.messages() == ()


def test_due_time_during_a_primitive_is_a_message() -> None:
    world = ScriptedWorld(
        [Row(("wait",), takes=5, after=20)], [At(3, asserts=(("foe", "east"),))]
    )
    assert world.perform(1, ("wait",)) is None
    assert world.messages() == (Datum(("at",)),)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (Row(("fly",)), r"\(fly\): unknown primitive `fly`"),
        (Row(("wait", "now")), r"\(wait now\): `wait` takes no arguments, not 1"),
        (Row(("wait",), "tired"), "`tired` is not a result of `wait`"),
        (Row(("wait",), asserts=(("foe", "?x"),)), r"`\?x` is not bound"),
        (Row(("grasp", "?", "b"), asserts=(("foe", "?"),)), r"`\?` is not bound"),
        (Row(("wait",), signals=((":bang",),)), "unknown event `:bang`"),
        (Row(("wait",), data=(("seen", "box"),)), "`seen` takes 2 arguments, not 1"),
        (Row(("wait",), data=(("seen", "box", 3),)), "datum `seen` has no handler"),
    ],
)
def test_script_with_undeclared_names_is_refused(row: Row, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ScriptedWorld([row], declared=WORDS)


def test_an_entry_at_a_time_is_looked_at_too() -> None:
    with pytest.raises(ValueError, match=r"at 5: `\?x` is not bound"):
        ScriptedWorld([], [At(5, asserts=(("foe", "?x"),))])


def test_script_offers_only_its_own_requests() -> None:
    rows = [Row(("grasp", "a", "b"), "dropped"), Row(("grasp", "?", "?"))]
    offer = mentioned(rows, [At(1, signals=((":bump", "left"),))])
    assert offer.primitives == {"grasp": (2, ("okay", "dropped"))}
    assert offer.events == {":bump": 1}


def test_a_state_of_another_script_is_refused() -> None:
    one = ScriptedWorld([Row(("grasp", "?", "?"))])
    two = ScriptedWorld([Row(("grasp", "?", "?")), Row(("wait",))])
    with pytest.raises(ValueError, match="another script"):
        one.restore(two.save())
    with pytest.raises(ValueError, match="no state of a scripted world"):
        one.restore(b"{")


def test_a_saved_script_goes_on_where_it_was() -> None:
    rows = [
        Row(("wait",), takes=1, after=5, asserts=(("foe", "gone"),)),
        Row(("grasp", "?arm", "?"), takes=3, times=1),
        Row(("grasp", "?arm", "?x"), takes=2, data=(("seen", "?x", 3),)),
    ]
    entries = [At(2, asserts=(("foe", "here"),)), At(9, erases=(("foe",),))]

    def made() -> ScriptedWorld:
        kit = Kit(handlers=Handlers(data={"seen": _seen}))
        return ScriptedWorld(rows, entries, declared=WORDS, kit=kit)

    one, two = made(), made()
    one.perform(1, ("wait",))
    one.perform(2, ("grasp", "arm1", "cup"))
    two.restore(one.save())
    for world in (one, two):
        assert world.perform(3, ("grasp", "arm1", "cup")) is not None
    assert one.save() == two.save()
    for to in (6, 10):
        one.advance(to)
        two.advance(to)
        assert one.messages() == two.messages()
    assert one.save() == two.save()


def test_script_refuses_after_for_an_atomic_primitive() -> None:
    said = r"row \(grasp .*`grasp` is declared atomic, so it does not end `:after`"
    with pytest.raises(ValueError, match=said):
        ScriptedWorld([Row(("grasp", "?arm", "?x"), after=3)], declared=WORDS)


def test_effects_use_the_memory_name_of_an_item() -> None:
    """The request is matched as it was sent; its handler gets it as it was made."""
    world = ScriptedWorld(
        [
            Row(
                ("grasp", "?arm", "?item"),
                asserts=(("holding", "?arm", "?item"), ("size", "s1", 3)),
            )
        ],
        declared=WORDS,
    )
    robot = Robot(world, WORDS)
    reply = world.perform(1, ("grasp", "arm1", "s1"))
    assert isinstance(reply, Reply)
    robot.digest(("grasp", "arm1", "item-7"), reply.result)
    assert robot.knows("holding arm1 item-7")
    assert robot.knows("size item-7 3")
