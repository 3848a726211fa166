"""Commands between the rows of a log: read as the log says, and no reason to name an effect."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj.cli import cli
from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose, learn
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.gates.refusal import errors
from infotraj.diagnosis.linear.candidates import candidates
from infotraj.diagnosis.report.summary import as_dict, as_text
from infotraj.diagnosis.select.prior import file_only
from infotraj.diagnosis.select.reading import as_commanded, as_healthy, unread
from infotraj.effects import catalogue
from infotraj.errors import InputError
from infotraj.flight import Flight, command_steps, read_flight, stepped
from infotraj.models import Model
from infotraj.models.recorded import recorded
from infotraj.sparse_commands import COMMAND_STEPS
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config/vehicles"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.001, "velocity": 0.005}


def model(name):
    return Model(load_vehicle(VEHICLES / f"{name}.yaml"))


def logs(name, effects, every, seconds=12.0):
    """Four flights, commanded at the simulation's 200 Hz, of which each `every`th row was logged."""
    content = yaml.safe_load((VEHICLES / f"{name}.yaml").read_text())
    flights = (fly(content, effects, seconds=seconds, seed=seed, noise=NOISE) for seed in range(4))
    return [Flight(f.iloc[::every].reset_index(drop=True)) for f in flights]


def test_steps_lie_on_the_line_between_commands_but_not_across_a_gap():
    flight = logs("quadrotor", {}, 4, seconds=2.0)[0]
    table = flight.table.copy()
    table.loc[20:30, [f"cmd_rotor_{i}" for i in range(4)]] = np.nan
    vehicle = load_vehicle(VEHICLES / "quadrotor.yaml")
    held = recorded(vehicle, Flight(table)).rotor
    made = recorded(vehicle, stepped(Flight(table), 4)).rotor
    kept = np.isin(made.times, held.times)
    np.testing.assert_array_equal(made.values[kept], held.values)
    np.testing.assert_allclose(made.times[:5] - made.times[0], 0.005 * np.arange(5), atol=1e-12)
    np.testing.assert_allclose(made.values[2], (held.values[0] + held.values[1]) / 2)
    inside = (made.times > table["t"][19] + 1e-9) & (made.times < table["t"][31] - 1e-9)
    assert not inside.any()


@pytest.mark.parametrize("lag", [1.0, 2.0], ids=["as it is", "twice the lag"])
def test_commands_of_a_controller_of_100_hz_are_read_as_held(lag):
    """A declared lag that is too long asks for earlier commands, until it is corrected."""
    folder = Path(__file__).parents[2] / "examples/quad"
    vehicle = load_vehicle(folder / "vehicle.yaml")
    rotors = tuple(r.model_copy(update={"time_constant": lag * r.time_constant}) for r in vehicle.rotors)
    vehicle = vehicle.model_copy(update={"rotors": rotors})
    flights = [read_flight(folder / f"healthy/flight_{k}.parquet") for k in range(3)]
    known, _ = candidates(catalogue(), vehicle, flights)
    every = [*known, *file_only(vehicle, known, flights)]
    found = as_commanded(observe(Model(vehicle), flights), (), every)
    assert {command_steps(s.flight) for s in found.observation.samples} == {1}


EXACT = {"gyro": 0.003, "accelerometer": 0.03, "position": 3e-4, "attitude": 9e-4, "velocity": 0.005}


@pytest.mark.long
def test_a_lag_is_no_surer_than_what_a_faster_controller_did_between_the_rows():
    """Of commands of 1 kHz a log of 200 Hz holds every fifth, 2 ms late in the mean: a lag looks that much shorter."""
    content = yaml.safe_load((VEHICLES / "quadrotor.yaml").read_text())
    lag = {"rotor_lag": {"extra_time_constant": 0.03}}
    flown = (fly(content, lag, seconds=8.0, seed=seed, noise=EXACT, row=0.001) for seed in range(3))
    made = add(model("quadrotor"), ["rotor_lag"], [Flight(f.iloc[::5].reset_index(drop=True)) for f in flown])
    (error,) = (e["extra_time_constant"] for e in made.errors if "extra_time_constant" in e)
    told = made.model.effects[0].values["extra_time_constant"]
    assert told < 0.029
    assert abs(told - 0.03) < 2.0 * error


