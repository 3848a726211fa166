"""A model made linear: numbers and bounds of its columns, what is known of each, and the effects that numbers make."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from linear_fits import BLOCKS, ROWS, VEHICLE, linear_fit

from infotraj.diagnosis.linear.candidates import Candidate, places, variants
from infotraj.diagnosis.linear.healthy import Healthy
from infotraj.diagnosis.noise.spectra import Spectrum
from infotraj.diagnosis.select.around import _column, balanced, in_balance
from infotraj.diagnosis.select.learned import _as_files_are, _before, _usual, learned, scattered
from infotraj.diagnosis.select.prior import SLAB, Scales, file_only, spikes
from infotraj.diagnosis.select.reading import ran_on, sparse
from infotraj.diagnosis.select.scaling import scaled
from infotraj.diagnosis.select.swinging import _variant, shape_of
from infotraj.effects import effect_class
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.flight import Flight
from infotraj.sparse_commands import COMMAND_STEPS
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle(Path(__file__).parents[2] / "config/vehicles/omav.yaml")


def candidate(name, **fixed):
    cls = effect_class(name)
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index), tuple(fixed.items()))


def before(**effects):
    """An observation whose effects were so before anything was found."""
    return SimpleNamespace(vehicle=VEHICLE, base=lambda c: effects.get(c.name) or c.absent(VEHICLE))


@pytest.mark.parametrize("held", [None, ()])
def test_a_number_that_stays_absent_is_fitted_by_nothing_and_the_others_take_its_part(held):
    def rows(rng, _):
        x = np.zeros((ROWS, 3))
        x[:, 1] = rng.standard_normal(ROWS)
        x[:, 2] = 0.5 * x[:, 1] + rng.standard_normal(ROWS)
        x[:, 0] = x[:, 1] + x[:, 2] + 0.1 * rng.standard_normal(ROWS)
        return x

    _, whole = linear_fit(["linear_drag", "quadratic_drag"], rows, ["linear_drag", "quadratic_drag"])
    assert whole.solution.theta == pytest.approx([1.0, 1.0], abs=0.02)
    whole.linear.observation.still = frozenset({("linear_drag", 0)})
    theta = whole.linear.scorer(Scales(0.0), held).solution((0, 1)).theta
    assert theta == pytest.approx([0.0, 1.0 + 0.5 / 1.25], abs=0.03)
    made = whole.linear.members((0, 1), np.array([1.0, 1.0]), shift=0.0)
    assert [np.any(m.effect.values["d"]) for m in made] == [False, True]


def test_a_number_that_the_point_leaves_to_the_linear_model_is_no_step_that_is_left():
    """A reaction torque that is hardly off stays linear: what its number explains is explained."""

    def rows(rng, _):
        x = np.zeros((ROWS, 3))
        x[:, 1:] = rng.standard_normal((ROWS, 2))
        x[:, 0] = 1.5 * x[:, 1] + 0.05 * x[:, 2] + rng.standard_normal(ROWS)
        return x

    _, whole = linear_fit(["linear_drag", "moment_scale"], rows, ["linear_drag"])
    now, scales = replace(whole.linear, point=()), Scales(9.0)
    made = replace(whole, linear=now, scales=scales, solution=now.scorer(scales).solution((0,)))
    left = now.sums.whole_error(made.solution.theta)
    of_drag, of_both = (now.sums.whole_error(x) - left for x in (np.array([0.0, made.solution.theta[1]]), np.zeros(2)))
    assert abs(of_both - of_drag) > 0.5
    assert made.gain_left == pytest.approx(of_drag, rel=1e-9)
    # Where every number of the file is computed, its step is left, too.
    assert replace(made, exact=True).gain_left == pytest.approx(of_both, rel=1e-9)


def test_a_column_counts_in_usual_sizes_from_what_was_before():
    delay = candidate("actuation_delay")
    absent = _column(delay, 0, 0.03, before())
    assert (absent.now, absent.low, absent.high) == pytest.approx((2.0, 0.0, 0.2 / 0.015))
    assert (absent.idle, absent.slope) == (False, 1.0)
    late = _column(delay, 0, 0.03, before(actuation_delay=delay.at({"delay": 0.015})))
    assert (late.now, late.low, late.high) == pytest.approx((1.0, -1.0, 0.2 / 0.015 - 1.0))
    # A candidate that is absent is not anywhere yet.
    assert _column(delay, 0, 0.03, before(), absent=True).now == 0.0


def test_a_lag_that_is_missing_is_longer_and_one_of_the_file_may_be_shorter():
    lag = _column(candidate("rotor_lag"), 0, 0.0, before())
    declared = min(r.time_constant for r in VEHICLE.rotors)
    assert (lag.low, lag.lowest) == pytest.approx((0.0, -declared / 0.03))
    mass = _column(candidate("mass_offset"), 0, 0.0, before())
    assert mass.low == mass.lowest < 0.0


def test_a_column_of_a_logarithm_has_the_slope_of_its_number_and_a_length_without_a_load_is_idle():
    mass = candidate("mass_offset")
    at = places(mass, VEHICLE)[0]
    twice = _column(mass, 0, at.coordinate(VEHICLE.mass), before())
    assert twice.now * twice.scale == pytest.approx(VEHICLE.mass * np.log(2.0))
    assert twice.slope == pytest.approx(2.0)
    load = candidate("suspended_load")
    idle = {
        p.parameter: _column(load, i, p.absent, before(), absent=True).idle for i, p in enumerate(places(load, VEHICLE))
    }
    assert idle == {"mass": False, "length": True}


def test_in_a_balance_a_column_is_the_mean_of_its_slowest_band():
    values = np.array([[9.0, 1.0, 4.0], [8.0, 3.0, 6.0], [7.0, 50.0, 60.0]])
    s = Spectrum("tz", 0, values.copy(), None, np.array([0, 0, 2]), np.zeros(3))
    balanced(s, [2])
    assert s.values.tolist() == [[9.0, 2.0, 0.0], [8.0, 2.0, 0.0], [7.0, 0.0, 0.0]]


def test_what_changes_a_balance_of_torques():
    names = ("rotor_effectiveness", "steady_torque", "mass_offset", "com_offset", "inertia_error", "actuation_delay")
    assert [in_balance(candidate(n)) for n in names] == [True, True, True, True, False, False]


def two(names=("actuation_delay", "mass_offset"), chosen=("actuation_delay",), sizes=(2.0, 0.5)):
    def rows(rng, _):
        x = np.zeros((ROWS, 1 + len(names)))
        x[:, 1:] = rng.standard_normal((ROWS, len(names)))
        x[:, 0] = x[:, 1:] @ sizes + rng.standard_normal(ROWS)
        return x

    return linear_fit(list(names), rows, list(chosen))[1].linear


def test_numbers_make_effects_and_effects_numbers():
    now = two()
    (delay,) = now.members((0,), np.array([2.0, 0.0]), np.inf)
    assert delay.effect.delay == pytest.approx(0.03)
    assert now._numbers([delay]) == pytest.approx([2.0, 0.0])
    # Within the bounds of a delay.
    assert now.members((0,), np.array([99.0, 0.0]), np.inf)[0].effect.delay == pytest.approx(0.2)
    moved = now.with_numbers([delay], np.array([3.0, 1.0]))
    assert moved[0].effect.delay == pytest.approx(0.045)
    # A number of 0 says that it stays.
    assert now.with_numbers([delay], np.zeros(2))[0].effect.delay == pytest.approx(0.03)


def test_a_number_of_the_file_is_taken_along_where_it_shifts_the_residual_by_enough():
    """Half a usual size of a column of 2000 rows and variance 1: a weighted square of 500."""
    now = two()

    def made(shift):
        return {m.candidate.name: m.effect for m in now.members((0,), np.array([2.0, 0.5]), shift, True)}

    assert made(400.0)["mass_offset"].dm == pytest.approx(VEHICLE.mass * np.expm1(0.5 * 0.05))
    assert set(made(600.0)) == {"actuation_delay"}


def test_a_number_is_as_far_off_as_files_are_once_and_an_effect_that_corrects_it_is_as_far():
    now = two()
    # Commands every 5 ms are stamped to a tenth of that: half a millisecond, of a usual delay of 15.
    delay = np.hypot(1 / 15, 0.5 / 15)
    assert now.spike(Scales(3.0)) == pytest.approx([delay, 0.3])
    twice = replace(now, columns=(now.columns[1], now.columns[1]))
    assert twice.spike(Scales(3.0)) == pytest.approx([0.3, 0.0])
    assert np.diag(now.prior(Scales(3.0))) == pytest.approx([delay**2, 0.09])
    corrects = Scales(3.0, corrects=frozenset({"mass_offset"}))
    assert np.diag(now.prior(corrects)) == pytest.approx([delay**2, 0.0])
    assert now._slab(corrects) == pytest.approx([SLAB, 0.3])
    assert now._slab(Scales(3.0)) == pytest.approx([SLAB, SLAB])


def test_the_frame_of_the_imu_is_no_further_off_where_the_file_is():
    """A tenth of a degree, where tilts are nine times as far off; as exact as a file that is exact."""
    frame, tilts = (Candidate(effect_class(n), effect_class(n).parameters) for n in ("imu_misalignment", "servo_bias"))
    sizes = [(frame, 0.0175), (tilts, 0.0175)]
    of_frame, of_tilts = np.array([spikes(sizes, Scales(c), 0.0, VEHICLE) for c in (0.05, 1.0, 9.0)]).T
    np.testing.assert_allclose(of_frame / of_frame[1], [0.05, 1.0, 1.0])
    np.testing.assert_allclose(of_tilts / of_tilts[1], [0.05, 1.0, 9.0])


def test_a_file_may_be_corrected_below_the_least_that_an_effect_may_be():
    now = two()
    column = replace(now.columns[0], low=0.0, lowest=-3.0)
    now = replace(now, columns=(column, now.columns[1]))
    corrects = Scales(1.0, corrects=frozenset({"actuation_delay"}))
    assert now.scorer(Scales(1.0)).low[0] == 0.0
    assert now.scorer(corrects).low[0] == -3.0
    # An idle number is told as a step from where it is.
    idle = replace(column, idle=True, now=1.5, high=4.0)
    scorer = replace(now, columns=(idle, now.columns[1])).scorer(Scales(1.0))
    assert (scorer.low[0], scorer.high[0]) == (-1.5, 2.5)


@pytest.mark.parametrize("flights", [1, 2])
def test_numbers_are_held_against_what_healthy_flights_would_have(flights):
    """One flight alone may differ by what flights differ by; bounds are those of the numbers, not of the changes."""
    owners = (("actuation_delay", 0), ("mass_offset", 0))
    mean, covariance = np.array([0.5, -0.2]), np.array([[0.04, 0.01], [0.01, 0.09]])
    healthy = Healthy({}, owners, mean, covariance, np.array([0.3, 0.4]), frozenset(), ())
    now = two()
    now.observation.healthy, now.observation.samples = healthy, [None] * flights
    now.observation.scatter = {("actuation_delay", 0): 0.3, ("mass_offset", 0): 0.4}
    column = replace(now.columns[0], low=0.0, high=4.0)
    now = replace(now, columns=(column, now.columns[1]))
    scorer = now.scorer(Scales(1.0))
    assert (scorer.low[0], scorer.high[0]) == pytest.approx((-0.5, 3.5))
    assert scorer.given == pytest.approx(mean)
    assert scorer.prior == pytest.approx(covariance + (np.diag([0.09, 0.16]) if flights == 1 else 0.0))
    assert now.scales == (Scales(1.0),)


def differing(scatter=0.5):
    """Forty flights: a drag of 1 that differs from flight to flight, and a delay and a mass that are as the file's."""

    def rows(rng, _):
        x = np.zeros((ROWS, 4))
        x[:, 1:] = rng.standard_normal((ROWS, 3))
        x[:, 0] = (1.0 + scatter * rng.standard_normal()) * x[:, 1] + rng.standard_normal(ROWS)
        return x

    return linear_fit(["linear_drag", "rotor_drag", "mass_offset"], rows, [])[1].linear


