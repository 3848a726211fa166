"""The catalogue's names and parameters, an effect of the user's own, the command."""

from __future__ import annotations

import importlib.metadata
import json
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from infotraj.diagnosis.linear.candidates import candidates
from infotraj.effects import Effect, Parameter, catalogue, effect_class, registry
from infotraj.effects.along import Actuation, Along, Motion
from infotraj.effects.command import effects_command
from infotraj.errors import InputError, UsageError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"

# Written down from the specification, not read from the code.
NAMES = {
    "mass_offset": {"dm"},
    "inertia_error": {"dxx", "dyy", "dzz"},
    "com_offset": {"r"},
    "thrust_scale": {"factor"},
    "rotor_effectiveness": {"rotor", "factor"},
    "coaxial_loss": {"fraction"},
    "moment_scale": {"factor"},
    "axial_inflow": {"k"},
    "ground_effect": {"k"},
    "battery_sag": {"rate", "exponent"},
    "rotor_interference": {"k"},
    "rotor_lag": {"extra_time_constant"},
    "servo_lag": {"extra_time_constant"},
    "servo_rate_limit": {"max_rate"},
    "servo_backlash": {"half_width"},
    "servo_bias": {"bias"},
    "actuation_delay": {"delay"},
    "rotor_drag": {"k"},
    "linear_drag": {"d"},
    "quadratic_drag": {"d"},
    "angular_damping": {"d"},
    "gyroscopic": {"rotor_inertia", "momentum"},  # the specification has the first; momentum: where no speed is known
    "steady_force": {"f"},
    "steady_torque": {"t"},
    "suspended_load": {"mass", "length"},
    "gyro_bias": {"b"},
    "accelerometer_bias": {"b"},  # not in the specification: every accelerometer has one
    "imu_misalignment": {"rotvec"},
    "time_offset": {"dt"},
    "telemetry_offset": {"dt"},  # not in the specification: of logs with measured rotors
    "wind": {"v"},
    "pressure_centre": {"r"},
    "hub_moment": {"k"},
    "translational_lift": {"k"},
    "thrust_exponent": {"n"},
    "sensor_lag": {"time_constant"},
}
USUAL: dict[str, Any] = {
    "mass_offset": {"omav": (0.05 * 4.04,) * 2, "quadrotor": (0.04, 0.04)},
    "com_offset": {"omav": (0.005, 0.02), "quadrotor": (0.002, 0.006)},
    "rotor_drag": {"omav": (3e-5, 1.2e-4), "quadrotor": (2e-5, 1.2e-4)},
    "linear_drag": {"omav": (0.01, 1), "quadrotor": (0.01, 1)},
    "quadratic_drag": {"omav": (0.01, 0.4), "quadrotor": (0.01, 0.4)},
    "angular_damping": {"omav": (0.03, 0.1), "quadrotor": (0.004, 0.01)},
    "steady_torque": {"omav": (0.03, 0.3), "quadrotor": (0.005, 0.02)},
    "steady_force": {"omav": (0.4, 2.0), "quadrotor": (0.08, 0.4)},
    "wind": {"omav": (1, 8), "quadrotor": (1, 8)},
    "pressure_centre": {"omav": (0.005, 0.05), "quadrotor": (0.005, 0.05)},
    # 1e-6 belongs to a radius of 0.1 m; these have 0.114 and 0.0635 m, and it grows with the fourth power.
    "hub_moment": {"omav": (1.7e-6, 1.75e-6), "quadrotor": (1.6e-7, 1.65e-7)},
    "translational_lift": {"omav": (2e-3, 1e-2), "quadrotor": (2e-3, 6e-3)},
    "thrust_exponent": {"omav": (0.1, 0.3), "quadrotor": (0.1, 0.3)},
    "sensor_lag": {"omav": (2e-3, 0.02), "quadrotor": (2e-3, 0.02)},
}

