"""Where a search begins: beside the file as it seems to be, and beside an ordinary one."""

from typing import Any

import numpy as np
import pytest
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis.select import search as module
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.search import Search

NAMES = ("linear_drag", "steady_force")


def rows(rng, k):
    """Columns that are alike but for a tenth: the residual goes with the second one."""
    one = rng.standard_normal(ROWS)
    two = one + 0.1 * rng.standard_normal(ROWS)
    return np.column_stack([two + 0.01 * rng.standard_normal(ROWS), one, two])


@pytest.fixture
def searching(monkeypatch):
    """A search that began with the first effect, and what it finds: where it begins, as good as `net` says by label."""
    _, whole = linear_fit(NAMES, rows, [NAMES[0]])
    search: Any = Search(whole.linear.observation, (), ())
    begun: list[Any] = []
    monkeypatch.setattr(Search, "_anew", lambda self, made: made)

    def begin(self, made):
        begun.append(made)
        return made

    monkeypatch.setattr(Search, "_from", begin)

    def end(net):
        monkeypatch.setattr(module, "net_of", lambda made: net[made.labels[0]])
        return search._better_start(whole, whole)

    return end, begun, whole, search


def test_the_other_start_is_beside_an_ordinary_file_and_is_taken_where_it_predicts_more(searching):
    end, begun, _, _ = searching
    assert end({"linear_drag": -1.0, "steady_force": -1.0 - 1.1 * TELLS}).labels == ("steady_force",)
    assert [m.labels for m in begun] == [("steady_force",)]
    assert begun[0].scales == Scales(1.0)


def test_a_start_that_predicts_hardly_more_is_no_reason_to_leave_the_first(searching):
    end, _, whole, _ = searching
    assert end({"linear_drag": -1.0, "steady_force": -1.0 - 0.9 * TELLS}) is whole


def test_no_second_search_begins_where_the_first_did_or_beside_healthy_flights(searching):
    end, begun, whole, search = searching
    same = linear_fit(NAMES, rows, [NAMES[1]])[1]
    assert search._better_start(same, whole) is whole
    search.observation.healthy = object()
    assert end({}) is whole
    assert not begun
