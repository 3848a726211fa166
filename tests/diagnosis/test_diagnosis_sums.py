"""Sums over blocks, and what is known of numbers before and after healthy flights, by numbers worked out by hand."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from given_sums import given_sums

from infotraj.diagnosis.linear.candidates import Candidate, Place, candidates, places, variants
from infotraj.diagnosis.linear.healthy import Healthy
from infotraj.diagnosis.linear.observation import Member, Observation, inward, packed, unpacked
from infotraj.diagnosis.linear.sums import WINDOW, Blocks, blocks, gathered
from infotraj.diagnosis.noise.spectra import BANDS, EDGES, SLOW_BANDS, Spectrum, Weights, spectra, weights
from infotraj.diagnosis.select.bounds import beyond_bounds
from infotraj.diagnosis.select.prior import Scales, price
from infotraj.effects import effect_class
from infotraj.effects.rotor_height import RotorHeight
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.effects.sensor_place import SensorPlace
from infotraj.flight import Flight
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")
RNG = np.random.default_rng(0)


def candidate(name, **fixed):
    cls = effect_class(name)
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index), tuple(fixed.items()))


def place(whole=0.0, absent=0.0, low=-9.0, high=9.0):
    return Place("x", 0, 0.1, low, high, absent, whole)


@pytest.mark.parametrize("absent", [0.0, 1.0])
def test_a_factor_and_its_inverse_are_as_far_from_one(absent):
    at = place(whole=2.0, absent=absent)
    twice, half = (at.coordinate(absent + 2.0 * (factor - 1.0)) for factor in (2.0, 0.5))
    assert twice - absent == pytest.approx(2.0 * np.log(2.0))
    assert half - absent == pytest.approx(-2.0 * np.log(2.0))
    for coordinate in (-1.3, 0.4, 2.0):
        value = at.value(coordinate)
        assert at.coordinate(value) == pytest.approx(coordinate)
        slope = (at.value(coordinate + 1e-6) - at.value(coordinate - 1e-6)) / 2e-6
        assert at.slope(value) == pytest.approx(slope, rel=1e-6)


def test_a_column_is_a_secant_of_the_numbers_own_step_and_a_length_without_a_load_has_none():
    (drag,) = variants(candidate("linear_drag"), VEHICLE)
    assert [i for i, *_ in drag.points] == [0, 1, 2]
    scale = places(candidate("linear_drag"), VEHICLE)[0].scale
    for i, effect, size in drag.points:
        assert size == pytest.approx(scale)
        assert effect.d == pytest.approx(scale * np.eye(3)[i])
    assert drag.start == pytest.approx(np.zeros(3))
    load = candidate("suspended_load")
    names = [p.parameter for p in places(load, VEHICLE)]
    for made in variants(load, VEHICLE):
        (one,) = made.points
        assert names[one[0]] == "mass"
        # Its length is that of the start.
        assert one[1].length == pytest.approx(made.start[names.index("length")])
        assert made.start[names.index("mass")] == 0.0


def test_all_numbers_of_a_form_are_counted():
    assert candidate("linear_drag").count(VEHICLE) == 3
    assert candidate("inertia_error").count(VEHICLE) == 3
    assert candidate("rotor_effectiveness", rotor=1).count(VEHICLE) == 1


def member(name, **values):
    c = candidate(name)
    return Member(c, c.at(values))


def test_packed_numbers_are_in_usual_sizes_and_come_back():
    members = [member("linear_drag", d=[0.1, 0.2, 0.3]), member("actuation_delay", delay=0.03)]
    x, owner = packed(members, VEHICLE)
    scale = places(candidate("linear_drag"), VEHICLE)[0].scale
    assert x == pytest.approx([0.1 / scale, 0.2 / scale, 0.3 / scale, 2.0])
    assert [k for k, _ in owner] == [0, 0, 0, 1]
    back = unpacked(members, VEHICLE, np.add(x, [0.0, 0.0, 1.0, -1.0]))
    assert back[0].effect.d == pytest.approx([0.1, 0.2, 0.3 + scale])
    assert back[1].effect.delay == pytest.approx(0.015)
    # A delay is between 0 and 0.2 s.
    far = unpacked(members[1:], VEHICLE, np.array([99.0]))
    assert far[0].effect.delay == pytest.approx(0.2)
    assert unpacked(members[1:], VEHICLE, np.array([-99.0]))[0].effect.delay == 0.0


def test_a_step_goes_inward_at_the_upper_bound():
    assert inward(8.0, place(), 0.5) == 0.5
    assert inward(8.8, place(), 0.5) == -0.5


def test_axes_that_are_left_out_add_up():
    made = Observation(VEHICLE, (), (), Blocks((), (), np.zeros(0), np.zeros(0)), ignored=frozenset({"fx"}))
    assert made.without_axes({"tz"}).ignored == {"fx", "tz"}


def test_healthy_numbers_stand_beside_what_is_asked_for_and_have_no_other():
    drag, delay = member("linear_drag", d=[0.1, 0.2, 0.3]), member("actuation_delay", delay=0.03)
    healthy = Healthy({"linear_drag": drag.effect}, (), *(np.zeros(0),) * 3, frozenset(), ())
    made = Observation(VEHICLE, (), (), Blocks((), (), np.zeros(0), np.zeros(0)), healthy=healthy)
    assert [e.name for e in made.model([delay]).effects] == ["linear_drag", "actuation_delay"]
    twice = member("linear_drag", d=[0.4, 0.4, 0.4])
    (only,) = made.model([twice]).effects
    assert only.d == pytest.approx([0.4, 0.4, 0.4])
    assert made.base(drag.candidate).d == pytest.approx([0.1, 0.2, 0.3])
    assert made.base(delay.candidate).delay == 0.0
    at = drag.places(VEHICLE)
    assert not healthy.changed(drag.candidate, drag.effect, at, VEHICLE)
    assert healthy.changed(drag.candidate, twice.effect, at, VEHICLE)


def healthy_of(owners, rather, covariance, scatter, **effects):
    numbers = (np.array(rather), np.array(covariance), np.array(scatter))
    return Healthy(effects, tuple(owners), *numbers, frozenset(), ())


def test_what_healthy_flights_know_is_told_in_the_numbers_own_unit():
    """Known to 0.3 usual sizes, scattering by 0.4: 0.5 together; of a mass that is twice the file's a step is twice."""
    mass, drag = candidate("mass_offset"), candidate("linear_drag")
    heavier = mass.at({"dm": VEHICLE.mass})
    owners = [("mass_offset", 0), ("linear_drag", 1)]
    made = healthy_of(owners, [0.2, -0.7], np.diag([0.09, 0.36]), [0.4, 0.8], mass_offset=heavier)
    said = made.said(mass, places(mass, VEHICLE), VEHICLE)
    assert said["parameters"] == {"dm": pytest.approx(VEHICLE.mass)}
    assert said["standard_errors"] == {"dm": pytest.approx(0.5 * 0.05 * VEHICLE.mass * 2.0)}
    assert said["from_flight_to_flight"] == {"dm": pytest.approx(0.4 * 0.05 * VEHICLE.mass * 2.0)}
    scale = places(drag, VEHICLE)[0].scale
    errors = made.said(drag, places(drag, VEHICLE), VEHICLE)["standard_errors"]
    assert errors == {"d": [None, pytest.approx(scale), None]}
    columns = [("linear_drag", 1), ("mass_offset", 0), ("wind", 0), ("mass_offset", 0)]
    assert made.mean(columns) == pytest.approx([-0.7, 0.2, 0.0, 0.0])
    known, hidden = made.shown([mass, drag, candidate("wind")], {"time_offset": "no gyro"})
    assert [c.name for c in known] == ["mass_offset", "linear_drag"]
    assert hidden == {"time_offset": "no gyro", "wind": "the healthy flights cannot show it"}


