"""One table says what each kind of definition is called and where it is kept."""

from __future__ import annotations

from typing import get_args

from rapc.ir import nodes
from rapc.library.library import KINDS, SEQUENCES, Library
from rapc.library.loader import load_text
from rapc.library.signatures import SPACES, Signatures


def test_each_kind_of_form_is_linked() -> None:
    kinds = {*get_args(nodes.TopForm)} - {nodes.Require}
    assert kinds == {*KINDS, *SEQUENCES}


def test_each_field_of_a_library_has_its_kinds() -> None:
    filled = [field for field, _, _ in KINDS.values()] + list(SEQUENCES.values())
    assert {*filled, "files", "forms", "tests"} == {*Library.__struct_fields__}


def test_each_kind_with_arguments_has_signatures() -> None:
    library = load_text("(declare-primitive go () (okay))").library
    spaces = {
        space
        for kind, (_, space, _) in KINDS.items()
        if {"args", "inputs"} & {*kind.__struct_fields__}
    }
    assert spaces == {*SPACES}
    assert list(Signatures.of(library).primitives) == ["go"]