def test_what_flights_differ_by_is_found_for_each_number():
    found = scattered(differing())
    assert 0.3 < found["linear_drag", 0] < 1.0
    assert found["rotor_drag", 0] <= 1 / 15
    # A mass differs by what a file is off by: a tenth of its usual size, and less where flights say so.
    assert found["mass_offset", 0] <= 0.1
    assert scattered(differing(0.0))["linear_drag", 0] <= 1 / 15


def test_what_flights_differ_by_makes_their_mean_as_unsure():
    """Of forty flights, each told to a variance of 1 / 50 by itself."""
    found = learned(differing(), [], 1.0)
    drag, other, _ = np.sqrt(np.diag(found.covariance))
    told = np.array([found.scatter[0] ** 2 + 1 / ROWS, found.scatter[1] ** 2 + 1 / ROWS]) / BLOCKS
    assert (drag, other) == pytest.approx(np.sqrt(told), rel=0.1)
    assert found.rather[0] == pytest.approx(1.0, abs=3.0 * drag)
    assert found.rather[1:] == pytest.approx([0.0, 0.0], abs=0.08)
    assert found.owners == (("linear_drag", 0), ("rotor_drag", 0), ("mass_offset", 0))
    # Noise of four times the variance that the weights say, where flights do not differ.
    wide, narrow = (np.sqrt(learned(differing(0.0), [], w).covariance[1, 1]) for w in (4.0, 1.0))
    assert 1.5 < wide / narrow < 2.1


