"""A first vehicle file from a few numbers, held against flights; what stands between a flight and an answer."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from infotraj.comparing.equation_error import equation_error
from infotraj.describing import guesses, layouts
from infotraj.describing.against import of_rotors, seen
from infotraj.describing.command import vehicle_command
from infotraj.describing.doctor import doctor_command
from infotraj.describing.plausible import require_sizes
from infotraj.describing.writing import Asked, vehicle_text
from infotraj.errors import InputError, UsageError
from infotraj.flight import read_flight
from infotraj.models import Model
from infotraj.vehicle import Vehicle, load_vehicle, parse_vehicle

TOP = Path(__file__).parents[2]
VEHICLES = TOP / "config" / "vehicles"
QUAD = TOP / "examples" / "quad"
HEALTHY = QUAD / "healthy" / "flight_0.parquet"
SMALL = ["--layout", "quad_x", "--order", "px4", "--arm", "0.16", "--mass", "0.8", "--propeller", "0.127"]
ASKED = Asked("mine", "quad_x", "px4", 0.16, 0.8, "speed", 0.127)


def new(*arguments):
    return CliRunner().invoke(vehicle_command, ["new", *map(str, arguments)])


def asked(**more) -> Vehicle:
    return parse_vehicle(yaml.safe_load(vehicle_text(Asked(**{**ASKED.__dict__, **more}))))


def test_a_layout_stands_where_a_shipped_file_of_that_firmware_has_its_rotors():
    for name, order, mapped in (("betaflight_5inch", "betaflight", 0.1103), ("nanobench", "crazyflie", 0.046)):
        shipped = load_vehicle(VEHICLES / f"{name}.yaml")
        made = layouts.places("quad_x", order)
        assert [place.spin for place in made] == [r.spin for r in shipped.rotors]
        spots = [layouts.position(place, mapped) for place in made]
        assert np.allclose(spots, [r.position for r in shipped.rotors], atol=3e-4)


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_every_layout_can_hover_and_turn_every_way(layout):
    """Even thrusts leave no torque, and rotors can make each torque alone: right places and senses of turning."""
    around = layouts.places(layout, "px4")
    spots = np.array([layouts.position(place, 0.3) for place in around])
    spin = np.array([place.spin for place in around])
    torque = np.stack([spots[:, 1], -spots[:, 0], -0.02 * spin])
    assert np.allclose(torque.sum(axis=1), 0.0, atol=1e-4)
    assert np.linalg.matrix_rank(np.vstack([np.ones(len(around)), torque])) == 4
    angles = np.sort([place.angle % 360 for place in around])
    assert np.allclose(np.diff(angles), 360 / len(around))
    # neighbours turn against each other, except across the sides of an octocopter
    if layout != "octo_x":
        order = np.argsort([place.angle % 360 for place in around])
        assert (np.diff(spin[order]) != 0).all()


def test_the_drawing_has_each_rotor_on_its_side():
    text = layouts.drawing(["a", "b", "c", "d"], layouts.places("quad_x", "px4"))
    lines = [line for line in text.splitlines() if "cw" in line]
    assert [re.findall(r"\w+", line) for line in lines] == [["c", "cw", "a", "ccw"], ["b", "ccw", "d", "cw"]]


@pytest.mark.parametrize("name", ["crazyflie_arpl", "nanobench"])
def test_the_guessed_inertia_is_near_a_published_one(name):
    vehicle = load_vehicle(VEHICLES / f"{name}.yaml")
    spots = [r.position for r in vehicle.rotors]
    made = guesses.inertia(vehicle.mass, spots, float(np.hypot(*spots[0][:2])))
    published = vehicle.inertia
    assert (made.xx, made.yy, made.zz) == pytest.approx((published.xx, published.yy, published.zz), rel=0.25)


def test_the_page_says_how_far_the_shipped_inertias_are_from_the_guess():
    ratio = {}
    for path in VEHICLES.glob("*.yaml"):
        vehicle = load_vehicle(path)
        if vehicle.rotors:
            spots = [r.position for r in vehicle.rotors]
            made = guesses.inertia(vehicle.mass, spots, float(np.hypot(*spots[0][:2])))
            ratio[path.stem] = [getattr(vehicle.inertia, axis) / getattr(made, axis) for axis in ("xx", "yy", "zz")]
    tall = ratio.pop("acsl_x8")
    flat = [value for values in ratio.values() for value in values]
    page = (VEHICLES.parents[1] / "docs/vehicle.md").read_text()
    said = re.search(
        r"are ([\d.]+) to ([\d.]+) times that guess; about x and y of the tall X8 ([\d.]+) and ([\d.]+)", page
    )
    assert [float(value) for value in said.groups()] == [round(v, 1) for v in (min(flat), max(flat), *tall[:2])]


def test_a_written_file_hovers_where_it_was_told_and_keeps_what_was_given():
    vehicle = asked(
        hover=1144.0, moments=(0.005, 0.006, 0.01), time_constant=0.04, moment_constant=0.011, max_speed=2200.0
    )
    assert sum(r.thrust_coefficient for r in vehicle.rotors) * 1144.0**2 == pytest.approx(0.8 * 9.81, rel=1e-3)
    assert (vehicle.inertia.xx, vehicle.inertia.yy, vehicle.inertia.zz) == (0.005, 0.006, 0.01)
    (rotor, *_) = vehicle.rotors
    assert (rotor.time_constant, rotor.moment_constant, rotor.max_speed, rotor.radius) == (0.04, 0.011, 2200.0, 0.0635)
    throttle = asked(input="throttle", hover=0.4)
    assert sum(r.thrust_polynomial[2] for r in throttle.rotors) * 0.4**2 == pytest.approx(0.8 * 9.81, rel=1e-3)
    assert asked(input="thrust").rotors[0].thrust_coefficient is None


def test_every_guess_is_said_in_the_file_and_what_is_given_is_not_called_one():
    text = vehicle_text(ASKED)
    for key in ("inertia", "thrust_coefficient", "moment_constant", "time_constant"):
        assert any(key in line and "guessed" in line for line in text.splitlines()), key
    known = Asked(
        **{**ASKED.__dict__, "thrust_coefficient": 1e-6, "moments": (0.005, 0.005, 0.01), "time_constant": 0.03}
    )
    given = [line for line in vehicle_text(known).splitlines() if "guessed:" in line or "guessed from" in line]
    assert [line.split(":")[0].strip("# ") for line in given] == ["moment_constant"]


def test_the_command_writes_checks_and_never_overwrites(tmp_path):
    out = tmp_path / "mine.yaml"
    done = new("-o", out, *SMALL, "--hover", "1144", "--flight", HEALTHY)
    assert done.exit_code == 0, done.output
    assert out.read_text() in done.stdout
    assert "3 numbers are guessed" in done.stderr
    assert "thrust: the flight has 1.00" in done.stdout
    assert "!" not in done.stdout
    before = out.read_text()
    again = new("-o", out, *SMALL)
    assert isinstance(again.exception, UsageError)
    assert out.read_text() == before


def test_numbers_that_agree_are_taken_together_and_every_guess_counts(tmp_path):
    """1e-5 N s^2/rad^2 lifts 0.8 kg at 443 rad/s. Of a throttle its square is guessed, too."""
    out = tmp_path / "mine.yaml"
    done = new("-o", out, *SMALL, "--hover", "450", "--thrust-coefficient", "1e-5", "--max-speed", "451")
    assert done.exit_code == 0, done.output
    assert load_vehicle(out).rotors[0].thrust_coefficient == 1e-5
    assert "3 numbers are guessed" in done.stderr
    done = new("-o", tmp_path / "guessed.yaml", *SMALL, "--input", "throttle", "--hover", "0.4")
    assert "4 numbers are guessed" in done.stderr


def test_a_speed_may_be_given_in_rpm(tmp_path):
    """5600 rpm are 586.43 rad/s: one file."""
    texts = []
    for hover, most in (("5600rpm", "9000 rpm"), ("586.43", "942.48"), ("586.43rad/s", "942.48 rad/s")):
        out = tmp_path / hover.replace("/", "") / "mine.yaml"
        assert new("-o", out, *SMALL, "--hover", hover, "--max-speed", most).exit_code == 0
        content = yaml.safe_load(out.read_text())
        texts.append([content["rotors"][0][k] for k in ("thrust_coefficient", "max_speed")])
    assert texts[0] == pytest.approx(texts[1], rel=1e-4)
    assert texts[1] == texts[2]
    for wrong in ("fast", "5600 rps", "-1", "0rpm", "inf"):
        assert new("-o", tmp_path / "no.yaml", *SMALL, "--hover", wrong).exit_code == 2


def test_lengths_may_be_given_in_the_units_they_are_sold_in(tmp_path):
    made = []
    for arm, propeller in (("0.275", "0.254"), ("27.5cm", "10in"), ("275 mm", "0.254m")):
        out = tmp_path / arm.replace(" ", "") / "mine.yaml"
        given = ["--layout", "hexa_x", "--order", "px4", "--mass", "2.1", "--hover", "5600rpm"]
        done = new("-o", out, *given, "--arm", arm, "--propeller", propeller)
        assert done.exit_code == 0, done.output
        made.append(yaml.safe_load(out.read_text())["rotors"])
    assert made[0] == made[1] == made[2]
    assert made[0][0]["position"] == [0, -0.275, 0]
    assert made[0][0]["radius"] == pytest.approx(0.127)
    refused = new("-o", tmp_path / "no.yaml", *SMALL, "--arm", "1ft")
    assert refused.exit_code == 2
    assert "m or cm or mm or in" in refused.output


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "--arm, --mass, --propeller"),
        (["--layout", "hexa_x"], "no --order (px4 | ardupilot), --arm"),
        ([*SMALL, "--input", "throttle"], "no --hover"),
        ([*SMALL, "--input", "throttle", "--hover", "40"], "--hover 40; expected a throttle of 0..1"),
        ([*SMALL, "--hover", "56000"], "If it is in rpm, give --hover 56000rpm"),
        ([*SMALL, "--hover", "0.52"], "If it is a throttle, add --input throttle"),
        ([*SMALL, "--arm", "160", "--mass", "800", "--propeller", "127"], "N a m^2 of their area; expected 3 to 3000"),
        ([*SMALL, "--mass", "800"], "--arm 160mm --mass 800g --propeller 5in"),
        ([*SMALL, "--propeller", "5"], "4 propellers carry 0.09992 N a m^2"),
        ([*SMALL, "--arm", "160"], "an arm is 1260 propellers long; expected 0.25 to 12"),
        ([*SMALL, "--input", "thrust", "--hover", "40"], "--hover with --input thrust"),
        (
            [*SMALL, "--hover", "5000rpm", "--thrust-coefficient", "1e-5"],
            "expected 442.9 rad/s, at which that lifts 0.8 kg",
        ),
        ([*SMALL, "--hover", "1144", "--max-speed", "1100"], "it cannot hover; expected more than the 1144 rad/s"),
        (
            [*SMALL, "--thrust-coefficient", "1e-5", "--max-speed", "440"],
            "the 442.9 rad/s in hover (--thrust-coefficient)",
        ),
        ([*SMALL, "--max-speed", "500"], "rad/s in hover (the thrust guessed). Correct it, or give --hover."),
        ([*SMALL, "--input", "throttle", "--hover", "0.4rpm"], "rad/s; expected a throttle of 0..1"),
        ([*SMALL, "--input", "throttle", "--hover", "0.4", "--max-speed", "900"], "--max-speed with --input throttle"),
        ([*SMALL, "--input", "thrust", "--max-speed", "900"], "--max-speed with --input thrust"),
        (
            [*SMALL, "--moment-constant", "5"],
            "--moment-constant 5 with a propeller of 0.127 m; expected m, 0.00127 to 0.127",
        ),
        ([*SMALL, "--time-constant", "30"], "--time-constant 30; expected s, 0.001 to 1. If it is in ms, give 0.03."),
        ([*SMALL, "--inertia", "0.1", "0.1"], "--inertia with 2 numbers"),
        (["--layout", "hexa_x", "--order", "betaflight", *SMALL[4:]], "the order of betaflight for hexa_x"),
    ],
)
def test_what_is_missing_or_contradicts_is_one_line_and_leaves_nothing(tmp_path, arguments, says):
    done = new("-o", tmp_path / "mine.yaml", *arguments)
    assert isinstance(done.exception, UsageError)
    assert says in str(done.exception)
    assert list(tmp_path.iterdir()) == []


def test_a_mass_may_be_given_in_grams_and_every_shipped_vehicle_is_of_sizes_that_fly(tmp_path):
    assert new("-o", tmp_path / "mine.yaml", *SMALL, "--mass", "800g").exit_code == 0
    assert load_vehicle(tmp_path / "mine.yaml").mass == pytest.approx(0.8)
    for path in sorted(VEHICLES.glob("*.yaml")):
        vehicle = load_vehicle(path)
        if vehicle.mass and vehicle.rotors and all(r.radius for r in vehicle.rotors):
            arm = max(np.linalg.norm(r.position) for r in vehicle.rotors)
            require_sizes(arm, vehicle.mass, 2 * vehicle.rotors[0].radius, len(vehicle.rotors))


def test_numbers_that_make_no_body_are_refused(tmp_path):
    done = new("-o", tmp_path / "mine.yaml", *SMALL, "--inertia", "0.001", "0.001", "0.1")
    assert isinstance(done.exception, InputError)
    assert list(tmp_path.iterdir()) == []


def told(**changes) -> dict[str, bool]:
    """What the healthy flight says of the quadrotor's file with these changes: axis to whether it is right."""
    content = yaml.safe_load((QUAD / "vehicle.yaml").read_text())
    for rotor, changed in zip(content["rotors"], changes.pop("rotors", [{}] * 4), strict=True):
        rotor.update(changed)
    content.update(changes)
    return {one.axis: one.good for one in held(content, HEALTHY)}


