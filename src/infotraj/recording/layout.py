"""How the viewer opens a recording: the scene on the left, plots of wrench, errors and residual on the right."""

from __future__ import annotations

import numpy as np
import rerun.blueprint as rrb

from infotraj.recording.stream import TIMELINE
from infotraj.rotations import Array

AXES = ("x", "y", "z")


def blueprint(center: Array, extent: float, size: float, present: set[str]) -> rrb.Blueprint:
    """The layout for a path with middle `center` (3,) m and `extent` m, a vehicle of `size` m, and what is recorded.

    `present` holds the groups that have data: force, torque, error/position, error/attitude,
    error/angular_acceleration, residual. A plot without data is left out.
    """
    distance = max(4.2 * size, 1.3 * extent)
    eye = center + distance * np.array([-0.55, -0.72, 0.42])
    scene = rrb.Spatial3DView(
        origin="world",
        name="Vehicle: thrust (orange arrows), flown (green), reference (yellow)",
        eye_controls=rrb.EyeControls3D(
            position=eye, look_target=center + np.array([0, 0, 0.3 * size]), eye_up=[0, 0, 1]
        ),
        line_grid=rrb.LineGrid3D(visible=True, spacing=max(0.1, round(size, 1))),
    )
    tabs = [rrb.Vertical(*views, name=name) for name, views in _plots(present).items() if views]
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


def _plots(present: set[str]) -> dict[str, list[rrb.View]]:
    def each_axis(group: str, title: str) -> list[rrb.View]:
        return [_plot(f"{group}/{a}", f"{title.format(axis=a)}") for a in AXES] if group in present else []

    errors = {
        "error/position": "Position error [m]",
        "error/attitude": "Attitude error [deg]",
        "error/angular_acceleration": "Angular acceleration error [rad/s^2]: achieved minus commanded, over inertia",
    }
    shown = {group: _plot(group, title) for group, title in errors.items() if group in present}
    overview = each_axis("torque", "Torque about {axis} [N m]")
    overview += [shown[g] for g in ("error/attitude",) if g in shown]
    return {
        "Torque and error": overview,
        "Residual": each_axis("residual", "Residual torque about {axis} [N m]: seen, learned, two sigma"),
        "Force": each_axis("force", "Force along {axis} [N], body frame"),
        "Errors": list(shown.values()),
    }


def _plot(origin: str, title: str) -> rrb.View:
    return rrb.TimeSeriesView(
        origin=origin,
        name=title,
        axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
    )
