"""The air around the body: that it moves, and where its drag acts. Both act only through effects that it makes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.laws import AirLaw
from infotraj.effects.rigid_body import arm_length
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_UPWARDS, _MOST_UPWARDS = 0.5, 3.0  # m/s


class Wind(Effect):
    """The air moves with v, world axes: what it does follows from R^T (v_body - v) in place of the body's velocity.

    One constant value for all flights of a model. Every effect of the air sees it: the drags, axial inflow, hub moment,
    translational lift. Without any of them in the model it changes nothing: wind then shows as steady_force, and with
    the same drag on all three axes that is not linear in the model it cannot be told from one.
    """

    name = "wind"
    place = "wrench"
    parameters = (Parameter("v", "m/s", 3.0, (-25.0, 25.0), size=3, meaning="of the air, world axes, z up"),)
    v: Array
    needs = ("velocity",)
    needs_to_act = needs
    beside = ("rotor_drag", "linear_drag", "quadratic_drag", "axial_inflow", "hub_moment", "translational_lift")
    source = "Leishman, Principles of Helicopter Aerodynamics, 2.14 (velocity against the undisturbed air)"
    hidden_when = "no effect of the air is in the model: it then shows as steady_force"

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> Array:
        """Near the ground the mean wind is level: its vertical part is that of slopes and thermals (Stull 1988)."""
        return np.array([parameter.scale, parameter.scale, _UPWARDS])

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[Array, Array]:
        low, high = parameter.bounds
        return np.array([low, low, -_MOST_UPWARDS]), np.array([high, high, _MOST_UPWARDS])

    def air(self, law: AirLaw) -> AirLaw:
        return replace(law, wind=law.wind + self.v)


class PressureCentre(Effect):
    """Linear and quadratic drag act at r instead of the body's origin: torque r x F, body axes.

    Without one of them in the model it changes nothing.
    """

    name = "pressure_centre"
    place = "wrench"
    parameters = (Parameter("r", "m", 0.02, (-0.2, 0.2), size=3, meaning="where the body's drag acts, body axes"),)
    r: Array
    needs = ("inertia", "velocity", "rate")
    needs_to_act = ("velocity",)
    beside = ("linear_drag", "quadratic_drag")
    source = "Etkin, Dynamics of Atmospheric Flight (1972), 6.3 (moment of a resultant force off the reference point)"
    hidden_when = "neither linear nor quadratic drag is in the model"
    # 1 % of an arm: no drawing says where the air pushes.
    declared = Declared("air", 1 / 10, "where the body's drag acts, further along {axis} by")

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.1 * arm_length(vehicle)

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        reach = arm_length(vehicle)
        return -reach, reach

    def air(self, law: AirLaw) -> AirLaw:
        return replace(law, pressure_centre=law.pressure_centre + self.r)
