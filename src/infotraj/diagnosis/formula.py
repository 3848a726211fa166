"""Whether an effect's formula holds: numbers that change with the motion belong to another cause.

An effect that is in no catalogue is often taken up by one that does nearly the same in these flights: a torque that
stays in the world while the vehicle turns by a steady_torque, an arm that bends under its rotor by a servo_bias, a mass
that sloshes by a com_offset. So each number of an effect may change in proportion to one named quantity (heading,
speed, thrust, place; varying coefficients, Hastie and Tibshirani 1993), or differ between what is fast and what is
slow, and what that gains on held-out flights is weighed against what the effect explains. The numbers of a true effect
gain nothing. Change with time alone is the business of `constancy`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.signal import lfilter

from infotraj.diagnosis.evidence import resampled
from infotraj.diagnosis.features import named
from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.leftover import left_over
from infotraj.diagnosis.observation import Member
from infotraj.diagnosis.residual import Channel
from infotraj.diagnosis.search import Search
from infotraj.diagnosis.sensitivities import sensitivities
from infotraj.diagnosis.sums import extended_sums, held_out, products
from infotraj.diagnosis.whitened import whiten
from infotraj.rotations import Array

_EXACT = 0.005  # of what an effect of mechanics explains: as much or more is gained by numbers that change
_APPROXIMATE = 0.1  # the same of an effect whose formula approximates: drag, inflow, lags
_PACE = 0.5  # the same between what is fast and what is slow: a noisy velocity alone makes some of that
_ITSELF = 0.15  # of the effect's own rise: with such a rise the change need not matter on its own
_SURE = 0.05  # of the resamples may show no gain
_QUANTITIES = (
    *("R11", "R21", "R31", "R32", "R33"),
    *("vx body", "vy body", "vz body", "|v|", "wx", "wy", "wz", "px", "py", "pz"),
    *("predicted fx", "predicted fy", "predicted fz", "mean rotor command"),
)
_SLOW = (0.05, 0.15, 0.5, 1.5)  # s: time constants that part fast from slow


@dataclass(frozen=True)
class Misfit:
    """Numbers of an effect that change. how: with what, in words; axis, rise: where it shows most, in units of the
    floor; share: of the squared error that the effect explains, gained on held-out flights; gain: that error."""

    how: str
    axis: str
    rise: float
    share: float
    gain: float = 0.0


class Formulas:
    """Tests the members of one fitted model."""

    def __init__(self, search: Search, whole: Fit, rng: np.random.Generator) -> None:
        self._search, self._whole = search, whole
        o = search.observation
        self._draws = resampled(o.blocks.flight, rng)
        self._own = sensitivities(o, whole.members, [])
        left = left_over(search, whole)
        self._left = [[x[:, :, None] for x in flight] for flight in left]
        columns = [1 + c for c in self._own.of_members]
        joint = [[x[:, :, columns] for x in flight] for flight in self._own.joint]
        self._others = [whiten(s, o.noise, x) for s, x in zip(o.samples, joint, strict=True)]
        self._known = products(o.samples, o.blocks, self._others)
        self._quantities = self._standardised()

    def misfit(self, m: Member, explained: float, rise: float) -> Misfit | None:
        """How far the numbers of a member change, None where they do not or where resampled blocks gain nothing by it.

        explained: squared error that it takes away; rise: its own.
        """
        exact = type(m.effect).exact
        worst = None
        for quantity in self._ways(m):
            gain, sure, rises = self._gained(m, quantity)
            axis, most = max(rises.items(), key=lambda item: item[1])
            part = gain / max(explained, 1e-300)
            share = _EXACT if exact else _APPROXIMATE if quantity in self._quantities else _PACE
            clear = part > share and most > self._search.matters
            itself = part > max(share, _APPROXIMATE) and most > _ITSELF * rise
            if sure and (clear or itself) and (worst is None or gain > worst.gain):
                worst = Misfit(_how(quantity), axis, most, part, gain)
        return worst

    def _ways(self, m: Member) -> list[str]:
        # What a lag or a limit of an actuator says of its dynamics is never quite right.
        paces = () if m.candidate.cls.place == "actuators" and not type(m.effect).exact else _SLOW
        return [*self._quantities, *(f"{tau} s" for tau in paces)]

    def _gained(self, m: Member, quantity: str) -> tuple[float, bool, dict[str, float]]:
        """Fall of the held-out squared error when the numbers of `m` change with a quantity, whether resamples have it
        too, and the rise by axis."""
        o = self._search.observation
        place = [x.candidate.label for x in self._whole.members].index(m.candidate.label)
        mine = [1 + c for c in self._own.members[place]]
        new = []
        for number, s in enumerate(o.samples):
            parts = []
            for k, channel in enumerate(s.channels):
                own = self._own.joint[number][k][:, :, mine]
                changed = (
                    own * self._quantities[quantity][number][k][:, None, None]
                    if quantity in self._quantities
                    else _slow_part(own, channel, float(quantity.split()[0]))
                )
                parts.append(np.concatenate([self._left[number][k], changed], axis=2))
            new.append(whiten(s, o.noise, parts))
        sums = extended_sums(o.samples, o.noise, o.blocks, new, self._others, self._known)
        without = list(range(len(mine), sums.gram.shape[-1]))
        fall = held_out(sums, without)[0] - held_out(sums)[0]
        rises = fall.sum(axis=1) / np.maximum(sums.windows.sum(axis=1), 1)
        sure = np.quantile(self._draws @ fall.sum(axis=0), _SURE) > 0
        return float(fall.sum()), bool(sure), dict(zip(sums.axes, map(float, rises), strict=True))

    def _standardised(self) -> dict[str, list[list[Array]]]:
        """Named quantities at the samples of every flight and channel, mean 0, variance 1; without constant ones."""
        o = self._search.observation
        model = o.model(self._whole.members)
        every = []
        for s in o.samples:
            prediction = model.predict(s.prepared)
            # A step between rows is the effect's work in the middle of it.
            every.append([named(s, prediction, s.times(c) - 0.5 * c.step * c.difference) for c in s.channels])
        out = {}
        for quantity in _QUANTITIES:
            if not all(quantity in channel for flight in every for channel in flight):
                continue
            values = np.concatenate([channel[quantity] for flight in every for channel in flight])
            mean, size = values.mean(), values.std()
            if size > 1e-6 * max(1.0, abs(mean)):
                out[quantity] = [[(channel[quantity] - mean) / size for channel in flight] for flight in every]
        return out


def _how(quantity: str) -> str:
    return f"between what is faster and slower than {quantity}" if quantity.endswith(" s") else f"with {quantity}"


def _slow_part(x: Array, channel: Channel, tau: float) -> Array:
    """Columns (m, 3, c) after a low-pass filter of first order, run by run."""
    a = np.exp(-channel.step / tau)
    out = np.empty_like(x)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(channel.run)) + 1, [len(x)]])
    for start, stop in pairwise(starts):
        out[start:stop] = lfilter([1 - a], [1, -a], x[start:stop], axis=0, zi=a * x[start : start + 1])[0]
    return out
