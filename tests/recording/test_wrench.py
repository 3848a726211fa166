"""What the viewer says of a model along a flight: units, effects apart from corrections of the file, the time."""

from pathlib import Path

import fast_flyer
from rerun.chunk import RrdReader

from infotraj.comparing import equation_error
from infotraj.effects import catalogue
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.recording import read_back
from infotraj.recording.wrench import record_comparison
from infotraj.vehicle import load_vehicle

QUADROTOR = Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml"


def test_the_viewer_opens_at_the_start_and_says_units_and_what_the_model_holds(tmp_path):
    path, effects = tmp_path / "f.rrd", catalogue()
    scaled = [effects["rotor_effectiveness"](rotor=k, factor=0.99) for k in (0, 2)]
    model = Model(load_vehicle(QUADROTOR), [effects["linear_drag"](d=[0.1, 0.1, 0.1]), *scaled])
    flight = Flight(fast_flyer.fly(QUADROTOR, 3.0, 2))
    record_comparison(path, flight, model, equation_error(model, flight), [e.label for e in scaled])
    about = read_back(path)["about"]["TextDocument:text"][0]
    assert about.startswith("**quadrotor with linear_drag**")
    assert "The vehicle file is corrected by rotor_effectiveness (0 2)." in about
    for axis in ("fx", "fy", "fz"):
        assert f"{axis} [N]: measured and predicted" in titles(path)
        assert f"{axis} [N]: measured - predicted, band of the noise" in titles(path)
        assert f"t{axis[1]} [N m]: measured and predicted" in titles(path)
    # Served, as the app does, the viewer would follow what comes in, and so open at the end.
    assert layout(path, "TimePanelBlueprint:play_state") == [[1]]

    record_comparison(path, flight, model, equation_error(model, flight))
    about = read_back(path)["about"]["TextDocument:text"][0]
    assert about.startswith("**quadrotor with linear_drag, rotor_effectiveness (0 2)**")
    assert "corrected" not in about


def titles(path):
    return [title for (title,) in layout(path, "ViewBlueprint:display_name")]


def layout(path, column):
    """All values that the layout of a recording holds in a column."""
    reader = RrdReader(str(path))
    batches = [chunk.to_record_batch() for chunk in reader.stream(store=reader.blueprints()[0])]
    return [value for b in batches if column in b.schema.names for value in b.column(column).to_pylist()]