OWN = '''
"""Side wind on a tail fin."""
import numpy as np
from infotraj.effects import Effect, Parameter

class TailFin(Effect):
    """Torque -k v_y |v_y| about z: a fin behind the centre."""
    name, place = "tail_fin", "wrench"
    parameters = (Parameter("k", "N s^2/m", 0.01, (0.0, 1.0)),)
    needs = needs_to_act = ("velocity",)
    def wrench(self, along):
        side = along.velocity[:, 1]
        return np.outer(-self.k * side * abs(side), [0, 0, 0, 0, 0, 1.0])
'''


@pytest.fixture
def own_file(tmp_path):
    path = tmp_path / "fin.py"
    path.write_text(OWN)
    return path


def flight():
    t = np.arange(400) / 200
    columns = {"t": t, "qw": np.ones(400), "pz": np.ones(400), "px": 0 * t, "py": np.sin(2 * t)}
    columns |= {c: 0 * t for c in ("qx", "qy", "qz", "wx", "wy", "wz", "ax", "ay")} | {"az": 0 * t + 9.81}
    columns |= {f"cmd_rotor_{i}": 1100 + 50 * np.sin(9 * t + i) for i in range(4)}
    return Flight(pd.DataFrame(columns))


def test_the_names_and_parameters_are_those_of_the_specification():
    found = {name: {p.name for p in cls.parameters} for name, cls in catalogue().items()}
    assert found == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_of_absent_values_changes_nothing_and_is_documented(name):
    cls = effect_class(name)
    assert cls.__doc__
    assert cls.source
    vehicle = load_vehicle(VEHICLES / "omav.yaml")
    assert cls().is_absent(vehicle)
    for p in cls.parameters:
        low, high = cls.bounds(vehicle, p)
        assert np.all(np.asarray(low) < high)
        if not p.index:
            assert np.all((low <= cls.absent(vehicle, p)) & (cls.absent(vehicle, p) <= high))
            assert np.all(cls.scale(vehicle, p) != 0.0)


@pytest.mark.parametrize("name", USUAL)
def test_scales_are_the_usual_sizes(name):
    cls = effect_class(name)
    for file, (low, high) in USUAL[name].items():
        scale = cls.scale(load_vehicle(VEHICLES / f"{file}.yaml"), cls.parameters[0])
        assert low * 0.999 <= np.max(scale) <= high * 1.001


def test_wrong_values_are_named_in_one_line():
    drag = effect_class("linear_drag")
    for values, word in (({"d": [1, 2]}, "d is"), ({"d": ["x", 0, 0]}, "d is"), ({"k": 1}, "unknown parameter k")):
        with pytest.raises(InputError, match=word) as caught:
            drag(**values)
        assert "\n" not in str(caught.value)
    quadrotor = load_vehicle(VEHICLES / "quadrotor.yaml")
    with pytest.raises(InputError, match="0 to 3"):
        Model(quadrotor, [effect_class("rotor_effectiveness")(rotor=4, factor=0.9)])
    with pytest.raises(InputError, match="one a tilt"):
        Model(load_vehicle(VEHICLES / "omav.yaml"), [effect_class("servo_bias")(bias=[0.1, 0.1])])
    with pytest.raises(UsageError, match="twice"):
        Model(quadrotor, [drag(), drag()])
    with pytest.raises(UsageError, match="linear_drag"):
        effect_class("liner_drag")
    with pytest.raises(UsageError) as caught:
        effect_class("drag")
    assert str(caught.value).startswith("no effect 'drag'; expected linear_drag or quadratic_drag or rotor_drag. The")


