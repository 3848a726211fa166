"""Equation error: one filter on both sides, a floor that is the floor, JSON, thresholds, rejected flights."""

import json
from dataclasses import replace
from pathlib import Path

import fast_flyer
import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from infotraj import rotations
from infotraj.comparing import compare, difference, equation_error, statistics
from infotraj.comparing.command import compare_command
from infotraj.comparing.equation_error import _by_slope
from infotraj.comparing.floor import white_noise
from infotraj.comparing.summary import as_text
from infotraj.comparing.unscored import unscored
from infotraj.comparing.window import Window
from infotraj.effects.registry import catalogue
from infotraj.errors import InputError, UsageError
from infotraj.flight import Flight
from infotraj.locating.command import locate_command
from infotraj.models import Model, load_model, save_model
from infotraj.vehicle import load_vehicle, parse_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
QUADROTOR, OMAV = VEHICLES / "quadrotor.yaml", VEHICLES / "omav.yaml"
SECONDS = 8.0


@pytest.fixture(scope="module")
def quiet():
    return Flight(fast_flyer.fly(QUADROTOR, SECONDS, 1, noise=0.0))


@pytest.fixture(scope="module")
def noisy():
    return Flight(fast_flyer.fly(QUADROTOR, SECONDS, 1))


@pytest.fixture(scope="module")
def dragged():
    return Flight(fast_flyer.fly(QUADROTOR, SECONDS, 2, {"linear_drag": 0.1}))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_slope_of_an_integral_is_a_mean_of_its_derivative_at_any_sampling(seed):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5, 1.5, 80) * 0.01)
    window = Window.over(t, 0.1)
    line = np.column_stack([3.0 * t + 1.0, np.full(80, 2.0)])
    inside = window.whole
    assert np.allclose(window.slope(line)[inside], [3.0, 0.0], atol=1e-9)
    assert np.allclose(window.mean(np.ones((80, 1)))[inside], 1.0)
    assert inside.sum() == 80 - 2 * window.half


def test_gains_are_those_of_white_noise():
    rng = np.random.default_rng(0)
    t = np.arange(200_000) * 0.005
    noise = rng.standard_normal((len(t), 1))
    window = Window.over(t, 0.15)
    for filtered, gain in ((window.slope(noise), window.slope_gain()), (window.mean(noise), window.mean_gain())):
        assert np.nanstd(filtered) == pytest.approx(np.nanmean(gain), rel=0.03)


def test_weights_of_a_mean_vanish_one_step_outside_its_window():
    """Of three samples the outer ones lie half way to where the parabola is zero: 3/4, 1, 3/4 of 2 1/2."""
    window = Window.over(np.arange(5) * 0.01, 0.02)
    assert window.half == 1
    assert window.mean(np.eye(5))[2] == pytest.approx([0.0, 0.3, 0.4, 0.3, 0.0])
    assert window.mean_gain()[2] == pytest.approx(np.sqrt(0.34))
    assert window.slope_gain()[2] == pytest.approx(np.sqrt(0.5) / 0.01)


def test_no_slope_reaches_over_a_step_without_a_prediction():
    t = np.arange(300) * 0.01
    mean = np.column_stack([np.cos(t), 5.0 + t, np.ones(300)])
    x = np.concatenate([np.zeros((1, 3)), np.cumsum(0.01 * mean[:-1], axis=0)])
    mean[150] = np.nan
    side = _by_slope(t, x, mean, np.ones(300, dtype=bool), 0.1)
    told = np.isfinite(side.measured).all(axis=1)
    assert not told[146:156].any()
    assert told[10:140].all()
    assert told[165:290].all()
    assert side.predicted[told] == pytest.approx(side.measured[told])


def test_no_window_reaches_over_a_gap():
    t = np.concatenate([np.arange(50), 100 + np.arange(50)]) * 0.01
    whole = Window.over(t, 0.1).whole
    assert not whole[45:55].any()
    assert whole[10:40].all()