def with_columns(vehicle, *candidates, balance=frozenset()):
    columns = [SimpleNamespace(candidate=c, place=0, scale=places(c, vehicle)[0].scale, idle=False) for c in candidates]
    observation = SimpleNamespace(vehicle=vehicle, balance=balance)
    return SimpleNamespace(columns=columns, observation=observation)


def test_places_of_a_small_vehicle_differ_by_its_size_and_what_no_file_has_by_a_fifteenth():
    torque = Candidate(RotorTorque, tuple(p for p in RotorTorque.parameters if not p.index), (("rotor", 0),))
    asked = (torque, candidate("mass_offset"), candidate("linear_drag"))

    def usual(reach):
        """What the three differ by, and by how much a file is off of the torque."""
        rotors = tuple(
            r.model_copy(update={"position": tuple(reach * np.array(r.position) / np.linalg.norm(r.position))})
            for r in VEHICLE.rotors
        )
        vehicle = VEHICLE.model_copy(update={"rotors": rotors})
        size = places(torque, vehicle)[0].scale
        return _usual(with_columns(vehicle, *asked), range(3)), RotorTorque.declared_deviation(vehicle, size)

    for reach, share in ((0.3, 1.0), (0.1, 1.0), (0.03, 0.3)):
        found, of_file = usual(reach)
        assert found == pytest.approx([share * of_file, 0.1, 1 / 15]), reach