def test_errors_are_those_of_the_commands_as_they_were_read():
    flights, given = logs("quadrotor", {"mass_offset": {"dm": 0.1}}, 4, seconds=6.0), model("quadrotor")
    made = add(given, ["mass_offset"], flights)
    assert made.command_steps > 1
    read = [stepped(f, made.command_steps) for f in flights]
    np.testing.assert_array_equal(made.before.rmse, errors(given, read, None, None).rmse)
    np.testing.assert_array_equal(made.after.rmse, errors(made.model, read, None, None).rmse)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "true"),
    [
        ("omav", {}),
        ("omav", {"mass_offset": {"dm": 0.2}}),
        ("omav", {"servo_lag": {"extra_time_constant": 0.03}}),
        ("quadrotor", {"linear_drag": {"d": [0.1, 0.1, 0.15]}}),
        ("quadrotor", {"time_offset": {"dt": 0.01}}),
    ],
)
def test_a_thinned_log_shows_what_is_missing_and_no_more(name, true):
    found = diagnose(model(name), logs(name, true, 4))
    assert found.supported == tuple(true)
    assert as_dict(found)["commands"]["every"] == pytest.approx(0.02, rel=0.01)
    assert "a delay or lag below 10 ms cannot be told" in as_text(found)
    for effect, numbers in true.items():
        finding = found.finding(effect)
        for parameter, value in numbers.items():
            error = np.abs(np.subtract(finding.parameters[parameter], value))
            assert np.all(error < 3.0 * np.array(finding.standard_errors[parameter]))


@pytest.mark.long
@pytest.mark.parametrize("true", [{}, {"actuation_delay": {"delay": 0.015}}], ids=["nothing", "delay"])
def test_commands_that_were_held_stay_held(true):
    """At 100 Hz, from a controller of 100 Hz."""
    content = yaml.safe_load((VEHICLES / "quadrotor.yaml").read_text())
    flights = [Flight(fly(content, true, seconds=8.0, seed=s, noise=NOISE, row=0.01)) for s in range(3)]
    found = diagnose(model("quadrotor"), flights)
    assert found.supported == tuple(true)
    assert not any(COMMAND_STEPS in s.flight.meta for s in found.samples)


@pytest.mark.long
def test_a_model_is_extended_by_what_thinned_logs_say():
    flights = logs("omav", {"linear_drag": {"d": [0.4, 0.5, 0.3]}}, 4)
    made = add(model("omav"), ["linear_drag"], flights)
    np.testing.assert_allclose(made.model.effects[0].values["d"], [0.4, 0.5, 0.3], rtol=0.1)


@pytest.mark.long
def test_what_the_metadata_say_of_commands_is_taken_and_checked(tmp_path):
    vehicle = load_vehicle(VEHICLES / "quadrotor.yaml")
    flights = []
    for k, made in enumerate(logs("quadrotor", {}, 4, seconds=8.0)):
        stepped(made, 4).write(tmp_path / f"{k}.parquet")
        flights.append(read_flight(tmp_path / f"{k}.parquet"))
    found = diagnose(model("quadrotor"), flights)
    assert found.supported == ()
    assert found.command_steps == 4
    for wrong in (0, 1.5, "two", True, 100_000):
        with pytest.raises(InputError, match="command_steps"):
            recorded(vehicle, Flight(flights[0].table, {COMMAND_STEPS: wrong}))


