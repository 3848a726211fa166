"""How the viewer opens a recording: the scene on the left, plots of wrench, errors and residual on the right."""

from __future__ import annotations

import numpy as np
import rerun.blueprint as rrb

from infotraj.recording.stream import TIMELINE
from infotraj.rotations import Array

AXES = ("x", "y", "z")
TORQUE = {f"torque/{a}": f"Torque about {a} [N m]" for a in AXES}
ATTITUDE = {"error/attitude": "Attitude error [deg]"}
ACCELERATION = {"error/angular_acceleration": "Angular acceleration error [rad/s^2]: achieved - demanded"}
# Each tab's plots: the entity whose series it shows, and its title.
TABS = {
    "Torque and error": {**TORQUE, **ATTITUDE},
    "Residual": {
        f"residual/{a}": f"Residual torque about {a} [N m]: seen (achieved - commanded) and learned" for a in AXES
    },
    "Force": {f"force/{a}": f"Force along {a} [N], body frame" for a in AXES},
    "Errors": {"error/position": "Position error [m]", **ATTITUDE, **ACCELERATION},
}


def blueprint(center: Array, extent: float, size: float, spans: dict[str, tuple[float, float]]) -> rrb.Blueprint:
    """The layout for a path with middle `center` (3,) m and `extent` m, and a vehicle that reaches `size` m.

    `spans` maps every recorded series to its smallest and largest value; a plot without a series is left out.
    """
    distance = max(3.6 * size, 1.3 * extent)
    eye = center + distance * np.array([-0.55, -0.72, 0.42])
    scene = rrb.Spatial3DView(
        origin="world",
        name="Vehicle: thrust (orange arrows), flown (green), reference (yellow)",
        eye_controls=rrb.EyeControls3D(
            position=eye, look_target=center + np.array([0, 0, 0.3 * size]), eye_up=[0, 0, 1]
        ),
        line_grid=rrb.LineGrid3D(visible=True, spacing=max(0.1, round(size, 1))),
    )
    tabs = [rrb.Vertical(*views, name=name) for name, plots in TABS.items() if (views := _views(plots, spans))]
    left = rrb.Vertical(scene, rrb.TextDocumentView(origin="about", name="About"), row_shares=[4, 1.2])
    right = [rrb.Tabs(*tabs, active_tab=0)] if tabs else []
    return rrb.Blueprint(
        rrb.Horizontal(left, *right, column_shares=[1.05, 1] if right else [1]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )


def _views(plots: dict[str, str], spans: dict[str, tuple[float, float]]) -> list[rrb.TimeSeriesView]:
    found = []
    for origin, title in plots.items():
        inside = [span for entity, span in spans.items() if entity.startswith(f"{origin}/")]
        if inside:
            low, high = min(s[0] for s in inside), max(s[1] for s in inside)
            margin = 0.08 * (high - low) or 1.0
            view = rrb.TimeSeriesView(
                origin=origin,
                name=title,
                axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
                axis_y=rrb.ScalarAxis(range=(low - margin, high + margin)),
                plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
            )
            found.append(view)
    return found
