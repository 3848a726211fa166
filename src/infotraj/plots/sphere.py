"""Fig. 3: how well a body-fixed vector follows the reference attitude, on the unit sphere."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from infotraj import rotations
from infotraj.errors import InputError, problem
from infotraj.plots import style
from infotraj.rotations import Array

VECTOR = np.ones(3) / np.sqrt(3.0)


def figure_3(reference: ArrayLike, flown: Mapping[str, ArrayLike], pdf: str | Path, png: str | Path) -> None:
    """Writes Fig. 3: the body vector (1, 1, 1)/sqrt(3) of attitudes (n, 4), quaternions w, x, y, z.

    reference: what was asked for; flown: what was flown with the model learned from each source (task, random, paper,
    informative). Right: the same curves unrolled around the vector's mean, in degrees.
    InputError where one is not (n, 4).
    """
    for name, attitude in {"reference": reference, **flown}.items():
        shape = np.shape(attitude)
        if len(shape) != 2 or shape[1] != 4 or shape[0] < 2:
            raise InputError(problem(f"figure 3: {name} has shape {shape}", "(n, 4), n > 1", "Hand in quaternions."))
    style.write(lambda: draw_figure_3(reference, flown), pdf, png)


def draw_figure_3(reference: ArrayLike, flown: Mapping[str, ArrayLike]) -> Figure:
    """The figure itself; arguments as in `figure_3`."""
    curves = {style.LABELS[name]: (tips(attitude), style.COLORS[name], "-", 1.0) for name, attitude in flown.items()}
    curves["reference orientation"] = (tips(reference), style.INK, "--", 0.9)
    center = rotations.normalize(np.mean(tips(reference), axis=0))
    figure = style.figure(style.DOUBLE, 3.2)
    globe = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False)
    assert isinstance(globe, Axes3D)
    flat = figure.add_subplot(1, 2, 2)
    _add_globe(globe, center)
    for name, (curve, color, dashes, width) in curves.items():
        globe.plot(*curve.T, dashes, color=color, lw=width, label=name, zorder=3)
        flat.plot(*np.degrees(unrolled(curve, center)).T, dashes, color=color, lw=width)
    flat.set_aspect("equal")
    flat.margins(0.08)
    flat.set_xlabel("east of the mean [deg]")
    flat.set_ylabel("north of the mean [deg]")
    figure.legend(*globe.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def tips(attitude: ArrayLike) -> Array:
    """The body vector in the world frame, (n, 3), unit length."""
    return rotations.to_world(rotations.normalize(attitude), VECTOR)


def unrolled(points: Array, center: Array) -> Array:
    """Azimuthal equidistant map of unit vectors (n, 3) around `center` (3,): east and north (n, 2), rad."""
    east = rotations.normalize(np.cross([0.0, 0.0, 1.0], center))
    north = np.cross(center, east)
    angle = np.arccos(np.clip(points @ center, -1.0, 1.0))
    return (points @ np.column_stack([east, north])) / np.sinc(angle / np.pi)[:, None]


def _add_globe(axes: Axes3D, center: Array) -> None:
    around, down = np.linspace(0, 2 * np.pi, 37), np.linspace(0, np.pi, 19)
    x, y, z = np.outer(np.cos(around), np.sin(down)), np.outer(np.sin(around), np.sin(down)), np.cos(down)
    axes.plot_surface(
        x, y, np.tile(z, (len(around), 1)), color="#F4F6F8", edgecolor="#D5DAE0", lw=0.3, shade=False, zorder=1
    )
    elevation = np.degrees(np.arcsin(center[2]))
    axes.view_init(elev=elevation, azim=np.degrees(np.arctan2(center[1], center[0])) - 12)
    axes.set(xlabel="x [-]", ylabel="y [-]", zlabel="z [-]")
    axes.set_box_aspect((1, 1, 1), zoom=1.1)
    ticks = [-1, -0.5, 0, 0.5, 1]
    axes.set(xticks=ticks, yticks=ticks, zticks=ticks)
    axes.tick_params(labelsize=7, pad=-2)
    sides: tuple[Any, ...] = (axes.xaxis, axes.yaxis, axes.zaxis)
    for axis in sides:
        axis.pane.set_visible(False)
        axis.labelpad = -6
    axes.grid(False)