def test_a_number_that_stopped_short_of_a_bound_by_a_thousandth_is_at_it():
    """Of the way from what changes nothing; where that is the bound it is none."""
    assert "delay (0.2)" in beyond_bounds([member("actuation_delay", delay=0.2 * 0.9995)], VEHICLE)["actuation_delay"]
    assert beyond_bounds([member("actuation_delay", delay=0.2 * 0.995)], VEHICLE) == {}
    assert beyond_bounds([member("actuation_delay", delay=0.0)], VEHICLE) == {}
    # A factor may be 0.5 to 2: a factor of 1 is the absent value.
    assert beyond_bounds([member("thrust_scale", factor=0.5)], VEHICLE)
    assert beyond_bounds([member("thrust_scale", factor=0.51)], VEHICLE) == {}
    # A thousandth of the way is one of ln 2.
    assert beyond_bounds([member("thrust_scale", factor=0.5 * np.exp(0.0009 * np.log(2.0)))], VEHICLE)


def test_what_a_name_costs_grows_with_the_number_of_its_places_and_is_infinite_for_what_is_none():
    drag = candidate("linear_drag")
    assert price(drag, 4, 1) - price(drag, 1, 1) == pytest.approx(np.log(4.0))
    assert price(drag, 1, 3) == price(drag, 1, 1) == 5.0
    # What changed is asked where something did: one effect of 30, not of 150.
    assert np.exp(-price(drag, 1, 1, changed=True)) == pytest.approx(1.0 / 30.0, rel=0.01)
    # A propeller's curve is as it was built: it may be missing in a model, and changes by itself in one case of ten.
    curve = candidate("thrust_exponent")
    assert price(curve, 1, 1) == price(drag, 1, 1)
    seldom = np.exp(price(drag, 1, 1, changed=True) - price(curve, 1, 1, changed=True))
    assert seldom == pytest.approx(0.1, rel=0.01)
    load = candidate("suspended_load")
    # The first swing of a load is four numbers of each flight.
    assert price(load, 1, 3) - price(load, 1, 1) == pytest.approx(2.0 * 2.0 * 4.0)
    for cls in (RotorTorque, RotorHeight, SensorPlace):
        assert price(Candidate(cls, tuple(p for p in cls.parameters if not p.index)), 1, 1) == float("inf")


