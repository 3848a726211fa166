"""Where a further flight of a study may be, and how fast: what the options of `infotraj design` say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from infotraj.design.design import room_of
from infotraj.design.paths import Room as Around
from infotraj.experiment.common.strict_yaml import Strict
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import Positive


class Room(Strict):
    """What the next flight may do, as the command's options say it."""

    box: tuple[Positive, Positive, Positive] = Field(description="m")
    seconds: Positive
    max_speed: Positive = Field(description="m/s")
    max_tilt: Positive = Field(description="deg")

    def around(self, flown: Sequence[Flight], model: Model) -> Around:
        """The room around these flights, as the command makes it of its options."""
        return room_of(flown, self.box, self.seconds, self.max_speed, float(np.deg2rad(self.max_tilt)), model)
