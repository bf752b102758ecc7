"""The reader on sound texts: atoms, lists, comments and where they stand."""

from __future__ import annotations

import pytest

from tests.parser.reading import plain, reading

ATOMS = [
    ("location", "Symbol", "location"),
    ("DEFINE-Rap", "Symbol", "define-rap"),
    ("=>", "Arrow", "=>"),
    ("<=", "Symbol", "<="),
    ("#1", "Symbol", "#1"),
    ("1st", "Symbol", "1st"),
    ("-", "Symbol", "-"),
    ("...", "Symbol", "..."),
    ("Größe", "Symbol", "größe"),
    ("?Thing", "Variable", "?thing"),
    ("?", "Variable", "?"),
    (":Succeed", "Keyword", ":succeed"),
    ("12", "Numeral", 12),
    ("-3", "Numeral", -3),
    ("+3", "Numeral", 3),
    ("0.5", "Numeral", 0.5),
    ("-12.25", "Numeral", -12.25),
    ("2.0", "Numeral", 2),
    ('"Two Words"', "String", "Two Words"),
    ('"a \\"b\\" \\\\ c"', "String", 'a "b" \\ c'),
    ('"two\nlines"', "String", "two\nlines"),
    ('""', "String", ""),
]


@pytest.mark.parametrize(("text", "kind", "value"), ATOMS, ids=[a[0] for a in ATOMS])
def test_atom(text: str, kind: str, value: object) -> None:
    found = reading(text)
    assert found.diagnostics == ()
    assert [plain(top.datum) for top in found.forms] == [(kind, value, 0, len(text))]


def test_whole_decimal_is_an_integer() -> None:
    (top,) = reading("2.0").forms
    assert type(plain(top.datum)[1]) is int


def test_list_spans_include_parentheses() -> None:
    (top,) = reading(" (a (b) ())\n").forms
    assert plain(top.datum) == (
        "List",
        (
            ("Symbol", "a", 2, 3),
            ("List", (("Symbol", "b", 5, 6),), 4, 7),
            ("List", (), 8, 10),
        ),
        1,
        11,
    )


def test_comments_are_kept_with_their_places() -> None:
    text = "; one\n(a ; two\n #| three #| inner |# ; |# b)"
    found = reading(text)
    assert [c.text for c in found.comments] == [
        "; one",
        "; two",
        "#| three #| inner |# ; |#",
    ]
    for comment in found.comments:
        assert text[comment.span.start : comment.span.end] == comment.text
    assert [plain(top.datum)[1] for top in found.forms] == [
        (("Symbol", "a", 7, 8), ("Symbol", "b", len(text) - 2, len(text) - 1))
    ]


def test_marks_of_comments_mean_nothing_in_strings_and_line_comments() -> None:
    found = reading('("#|" a) ; #| not open\n(b) ; |#\n')
    assert found.diagnostics == ()
    assert len(found.forms) == 2


@pytest.mark.parametrize("text", ["", " \n\t\r\n", "; nothing\n", "#| nothing |#"])
def test_no_data(text: str) -> None:
    found = reading(text)
    assert (found.forms, found.diagnostics) == ((), ())


def test_byte_order_mark_is_passed_over() -> None:
    found = reading("\ufeff(a)")
    assert found.diagnostics == ()
    assert len(found.forms) == 1


def test_name_as_long_as_may_be() -> None:
    assert reading("a" * 1000).diagnostics == ()
    assert [d.rule for d in reading("a" * 1001).diagnostics] == ["too-long"]


def test_number_as_long_as_may_be() -> None:
    assert reading("1" * 100).diagnostics == ()
    assert [d.rule for d in reading("1" * 101).diagnostics] == ["too-long"]


def test_lists_nested_as_deep_as_may_be() -> None:
    assert reading("(" * 100 + ")" * 100).diagnostics == ()
    found = reading("(" * 101 + ")" * 101).diagnostics
    assert [d.rule for d in found] == ["nested-too-deeply"]


NUMBER_LIKE = [("1e3", "1000"), ("5.", "5"), (".5", "0.5"), ("-.25", "-0.25")]


@pytest.mark.parametrize(("text", "meant"), NUMBER_LIKE)
def test_what_looks_like_a_number_is_read_as_it_was_meant(
    text: str, meant: str
) -> None:
    found = reading(text)
    (said,) = found.diagnostics
    assert said.rule == "malformed-number"
    assert said.fix is not None
    assert [edit.content for edit in said.fix.edits] == [meant]
    (top,), (sound,) = found.forms, reading(meant).forms
    assert plain(top.datum)[:2] == plain(sound.datum)[:2]
    assert not top.damaged


def test_number_beyond_measure_has_no_fix() -> None:
    (said,) = reading("1e999").diagnostics
    assert (said.rule, said.fix) == ("malformed-number", None)