def test_air_batteries_and_the_offsets_of_sensors_differ_by_more_from_day_to_day():
    """The thrust of all rotors by 2 %, an accelerometer by 3 mg; before any flight they are as unsure as others."""
    asked = tuple(map(candidate, ("thrust_scale", "battery_sag", "accelerometer_bias", "gyro_bias")))
    now = with_columns(VEHICLE, *asked, balance=frozenset({"tz"}))
    assert _usual(now, range(4)) * [c.scale for c in now.columns] == pytest.approx([0.02, 0.0006, 0.03, 0.002])
    assert _before(now, range(2)) == pytest.approx([9.0 / 15, 9.0 / 15])


def test_before_a_flight_a_file_is_as_wrong_as_the_worst_and_effects_are_wide():
    asked = (candidate("mass_offset"), candidate("linear_drag"), candidate("thrust_scale"), candidate("steady_force"))
    free = _before(with_columns(VEHICLE, *asked), range(4))
    assert free == pytest.approx([0.9, SLAB, SLAB, SLAB])
    # A balance alone does not tell thrusts.
    held = _before(with_columns(VEHICLE, *asked, balance=frozenset({"tz"})), range(4))
    assert held == pytest.approx([0.9, SLAB, 9.0 / 15, SLAB])


def test_numbers_of_what_is_chosen_are_wide_and_those_of_the_file_are_not():
    now = two(("actuation_delay", "mass_offset", "linear_drag"), sizes=(0.0, 0.0, 0.0))
    whole = SimpleNamespace(linear=now, chosen=(0,), scales=Scales(3.0))
    assert _as_files_are(now, whole, [0, 1, 2]) == pytest.approx([SLAB, 0.3, SLAB], rel=2e-3)


def rotors_off(by, sign=(1, -1, 1, 1)):
    """Four rotors that are off by `by` usual sizes, and a mass that is off by a tenth of one."""
    names = [*(f"rotor_effectiveness {i}" for i in range(4)), "mass_offset"]
    return two(names, (), [*(by * np.array(sign)), 0.1])


def test_a_kind_of_several_numbers_is_further_off_than_the_rest_of_the_file():
    """Rotors differ by a fifteenth of their usual size where all is as usual."""
    assert scaled(rotors_off(1 / 15), (), 1.0).kinds == {}
    far = scaled(rotors_off(9 / 15), (), 1.0)
    assert set(far.kinds) == {"rotors"}
    assert far.kinds["rotors"] in (3.0, 9.0)
    assert far.common == 1.0
    # What is chosen is no number of the file: of the two rotors that are left no kind is told.
    assert scaled(rotors_off(9 / 15), (0, 1), 1.0).kinds == {}


def commanded(step, start=0.0, **meta):
    t = start + np.arange(0.0, 3.0, step)
    return Flight(pd.DataFrame({"t": t, **{f"cmd_rotor_{i}": 400.0 + t for i in range(4)}}), meta)


