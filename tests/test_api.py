"""The commands from Python: the same door, the same answers, and nothing loaded before it is needed."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import infotraj
from infotraj.api import Diagnosed
from infotraj.comparing.command import compare_command
from infotraj.errors import InputError, UsageError
from infotraj.flight import Flight

QUAD = Path(__file__).parents[1] / "examples" / "quad"
VEHICLE = QUAD / "vehicle.yaml"
FLIGHT = QUAD / "healthy" / "flight_0.parquet"


def test_importing_the_package_loads_nothing():
    code = (
        "import sys, infotraj; assert {'diagnose', 'compare'} <= set(dir(infotraj)); "
        "heavy = {'numpy', 'pandas', 'scipy', 'numba', 'click'} & set(sys.modules); assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    with pytest.raises(AttributeError, match="frobnicate"):
        infotraj.frobnicate  # noqa: B018


def test_an_answer_prints_what_the_command_prints():
    done = CliRunner().invoke(compare_command, [str(QUAD / "vehicle.yaml"), str(FLIGHT), "-q"])
    assert done.exit_code == 0, done.output
    made = infotraj.compare(QUAD / "vehicle.yaml", FLIGHT)
    assert str(made) == repr(made)
    assert [line.split(":")[-1] for line in str(made).splitlines()] == [
        line.split(":")[-1] for line in done.stdout.splitlines()
    ]


def test_a_flight_in_memory_counts_as_its_file():
    flight = infotraj.read_flight(FLIGHT)
    model = infotraj.load_model(QUAD / "vehicle.yaml")
    one, other = infotraj.compare(model, [flight]), infotraj.compare(QUAD / "vehicle.yaml", str(FLIGHT))
    assert one.as_dict() == other.as_dict()
    where = infotraj.locate(model, flight, reference=FLIGHT.with_name("flight_1.parquet"))
    assert where.healthy is not None
    assert str(where).startswith(("where it fails", "no place"))


@pytest.mark.parametrize("ask", [infotraj.locate, infotraj.diagnose])
def test_no_flight_is_its_own_reference(ask):
    with pytest.raises(UsageError, match="is asked about and healthy at once"):
        ask(VEHICLE, str(FLIGHT), reference=FLIGHT)
    flight = infotraj.read_flight(FLIGHT)
    for reference in (flight, FLIGHT):
        with pytest.raises(
            InputError, match=r"holds the same numbers as .*flight_0\.parquet, which is asked about \(own_reference\)"
        ):
            ask(VEHICLE, flight, reference=reference)


def test_the_floor_is_that_of_the_new_model_as_the_command_prints_it():
    before, after = (SimpleNamespace(rmse=np.ones(6), floor=np.full(6, floor)) for floor in (0.3, 0.1))
    assert (Diagnosed(SimpleNamespace(before=before, after=after)).errors["floor"] == 0.1).all()


def test_what_check_rejects_is_an_error_here_too():
    flight = infotraj.read_flight(FLIGHT)
    table = flight.table.copy()
    table[["wx", "wy", "wz"]] *= 57.3
    with pytest.raises(InputError, match=r"rate_unit|passes infotraj check"):
        infotraj.diagnose(QUAD / "vehicle.yaml", Flight(table, dict(flight.meta)))


@pytest.mark.parametrize(
    ("flights", "said"),
    [
        ([], "no flight"),
        ([3], "type int"),
        (3, "a flight of type int"),
        (None, "a flight of type NoneType"),
        ({"t": 1}, "a flight of type dict"),
        (pd.DataFrame({"t": [0.0, 1.0]}), r"type DataFrame; .* `infotraj.flight.Flight\(table\)` makes one"),
    ],
)
def test_what_is_no_flight_is_one_line(flights, said):
    with pytest.raises(InputError, match=said) as error:
        infotraj.compare(QUAD / "vehicle.yaml", flights)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: infotraj.compare(None, FLIGHT), "a model of type NoneType; expected a path or a Model"),
        (lambda: infotraj.compare(VEHICLE, FLIGHT, against={}), "a model of type dict"),
        (lambda: infotraj.compare(VEHICLE, FLIGHT, start="5"), "start='5'; expected a time in s"),
        (lambda: infotraj.compare(VEHICLE, FLIGHT, stop=float("nan")), "stop=nan; expected a time in s"),
        (lambda: infotraj.compare(VEHICLE, FLIGHT, start=5, stop=3), "stop=3 is not after start=5"),
        (lambda: infotraj.compare(VEHICLE, FLIGHT, accept=3), "accept of type int"),
        (lambda: infotraj.compare(VEHICLE, FLIGHT, accept=[3]), "accept=.3.; expected codes"),
        (lambda: infotraj.locate(VEHICLE, FLIGHT, seed="a"), "seed='a'; expected a whole number"),
        (lambda: infotraj.diagnose(VEHICLE, FLIGHT, seed=-1), "seed=-1; expected a whole number"),
        (lambda: infotraj.diagnose(VEHICLE, FLIGHT, effects_from=3), "effects_from of type int"),
        (lambda: infotraj.load_model(None), "a model of type NoneType; expected a path"),
        (lambda: infotraj.read_flight(pd.DataFrame()), "a flight of type DataFrame; expected a path"),
        (lambda: infotraj.import_log(3), "a log of type int; expected a path"),
        (lambda: infotraj.import_log("log.ulg", start=5, stop=3), "stop=3 is not after start=5"),
        (lambda: infotraj.save_model(VEHICLE, "new.yaml"), "a model of type PosixPath; expected a Model"),
    ],
)
def test_an_argument_of_another_kind_is_one_line(call, said):
    with pytest.raises(UsageError, match=said) as error:
        call()
    assert "\n" not in str(error.value)


class Named:
    """A path of another library: it has no more than `__fspath__`."""

    def __init__(self, path):
        self.path = path

    def __fspath__(self):
        return str(self.path) if isinstance(self.path, Path) else self.path


def test_a_path_of_another_library_is_one(tmp_path):
    flight = infotraj.read_flight(Named(FLIGHT))
    told = infotraj.compare(Named(VEHICLE), [Named(FLIGHT)]).as_dict()
    assert told == infotraj.compare(VEHICLE, Named(FLIGHT)).as_dict() == infotraj.compare(VEHICLE, FLIGHT).as_dict()
    (tmp_path / "mapping.yaml").write_text("extends: flight_table\n")
    made = infotraj.import_log(Named(FLIGHT), Named(tmp_path / "mapping.yaml"))
    assert len(made.table) == len(flight.table)
    made.write(Named(tmp_path / "again.csv"))
    infotraj.save_model(infotraj.load_model(Named(VEHICLE)), Named(tmp_path / "new.yaml"))
    assert (tmp_path / "again.csv").is_file()
    assert (tmp_path / "new.yaml").is_file()
    with pytest.raises(InputError, match=r"none\.py: no such file"):
        infotraj.diagnose(VEHICLE, FLIGHT, effects_from=Named(tmp_path / "none.py"))
    with pytest.raises(UsageError, match="a flight of type Named; expected a path"):
        infotraj.read_flight(Named(b"flight.parquet"))


def test_one_file_of_effects_may_be_given_alone(tmp_path):
    with pytest.raises(InputError, match=r"none\.py: no such file or folder"):
        infotraj.diagnose(VEHICLE, FLIGHT, effects_from=str(tmp_path / "none.py"))