def held(content, path):
    """What a flight says of a vehicle file with this content."""
    model, flight = Model(parse_vehicle(content)), read_flight(path)
    error = equation_error(model, flight)
    return seen(error, rotors=of_rotors(model, flight, error))


def test_a_right_file_is_right_and_each_error_is_told_on_its_own_axis():
    assert told() == {"fz": True, "tx": True, "ty": True, "tz": True}
    assert told(mass=0.88)["fz"] is False
    assert told(inertia={"xx": 0.0085, "yy": 0.0055, "zz": 0.0105}) == {"fz": True, "tx": False, "ty": True, "tz": True}
    assert told(rotors=[{"spin": -1}, {"spin": -1}, {"spin": 1}, {"spin": 1}]) == {
        "fz": True,
        "tx": True,
        "ty": True,
        "tz": False,
    }
    mirrored = [{"position": [-0.113, -0.113, 0]}, {"position": [0.113, 0.113, 0]}]
    mirrored += [{"position": [-0.113, 0.113, 0]}, {"position": [0.113, -0.113, 0]}]
    assert told(rotors=mirrored) == {"fz": True, "tx": True, "ty": False, "tz": True}


@pytest.mark.parametrize(
    ("changes", "says", "wrong", "true"),
    [
        ({"mass": 1.0}, r"thrust: the flight has ([\d.]+) of .* or divide the mass by it", 1.0, 0.8),
        ({"inertia": {"xx": 0.0075, "yy": 0.0055, "zz": 0.0105}}, r"divide inertia.xx by ([\d.]+)", 0.0075, 0.0055),
        ({"inertia": {"xx": 0.0055, "yy": 0.0075, "zz": 0.0105}}, r"divide inertia.yy by ([\d.]+)", 0.0075, 0.0055),
        ({"rotors": [{"moment_constant": 0.018}] * 4}, r"multiply moment_constant by ([\d.]+)", 1 / 0.018, 1 / 0.012),
    ],
)
def test_what_is_to_be_done_mends_the_file(changes, says, wrong, true):
    """The factor that the sentence names brings the number back to the true one."""
    content = yaml.safe_load((QUAD / "vehicle.yaml").read_text())
    for rotor, changed in zip(content["rotors"], changes.pop("rotors", [{}] * 4), strict=True):
        rotor.update(changed)
    said = held(content | changes, HEALTHY)
    (factor,) = (float(found[1]) for one in said if (found := re.search(says, one.sentence)))
    # Rotors that may differ take a part of it.
    assert wrong / factor == pytest.approx(true, rel=0.07)


