"""The battery as it drains: what it leaves of the thrust, row by row, and the voltage that a log holds."""

from __future__ import annotations

import numpy as np

from infotraj.robots.plant.hidden import Pack, Sag
from infotraj.rotations import Array


class Drain:
    """A supply over one flight. `advance` once a row of `period` s; rows before the flight's first do not drain it."""

    def __init__(self, supply: Sag | Pack, period: float, rng: np.random.Generator) -> None:
        self.supply, self._period, self._rng = supply, period, rng
        self._t = self._charge = 0.0
        self.volts = self._logged = supply.full if isinstance(supply, Pack) else np.nan
        self._shown = self._logged
        self._every = max(1, round(supply.log_period / period)) if isinstance(supply, Pack) else 1
        self._row = 0

    def advance(self, speed: Array, started: bool) -> float:
        """The thrust's factor at this row, with the rotors at `speed` (rotors,) rad/s."""
        s = self.supply
        if isinstance(s, Sag):
            factor = 1.0 - s.rate * self._t
        else:
            open_circuit = s.full - s.slope * self._charge
            power = s.power_coefficient * float(np.sum(np.abs(speed) ** 3))
            # the higher root of V^2 - E V + R P = 0; beyond the greatest power the voltage is half of E
            self.volts = 0.5 * (open_circuit + np.sqrt(max(open_circuit**2 - 4.0 * s.resistance * power, 0.0)))
            if started:
                self._charge += power / self.volts * self._period
            factor = max((self.volts / s.nominal - s.blind) / (1.0 - s.blind), 0.0) ** s.exponent
        self._t += self._period if started else 0.0
        return factor

    def log(self) -> float:
        """The voltage (V) that this row of the log holds; NaN without a measurement."""
        s = self.supply
        if isinstance(s, Sag):
            return np.nan
        share = 1.0 - np.exp(-self._period / s.log_lag) if s.log_lag > 0 else 1.0
        self._logged += share * (self.volts - self._logged)
        if self._row % self._every == 0:
            shown = self._logged + s.log_noise * self._rng.standard_normal()
            self._shown = round(shown / s.log_step) * s.log_step if s.log_step > 0 else shown
        self._row += 1
        return self._shown