def test_noise_is_told_from_motion_and_spikes():
    rng = np.random.default_rng(1)
    t = np.arange(4000) * 0.005
    smooth = 5.0 * np.sin(2 * np.pi * 0.7 * t)[:, None]
    assert white_noise(t, smooth)[0] < 1e-3
    found = smooth + 0.1 * rng.standard_normal((4000, 1))
    assert white_noise(t, found)[0] == pytest.approx(0.1, rel=0.06)
    found[rng.integers(0, 4000, 15)] += 50.0
    assert white_noise(t, found)[0] == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize("path", [QUADROTOR, OMAV])
def test_without_noise_and_hidden_effects_nothing_is_left(path):
    error = equation_error(load_model(path), Flight(fast_flyer.fly(path, 4.0, 3, noise=0.0)))
    assert np.nanmax(np.abs(error.residual[:, :3])) < 1e-9
    assert np.nanmax(np.abs(error.residual[:, 3:])) < 1e-4 * np.nanmax(np.abs(error.measured[:, 3:]))


def test_the_error_of_the_right_model_is_the_floor(noisy):
    s = statistics([equation_error(load_model(QUADROTOR), noisy)])
    assert np.all(np.abs(s.rmse / s.floor - 1.0) < 0.2)
    assert s.explained[2] > 0.99


def test_velocity_serves_where_there_is_no_accelerometer(noisy, quiet):
    model = load_model(QUADROTOR)
    without = Flight(noisy.table.drop(columns=["ax", "ay", "az"]))
    error = equation_error(model, without)
    assert error.force_from == "velocity"
    s = statistics([error])
    assert np.all(np.abs(s.rmse / s.floor - 1.0) < 0.25)
    # the attitude turns within a row, so this side is exact to the square of the step only
    still = equation_error(model, quiet, force_from="velocity")
    assert np.nanmax(np.abs(still.residual[:, :3])) < 1e-3
    # Both tell the force that an accelerometer feels, gravity's counterpart in it.
    felt = equation_error(model, quiet).measured[:, :3]
    both = np.isfinite(felt + still.measured[:, :3]).all(axis=1)
    assert both.sum() > 1000
    assert (
        np.sqrt(np.mean(np.square(still.measured[both, :3] - felt[both]), axis=0)).max() < 0.02 * felt[both, 2].mean()
    )


def test_the_floor_of_a_velocity_is_turned_into_the_body_as_its_noise_is():
    """Noise along the world's x alone is, on a body that leans and looks aside, what R^T makes of that axis."""
    rng, n = np.random.default_rng(5), 4000
    q = rotations.from_euler(0.5, 0.7, 1.1)
    columns = {"t": 0.005 * np.arange(n), "airborne": np.ones(n), "pz": np.full(n, 2.0)}
    columns |= {c: np.full(n, x) for c, x in zip(("qw", "qx", "qy", "qz"), q, strict=True)}
    columns |= {c: s * rng.standard_normal(n) for c, s in (("vx", 0.1), ("vy", 1e-5), ("vz", 1e-5))}
    columns |= {f"cmd_rotor_{i}": np.full(n, 400.0) for i in range(4)}
    columns |= {"px": np.zeros(n), "py": np.zeros(n), **{w: np.zeros(n) for w in ("wx", "wy", "wz")}}
    floor = equation_error(load_model(QUADROTOR), Flight(pd.DataFrame(columns)), force_from="velocity").floor[:3]
    np.testing.assert_allclose(floor / np.linalg.norm(floor), np.abs(rotations.matrix(q)[0]), rtol=1e-3)


def test_a_missing_effect_shows_and_the_right_one_takes_it_away(dragged):
    wrong, right = (
        load_model(QUADROTOR),
        Model(load_vehicle(QUADROTOR), [catalogue()["linear_drag"](d=0.1 * np.ones(3))]),
    )
    before, after = (equation_error(m, dragged) for m in (wrong, right))
    s0, s1 = statistics([before]), statistics([after])
    assert np.all(s0.rmse[:2] > 3 * s0.floor[:2])
    assert np.all(s1.rmse[:2] < 1.2 * s1.floor[:2])
    apart = difference([after], [before])
    assert np.all(apart.mean[:2] < -0.8)
    assert np.all(apart.mean[:2] + 2 * apart.standard_error[:2] < 0)
    assert apart.few


