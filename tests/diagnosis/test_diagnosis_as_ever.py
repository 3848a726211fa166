"""Where an error is no larger than on some healthy flight."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from infotraj.diagnosis.diagnosis import _no_more
from infotraj.diagnosis.judge.as_ever import as_ever, largest
from infotraj.diagnosis.judge.evidence import Evidence
from infotraj.diagnosis.judge.verdicts import Judge
from infotraj.effects import effect_class

AXES = {"force": ("fx", "fy", "fz"), "rate": ("tx", "ty", "tz"), "push": ("push x", "push y", "push z")}


def flight(steady, swings, name="force", step=0.01, period=0.2):
    """Samples of 4 s: on each axis what is left is steady, and swings (peak) with a period that 0.1 s can follow."""
    t = step * np.arange(round(4.0 / step))
    left = np.array(steady) + np.array(swings) * np.sign(np.sin(2.0 * np.pi * (t + 0.01 * step) / period))[:, None]
    channel = SimpleNamespace(axes=AXES[name], step=step, difference=name != "force", run=np.zeros(len(t), dtype=int))
    left = left * step if channel.difference else left
    return SimpleNamespace(channels=(channel,), residual=lambda model: [left], times=lambda c: t)


def most(*flights, balance=()):
    model: Any = None
    return largest(model, flights, balance)


def test_the_largest_of_flights_counts_on_each_axis_fast_and_slow():
    found = most(flight([0.0, 3.0, 0.0], [1.0, 4.0, 0.0]), flight([1.0, 0.0, 0.0], [0.0, 1.0, 2.0]))
    expected = {"fx": (1.0, 1.0), "fy": (5.0, 3.0), "fz": (2.0, 0.0)}
    assert found.keys() == expected.keys()
    for axis, both in expected.items():
        assert found[axis] == pytest.approx(both, abs=0.1)


def test_steps_between_rows_count_a_second_whatever_the_rate_of_the_log():
    slow, fast = (most(flight([0.5, 0.0, 0.0], [0.0, 0.3, 0.0], "rate", step)) for step in (0.01, 0.0025))
    for axis, both in slow.items():
        assert fast[axis] == pytest.approx(both, abs=0.01)
    assert slow["tx"] == pytest.approx([0.5, 0.5])


def test_noise_from_sample_to_sample_hides_nothing():
    noisy, steady = flight([0.1, 0.0, 0.0], [5.0, 0.0, 0.0], period=0.02), flight([0.2, 0.0, 0.0], [0.0, 0.0, 0.0])
    assert as_ever(most(steady), most(noisy)) == {"fy", "fz"}


def test_no_stretch_is_averaged_over_a_gap():
    broken = flight([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    t = broken.times(None)
    broken.channels[0].run = (t >= 2.05).astype(int)
    left = np.where(t < 2.05, 1.0, -1.0)[:, None] * np.ones(3)
    broken.residual = lambda model: [left]
    assert most(broken)["fx"] == pytest.approx([1.0, 1.0])


def test_of_a_balance_what_is_slow_counts_alone_and_an_axis_that_no_healthy_flight_shows_is_new():
    healthy, now = flight([0.1, 0.0, 0.0], [1.0, 1.0, 1.0], "rate"), flight([0.05, 0.2, 0.0], [2.0, 0.0, 0.0], "rate")
    assert as_ever(most(now), most(healthy)) == {"tz"}
    in_balance = most(now, balance={"tx"}), most(healthy, balance={"tx"})
    assert as_ever(*in_balance) >= {"tx", "tz"}
    assert as_ever(most(flight([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], "push")), most(healthy)) == set()


def test_an_axis_whose_told_error_is_larger_than_on_healthy_flights_is_not_as_ever():
    after: Any = SimpleNamespace(rmse=np.array([1.0, 1.0, 2.0, 1.0, 1.0, 2.0]))
    now = frozenset({"fx", "vz", "tz", "push z"})
    assert _no_more(now, after, np.ones(6)) == {"fx", "push z"}
    assert _no_more(now, after, np.full(6, np.nan)) == now


@pytest.mark.parametrize(
    ("falls", "usual", "said"),
    [
        ({"fz": 0.8}, {"fz"}, True),
        ({"fz": 0.8, "tx": 0.1}, {"fz"}, True),  # what it takes off elsewhere is less than a sixth
        ({"fz": 0.8, "tx": 0.2}, {"fz"}, False),
        ({"fz": 0.1, "tx": -0.2}, {"tx"}, False),
        ({"vz": 0.8}, {"vz"}, True),
        ({"fz": 0.8}, {"fx"}, False),
    ],
)
def test_an_error_as_large_as_a_healthy_flight_s_needs_no_change(falls, usual, said):
    nothing: Any = None
    judge = Judge(nothing, nothing, (), (), nothing, {}, 0.05, nothing, as_ever=frozenset(usual))
    found = Evidence(-0.5, (-0.6, -0.4), (3, 3), 1.0, 1.0, "fz", falls=falls, gain=0.8, probability=1.0)
    member = SimpleNamespace(candidate=SimpleNamespace(cls=effect_class("linear_drag")))
    asked: Any = SimpleNamespace(evidence=found, needed=True, member=member)
    why = "the healthy model leaves no more on fz here than on some healthy flight"
    assert judge._doubt(asked) == (("Plausible", why) if said else (None, ""))
