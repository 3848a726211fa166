"""The time left of what has parts of known shares: right where they are right, steady and never nothing where not."""

import pytest

from infotraj.remaining import Plan

PARTS = {"search": 40.0, "judge": 40.0, "write": 20.0}


def begun(parts, now=0.0):
    plan = Plan(parts)
    plan.reached("search", 0, 1, now)
    return plan


def test_parts_that_take_their_share_are_foretold_to_the_second():
    plan = begun(PARTS, 1000.0)
    assert plan.left(1000.0) is None
    for k in range(1, 4):
        plan.reached("search", k, 4, 1000.0 + 10.0 * k)
        assert plan.left(1000.0 + 10.0 * k) == pytest.approx(100.0 - 10.0 * k)
    assert plan.left(1037.0) == pytest.approx(63.0)  # it counts down meanwhile
    plan.reached("judge", 0, 1, 1040.0)
    plan.reached("write", 0, 1, 1080.0)
    assert plan.left(1081.0) == pytest.approx(19.0)


def test_nothing_is_said_of_the_first_twentieth():
    plan = begun(PARTS)
    plan.reached("search", 1, 10, 50.0)
    assert plan.left(50.0) is None


def test_a_piece_that_takes_longer_leaves_what_comes_after_it_then_nothing_is_said():
    plan = begun(PARTS)
    plan.reached("judge", 0, 1, 40.0)
    assert plan.left(40.0) == pytest.approx(60.0)
    assert plan.left(79.0) == pytest.approx(21.0)
    assert plan.left(95.0) == pytest.approx(20.0)
    assert plan.left(99.0) == pytest.approx(20.0)
    assert plan.left(101.0) is None


def test_one_unusual_part_changes_the_word_by_no_more_than_what_was_done():
    """A search of twice its share: the naive whole would be 100 s first, then 200 s."""
    plan = begun(PARTS)
    plan.reached("search", 1, 2, 20.0)
    plan.reached("search", 3, 4, 60.0)
    assert 100.0 < 60.0 + plan.left(60.0) < 200.0


def test_what_is_no_part_or_is_passed_says_nothing():
    plan = begun(PARTS)
    plan.reached("judge", 1, 2, 60.0)
    before = plan.left(61.0)
    plan.reached("search", 1, 2, 61.0)
    plan.reached("judge", 1, 4, 61.0)
    plan.reached("draw", 0, 1, 61.0)
    plan.pieces("judge", 7)
    plan.pieces("draw", 7)
    assert plan.left(61.0) == before


def test_a_part_is_as_long_as_its_pieces_are_many():
    plan = begun({"search": 10.0, "judge": 10.0})
    plan.pieces("judge", 3)
    plan.reached("search", 1, 2, 5.0)
    assert plan.left(5.0) == pytest.approx(35.0)
    plan.pieces("judge", 0)
    plan.reached("judge", 0, 1, 10.0)
    assert plan.left(10.0) == pytest.approx(0.0)


def test_more_pieces_than_there_are_count_as_all():
    plan = begun(PARTS)
    plan.reached("search", 9, 5, 40.0)
    assert plan.left(40.0) == pytest.approx(60.0)


def test_what_was_before_its_first_word_does_not_count():
    plan = Plan(PARTS)
    assert plan.left(500.0) is None
    plan.reached("judge", 0, 1, 1000.0)
    assert plan.left(1000.0) is None
    plan.reached("judge", 1, 2, 1020.0)
    assert plan.left(1020.0) == pytest.approx(40.0)
    assert plan.left(1025.0) == pytest.approx(35.0)


def test_pieces_of_the_first_part_may_be_said_before_it_begins():
    plan = Plan({"search": 10.0, "judge": 10.0})
    plan.pieces("search", 3)
    plan.reached("search", 0, 1, 0.0)
    plan.reached("search", 1, 3, 10.0)
    assert plan.left(10.0) == pytest.approx(30.0)


def test_of_nothing_all_is_done():
    plan = begun(PARTS)
    plan.reached("search", 0, 0, 5.0)
    plan.reached("judge", 0, 1, 40.0)
    assert plan.left(40.0) == pytest.approx(60.0)