def test_rows_before_half_a_second_and_off_the_ground_do_not_count(noisy):
    table = noisy.table.assign(airborne=(noisy.t < 5.0).astype(int))
    error = equation_error(load_model(QUADROTOR), Flight(table), start=1.0)
    scored = error.t[error.scored.any(axis=1)]
    assert scored.min() >= 1.0
    assert scored.max() < 5.0
    assert error.left_out["not in the air"] == (noisy.t >= 5.0).sum()


def test_channels_on_their_own_rows_give_the_same_answer(quiet):
    table = quiet.table.copy()
    table.loc[table.index % 2 == 1, ["wx", "wy", "wz"]] = np.nan
    error = equation_error(load_model(QUADROTOR), Flight(table))
    assert np.isfinite(error.residual[::2, 3]).sum() > 500
    assert np.nanmax(np.abs(error.residual[:, 3:])) < 1e-2 * np.nanmax(np.abs(error.measured[:, 3:]))


def test_what_a_vehicle_file_leaves_out_is_said(noisy):
    content = load_vehicle(QUADROTOR).model_dump(exclude_none=True)
    content.pop("inertia")
    error = equation_error(Model(parse_vehicle(content)), noisy)
    assert set(error.reasons) == {"tx", "ty", "tz"}
    assert not error.scored[:, 3:].any()
    assert error.scored[:, 2].any()


def scaled(factor):
    """The quadrotor with mass, inertia and thrusts times a factor: it moves as before."""
    content = load_vehicle(QUADROTOR).model_dump(exclude_none=True)
    content["mass"] *= factor
    content["inertia"] = {k: factor * v for k, v in content["inertia"].items()}
    for rotor in content["rotors"]:
        rotor["thrust_coefficient"] *= factor
    return Model(parse_vehicle(content))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_models_that_predict_the_same_motion_do_not_differ_whatever_their_mass(noisy, factor):
    found = compare({"file": load_model(QUADROTOR), "scaled": scaled(factor)}, [noisy])
    (apart,) = found.differences()
    assert apart.mean == pytest.approx(np.zeros(6), abs=1e-9)
    first, other = (m.overall for m in found.models)
    assert other.rmse == pytest.approx(first.rmse)
    assert other.floor == pytest.approx(first.floor)


@pytest.mark.parametrize(("key", "axes"), [("mass", "fx, fy, fz"), ("inertia", "tx, ty, tz")])
def test_a_model_whose_file_says_less_is_compared_on_the_axes_that_both_can_answer(noisy, key, axes):
    content = load_vehicle(QUADROTOR).model_dump(exclude_none=True)
    content.pop(key)
    less, whole = Model(parse_vehicle(content)), load_model(QUADROTOR)
    for models in ({"whole": whole, "less": less}, {"less": less, "whole": whole}):
        found = compare(models, [noisy])
        (apart,) = found.differences()
        answered = [axis not in axes for axis in ("fx", "fy", "fz", "tx", "ty", "tz")]
        assert list(np.isfinite(apart.mean)) == answered
        of = "" if next(iter(models)) == "less" else "with less "
        assert f"{of}nothing can be said about {axes}: the vehicle file gives no {key}" in as_text(found)


def test_where_no_axis_can_be_compared_that_is_said_and_no_block_counted(noisy):
    content = load_vehicle(QUADROTOR).model_dump(exclude_none=True)
    less = Model(parse_vehicle({k: v for k, v in content.items() if k not in ("mass", "inertia")}))
    said = as_text(compare({"whole": load_model(QUADROTOR), "less": less}, [noisy]))
    assert "less: fx -  fy -  fz -  tx -  ty -  tz -  (both predict no row)\n" in said
    assert "with less nothing can be said about fx, fy, fz: the vehicle file gives no mass" in said


def invoke(*arguments):
    return CliRunner().invoke(compare_command, [str(a) for a in arguments], standalone_mode=False)