@pytest.mark.parametrize("flight", sorted(QUAD.glob("flight_*.parquet")), ids=lambda p: p.stem)
def test_a_weak_rotor_does_not_make_a_right_file_wrong(flight):
    """Its torque goes with the thrust, as no inertia's does; a fit of one number takes a quarter off the inertia."""
    said = {one.axis: one for one in held(yaml.safe_load((QUAD / "vehicle.yaml").read_text()), flight)}
    assert {axis: one.good for axis, one in said.items()} == {"fz": False, "tx": True, "ty": True, "tz": True}
    assert "one weak rotor" in said["fz"].sentence
    assert not any(word in one.sentence for one in said.values() for word in ("divide", "multiply"))


@pytest.mark.parametrize("flight", sorted(QUAD.glob("flight_*.parquet")), ids=lambda p: p.stem)
def test_a_wrong_inertia_is_told_beside_a_weak_rotor(flight):
    content = yaml.safe_load((QUAD / "vehicle.yaml").read_text()) | {
        "inertia": {"xx": 0.008, "yy": 0.0055, "zz": 0.0105}
    }
    said = {one.axis: one for one in held(content, flight)}
    assert said["ty"].good
    (factor,) = re.findall(r"divide inertia.xx by ([\d.]+)", said["tx"].sentence)
    assert 0.008 / float(factor) == pytest.approx(0.0055, rel=0.06)


