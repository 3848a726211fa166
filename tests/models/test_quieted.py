"""What the IMU says without what is faster than the motion that poses show as well: what stays, what goes, where."""

import numpy as np
import pytest

from infotraj.models.quieted import fastest, quieted
from infotraj.models.recorded import Samples

STEP = 0.005
T = STEP * np.arange(6000)


def motion(t, *frequencies):
    """Of three axes, with as much power at each frequency."""
    phase = np.arange(3.0)
    return sum(np.sin(2 * np.pi * f * t[:, None] + phase + f) for f in frequencies)


def noise(size, seed=0):
    return size * np.random.default_rng(seed).standard_normal((len(T), 3))


def slow(seed, top):
    """Random motion (n, 3) up to a frequency (Hz), 1 in size."""
    z = np.fft.rfft(noise(1.0, seed), axis=0)
    z[np.fft.rfftfreq(len(T), STEP) > top] = 0.0
    x = np.fft.irfft(z, n=len(T), axis=0)
    return x / x.std()


def test_what_moves_ends_where_the_motion_does():
    moved = slow(1, 4.0)
    cut = fastest(T, moved + noise(0.05, 2), moved + noise(0.2, 3))
    assert 3.5 < cut < 5.6


def test_vibration_of_the_imu_alone_is_no_motion_however_slow_it_looks():
    moved = slow(1, 3.0)
    shaken = 0.3 * slow(7, 30.0)
    assert 1.5 < fastest(T, moved + noise(0.02, 2), moved + shaken) < 4.0


def test_poses_that_are_noisy_do_not_say_that_the_imu_is():
    """Noise of the poses alone, much larger than what moves there, and an IMU that shows the motion as it is."""
    moved = slow(1, 4.0) + 0.03 * slow(2, 60.0)
    assert fastest(T, moved + noise(1.0, 3), moved) == np.inf
    assert fastest(T, moved, moved) == np.inf


def test_one_axis_that_moves_fast_is_enough():
    fast, calm = slow(1, 8.0), slow(2, 2.0)
    moved = np.stack([calm[:, 0], fast[:, 1], calm[:, 2]], axis=1)
    assert 4.5 < fastest(T, moved + noise(0.05, 3), moved + noise(0.2, 4)) < 9.0


def test_rows_that_are_too_few_say_nothing():
    assert fastest(T[:60], slow(1, 4.0)[:60], noise(1.0)[:60]) == np.inf
    gone = slow(1, 4.0)
    gone[5::20] = np.nan
    assert fastest(T, gone, gone) == np.inf


def test_motion_stays_and_is_not_late_and_noise_goes():
    given = motion(T, 0.5, 1.0)
    found = quieted(Samples(T, given + noise(0.05)), 4.0)
    inside = slice(400, -400)
    assert np.abs(found.values[inside] - given[inside]).std() < 0.02
    # What is left of it is slow: its differences, of which the column of a clock is made, are next to nothing.
    left = np.diff(found.values[inside] - given[inside], axis=0).std()
    assert left < 0.05 * np.diff(noise(0.05), axis=0).std()
    assert np.array_equal(found.times, T)


def test_samples_of_which_all_is_motion_stay_as_they_are():
    given = Samples(T, motion(T, 1.0))
    assert quieted(given, np.inf) is given
    assert quieted(given, 90.0) is given


def test_stretches_between_gaps_are_filtered_apart():
    t = T.copy()
    t[3000:] += 3.0
    values = motion(T, 0.5) + noise(0.02)
    values[3000:] += 50.0
    found = quieted(Samples(t, values), 4.0).values
    assert np.abs(found[2900:3000] - motion(T, 0.5)[2900:3000]).max() < 0.1
    assert np.abs(found[3000:3100] - 50.0 - motion(T, 0.5)[3000:3100]).max() < 0.1


@pytest.mark.parametrize("few", [10, 63])
def test_a_short_stretch_stays_as_it_is(few):
    t = T.copy()
    t[few:] += 3.0
    values = noise(0.1)
    assert np.array_equal(quieted(Samples(t, values), 4.0).values[:few], values[:few])