def test_commands_are_sparse_below_133_hz_unless_the_log_says_how_many_there_were():
    assert not any(ran_on(commanded(0.002, start), VEHICLE) for start in (0.0, 10.0, 1700.0))
    assert ran_on(commanded(0.0025), VEHICLE)
    assert not sparse(commanded(0.005), VEHICLE)
    assert sparse(commanded(0.01), VEHICLE)
    assert not sparse(commanded(0.01, **{COMMAND_STEPS: 2}), VEHICLE)
    assert not sparse(Flight(commanded(0.01).table[["t"]]), VEHICLE)


def test_commands_of_a_slower_controller_or_means_of_a_denser_log_did_not_run_on():
    def logged(hz):
        return commanded(0.005, channels={"rotor_command": {"rate_hz": hz}})

    assert ran_on(logged(200.0), VEHICLE)
    assert not ran_on(logged(400.0), VEHICLE)
    table = commanded(0.005).table
    for rows, seen in ((1, True), (2, False)):
        first = rows * (np.arange(len(table)) // rows)
        copied = table.assign(**{c: table[c].to_numpy()[first] for c in table.columns if c != "t"})
        assert ran_on(Flight(copied), VEHICLE) is seen


def test_places_of_rotors_and_of_what_was_followed_are_numbers_of_the_file_alone():
    t = np.arange(0.0, 3.0, 0.01)
    motion = {f"v{a}": t for a in "xyz"} | {f"q{a}": (1.0 if a == "w" else 0.0) + 0.0 * t for a in "wxyz"}
    blind = Flight(pd.DataFrame({"t": t, **motion, "wx": t, "wy": t, "wz": t}))
    felt = Flight(blind.table.assign(ax=t, ay=t, az=t))
    known = [candidate("com_offset"), *(candidate("rotor_effectiveness", rotor=i) for i in range(4))]

    def names(asked, *flights):
        return sorted({c.name for c in file_only(VEHICLE, asked, flights)})

    assert names(known, blind) == ["rotor_torque", "sensor_place"]
    assert names(known, felt) == names(known, blind, felt) == ["rotor_torque"]
    assert names([*known, candidate("rotor_drag")], felt) == ["rotor_height", "rotor_torque"]
    assert names([candidate("linear_drag")], felt) == []


def test_what_an_effect_that_is_chosen_takes_is_no_error_of_the_file():
    """A drag whose column is half of each rotor's: rotors that are as the file has them would explain it."""
    names = [*(f"rotor_effectiveness {i}" for i in range(4)), "linear_drag"]

    def rows(rng, _):
        x = np.zeros((ROWS, 6))
        x[:, 1:] = rng.standard_normal((ROWS, 5))
        x[:, 5] = 0.5 * x[:, 1:5].sum(axis=1) + 0.1 * x[:, 5]
        x[:, 0] = 1.5 * x[:, 5] + rng.standard_normal(ROWS)
        return x

    now = linear_fit(names, rows, [])[1].linear
    assert scaled(now, (), 1.0).kinds["rotors"] >= 3.0
    assert scaled(now, (4,), 1.0).kinds.get("rotors", 1.0) <= 1.0


def test_a_swinging_load_is_made_linear_at_the_length_that_was_found():
    load = candidate("suspended_load")
    own = variants(load, VEHICLE)[0]
    shape = shape_of(load, VEHICLE)
    at = places(load, VEHICLE)
    assert at[shape].parameter == "length"
    assert shape_of(candidate("linear_drag"), VEHICLE) is None
    made = _variant(load, at, own, 0.77, VEHICLE, shape)
    ((_, effect, size),) = made.points
    assert effect.length == pytest.approx(0.77)
    assert effect.mass == pytest.approx(size)
    assert size > 0.0
    assert made.start[shape] == 0.77


def test_every_number_that_healthy_flights_know_is_in_the_model_of_a_set_and_of_the_file_those_of_the_file():
    """A drag is no number of a file: beside one it is absent where no set has it. Healthy flights know its size."""
    _, whole = linear_fit(["linear_drag", "mass_offset"], lambda rng, k: rng.standard_normal((ROWS, 3)), [])
    beside_file = whole.linear
    healthy = SimpleNamespace(**{**vars(beside_file.observation), "healthy": SimpleNamespace(effects={})})
    beside_healthy = replace(beside_file, observation=healthy)
    theta = np.array([0.5, 0.5])
    labels = [[m.candidate.label for m in x.members((), theta, 0.0, True)] for x in (beside_file, beside_healthy)]
    assert labels == [["mass_offset"], ["linear_drag", "mass_offset"]]