def test_what_no_rotor_and_no_inertia_makes_is_no_reason_to_correct_the_file():
    """A rotor that loses a third of its thrust half way: nothing that stays as it is explains that torque."""
    content, flight = yaml.safe_load((QUAD / "vehicle.yaml").read_text()), read_flight(HEALTHY)
    model = Model(parse_vehicle(content))
    error = equation_error(model, flight)
    rotors = of_rotors(model, flight, error)
    late = error.t > np.median(error.t)
    lost = replace(error, measured=error.measured - 0.33 * np.where(late[:, None], rotors[0], 0.0))
    said = {one.axis: one for one in seen(lost, rotors=rotors)}
    assert not any("divide" in said[axis].sentence for axis in ("tx", "ty", "tz"))
    assert "infotraj diagnose" in said["tx"].sentence + said["ty"].sentence


def test_the_guessed_thrust_is_c_t_rho_n2_d4_and_within_what_it_says_of_shipped_files():
    turns, diameter = 100.0, 0.2  # 1/s, m
    thrust = guesses.thrust_coefficient_of_propeller(diameter).value * (2 * np.pi * turns) ** 2
    assert thrust == pytest.approx(0.14 * 1.225 * turns**2 * diameter**4)
    for name in ("quadrotor", "agile_quadrotor"):
        (rotor, *_) = load_vehicle(VEHICLES / f"{name}.yaml").rotors
        made = guesses.thrust_coefficient_of_propeller(2 * rotor.radius).value
        assert 1 / 1.6 < made / rotor.thrust_coefficient < 1.6