@pytest.mark.long
def test_the_commands_take_and_hand_on_how_to_read(tmp_path):
    paths = []
    for k, made in enumerate(logs("omav", {"linear_drag": {"d": [0.4, 0.5, 0.3]}}, 4)):
        paths.append(str(tmp_path / f"{k}.parquet"))
        made.write(tmp_path / f"{k}.parquet")
    vehicle, new = str(VEHICLES / "omav.yaml"), str(tmp_path / "new.yaml")
    run = CliRunner().invoke(cli, ["diagnose", vehicle, *paths, "--command-steps", "4", "--save-model", new])
    assert run.exit_code == 0, run.output
    assert "read as 4 steps" in run.output
    assert "--command-steps 4" in next(line for line in run.output.splitlines() if line.startswith("next: "))
    assert "--command-steps 4" in Path(new).read_text()
    errors = {}
    for steps in ("1", "4"):
        numbers = tmp_path / f"{steps}.json"
        run = CliRunner().invoke(cli, ["compare", new, paths[0], "--command-steps", steps, "--json", str(numbers)])
        assert run.exit_code == 0, run.output
        errors[steps] = json.loads(numbers.read_text())["rmse"]["fx"]
    assert errors["4"] < errors["1"]


def test_flights_are_read_as_the_healthy_ones_of_their_controller():
    """A controller of 100 Hz, as logs of 50 Hz are read, makes 4 commands in a row of 25 Hz and 1 in one of 100; what a
    flight says itself stands."""
    vehicle = model("quadrotor").vehicle
    every = {step: logs("quadrotor", {}, step, seconds=2.0)[0] for step in (2, 4, 8)}
    own = stepped(every[8], 2)
    for healthy, expected in ((stepped(every[4], 2), [1, 2, 4]), (every[4], [1, 1, 2])):
        read = as_healthy(list(every.values()), [healthy], vehicle)
        assert [command_steps(f) for f in read] == expected
        assert as_healthy([own], [healthy], vehicle) == [own]
    # Held over rows of 5 ms, each a row in which it is half the one before: they come every 20 ms all the same.
    table = every[4].table.loc[every[4].table.index.repeat(4)].reset_index(drop=True)
    commands = [f"cmd_rotor_{i}" for i in range(4)]
    table.loc[4::4, commands] = (table[commands].to_numpy()[3:-1:4] + table[commands].to_numpy()[4::4]) / 2
    held = Flight(table.assign(t=table["t"].iloc[0] + 0.005 * np.arange(len(table))))
    assert command_steps(as_healthy([every[4]], [held], vehicle)[0]) == 1


@pytest.mark.long
def test_a_flight_too_short_to_say_is_read_as_the_healthy_ones_were():
    flights = logs("quadrotor", {}, 4, seconds=8.0)
    usual = learn(model("quadrotor"), flights[:3])
    (count,) = {command_steps(f) for f in usual.flights}
    assert count > 1
    one = flights[3].table
    found = diagnose(model("quadrotor"), [Flight(one[one["t"] < one["t"].iloc[0] + 3.0])], reference=usual)
    assert found.command_steps == count
    assert found.supported == ()


def test_a_delay_is_as_unsure_as_how_commands_ran_between_their_rows():
    """Of rows of 20 ms: held, commands come 7.5 ms later in the mean than in four steps; half of it is not known."""
    found = model("quadrotor")
    known = {c.name: c for c in candidates(catalogue(), found.vehicle, logs("quadrotor", {}, 4))[0]}
    observation = observe(found, logs("quadrotor", {}, 4))
    assert unread(known["actuation_delay"], observation) == pytest.approx(0.25 * 0.0075 / 0.5)
    assert unread(known["rotor_lag"], observation) == unread(known["actuation_delay"], observation)
    assert unread(known["linear_drag"], observation) == unread(known["time_offset"], observation) == 0.0
    told = [stepped(f, 2) for f in logs("quadrotor", {}, 4)]
    assert unread(known["actuation_delay"], observe(found, told)) == 0.0
