"""A reference: what a vehicle is asked to fly, and its CSV file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import make_interp_spline

from infotraj import rotations
from infotraj.errors import InputError, problem
from infotraj.rotations import Array
from infotraj.writing import whole

COLUMNS = {
    "position": ("ref_px", "ref_py", "ref_pz"),
    "attitude": ("ref_qw", "ref_qx", "ref_qy", "ref_qz"),
    "velocity": ("ref_vx", "ref_vy", "ref_vz"),
    "rate": ("ref_wx", "ref_wy", "ref_wz"),
    "acceleration": ("ref_ax", "ref_ay", "ref_az"),
    "angular_acceleration": ("ref_alphax", "ref_alphay", "ref_alphaz"),
}


@dataclass(frozen=True)
class Reference:
    """A reference trajectory on a uniform time grid of n samples.

    t (n,) s; position (n, 3) m, world; attitude (n, 4) body to world; velocity (n, 3) m/s, world;
    rate (n, 3) rad/s, body; acceleration (n, 3) m/s^2, world; angular_acceleration (n, 3) rad/s^2, body.
    """

    t: Array
    position: Array
    attitude: Array
    velocity: Array
    rate: Array
    acceleration: Array
    angular_acceleration: Array

    @property
    def dt(self) -> float:
        """The sample time (s)."""
        return float(self.t[1] - self.t[0])

    def table(self) -> pd.DataFrame:
        """The reference as the columns of its file."""
        columns: dict[str, Array] = {"t": self.t}
        for name, labels in COLUMNS.items():
            columns.update(zip(labels, getattr(self, name).T, strict=True))
        return pd.DataFrame(columns)

    def write(self, path: str | Path) -> None:
        """Writes the reference file (CSV), whole or not at all."""
        with whole(Path(path)) as part:
            self.table().to_csv(part, index=False, float_format="%.12g")


def from_poses(t: Array, position: Array, attitude: Array) -> Reference:
    """The reference that passes through the given poses: derivatives from quintic splines through them.

    t (n,) s, uniform, n >= 6; position (n, 3) m, world; attitude (n, 4), body to world. For a unit quaternion
    q' = q w / 2, hence w = 2 vec(q* q') and dw/dt = 2 vec(q* q'') (Sola 2017, eq. 199).
    """
    path = make_interp_spline(t, position, k=5)
    turn = make_interp_spline(t, rotations.continuous(rotations.normalize(attitude)), k=5)
    attitude = rotations.normalize(turn(t))
    back = rotations.conjugate(attitude)
    return Reference(
        t=t,
        position=path(t),
        attitude=attitude,
        velocity=path(t, 1),
        rate=2.0 * rotations.multiply(back, turn(t, 1))[:, 1:],
        acceleration=path(t, 2),
        angular_acceleration=2.0 * rotations.multiply(back, turn(t, 2))[:, 1:],
    )


def read_reference(path: str | Path) -> Reference:
    """Reads a reference file (CSV). InputError, one line, where it is not one."""
    try:
        table = pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise InputError(problem(f"{path}: cannot be read ({error})", "a reference CSV", "Check the path.")) from error
    missing = [c for c in ("t", *sum(COLUMNS.values(), ())) if c not in table]
    if missing:
        raise InputError(problem(f"{path}: no columns {', '.join(missing[:4])}", "a reference CSV", "Add them."))
    table = table.apply(pd.to_numeric, errors="coerce")
    values = {name: table[list(labels)].to_numpy(dtype=float) for name, labels in COLUMNS.items()}
    t = table["t"].to_numpy(dtype=float)
    if not (np.isfinite(t).all() and all(np.isfinite(v).all() for v in values.values())):
        raise InputError(problem(f"{path}: holds cells that are not numbers", "finite numbers", "Complete it."))
    steps = np.diff(t)
    if len(t) < 2 or steps.min() <= 0 or np.ptp(steps) > 1e-6 + 1e-3 * steps.mean():
        raise InputError(problem(f"{path}: t is not uniform", "an increasing t with one step", "Resample it."))
    values["attitude"] = rotations.normalize(values["attitude"])
    return Reference(t=t, **values)