def test_a_kind_costs_by_how_many_deviations_its_scale_is_from_the_others():
    """A factor of e to the 0.8 is two standard deviations of 0.4."""
    assert Scales(1.0, {"mass": np.exp(0.8)}).cost() == pytest.approx(2.0)
    assert Scales(3.0, {"mass": 3.0 * np.exp(-0.4), "arms": 3.0}).cost() == pytest.approx(0.5)
    assert Scales(3.0).cost() == 0.0
    wider = Scales(3.0, {"mass": 9.0}, frozenset({"x"})).times(2.0)
    assert (wider.common, wider.kinds, wider.corrects) == (6.0, {"mass": 18.0}, {"x"})


def spectrum(axis, flight, values, band, time, measured=None):
    return Spectrum(axis, flight, values, measured, np.asarray(band), np.asarray(time, dtype=float))


def made_of(flights=3, seconds=20, count=12):
    """Coefficients of two axes of several flights, a dozen a second from band to band, weights of every kind."""
    found = []
    for flight in range(flights):
        for axis in ("fx", "tz"):
            n = seconds * count
            band = np.tile(np.arange(count) % BANDS, seconds)
            time = 1.0 + np.repeat(np.arange(seconds), count)
            found.append(spectrum(axis, flight, RNG.standard_normal((n, 3)), band, time))
    noise, coherence = RNG.uniform(0.5, 2.0, (2, BANDS)), RNG.uniform(0.1, 1.0, (2, BANDS))
    second = tuple(RNG.uniform(0.1, 1.0, len(s.band)) for s in found)
    return found, Weights(("fx", "tz"), noise, coherence, second, noise)


def test_sums_are_those_of_the_coefficients_written_out():
    found, w = made_of()
    cut = blocks(found)
    sums = gathered(found, w, cut)
    assert sums.gram.shape[1] == len(cut.flight) == 3 * 10
    for a, axis in enumerate(sums.axes):
        own = [(k, s) for k, s in enumerate(found) if s.axis == axis]
        weighed = sum(
            (s.values * (w.coherence[a] / w.noise[a])[s.band, None] * w.second[k][:, None]).T @ s.values for k, s in own
        )
        np.testing.assert_allclose(sums.gram[a].sum(axis=0), weighed)
        slow = [s.band < SLOW_BANDS for _, s in own]
        plain = sum(s.values[low].T @ s.values[low] for (_, s), low in zip(own, slow, strict=True))
        np.testing.assert_allclose(sums.plain[a].sum(axis=0), plain)
        believed = sum(
            (s.values[low] * w.coherence[a, s.band[low], None]).T @ s.values[low]
            for (_, s), low in zip(own, slow, strict=True)
        )
        np.testing.assert_allclose(sums.believed[a].sum(axis=0), believed)
        assert sums.slow[a].sum() == sum(low.sum() for low in slow)
        expected = sum(np.sum(w.coherence[a, s.band] * w.second[k]) for k, s in own)
        assert sums.noise[a] == pytest.approx(expected)
        # Twenty seconds of each flight, in units of a window.
        assert sums.windows[a].sum() == pytest.approx(3 * 20.0 / WINDOW)
    # Each fold is a flight: the third holds what its own coefficients are.
    third = [s for s in found if s.flight == 2]
    low = third[0].band < SLOW_BANDS
    np.testing.assert_allclose(sums.plain[0, 2], third[0].values[low].T @ third[0].values[low])
    assert sums.flight.tolist() == sums.fold.tolist() == np.repeat([0, 1, 2], 10).tolist()


