"""What holds Python's search for reference cycles back, and lets it go on."""

from __future__ import annotations

import gc

from rapc.base.gc_paused import gc_paused, gc_spared


def test_the_search_goes_on_as_it_was_before() -> None:
    with gc_paused():
        assert not gc.isenabled()
        with gc_paused():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()


def test_what_is_spared_is_left_out_of_later_searches() -> None:
    kept: list[object] = [[]]
    try:
        with gc_spared():
            kept.append([kept])
        assert gc.isenabled()
        assert not any(one is kept for one in gc.get_objects())
    finally:
        gc.unfreeze()
    assert any(one is kept for one in gc.get_objects())
