"""An accelerometer that is shaken: a diagnosis tells forces from the velocity, and a comparison says so."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj.cli import cli
from infotraj.comparing.equation_error import equation_error
from infotraj.comparing.shaken import shaken, told_by_velocity
from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates.accelerometer import unshaken
from infotraj.diagnosis.measure.residual import flight_samples
from infotraj.diagnosis.report.summary import as_dict, as_text
from infotraj.effects.channels import from_velocity, missing_channel
from infotraj.effects.laws import ImuLaw
from infotraj.errors import InputError
from infotraj.flight import RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml"
MODEL = Model(load_vehicle(FILE))
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
DRAG = {"linear_drag": {"d": [0.1, 0.1, 0.05]}}


def flown(seed=0, hidden=None, **noise):
    table = fly(yaml.safe_load(FILE.read_text()), hidden or {}, seconds=8.0, seed=seed, noise={**NOISE, **noise})
    return Flight(table, {"source": f"{seed}.parquet"})


def changed(flight, columns, values):
    return Flight(flight.table.assign(**dict(zip(columns, values.T, strict=True))), flight.meta)


@pytest.fixture(scope="module")
def vibrating():
    return [flown(seed, DRAG, accelerometer=6.0) for seed in (0, 1)]


@pytest.fixture(scope="module")
def clean():
    return flown(2, DRAG)


def test_an_error_that_only_the_accelerometer_shows_and_that_is_faster_still_is_vibration(vibrating, clean):
    """White noise of 6 m/s^2 at 200 Hz, over 41 rows with parabolic weights, on 0.8 kg; aliases of a tone as well."""
    for flight in vibrating:
        own, left = shaken(MODEL, flight)
        np.testing.assert_allclose(own, 0.8 * 6.0 * np.sqrt(1.2 / 41), rtol=0.35)
        moved = equation_error(MODEL, flight, window=0.2, force_from="velocity").residual[:, :3]
        np.testing.assert_allclose(left, np.nanstd(moved, axis=0))
    assert shaken(MODEL, clean) is None
    assert shaken(MODEL, vibrating[0], stop=0.8) is None  # too little of it to say so
    # Rotors of 170 to 230 Hz, sampled at 200 Hz: it lies below 5 Hz for a sixth of the time.
    phase = 2.0 * np.pi * np.cumsum(200.0 + 30.0 * np.sin(2.0 * np.pi * 0.4 * clean.t)) * 0.005
    tone = 8.0 * np.sin(phase[:, None] + [0.0, 1.0, 2.0])
    assert shaken(MODEL, changed(clean, SPECIFIC_FORCE, clean.get(*SPECIFIC_FORCE) + tone)) is not None


def test_a_lever_a_bias_a_scale_a_lag_and_gusts_are_no_vibration(clean):
    """Each makes the error beside the accelerometer more than twice the one beside the velocity, and none is noise."""
    felt, rate, t = clean.get(*SPECIFIC_FORCE), clean.get(*RATE), clean.t
    lever = np.array([0.1, 0.0, 0.05])
    smooth = np.apply_along_axis(np.convolve, 0, rate, np.hanning(15) / np.hanning(15).sum(), mode="same")
    turning = np.gradient(smooth, t, axis=0)
    gust = 3.0 * np.sin(2.0 * np.pi * np.array([1.1, 1.7, 2.3]) * t[:, None])
    late = clean.table[list(SPECIFIC_FORCE)].shift(12).bfill().to_numpy()
    beside = {
        "lever": felt + np.cross(turning, lever) + np.cross(smooth, np.cross(smooth, lever)),
        "bias and scale": 1.2 * felt + [1.0, -1.0, 0.5],
        "lag": late,
        "gusts": felt + gust,
    }
    left = np.nanstd(equation_error(MODEL, clean, window=0.2, force_from="velocity").residual[:, :3], axis=0)
    for why, values in beside.items():
        flight = changed(clean, SPECIFIC_FORCE, values)
        own = np.nanstd(equation_error(MODEL, flight, window=0.2, force_from="accelerometer").residual[:, :3], axis=0)
        assert np.max(own / left) > 2.0, why
        assert shaken(MODEL, flight) is None, why


def test_a_fast_tone_that_the_means_do_not_show_is_no_reason(clean):
    """At 40 Hz, eight periods a mean: neighbours differ by it, and forces below 5 Hz do not."""
    tone = 3.0 * np.sin(2.0 * np.pi * 40.0 * clean.t)[:, None] * np.ones(3)
    assert shaken(MODEL, changed(clean, SPECIFIC_FORCE, clean.get(*SPECIFIC_FORCE) + tone)) is None


def test_without_a_velocity_of_its_own_that_is_fast_enough_a_flight_keeps_its_accelerometer(vibrating):
    one = vibrating[0]
    lacks = Flight(one.table.drop(columns=list(VELOCITY)), one.meta)
    derived = Flight(one.table, {"derived": list(VELOCITY)})
    slow = one.table.copy()
    slow.loc[slow.index % 20 > 0, list(VELOCITY)] = np.nan
    for flight in (lacks, derived, Flight(slow, one.meta)):
        assert unshaken(MODEL, [flight]) == ([flight], ())


def test_each_flight_is_told_from_its_own_quiet_side_and_all_alike_where_most_are_shaken_or_one_is_a_reference(
    vibrating, clean
):
    flights, (note,) = unshaken(MODEL, [clean, vibrating[0]])
    assert [from_velocity(f) for f in flights] == [False, True]
    assert note.reason.startswith("forces of 0.parquet are told from the velocity: vibration of the accelerometer")
    assert not note.refuses
    assert not note.axes
    read = [[c.name for c in flight_samples(MODEL, f).channels] for f in flights]
    assert read == [["force", "rate", "turn", "push"], ["velocity", "rate", "turn"]]
    flights, _ = unshaken(MODEL, [clean, vibrating[0]], together=True)
    assert [from_velocity(f) for f in flights] == [True, True]
    without = Flight(clean.table.drop(columns=list(VELOCITY)), clean.meta)
    flights, (note,) = unshaken(MODEL, [*vibrating, clean, without])
    assert [from_velocity(f) for f in flights] == [True, True, False, False]
    flights, (note,) = unshaken(MODEL, [*vibrating, clean])
    assert [from_velocity(f) for f in flights] == [True, True, True]
    assert note.reason.startswith("forces are told from the velocity: ")
    assert unshaken(MODEL, [clean], together=True) == ([clean], ())


def test_who_accepts_it_keeps_the_accelerometer(vibrating):
    accepting = [Flight(f.table, {**f.meta, "accept": ["accelerometer_shaken"]}) for f in vibrating]
    flights, (note,) = unshaken(MODEL, accepting)
    assert note.accepted
    assert not any(from_velocity(f) for f in flights)
    flights, notes = unshaken(MODEL, [accepting[0], vibrating[1]])
    assert [n.accepted for n in notes] == [False, True]
    assert [from_velocity(f) for f in flights] == [False, True]


def test_a_marked_flight_is_compared_by_its_velocity_unless_the_accelerometer_is_asked_for(vibrating):
    flight = told_by_velocity(vibrating[0])
    assert equation_error(MODEL, flight).force_from == "velocity"
    assert equation_error(MODEL, flight, force_from="accelerometer").force_from == "accelerometer"
    assert equation_error(MODEL, vibrating[0]).force_from == "accelerometer"
    assert missing_channel("accelerometer", MODEL.vehicle, vibrating[0]) is None
    assert "accelerometer_shaken" in str(missing_channel("accelerometer", MODEL.vehicle, flight))


def test_a_load_swings_by_the_path_and_not_by_a_shaken_accelerometer(vibrating):
    t = np.linspace(2.0, 6.0, 200)
    marked = told_by_velocity(vibrating[0])
    lacks = Flight(marked.table.drop(columns=list(SPECIFIC_FORCE)), marked.meta)
    by_flight = [MODEL.prepare(f).origin_path(ImuLaw.ideal()).at(t) for f in (vibrating[0], marked, lacks)]
    assert np.array_equal(by_flight[1], by_flight[2])
    assert np.std(by_flight[0] - by_flight[1]) > 3.0


def run(*words):
    return CliRunner().invoke(cli, [str(w) for w in words]).output


def test_a_comparison_says_so_and_leads_to_the_velocity(vibrating, tmp_path):
    path = tmp_path / "a.parquet"
    vibrating[0].write(path)
    said = run("compare", FILE, path)
    assert ": --force-from velocity compares with that\n" in said
    assert said.splitlines()[-1].endswith(f"{path} --force-from velocity")
    assert "vibration" not in run("compare", FILE, path, "--force-from", "velocity")
    accepted = run("compare", FILE, path, "--accept", "accelerometer_shaken")
    assert "vibration" not in accepted
    assert "no such finding here" not in accepted


@pytest.mark.long
def test_a_drag_that_vibration_hides_is_named_from_the_velocity(vibrating, tmp_path):
    found = diagnose(MODEL, vibrating)
    assert found.supported == ("linear_drag",)
    values = found.finding("linear_drag").parameters["d"]
    np.testing.assert_allclose(values[:2], 0.1, rtol=0.1)
    assert "\nwarning: forces are told from the velocity: vibration of the accelerometer" in as_text(found)
    assert [w[:22] for w in as_dict(found)["warnings"]] == ["forces are told from t"]
    made = add(MODEL, ["linear_drag"], vibrating)
    np.testing.assert_allclose(made.model.effects[0].values["d"][:2], 0.1, rtol=0.1)
    assert "warning: forces are told from the velocity" in made.as_text()
    assert made.as_dict()["warnings"] == list(made.notes) != []
    with pytest.raises(InputError, match="vibration and little else"):
        add(MODEL, ["accelerometer_bias"], vibrating)


@pytest.mark.long
def test_what_is_added_to_is_compared_as_it_was_fitted(vibrating, tmp_path):
    path, new = tmp_path / "a.parquet", tmp_path / "new.yaml"
    vibrating[0].write(path)
    said = run("add", FILE, "linear_drag", "--fit", path, "-o", new)
    assert f"{path} --against {FILE} --force-from velocity\n" in said
    assert "; forces from the velocity" in new.read_text()
    other = tmp_path / "other.yaml"
    said = run("add", FILE, "linear_drag", "--fit", path, "-o", other, "--accept", "accelerometer_shaken")
    assert "--force-from" not in said
    assert "forces are told from the accelerometer: vibration of the accelerometer alone is" in said
    assert "no such finding here" not in said
    assert "code: accelerometer_shaken" in other.read_text()