def test_products_by_fold_are_those_of_all_axes_together():
    found, w = made_of()
    sums = gathered(found, w, blocks(found))
    of_flights = [sums.gram[:, sums.flight == k].sum(axis=(0, 1)) for k in range(3)]
    np.testing.assert_allclose(sums.by_fold, of_flights)
    np.testing.assert_allclose(sums.total, np.sum(of_flights, axis=0))
    theta = np.array([0.7, -1.2])
    assert sums.whole_error(theta) == pytest.approx(sums.error(theta).sum())
    assert sums.shifted(theta).whole_error(0.0 * theta) == pytest.approx(sums.whole_error(theta))


def test_columns_that_stay_under_the_same_weights_have_the_sums_of_their_own():
    """Another residual, one column new, and the two of before the other way round."""
    found, w = made_of()
    cut, first = blocks(found), gathered(found, w, blocks(found))
    other = []
    for s in found:
        fresh = RNG.standard_normal((len(s.values), 2))
        other.append(spectrum(s.axis, s.flight, np.hstack([fresh, s.values[:, [2, 1]]]), s.band, s.time))
    made, wanted = gathered(other, w, cut, first, [2, 3], [2, 1]), gathered(other, w, cut)
    for name in ("by_fold", "gram", "plain", "believed"):
        np.testing.assert_allclose(getattr(made, name), getattr(wanted, name), atol=1e-9)


def test_a_residual_less_its_columns_has_the_squares_of_what_is_left():
    x = RNG.standard_normal((50, 3))
    theta, step = np.array([0.7, -1.2]), np.array([0.4, 0.1])
    gram = np.broadcast_to(x.T @ x, (1, 1, 3, 3))
    sums = given_sums(gram, np.full((1, 1), 50.0), ("fx",))
    left = x[:, 0] - x[:, 1:] @ theta
    moved = sums.shifted(theta)
    whole = np.column_stack([left, x[:, 1:]])
    np.testing.assert_allclose(moved.gram[0, 0], whole.T @ whole)
    assert moved.error(step)[0, 0] == pytest.approx(np.sum((left - x[:, 1:] @ step) ** 2))
    assert sums.plain_error(theta[None])[0] == sums.believed_error(theta[None])[0] == pytest.approx(np.mean(left**2))


def test_blocks_are_of_about_two_seconds_one_flight_after_another():
    """A flight of 20 s and one of 7 s: ten and four blocks, in which a time is found again."""
    times = [np.arange(3.0, 23.01, 0.5), np.arange(50.0, 57.01, 0.5)]
    found = [spectrum("fx", k, np.zeros((len(t), 2)), np.zeros(len(t), dtype=int), t) for k, t in enumerate(times)]
    cut = blocks(found)
    assert cut.flight.tolist() == [0] * 10 + [1] * 4
    assert cut.at(0, np.array([3.1, 4.9, 5.1, 22.9])).tolist() == [0, 0, 1, 9]
    assert cut.at(1, np.array([50.1, 51.9, 56.9])).tolist() == [10, 11, 13]
    hour = np.arange(0.0, 3600.0, 1.0)
    long = blocks([spectrum("fx", 0, np.zeros((len(hour), 2)), np.zeros(len(hour), dtype=int), hour)])
    assert 80 <= len(long.flight) <= 96


def test_axes_that_are_ignored_weigh_nothing_and_those_in_balance_by_their_slowest_band_alone():
    found, _ = made_of(flights=1)
    for s in found:
        s.values[:, 0] += 3.0 * s.values[:, 1]
    found = [spectrum(s.axis, 0, s.values, s.band, s.time, measured=s.values[:, 0].copy()) for s in found]
    w = weights(found, ignored=frozenset({"fx"}))
    assert not w.coherence[0].any()
    assert w.coherence[1].min() > 0.5
    assert not w.of(0, found[0]).any()
    balance = weights(found, balance=frozenset({"tz"}))
    assert balance.coherence[1].tolist() == [1.0] + [0.0] * (BANDS - 1)
    assert (balance.slow("fx"), balance.slow("tz")) == (SLOW_BANDS, 1)


def test_what_an_ignored_axis_says_of_a_number_does_not_reach_another_axis():
    """One column, of which five flights' first axis has three times as much as the second, which one flight shows."""
    found, _ = made_of(flights=5)
    found = [s for s in found if s.axis == "fx" or s.flight == 0]
    noise = []
    for ignored in (frozenset(), frozenset({"fx"})):
        for s in found:
            size, own = (3.0, 0.01) if s.axis == "fx" else (1.0, 1.0)
            s.values[:, 0] = size * s.values[:, 1] + own * RNG.standard_normal(len(s.band))
        noise.append(weights(found, ignored).noise[1].mean())
    assert noise[0] > 3.0
    assert noise[1] == pytest.approx(1.0, rel=0.3)