def doctor(*arguments):
    return CliRunner().invoke(doctor_command, list(map(str, arguments)))


def test_the_doctor_has_a_line_a_flight_and_names_what_to_do(tmp_path):
    fine = doctor(QUAD / "vehicle.yaml", HEALTHY)
    assert (fine.exit_code, fine.stdout) == (0, f"{HEALTHY}: nothing stands in the way\n")
    assert f"infotraj diagnose {QUAD / 'vehicle.yaml'} {HEALTHY}" in fine.stderr
    flight = read_flight(HEALTHY)
    wrong = flight.table.copy()
    wrong[["wx", "wy", "wz"]] *= 180 / np.pi
    type(flight)(wrong).write(tmp_path / "degrees.parquet")
    type(flight)(flight.table.drop(columns=["cmd_rotor_3"])).write(tmp_path / "three.parquet")
    type(flight)(flight.table.iloc[:301]).write(tmp_path / "short.parquet")
    type(flight)(flight.table.drop(columns=["wx", "wy", "wz", "qw", "qx", "qy", "qz"])).write(
        tmp_path / "force.parquet"
    )
    paths = [tmp_path / f"{name}.parquet" for name in ("degrees", "three", "short", "force", "none")]
    done = doctor(QUAD / "vehicle.yaml", *paths)
    lines = done.stdout.splitlines()
    assert done.exit_code == 3
    assert len(lines) == len(paths)
    assert "rate_unit: angular velocity is in deg/s" in lines[0]
    assert "--set rate.scale=0.0174533" in lines[0]
    assert "missing_columns: quadrotor has 4 rotors, the flight commands of 3: another vehicle's file?" in lines[1]
    assert "map cmd_rotor_3" in lines[1]
    assert "only 3.0 s in the air" in lines[2]
    assert "not judged: " in lines[3]
    assert "tx ty tz" in lines[3]
    assert "no file" in lines[4] or "no such file" in lines[4]
    assert all("Traceback" not in line for line in lines)


def test_the_doctor_says_what_check_warns_of(tmp_path):
    flight = read_flight(HEALTHY)
    type(flight)(flight.table.drop(columns=["qw"])).write(tmp_path / "half.csv")
    done = doctor(QUAD / "vehicle.yaml", tmp_path / "half.csv")
    assert done.exit_code == 0
    assert "; warning incomplete: attitude incomplete: qx, qy, qz hold numbers, qw not" in done.stdout
