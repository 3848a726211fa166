"""Every convention error is named for what it is; what a flight does not excite is not named at all."""

import numpy as np
import pytest
from check_flights import SPOILED, A, P, Q, V, W, named, simulated

from infotraj.checking import check, examine
from infotraj.checking.attitude import READINGS, unwrapped_euler
from infotraj.checking.likelihood import AXES, moments, sure_of_difference
from infotraj.checking.readings import NOISE, PENALTY, POSITION_UNITS, Pose, Vector
from infotraj.flight import Flight
from infotraj.rotations import angle_between, from_euler

FLIGHTS = {"quadrotor": simulated(3, duration=15.0), "omav": simulated(4, "omav", rate_hz=50.0, duration=15.0)}


@pytest.mark.parametrize("kind", FLIGHTS)
def test_good_flights_have_no_finding_beyond_notes(kind):
    assert named(examine(FLIGHTS[kind])) == set()


@pytest.mark.parametrize(("k", "error"), list(enumerate(SPOILED)))
def test_each_error_is_named(k, error):
    spoil, codes = SPOILED[error]
    found = named(examine(spoil(FLIGHTS[("quadrotor", "omav")[k % 2]])))
    assert found & set(codes), found


def test_two_errors_at_once_are_both_named():
    spoiled = SPOILED["rates in deg/s"][0](SPOILED["velocity in the body frame"][0](FLIGHTS["omav"]))
    assert {"rate_unit", "velocity_frame"} <= named(examine(spoiled))


def test_a_rejecting_finding_says_all_that_is_needed():
    (finding,) = [f for f in check(SPOILED["rates in deg/s"][0](FLIGHTS["quadrotor"])) if f.severity == "reject"]
    assert finding.sure > 0.99
    assert finding.channels == tuple(W)
    assert "deg/s" in finding.what
    assert "0.0174533" in finding.remedy
    assert finding.values["rate"]["as_found"] < 0.1 < finding.values["rate"]["as_declared"]  # rad/s
    assert finding.settings == ("rate.scale=0.0174533",)


def test_a_hover_says_nothing_about_body_or_world_rates():
    t = np.arange(0, 15, 0.01)
    rng = np.random.default_rng(0)
    q = from_euler(*(0.002 * rng.standard_normal((3, len(t)))))
    noise = {n: 0.02 * rng.standard_normal(len(t)) for n in W}
    still = FLIGHTS["quadrotor"].table.iloc[: len(t)].assign(t=t, **dict(zip(Q, q.T, strict=True)), **noise)
    still = still.assign(**dict.fromkeys(P[:2] + V, 0.0), pz=1.0, ax=0.0, ay=0.0, az=9.81)
    still = still.assign(**{n: still[n] + 1e-3 * rng.standard_normal(len(t)) for n in (*P, *V, *A)})
    still = still.drop(columns=[f"cmd_rotor_{k}" for k in range(4)]).assign(airborne=1.0)
    assert named(examine(Flight(still))) == set()


def test_without_an_attitude_units_of_the_accelerometer_are_still_judged():
    table = FLIGHTS["quadrotor"].table.drop(columns=[*Q, *P, *V])
    assert named(examine(Flight(table))) == set()
    in_g = Flight(table.assign(**{n: table[n] / 9.81 for n in A}))
    down = Flight(table.assign(**{n: -table[n] for n in A}))
    assert named(examine(in_g)) == {"acceleration_unit"}
    assert named(examine(down)) == {"acceleration_axes"}


def test_without_a_position_thrust_along_the_body_is_not_taken_for_the_world_frame():
    table = FLIGHTS["quadrotor"].table.drop(columns=[*P, *V])
    assert named(examine(Flight(table))) == set()
    in_g = Flight(table.assign(**{n: table[n] / 9.81 for n in A}))
    assert "acceleration_unit" in named(examine(in_g))


def test_derived_channels_are_no_evidence():
    spoiled = SPOILED["rates in the world frame"][0](FLIGHTS["omav"])
    assert "rate_frame" in named(examine(spoiled))
    assert "rate_frame" not in named(examine(Flight(spoiled.table, {"derived": W})))


