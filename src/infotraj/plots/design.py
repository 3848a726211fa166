"""A designed flight: its path from above and from the side, its speed, and what the rotors do, within their limits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from infotraj.plots import style
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference

_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE, style.SKY, style.INK, style.GREY)


def design_figure(reference: Reference, simulated: Array | None, inputs: Array, limits: Any, *paths: Path) -> None:
    """Draws the reference to each path (.pdf or .png).

    simulated: position (n, 3) m of the simulated vehicle, or None; inputs (n, rotors), limits: with `low` and `high`.
    """
    style.write(lambda: _drawn(reference, simulated, inputs, limits), *paths)


def _drawn(r: Reference, simulated: Array | None, inputs: Array, limits: Any) -> Figure:
    figure = style.figure(style.DOUBLE, 4.4)
    above, side, speed, rotor = figure.subplots(2, 2).ravel()
    for panel, (i, j), names in ((above, (0, 1), "xy"), (side, (0, 2), "xz")):
        if simulated is not None and np.isfinite(simulated).all():
            panel.plot(simulated[:, i], simulated[:, j], color=style.VERMILION, lw=0.8, label="simulated")
        panel.plot(r.position[:, i], r.position[:, j], color=style.BLUE, lw=1.2, label="reference")
        panel.plot(r.position[0, i], r.position[0, j], "o", color="black", ms=4, label="begins and ends here")
        panel.set(xlabel=f"{names[0]} [m]", ylabel=f"{names[1]} [m]", aspect="equal")
        panel.set_title("from above" if names == "xy" else "from the side", fontsize=8)
    figure.legend(*above.get_legend_handles_labels(), fontsize=7, ncols=3, loc="outside upper center")
    speed.plot(r.t, np.linalg.norm(r.velocity, axis=1), color=style.BLUE, lw=1.2, label="speed [m/s]")
    speed.plot(r.t, np.linalg.norm(r.rate, axis=1), color=style.ORANGE, lw=1.0, label="rate [rad/s]")
    speed.set(xlabel="t [s]", ylabel="speed, rate", ylim=(0.0, 1.25 * speed.get_ylim()[1]))  # room for the legend
    speed.legend(fontsize=7, ncols=2, loc="upper center")
    if inputs.size and np.isfinite(limits.high).all():
        share = (inputs - limits.low) / (limits.high - limits.low)
        t = np.linspace(r.t[0], r.t[-1], len(share))
        for k, x in enumerate(share.T):
            rotor.plot(t, 100 * x, lw=0.8, color=_COLORS[k % len(_COLORS)], label=f"rotor {k}")
        rotor.set(xlabel="t [s]", ylabel="input [% of range]", ylim=(0, 130), yticks=range(0, 101, 20))
        rotor.axhline(100.0, color=style.GREY, lw=0.8, ls="--")
        rotor.legend(fontsize=7, ncols=min(4, share.shape[1]), loc="upper center")  # above what a rotor can do
    else:
        rotor.set_axis_off()
    return figure