@pytest.mark.parametrize("command", [compare_command, locate_command])
def test_a_window_that_is_longer_than_the_flight_is_no_fault_of_the_flight(tmp_path, noisy, command):
    noisy.write(tmp_path / "a.parquet")
    arguments = [str(QUADROTOR), str(tmp_path / "a.parquet"), "--window", "20"]
    said = str(CliRunner().invoke(command, arguments, standalone_mode=False).exception)
    assert said.endswith("longer than the window of 20 s. Give a smaller --window, or more of the flight.")


@pytest.mark.parametrize("lacks", [("mass",), ("inertia",), ("mass", "inertia")])
def test_what_the_vehicle_file_lacks_is_no_fault_of_the_flight(lacks):
    reasons = [f"force: the vehicle file gives no {x}" for x in lacks]
    said = str(unscored("a.csv: nothing", reasons, {"first half second": 50, "not in the air": 0}, 800))
    assert said.endswith(f"expected a vehicle file with {' and '.join(lacks)}. Add what it lacks to the file.")
    assert said.startswith("a.csv: nothing (50 first half second; force: ")
    said = str(unscored("a.csv: nothing", [], {"not in the air": 800}, 800, 0.15))
    assert said.endswith("expected a flight in the air with commands and measured motion. Leave it out.")


def test_json_holds_what_others_rely_on(tmp_path, noisy, dragged):
    paths = [tmp_path / "a.parquet", tmp_path / "b.parquet"]
    noisy.write(paths[0])
    dragged.write(paths[1])
    right = tmp_path / "right.yaml"
    save_model(Model(load_vehicle(QUADROTOR), [catalogue()["linear_drag"](d=0.1 * np.ones(3))]), right)
    out = tmp_path / "out.json"
    done = invoke(QUADROTOR, *paths, "--against", right, "--horizons", "1,10,0.5s", "--json", out, "-q")
    assert done.exception is None, done.exception
    content = json.loads(out.read_text())
    axes = {"fx", "fy", "fz", "tx", "ty", "tz"}
    assert content["unit"] == {"force": "N", "torque": "N m"}
    assert set(content["rmse"]) == set(content["floor"]) == axes
    assert [f["path"] for f in content["flights"]] == [str(p) for p in paths]
    assert all(set(f["rmse"]) == axes and f["rows"] > 0 for f in content["flights"])
    rollouts = content["rollouts"]
    assert set(rollouts) == {"position", "velocity", "attitude", "rate"}
    assert all(set(v) == {"1", "10", "0.5s"} for v in rollouts.values())
    assert rollouts["position"]["0.5s"] > rollouts["position"]["1"]
    squares = [f["rmse"]["fx"] ** 2 * f["rows"] for f in content["flights"]]
    rows = sum(f["rows"] for f in content["flights"])
    assert content["rmse"]["fx"] == pytest.approx(np.sqrt(sum(squares) / rows))
    assert [m["model"] for m in content["models"]] == [str(QUADROTOR), str(right)]


def test_thresholds_end_with_status_4(tmp_path, dragged, capsys):
    path = tmp_path / "a.parquet"
    dragged.write(path)
    assert invoke(QUADROTOR, path, "--fail-above", "force=5,torque=1").exception is None
    done = invoke(QUADROTOR, path, "--fail-above", "force=0.02")
    assert isinstance(done.exception, SystemExit)
    assert done.exception.code == 4
    with pytest.raises(UsageError):
        raise invoke(QUADROTOR, path, "--fail-above", "power=1").exception


def test_what_comes_next_is_locate_only_where_something_is_left(tmp_path, noisy, dragged):
    noisy.write(tmp_path / "fits.parquet")
    dragged.write(tmp_path / "drag.parquet")
    fits, drag = (invoke(QUADROTOR, tmp_path / f"{name}.parquet").stderr for name in ("fits", "drag"))
    assert "every axis is within 1.5 times its floor: nothing is left to name on these flights" in fits
    assert f"next: infotraj design {QUADROTOR} --flown {tmp_path / 'fits.parquet'} -o ref.csv\n" in fits
    assert "infotraj locate" not in fits
    assert f"next: infotraj locate {QUADROTOR} {tmp_path / 'drag.parquet'}\n" in drag
    assert "nothing is left" not in drag