def test_what_cannot_show_is_said_with_a_reason():
    quadrotor = load_vehicle(VEHICLES / "quadrotor.yaml")
    f = flight()
    hidden = {name: cls.cannot_show(quadrotor, f) for name, cls in catalogue().items()}
    assert {n for n, reason in hidden.items() if reason} == {
        *("coaxial_loss", "rotor_interference", "servo_lag", "servo_rate_limit", "servo_backlash", "servo_bias"),
        "telemetry_offset",
    }
    commands = [f"cmd_rotor_{i}" for i in range(4)]
    measured = Flight(f.table.rename(columns={c: c[4:] for c in commands}))
    for name in ("rotor_lag", "actuation_delay"):
        assert "commands" in effect_class(name).cannot_show(quadrotor, measured)
    assert effect_class("telemetry_offset").cannot_show(quadrotor, measured) is None
    unfelt = Flight(measured.table.drop(columns=["ax", "ay", "az"]))
    assert "specific force" in effect_class("telemetry_offset").cannot_show(quadrotor, unfelt)
    derived = Flight(f.table, {"derived": ["wx", "wy", "wz"]})
    assert "derived" in effect_class("gyro_bias").cannot_show(quadrotor, derived)
    high = Flight(f.table.assign(pz=5.0))
    assert "radii" in effect_class("ground_effect").cannot_show(quadrotor, high)
    blind = Flight(f.table.drop(columns=["px", "py", "pz", "qw", "qx", "qy", "qz"]))
    for name in ("linear_drag", "ground_effect", "steady_force", "suspended_load"):
        assert effect_class(name).cannot_show(quadrotor, blind)
    slow = f.table.copy()
    slow.loc[slow.index % 20 != 0, commands] = np.nan
    assert "100 ms" in effect_class("rotor_lag").cannot_show(quadrotor, Flight(slow))


def test_an_effect_of_ones_own_is_one_file(own_file, monkeypatch):
    assert "tail_fin" not in catalogue()
    cls = effect_class("tail_fin", [own_file])
    assert effect_class("tail_fin", [own_file.parent]) is cls
    monkeypatch.setenv("INFOTRAJ_EFFECTS", str(own_file))
    assert catalogue()["tail_fin"] is cls
    quadrotor = load_vehicle(VEHICLES / "quadrotor.yaml")
    f = flight()
    difference = (
        Model(quadrotor, [cls(k=0.02)]).predict(f).angular_acceleration
        - Model(quadrotor).predict(f).angular_acceleration
    )
    side = 2 * np.cos(2 * f.t)
    np.testing.assert_allclose(difference[2:-2, 2], (-0.02 * side * abs(side) / 0.0105)[2:-2], rtol=2e-3, atol=1e-3)
    np.testing.assert_allclose(difference[:, :2], 0.0, atol=1e-12)


def test_an_installed_package_adds_effects_by_an_entry_point(own_file, monkeypatch):
    cls = effect_class("tail_fin", [own_file])

    class Entry:
        name, value, group = "fin", "fin:TailFin", "infotraj.effects"

        def load(self):
            return cls

    monkeypatch.setattr(
        "infotraj.effects.registry.entry_points",
        lambda group: importlib.metadata.EntryPoints([Entry()]) if group == Entry.group else (),
    )
    registry._of_packages.cache_clear()
    try:
        assert catalogue()["tail_fin"] is cls
    finally:
        registry._of_packages.cache_clear()


@pytest.mark.parametrize(
    ("content", "word"),
    [
        ("import nothing_of_that_name", "cannot be imported"),
        ("x = 1", "holds no effect"),
        (OWN.replace("tail_fin", "linear_drag"), "is taken"),
        (OWN.replace("tail_fin", "inertia_products"), "is taken"),  # a number of the file, which models hold by it
        (OWN.replace('name, place = "tail_fin", "wrench"', 'name = "tail_fin"'), "has no place"),
    ],
)
def test_a_broken_file_is_refused_in_one_line(tmp_path, content, word):
    path = tmp_path / "mine.py"
    path.write_text(textwrap.dedent(content))
    with pytest.raises(InputError, match=word) as caught:
        catalogue([path])
    assert "\n" not in str(caught.value)


