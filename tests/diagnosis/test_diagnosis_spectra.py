"""The transform that residual and columns go through, and the weights of its coefficients."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.linear.sensitivities import sensitivities
from infotraj.diagnosis.linear.sums import blocks, gathered
from infotraj.diagnosis.measure.lapped import lapped
from infotraj.diagnosis.measure.residual import Channel, flight_samples
from infotraj.diagnosis.noise.spectra import BANDS, EDGES, Spectrum, Weights, spectra, weights
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

FILE = Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml"
STEP = 0.005


class Samples:
    """Stands for a flight's samples: times alone."""

    def __init__(self, t):
        self.t = t

    def times(self, channel):
        return self.t


def channel(count, difference=False, run=None, step=STEP):
    run = np.zeros(count, dtype=int) if run is None else run
    rows = np.arange(count)
    return Channel("rate" if difference else "force", difference, rows, rows, rows[:, None], run, step)


def turned(values, difference=False, t=None, run=None):
    t = STEP * np.arange(len(values)) if t is None else t
    made = lapped(Samples(t), channel(len(values), difference, run))
    return made, made(np.repeat(values[:, None, None], 3, axis=1))[:, 0, 0]


def test_the_transform_keeps_the_power_of_white_noise_at_every_frequency():
    x = np.random.default_rng(0).standard_normal(40_000)
    made, c = turned(x)
    for low, high in ((0, 1), (1, 5), (5, 20)):
        part = c[(made.frequency >= low) & (made.frequency < high)]
        # Means over five samples.
        assert np.mean(part**2) == pytest.approx(1 / 5, rel=0.15)
    assert np.corrcoef(c[:-1], c[1:])[0, 1] == pytest.approx(0.0, abs=0.05)


def test_a_sine_stays_at_its_frequency_and_in_its_second():
    t = STEP * np.arange(4000)
    x = np.where((t > 8) & (t < 12), np.sin(2 * np.pi * 3.1 * t), 0.0)
    made, c = turned(x)
    inside = (np.abs(made.frequency - 3.1) < 1.5) & (made.time >= 7) & (made.time <= 13)
    assert np.sum(c[inside] ** 2) > 0.97 * np.sum(c**2)


def test_noise_of_positions_twice_differenced_stays_out_of_the_slow_coefficients():
    """A position to 1 mm at 200 Hz: noise of its velocity, from neighbours, and the velocity's differences."""
    rng = np.random.default_rng(1)
    velocity = np.diff(0.001 * rng.standard_normal(8001)) / STEP
    made, c = turned(np.diff(velocity), difference=True)
    slow, fast = c[made.frequency < 1], c[made.frequency > 15]
    assert np.sqrt(np.mean(slow**2)) < 0.1
    assert np.sqrt(np.mean(fast**2)) > 50 * np.sqrt(np.mean(slow**2))


def test_residual_and_columns_pass_gaps_alike():
    t = STEP * np.arange(4000)
    kept = (np.arange(4000) % 500) > 20
    x, s = np.sin(t), np.cos(0.7 * t)
    run = np.cumsum(np.concatenate([[False], np.diff(np.flatnonzero(kept)) > 1]))
    _, a = turned(x[kept], t=t[kept], run=run)
    _, b = turned(s[kept], t=t[kept], run=run)
    _, both = turned((x + 2 * s)[kept], t=t[kept], run=run)
    np.testing.assert_allclose(both, a + 2 * b, atol=1e-9)


def test_a_slope_is_that_of_the_differences():
    x = np.full(4000, 0.3 * STEP)
    _, steady = turned(np.full(4000, 0.3))
    _, c = turned(x, difference=True)
    assert np.sum(c**2) / len(c) == pytest.approx(np.sum(steady**2) / len(steady), rel=0.02)