def test_what_is_missing_or_swapped_is_one_line(tmp_path, noisy):
    flight, table = tmp_path / "a.parquet", tmp_path / "a.csv"
    noisy.write(flight)
    noisy.write(table)
    expected = {
        (
            flight,
            QUADROTOR,
        ): f"{flight} is no YAML file; expected a model or vehicle file. Is it a flight or a log? MODEL",
        (table, QUADROTOR): f"{table} is no YAML file; expected a vehicle file. Is it a flight or a log? MODEL comes",
        (
            QUADROTOR,
            QUADROTOR,
        ): f"{QUADROTOR}: ends in '.yaml'; expected a flight table (.csv or .parquet). Is it a mod",
        (tmp_path / "none.yaml", flight): f"{tmp_path / 'none.yaml'}: there is no such file; expected a model or veh",
        (QUADROTOR, tmp_path / "no.csv"): f"{tmp_path / 'no.csv'}: there is no such file; expected a flight table",
    }
    for arguments, line in expected.items():
        done = invoke(*arguments)
        assert isinstance(done.exception, InputError)
        assert str(done.exception).startswith(line)
        assert "\n" not in str(done.exception)
        assert not done.output


def test_a_model_of_which_nothing_can_be_said_is_held_against_one_of_which_all_can(tmp_path, noisy):
    flight, out, bare = tmp_path / "a.parquet", tmp_path / "a.json", tmp_path / "bare.yaml"
    noisy.write(flight)
    content = yaml.safe_load(QUADROTOR.read_text())
    bare.write_text(yaml.safe_dump({k: v for k, v in content.items() if k not in ("mass", "inertia")}))
    drawn = ("--figures", tmp_path / "figures", "--recording", tmp_path / "a.rrd")
    done = invoke(bare, flight, "--against", QUADROTOR, "--json", out, *drawn)
    assert done.exception is None, done.exception
    assert "both predict no row" in done.output
    assert "nothing is drawn or recorded: no axis can be said" in done.output
    against = json.loads(out.read_text())["models"][1]["against_first"]
    assert against["blocks"] == 0
    assert set(against["relative_change"].values()) == {None}


def test_rejected_flights_are_all_named(tmp_path, noisy):
    good, bad, worse = tmp_path / "a.parquet", tmp_path / "b.csv", tmp_path / "c.parquet"
    noisy.write(good)
    bad.write_text("t,wx\n0,1\n1,2\n")
    worse.write_text("no table")
    out = tmp_path / "out.json"
    done = invoke(QUADROTOR, bad, good, worse, "--json", out)
    assert isinstance(done.exception, InputError)
    assert "2 of 3 flights rejected" in str(done.exception)
    assert not out.exists()
    assert done.stderr.count("rejected:") == 2
    assert invoke(QUADROTOR, bad, good, worse, "--json", out, "--skip-rejected").exception is None
    assert len(json.loads(out.read_text())["flights"]) == 1


def test_figures_and_recording_are_written(tmp_path, dragged):
    model = load_model(QUADROTOR)
    from infotraj.comparing import parse_horizons
    from infotraj.plots.comparison import comparison_figures
    from infotraj.recording import read_back
    from infotraj.recording.wrench import record_comparison

    short = dragged.between(0.0, 4.0)
    found = compare(model, [short], horizons=parse_horizons("1,10"))
    written = comparison_figures(found, tmp_path)
    assert {p.name for p in written} == {"wrench.png", "errors.png", "rollouts.png"}
    record_comparison(tmp_path / "a.rrd", short, model, found.models[0].errors[0])
    entities = str(read_back(tmp_path / "a.rrd"))
    for entity in ("force_measured", "force_predicted", "force_residual", "error_path", "residual/fx/residual"):
        assert entity in entities


