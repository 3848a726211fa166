"""A number that stopped at a physical bound is no measurement: it is said wherever it is printed, and names nothing."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.judge.verdicts import CONFIDENT
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.report.command import add_command, diagnose_command
from infotraj.diagnosis.select.bounds import beyond_bounds, parts_beyond
from infotraj.diagnosis.select.search import Search
from infotraj.effects import effect_class
from infotraj.errors import UsageError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.models.file import read_model
from infotraj.vehicle import load_vehicle, parse_vehicle

VEHICLE = Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml"
CONTENT = yaml.safe_load(VEHICLE.read_text())
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
WEIGHT = CONTENT["mass"] * 9.81


def flights(effects, count=2):
    made = [fly(CONTENT, effects, seconds=7.0, seed=k, noise=NOISE) for k in range(count)]
    return [Flight(t, {"source": f"flight {k}"}) for k, t in enumerate(made)]


@pytest.fixture(scope="module")
def stormy():
    """A wind that pushes with more than the two weights that a steady force may have."""
    return flights({"steady_force": {"f": [4.0 * WEIGHT, 0.0, 0.0]}})


@pytest.fixture(scope="module")
def heavy():
    """An inertia about y of twelve times the file's."""
    return flights({"inertia_error": {"dxx": 0.0, "dyy": 11.0 * CONTENT["inertia"]["yy"], "dzz": 0.0}})


def member(name, **values):
    cls = effect_class(name)
    return Member(Candidate(cls, tuple(p for p in cls.parameters if not p.index)), cls(**values))


@pytest.mark.parametrize(
    ("effect", "parts"),
    [
        (member("wind", v=[-4.0, 0.1, 3.0]), (2,)),
        (member("wind", v=[25.0, 0.1, -3.0]), (0, 2)),
        (member("wind", v=[-4.0, 0.1, 2.9]), ()),
        (member("wind", v=[0.0, 0.0, 3.0]), ()),  # nothing of it would be left
        (member("wind", v=[25.0, 25.0, 3.0]), ()),
        (member("thrust_exponent", n=3.0), ()),  # no vector
    ],
)
def test_of_a_vector_the_numbers_at_a_bound_are_told_from_those_that_are_not(effect, parts):
    vehicle = load_vehicle(VEHICLE)
    assert parts_beyond(effect, vehicle) == parts
    assert bool(beyond_bounds([effect], vehicle)) == (effect.effect.values != {"v": [-4.0, 0.1, 2.9]})


def test_what_ends_at_a_bound_stays_absent_and_the_rest_of_the_vector_is_fitted():
    """The third number of a wind is held at nothing, in the fit and in the model; what was held before stays held."""
    wind = member("wind", v=[-4.0, 0.1, 3.0])
    search = Search(Observation(load_vehicle(VEHICLE), (), (), None), (wind.candidate,), ())
    assert not search.hold_parts([wind], {"linear_drag": "another one's bound"})
    assert search.hold_parts([wind], {"wind": "its bound"})
    assert search.observation.still == {("wind", 2)}
    assert not search.hold_parts([wind], {"wind": "its bound"})
    healthy = replace(Observation(load_vehicle(VEHICLE), (), (), None), healthy=object())
    assert not Search(healthy, (wind.candidate,), ()).hold_parts([wind], {"wind": "its bound"})


@pytest.mark.long
def test_nothing_at_its_bound_is_supported(stormy, heavy):
    model = Model(load_vehicle(VEHICLE))
    for made, name in ((stormy, "steady_force"), (heavy, "inertia_error")):
        found = diagnose(model, made)
        assert name not in found.supported
        confident = {f.name for f in found.findings if f.verdict in CONFIDENT}
        assert not confident & {label.split()[0] for label in beyond_bounds(found.final.members, model.vehicle)}
        assert found.finding(name).verdict in ("Plausible", "Not needed")
        why = found.finding(name).reason
        assert found.unexplained.found or "bound" in why


@pytest.mark.long
@pytest.mark.parametrize("share", [0.3, 0.7])
def test_a_wind_that_a_vehicle_can_hold_against_is_named_with_its_force(share):
    """As in a wind tunnel: half of the weight and more, at a tilt of 35 degrees."""
    found = diagnose(Model(load_vehicle(VEHICLE)), flights({"steady_force": {"f": [share * WEIGHT, 0.0, 0.0]}}))
    assert found.supported == ("steady_force",)
    assert found.finding("steady_force").parameters["f"] == pytest.approx([share * WEIGHT, 0.0, 0.0], abs=0.02)