def test_readings_of_the_attitude_undo_what_they_describe():
    rng = np.random.default_rng(1)
    t = np.arange(0, 5, 0.01)
    angles = 0.3 * np.stack([np.sin(2 * t + p) for p in rng.uniform(0, 6, 3)])
    q = from_euler(*angles)
    by_name = {r.name: r for r in READINGS}
    wrong = {
        "xyzw": q[:, [1, 2, 3, 0]],
        "wxyz": q[:, [3, 0, 1, 2]],
        "world to body": q * [1, -1, -1, -1],
        "radians taken as degrees": from_euler(*np.radians(angles)),
        "pitch of the other sign": from_euler(angles[0], -angles[1], angles[2]),
    }
    for name, declared in wrong.items():
        np.testing.assert_allclose(angle_between(by_name[name].true(declared), q), 0, atol=1e-6)
    np.testing.assert_allclose(np.diff(unwrapped_euler(q), axis=0), np.diff(angles.T, axis=0), atol=1e-9)


def test_axes_are_the_24_rotations_and_the_inversion():
    assert len({tuple(a.ravel()) for a in AXES}) == 25
    assert sum(np.linalg.det(a) > 0 for a in AXES) == 24
    assert np.array_equal(AXES[0], np.eye(3))


def test_scores_from_moments_are_those_from_the_samples():
    rng = np.random.default_rng(2)
    x, y = rng.standard_normal((1, 400, 3)), rng.standard_normal((2, 400, 3))
    m = moments(x, y, np.arange(400.0), np.repeat(np.arange(10), 40), allowance=0.05)
    values, _ = m.scores(AXES, np.array([1.0, 2.0]))
    for c, g, u in ((0, 0, 0), (1, 7, 1), (0, 24, 1)):
        rest = x[0] - (1.0, 2.0)[u] * y[c] @ AXES[g].T
        rest = rest - np.clip(rest.mean(axis=0), -0.05, 0.05)
        expected = -0.5 * m.independent * np.log((rest**2).mean(axis=0) + m.floor).sum()
        assert values[c, g, u] == pytest.approx(expected)
        np.testing.assert_allclose(m.residual(c, AXES[g], (1.0, 2.0)[u])[:, 0].sum(axis=0), (rest**2).sum(axis=0))


def test_the_test_between_readings_keeps_its_level():
    """Under the declared reading a false claim at 1 % must stay rare; under the other one it must be found."""
    rng = np.random.default_rng(3)
    false = found = 0
    for _ in range(400):
        d = rng.standard_normal((30, 20))
        e = np.repeat(rng.standard_normal((30, 10)), 2, axis=1)
        for truth in (0.0, 1.0):
            r = truth * d + e
            sure = sure_of_difference((r * d).sum(1), (d * d).sum(1), ((r - d) * d).sum(1), tried=1)
            false += truth == 0 and sure > 0.99
            found += truth == 1 and sure > 0.99
    assert false <= 8
    assert found >= 380


def test_only_the_declared_reading_is_free_and_each_change_costs_more():
    """Prior odds: one change about PENALTY, two changes more than either alone."""
    changes = [("attitude", k) for k in range(1, len(READINGS))] + [("axes", "yxz"), ("down", True), ("unit", NOISE)]
    changes += [("unit", unit) for unit in POSITION_UNITS if unit != 1.0]
    assert Pose().penalty == Vector().penalty == 0.0
    for name, value in changes:
        alone = Pose(**{name: value}).penalty
        assert 0.5 * PENALTY <= alone <= 1.5 * PENALTY
        for other, its in changes:
            if other != name:
                assert np.isclose(
                    Pose(**{name: value, other: its}).penalty, alone + Pose(**{other: its}).penalty, rtol=1e-12
                )
    for change in ({"turn": 1}, {"turn": -1}, {"axes": 5}, {"unit": 0.01}, {"removed": True}):
        assert PENALTY <= Vector(**change).penalty <= 1.5 * PENALTY