def test_a_recording_holds_every_model_that_was_compared(tmp_path, dragged):
    from infotraj.recording import read_back

    flight, other, both, alone = (tmp_path / n for n in ("a.parquet", "other.yaml", "both.rrd", "alone.rrd"))
    dragged.between(0.0, 4.0).write(flight)
    save_model(Model(load_vehicle(QUADROTOR), [catalogue()["linear_drag"](d=[0.3, 0.3, 0.3])]), other)
    assert invoke(QUADROTOR, flight, "--against", other, "--recording", both).exception is None
    assert invoke(QUADROTOR, flight, "--recording", alone).exception is None
    held, one = read_back(both), read_back(alone)
    lines = {"measured": "measured", "predicted": "predicted by quadrotor", "predicted_2": "predicted by other"}
    colors = set()
    for axis in ("fx", "fy", "fz", "tx", "ty", "tz"):
        of = {e.split("/")[-1]: held[e] for e in held if e.startswith(f"wrench/{axis}/")}
        assert {k: v["SeriesLines:names"][0] for k, v in of.items()} == lines
        left = {e.split("/")[-1]: held[e] for e in held if e.startswith(f"residual/{axis}/")}
        assert set(left) == {"residual", "residual_2", "upper", "lower"}
        for k in ("", "_2"):
            assert left[f"residual{k}"]["SeriesLines:names"] == of[f"predicted{k}"]["SeriesLines:names"]
            assert left[f"residual{k}"]["SeriesLines:colors"] == of[f"predicted{k}"]["SeriesLines:colors"]
            drawn = of["measured"]["Scalars:scalars"] - of[f"predicted{k}"]["Scalars:scalars"]
            np.testing.assert_allclose(left[f"residual{k}"]["Scalars:scalars"], drawn, atol=1e-12)
        colors.add(tuple(of[k]["SeriesLines:colors"][0] >> 8 for k in lines))
    # Measured, the first model and the second as in the report: grey, blue and vermilion.
    assert colors == {(0x9AA1A8, 0x0072B2, 0xD55E00)}
    fx = [np.std(held[f"residual/fx/residual{k}"]["Scalars:scalars"]) for k in ("", "_2")]
    assert not np.isclose(*fx)
    assert {e for e in one if e.startswith(("wrench/fx/", "residual/fx/"))} == {
        "wrench/fx/measured", "wrench/fx/predicted", "residual/fx/residual", "residual/fx/upper", "residual/fx/lower"
    }  # fmt: skip
    assert one["wrench/fx/predicted"]["SeriesLines:names"] == ["predicted"]


def test_a_residual_that_is_all_mean_is_drawn_beside_its_mean_and_says_so(quiet):
    from infotraj.plots.comparison import draw_wrench

    made = compare({"model": load_model(QUADROTOR)}, [quiet])
    (error,) = made.models[0].errors

    def panel_of(fz):
        off = replace(error, predicted=error.predicted + np.array([0, 0, fz, 0, 0, 0]))
        figure = draw_wrench(replace(made, models=(replace(made.models[0], errors=(off,)),)))
        panel = next(b for a, b in zip(figure.axes[::2], figure.axes[1::2], strict=True) if "fz" in a.get_ylabel())
        low, high = panel.get_ylim()
        drawn = panel.lines[0].get_ydata()
        return panel.get_title(loc="right"), (np.nanmax(drawn) - np.nanmin(drawn)) / (high - low), low, high

    title, share, *_ = panel_of(-3.0)
    assert "less its mean of +" in title
    assert share > 0.4
    title, _, low, high = panel_of(0.0)
    assert "mean" not in title
    assert low < 0.0 < high


def test_a_prediction_far_worse_than_none_leaves_its_columns_apart(quiet):
    made = compare({"model": load_model(QUADROTOR)}, [quiet])
    (error,) = made.models[0].errors
    wild = replace(error, predicted=error.predicted + np.array([12.5, 0, 0, 0, 0, 3e4]) * np.sin(40 * error.t)[:, None])
    text = as_text(replace(made, models=(replace(made.models[0], errors=(wild,)),)))
    row = next(line for line in text.splitlines() if line.startswith("tz")).split()
    assert len(row) == 8  # the unit has a space in it: axis, N, m, and five numbers
    assert row[-1] == "<-1000%"
    assert all(np.isfinite(float(cell)) for cell in row[3:-1])