def test_add_says_that_a_number_stopped_at_its_bound_and_marks_it_in_the_file(tmp_path):
    path, out = tmp_path / "a.parquet", tmp_path / "m.yaml"
    (bent,) = flights({"thrust_exponent": {"n": 3.6}}, 1)
    replace(bent, meta={}).write(path)
    done = CliRunner().invoke(
        add_command,
        [str(VEHICLE), "thrust_exponent", "--fit", str(path), "-o", str(out), "--json", str(tmp_path / "a.json")],
        standalone_mode=False,
    )
    assert done.exception is None, done.stderr
    assert re.search(r"WARNING thrust_exponent: the fit ends at the physical bound of n", done.stdout)
    assert "thrust_exponent: the fit ends" in done.stderr
    assert "thrust_exponent" in json.loads((tmp_path / "a.json").read_text())["at_bound"]
    model, content = read_model(out)
    assert "bound of n" in content.provenance.at_bound["thrust_exponent"]
    assert model.effects[0].n == 3.0


def test_add_says_that_a_lag_which_the_file_declares_too_long_stops_at_nothing(tmp_path):
    """The file's lag is twice the true one: as an effect it can only grow."""
    slow = {**CONTENT, "rotors": [{**r, "time_constant": 2.0 * r["time_constant"]} for r in CONTENT["rotors"]]}
    flown = flights({})
    made = add(Model(parse_vehicle(slow)), ["rotor_lag"], flown)
    assert made.model.effects[0].extra_time_constant == 0.0
    assert made.as_dict()["at_bound"]["rotor_lag"].startswith("the fit ends at extra_time_constant 0, ")
    assert "ask for less than the file declares, and `infotraj diagnose` says" in made.as_text()
    fast = {**CONTENT, "rotors": [{**r, "time_constant": 0.5 * r["time_constant"]} for r in CONTENT["rotors"]]}
    longer = add(Model(parse_vehicle(fast)), ["rotor_lag"], flown)
    assert longer.model.effects[0].extra_time_constant > 0.01
    assert longer.ended == {}


def test_add_prints_as_many_digits_as_the_standard_error_leaves():
    made = add(Model(load_vehicle(VEHICLE)), ["linear_drag"], flights({"linear_drag": {"d": [0.1, 0.1, 0.1]}}, 1))
    (line,) = [x for x in made.as_text().splitlines() if x.startswith("linear_drag")]
    numbers = re.findall(r"\d\.\d+(?:e-\d+)?", line)
    assert len(numbers) == 6
    assert max(len(n.replace(".", "").lstrip("0")) for n in numbers) <= 5
    values, errors = np.array(numbers[:3], dtype=float), np.array(numbers[3:], dtype=float)
    assert np.all(np.abs(values - made.model.effects[0].d) < 0.1 * errors)


def test_a_refused_diagnosis_writes_no_model_and_says_so(tmp_path):
    (flight,) = flights({"linear_drag": {"d": [0.1, 0.1, 0.1]}}, 1)
    table = flight.table.copy()
    columns = [c for c in table if c.startswith("cmd_rotor_")]
    table[columns] = table[columns].to_numpy()[::-1]
    Flight(table).write(tmp_path / "a.parquet")
    arguments = [str(VEHICLE), str(tmp_path / "a.parquet"), "--save-model", str(tmp_path / "m.yaml")]
    done = CliRunner().invoke(diagnose_command, arguments, standalone_mode=False)
    assert done.exception is None, done.stderr
    assert "These data cannot say" in done.stdout
    assert f"{tmp_path / 'm.yaml'} is not written" in done.stderr
    assert "--against" not in done.stderr
    assert not (tmp_path / "m.yaml").exists()


def test_add_names_the_places_where_the_one_that_was_asked_for_is_none(stormy):
    for asked in ("rotor_effectiveness:7", "rotor_effectiveness"):
        with pytest.raises(UsageError, match=r"expected one of rotor_effectiveness:0, .*rotor_effectiveness:3"):
            add(Model(load_vehicle(VEHICLE)), [asked], stormy)
