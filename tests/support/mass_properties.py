"""What a plant weighs and where, added up over the bodies that MuJoCo made of it."""

import mujoco
import numpy as np


def mass_properties(bodies):
    """Total mass (kg), centre of mass (3,) m and inertia about it (3, 3) kg m^2 in the body's frame, as placed."""
    m, d = bodies.model, bodies.data
    mujoco.mj_forward(m, d)
    body = d.xmat[1].reshape(3, 3)
    masses = m.body_mass[1:]
    center = masses @ d.xipos[1:] / masses.sum()
    inertia = np.zeros((3, 3))
    for mass, place, turned, principal in zip(masses, d.xipos[1:], d.ximat[1:], m.body_inertia[1:], strict=True):
        axes, r = turned.reshape(3, 3), place - center
        inertia += axes @ np.diag(principal) @ axes.T + mass * (np.dot(r, r) * np.eye(3) - np.outer(r, r))
    return float(masses.sum()), body.T @ (center - d.xpos[1]), body.T @ inertia @ body