def made_spectra(rng, noise, signal=1.0, count=4000):
    """One axis: a column that is measured, and noise that grows with the frequency."""
    frequency = np.tile((np.arange(40) + 0.5) / 2, count // 40)
    band = np.clip(np.searchsorted(EDGES, frequency, side="right") - 1, 0, len(EDGES) - 2)
    column = rng.standard_normal(count)
    left = rng.standard_normal(count) * noise(frequency)
    residual = signal * column + left
    time = np.repeat(np.arange(count // 40) + 1.0, 40)
    return Spectrum("fx", 0, np.stack([residual, column], axis=1), residual, band, time), frequency


def test_noise_is_what_the_richest_model_leaves_and_coherence_what_it_explains():
    found, frequency = made_spectra(np.random.default_rng(2), lambda f: 0.1 + (f > 10) * 0.7)
    w = weights([found])
    slow, fast = EDGES[:-1] < 9, EDGES[:-1] >= 10
    np.testing.assert_allclose(np.sqrt(w.noise[0, slow]), 0.1, rtol=0.2)
    np.testing.assert_allclose(np.sqrt(w.noise[0, fast]), 0.8, rtol=0.2)
    assert (w.coherence[0, slow] > 0.95).all()
    np.testing.assert_allclose(w.coherence[0, fast], 1.0 / (1.0 + 0.8**2), atol=0.1)
    of = w.of(0, found)
    assert of[frequency < 9].mean() > 80 * of[frequency > 10].mean()


def test_a_second_of_spikes_counts_little():
    found, _ = made_spectra(np.random.default_rng(3), lambda f: 0.1)
    spoiled = found.values.copy()
    bad = found.time == 20.0
    spoiled[bad, 0] += 30.0
    second = weights([Spectrum("fx", 0, spoiled, None, found.band, found.time)]).second[0]
    assert second[bad].max() < 0.1
    assert second[~bad].mean() > 0.9


def test_sums_are_products_of_what_was_weighed_and_shift_with_the_numbers():
    found, _ = made_spectra(np.random.default_rng(4), lambda f: 0.1)
    w = weights([found])
    cut = blocks([found])
    sums = gathered([found], w, cut)
    x = found.weighted(w.of(0, found))
    np.testing.assert_allclose(sums.gram.sum(axis=(0, 1)), x.T @ x, rtol=1e-9)
    moved = sums.shifted(np.array([0.7]))
    np.testing.assert_allclose(moved.error(np.array([0.3])), sums.error(np.array([1.0])), rtol=1e-6)
    assert len(np.unique(cut.fold)) == 5  # of one flight
    assert sums.windows.sum() == pytest.approx(100 / 0.05, rel=0.02)


def test_a_window_of_the_flights_is_all_that_blocks_know():
    vehicle = load_vehicle(FILE)
    table = fly(yaml.safe_load(FILE.read_text()), {}, seconds=12, seed=0, noise={"accelerometer": 0.05, "gyro": 0.01})
    o = observe(Model(vehicle), [Flight(table)], 6.0, None)
    found = spectra(o.samples, o.transforms, sensitivities(o, (), []).joint)
    assert min(s.time.min() for s in found) > 6.0
    counts = np.bincount(np.concatenate([o.blocks.of(s) for s in found]), minlength=len(o.blocks.flight))
    assert (counts > 0).all()
    assert len(flight_samples(Model(vehicle), Flight(table), 6.0, None).channels) == 4


def test_the_times_of_coefficients_are_those_of_the_samples():
    t = 50.0 + STEP * np.arange(6000)
    burst = (t > 59.0) & (t < 71.0)
    made, c = turned(np.where(burst, np.random.default_rng(0).standard_normal(len(t)), 0.0), t=t)
    assert np.average(made.time, weights=c**2) == pytest.approx(65.0, abs=0.4)


def test_a_straight_line_stays_straight_across_a_gap():
    t = STEP * np.arange(2000)
    t = t[(t < 4.0) | (t > 4.2)]
    made = lapped(Samples(t), channel(len(t)))
    binned = made.binned(np.repeat(3.0 * t[:, None, None], 3, axis=1))[:, 0, 0]
    assert len(binned) == 400
    np.testing.assert_allclose(np.diff(binned), 3.0 * 0.025, atol=0.015)


def test_what_a_second_counts_does_not_hang_on_the_unit():
    found, _ = made_spectra(np.random.default_rng(5), lambda f: 0.1)
    values = found.values.copy()
    values[found.time == 20.0, 0] += 0.3
    other = values * [10.0, 1.0]
    one, two = (weights([Spectrum("fx", 0, v, None, found.band, found.time)]).second[0] for v in (values, other))
    assert one[found.time == 20.0].max() < 0.7
    np.testing.assert_allclose(one, two, atol=0.05)


def test_what_many_columns_take_up_is_no_less_noise():
    ratio = []
    for seed in range(6):
        found, _ = made_spectra(np.random.default_rng(seed), lambda f: 0.1, count=800)
        more = np.random.default_rng([seed, 1]).standard_normal((800, 160))
        values = np.column_stack([found.values, more])
        w = weights([Spectrum("fx", 0, values, None, found.band, found.time)])
        full = np.bincount(found.band, minlength=w.noise.shape[1])
        ratio.append(np.sum(w.noise[0] * full) / np.sum(full) / 0.01)
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.08)


@pytest.mark.parametrize("start", [False, True])
def test_noise_of_the_inputs_does_not_make_noise_of_what_moves(start):
    """Slow motion that is predicted but for 1 % noise, and the same noise where nothing moves: a vehicle that does not
    answer explains that, and is not believed."""
    rng = np.random.default_rng(6)
    frequency = np.tile((np.arange(40) + 0.5) / 2, 100)
    band = np.clip(np.searchsorted(EDGES, frequency, side="right") - 1, 0, len(EDGES) - 2)
    moves = frequency < 1.5
    motion = np.where(moves, rng.standard_normal(len(frequency)), 0.0)
    measured = motion + 0.02 * rng.standard_normal(len(frequency))
    predicted = motion + 0.1 * rng.standard_normal(len(frequency))
    time = np.repeat(np.arange(100) + 1.0, 40)
    # A file whose inertia is a third too small: the residual is what the column has to take up.
    s = Spectrum("tx", 0, np.stack([measured - 1.5 * predicted, predicted], axis=1), measured, band, time, noisy=True)
    found = weights([s], start=weights([s]) if start else None)
    assert (found.coherence[0, :3] > 0.97).all()
    np.testing.assert_allclose(np.sqrt(found.noise[0, :3]), 0.1, rtol=0.25)
    assert (found.coherence[0, 3:] < 0.1).all()


@pytest.mark.parametrize("noisy", [False, True])
def test_a_torque_that_is_commanded_and_turns_nothing_is_to_be_explained(noisy):
    """Nothing turns but for noise: the model as given is wrong by all that is commanded, which a column explains. Of
    inputs that are measured that may be their noise."""
    rng = np.random.default_rng(8)
    frequency = np.tile((np.arange(40) + 0.5) / 2, 100)
    band = np.clip(np.searchsorted(EDGES, frequency, side="right") - 1, 0, len(EDGES) - 2)
    commanded = np.where(frequency < 1.5, rng.standard_normal(len(frequency)), 0.0)
    measured = 0.05 * rng.standard_normal(len(frequency))
    time = np.repeat(np.arange(100) + 1.0, 40)
    s = Spectrum("tx", 0, np.stack([measured - commanded, commanded], axis=1), measured, band, time, noisy=noisy)
    first = weights([s])
    assert (first.coherence[0, :3] > 0.95).all() if not noisy else (first.coherence[0, :3] < 0.1).all()
    # Beside the column nothing of it is left: what was to be explained is as it was.
    explained = Spectrum("tx", 0, np.stack([measured, commanded], axis=1), measured, band, time, noisy=noisy)
    np.testing.assert_allclose(weights([explained], start=first).coherence[0, :3], first.coherence[0, :3], atol=0.05)


def test_parts_of_one_flight_that_are_held_out_are_each_in_one_piece():
    found, _ = made_spectra(np.random.default_rng(6), lambda f: 0.1)
    cut = blocks([found])
    assert len(np.unique(cut.fold)) == 5
    assert (np.diff(cut.fold) >= 0).all()


def test_an_axis_that_is_left_out_later_has_no_weight_and_the_others_have_theirs():
    noise, coherence = np.full((2, BANDS), 2.0), np.full((2, BANDS), 0.7)
    made = Weights(("fx", "tz"), noise, coherence, (), noise).without({"tz"})
    assert np.array_equal(made.coherence, np.stack([coherence[0], np.zeros(BANDS)]))
    assert np.array_equal(made.noise, noise)