_WRENCH = "np.outer(-self.k * side * abs(side), [0, 0, 0, 0, 0, 1.0])"
_FACTOR = OWN.replace("def wrench", "def thrust_factor")


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (OWN.replace(_WRENCH, "np.zeros((along.count, 5))"),
         r"wrench returns an array \(\d+, 5\); expected an array \(N, 6\)"),
        (OWN.replace(_WRENCH, "None"), r"wrench returns nothing; expected an array \(N, 6\)"),
        (OWN.replace("along.velocity[", "along.velocities["), r"wrench, line \d+: AttributeError: .*velocities"),
        (OWN.replace("self.k *", "np.nan *"), r"wrench returns numbers of which 100 % are not finite"),
        (_FACTOR.replace(_WRENCH, "1.0 + self.k * side"),
         r"thrust_factor returns an array \(\d+,\); expected a number"),
        (OWN.replace("def wrench(self, along)", "def body(self, law)").replace("along.velocity", "np.zeros((9, 3))"),
         r"body returns ndarray; expected BodyLaw"),
        (OWN.replace("def wrench", "def rotor_momentum"), r"rotor_momentum returns ndarray; expected two arrays"),
        (OWN + "    @classmethod\n    def hidden(cls, vehicle, flight):\n        return 1 / 0\n",
         "hidden, line .*ZeroDivision"),
    ],
)  # fmt: skip
def test_an_effect_that_fails_is_named_with_its_file_and_its_hook(tmp_path, content, says):
    path = tmp_path / "mine.py"
    path.write_text(content)
    vehicle = load_vehicle(VEHICLES / "quadrotor.yaml")
    own = {"tail_fin": catalogue([path])["tail_fin"]}
    with pytest.raises(InputError, match=says) as caught:
        candidates(own, vehicle, [flight()])
    assert str(caught.value).startswith(f"{path}: tail_fin: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content", [OWN, *(_FACTOR.replace(_WRENCH, x) for x in ("1.1", "np.ones(4)", "np.ones((along.count, 1))"))]
)
def test_an_effect_that_is_right_is_a_candidate(tmp_path, content):
    path = tmp_path / "mine.py"
    path.write_text(content)
    own = {"tail_fin": catalogue([path])["tail_fin"]}
    known, hidden = candidates(own, load_vehicle(VEHICLES / "quadrotor.yaml"), [flight()])
    assert [c.label for c in known] == ["tail_fin"]
    assert hidden == {}


def test_the_command_lists_and_shows(own_file, tmp_path):
    run = CliRunner()
    listed = run.invoke(effects_command, ["--json", str(tmp_path / "c.json")])
    assert listed.exit_code == 0
    assert all(name in listed.output for name in NAMES)
    assert [e["name"] for e in json.loads((tmp_path / "c.json").read_text())] == list(catalogue())
    shown = run.invoke(effects_command, ["show", "com_offset"])
    assert "Featherstone" in shown.output
    assert "r (m) x 3" in shown.output
    assert "tail_fin" in run.invoke(effects_command, ["--effects", str(own_file)]).output
    assert isinstance(run.invoke(effects_command, ["show", "nonsense"]).exception, UsageError)


def test_an_effect_without_a_hook_of_its_own_leaves_the_model_alone():
    class Nothing(Effect):
        """Nothing."""

        name, place, parameters = "nothing", "wrench", (Parameter("x", "-", 1.0, (0.0, 1.0)),)

    quadrotor = load_vehicle(VEHICLES / "quadrotor.yaml")
    f = flight()
    np.testing.assert_array_equal(
        Model(quadrotor, [Nothing(x=1.0)]).predict(f).specific_force, Model(quadrotor).predict(f).specific_force
    )


def test_the_momentum_of_rotors_on_arms_that_tilt_changes_as_their_slope_says():
    vehicle = load_vehicle(VEHICLES / "omav.yaml")
    rotors, tilts = len(vehicle.rotors), len(vehicle.tilts)
    rng = np.random.default_rng(0)
    speed, rise = rng.uniform(300, 900, rotors), rng.uniform(-50, 50, rotors)
    tilt, turning = rng.uniform(-1, 1, tilts), rng.uniform(-2, 2, tilts)
    effect = catalogue()["gyroscopic"](rotor_inertia=3e-5)

    def along(t):
        now = Actuation(*(x[None] for x in (speed + t * rise, rise, tilt + t * turning, turning)))
        return Along(vehicle, Motion(np.zeros(1), None, None, None, None, None), now)

    h = 1e-5
    before, after = (effect.rotor_momentum(along(t))[0] for t in (-h, h))
    np.testing.assert_allclose(effect.rotor_momentum(along(0.0))[1], (after - before) / (2 * h), rtol=1e-6, atol=1e-9)