def test_the_mean_of_a_balance_is_no_noise_of_its_seconds():
    found, _ = made_of(flights=2)
    for s in found:
        steady = np.where(s.band == 0, 5.0 if s.flight else -5.0, 0.0)
        s.values[:, 0] = 0.1 * RNG.standard_normal(len(s.band)) + steady
        s.values[:, 1:] = 0.0
    w = weights(found, balance=frozenset({"tz"}))
    assert w.noise[1, 0] == pytest.approx(0.01, rel=0.4)
    assert w.noise[0, 0] == pytest.approx(25.0, rel=0.1)


def test_coefficients_stand_in_the_band_of_their_frequency():
    frequency = np.array([0.2, 0.5, 1.2, 4.9, 5.0, 13.0, 20.05, 25.0])

    class Turn:
        """Leaves what it is given."""

        time = np.zeros(8)

        def __init__(self, frequency):
            self.frequency = frequency

        def turned(self, x):
            return x

    turn = Turn(frequency)
    kept = SimpleNamespace(get=lambda *_: None)

    def made(rotor, tilt, tilts):
        recorded = SimpleNamespace(
            tilt=SimpleNamespace(values=np.zeros((4, tilts))), rotor_commanded=rotor, tilt_commanded=tilt
        )
        sample = SimpleNamespace(
            prepared=SimpleNamespace(recorded=recorded, kept=kept), channels=[SimpleNamespace(axes=("fx", "fy", "fz"))]
        )
        return spectra([sample], [[turn]], [[np.zeros((len(frequency), 3, 2))]])[0]

    assert made(True, False, 0).band.tolist() == [0, 1, 2, 5, 6, 8, 9, 9]
    assert len(EDGES) == BANDS + 1 == 11
    assert [made(*x).noisy for x in ((True, False, 0), (True, False, 2), (False, True, 2), (True, True, 2))] == [
        False,
        True,
        True,
        False,
    ]


def test_a_bound_is_one_of_the_coordinate():
    """An inertia may be a fifth of the file's: that is as far as five times it, in logarithms."""
    c = candidate("inertia_error")
    at = places(c, VEHICLE)[0]
    nominal = VEHICLE.inertia.xx
    assert (at.low, at.high) == pytest.approx((nominal * np.log(0.2), nominal * np.log(10.0)))
    # A number of the file that is next to nothing is a hundredth of it.
    assert at.coordinate(-0.97 * nominal) == pytest.approx(nominal * np.log(0.03))
    assert at.coordinate(-nominal) == pytest.approx(nominal * np.log(0.01))


def test_an_effect_is_asked_about_where_one_flight_can_show_it_and_all_can_be_evaluated():
    t = np.arange(0.0, 3.0, 0.01)
    commands = {f"cmd_rotor_{i}": 500.0 + 10.0 * np.sin(t + i) for i in range(4)}
    turned = {"qw": np.ones(len(t)), "qx": 0.0 * t, "qy": 0.0 * t, "qz": 0.0 * t}
    moving = Flight(pd.DataFrame({"t": t, **commands, **turned, "wx": t, "wy": t, "wz": t, "vx": t, "vy": t, "vz": t}))
    blind = Flight(moving.table.drop(columns=["vx", "vy", "vz"]))
    steady = Flight(moving.table.assign(**dict.fromkeys(commands, 500.0)))
    asked = {n: effect_class(n) for n in ("linear_drag", "actuation_delay", "rotor_effectiveness", "servo_bias")}

    def found(*flights):
        known, hidden = candidates(asked, VEHICLE, flights)
        return [c.label for c in known], hidden

    rotors = [f"rotor_effectiveness {i}" for i in range(4)]
    tilts = {"servo_bias": "the vehicle has no tilts"}
    assert found(moving) == (["linear_drag", "actuation_delay", *rotors], tilts)
    # A delay of constant commands is not seen, but may be there; a drag without a velocity cannot be evaluated.
    assert found(steady, moving) == (["linear_drag", "actuation_delay", *rotors], tilts)
    assert found(steady)[1].keys() == {"actuation_delay", *tilts}
    known, hidden = found(moving, blind)
    assert known == ["actuation_delay", *rotors]
    assert hidden["linear_drag"] == "the flight has neither velocity nor position"
