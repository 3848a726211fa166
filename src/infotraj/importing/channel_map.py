"""One channel of a mapping: its fields, and everything that must be known to turn them into the table's columns.

The keys act in this order, whatever their order in the file: `unit`; `pick`, then `mix`; `absolute`; `scale`; `offset`;
`clip`; for an attitude `order` or `euler` and `rotates`; the frames (`world`, `body`); `axes`, of an
attitude `angle_signs`; `expressed_in` and `gravity_removed`. `shift` moves the time stamps and touches no value;
`remark` touches nothing.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from infotraj.importing.channels import CHANNELS, Resample
from infotraj.importing.frames import BODY_FRAMES, WORLD_FRAMES, axes_matrix
from infotraj.importing.units import SI, conversion
from infotraj.rotations import Array


def as_tuple(value: Any) -> Any:
    """A single name where a list of names is meant."""
    return (value,) if isinstance(value, str) else value


Names = Annotated[tuple[str, ...], BeforeValidator(as_tuple)]
Axes = str | tuple[str, str, str]
Number = Annotated[float, Field(allow_inf_nan=False)]


class Strict(BaseModel):
    """A part of a mapping file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ChannelMap(Strict):
    """One channel in a stream."""

    fields: Names = Field(
        min_length=1, description="in the table's order; `*` counts 0, 1, 2, .. as far as the log goes"
    )
    unit: str | None = Field(None, description="default SI; see `infotraj.importing.units`")
    pick: tuple[Annotated[int, Field(ge=0)], ...] | None = Field(
        None, min_length=1, description="which of the fields, counted from 0, in the order that the table is to have"
    )
    mix: tuple[tuple[Number, ...], ...] | None = Field(
        None, min_length=1, description="each output a weighted sum of the fields, one list of weights an output"
    )
    absolute: bool = Field(False, description="the sign is dropped: rotor speeds that are signed by their direction")
    scale: Number = Field(1.0, description="multiplies the value in SI, for what no unit covers (-1: inverted)")
    offset: Number = Field(0.0, description="added after the scale, in SI")
    clip: tuple[Number, Number] | None = Field(
        None, description="least and greatest value, in SI, where the robot limits what is logged before the limit"
    )
    shift: Number = Field(0.0, description="s, added to the channel's time stamps (a sample logged too late: negative)")
    order: str = Field("wxyz", description="of a quaternion's fields: the letters w, x, y, z as they stand")
    euler: bool = Field(False, description="attitude only: the fields are roll, pitch, yaw; R = Rz(yaw) Ry(pitch) Rx")
    rotates: Literal["body_to_world", "world_to_body"] = Field("body_to_world", description="attitude only")
    expressed_in: Literal["world", "body"] | None = Field(None, description="axes of a vector; default: the table's")
    world: Axes | None = Field(None, description="this channel's world frame; default: the stream's")
    body: Axes | None = Field(None, description="this channel's body frame; default: the stream's")
    axes: tuple[str, str, str] | None = Field(
        None, description="vectors only, after the frames: which axes lie along x, y, z; may mirror ([x, -y, z])"
    )
    angle_signs: tuple[Literal[1, -1], Literal[1, -1], Literal[1, -1]] | None = Field(
        None, description="attitude only, after the frames: signs of roll, pitch, yaw, also of a quaternion"
    )
    gravity_removed: bool = Field(False, description="specific_force only: the log holds acceleration without gravity")
    count: str | None = Field(None, description="field that says how many of the `*` are in use")
    resample: Resample | None = Field(None, description="default: the channel's rule")
    states: dict[int, Literal[0, 1] | None] | None = Field(
        None, description="airborne only: number in the log: 1 in the air, 0 not, null says nothing; others are skipped"
    )
    remark: str | None = Field(None, description="what whoever reads the table has to know of it; the import says it")

    @model_validator(mode="after")
    def _consistent(self) -> ChannelMap:
        frame_matrix(self.world, "world")
        frame_matrix(self.body, "body")
        if sorted(self.order) != list("wxyz"):
            raise ValueError(f"order {self.order!r} is not w, x, y and z in some order (wxyz, xyzw)")
        if self.axes is not None:
            axes_matrix(self.axes, mirrored=True)
        if self.clip is not None and self.clip[0] >= self.clip[1]:
            raise ValueError(f"clip {list(self.clip)}: the first is to be below the second")
        if self.mix is not None and len({len(row) for row in self.mix}) > 1:
            raise ValueError("mix: its lists differ in length")
        return self


def check_channel(name: str, mapped: ChannelMap) -> None:
    """ValueError where a channel's keys do not fit the channel, or each other."""
    if name not in CHANNELS:
        raise ValueError(f"unknown channel {name!r}; known: {', '.join(CHANNELS)}")
    channel = CHANNELS[name]
    attitude = channel.frame == "attitude"
    vector = channel.frame in ("world", "body")
    if mapped.euler and not attitude:
        raise ValueError(f"{name}: `euler` is for attitudes only")
    _check_count(name, mapped)
    try:
        conversion(dimension_of(name, mapped), unit_of(name, mapped))
    except KeyError as error:
        raise ValueError(f"{name}: {error.args[0]}") from error
    if mapped.gravity_removed and name != "specific_force":
        raise ValueError(f"{name}: `gravity_removed` is for specific_force only")
    if mapped.expressed_in is not None and not vector:
        raise ValueError(f"{name}: `expressed_in` is for vectors only")
    if mapped.axes is not None and not vector:
        remedy = "; an attitude's frames are `world` and `body`" if attitude else ""
        raise ValueError(f"{name}: `axes` is for vectors only{remedy}")
    if mapped.angle_signs is not None and not attitude:
        raise ValueError(f"{name}: `angle_signs` is for attitudes only")
    if (mapped.world is not None or mapped.body is not None) and not (vector or attitude):
        raise ValueError(f"{name}: it has no axes, so no `world` or `body`")
    if mapped.absolute and not channel.numbered:
        raise ValueError(f"{name}: `absolute` is for rotors and tilts only")
    if mapped.states is not None and name != "airborne":
        raise ValueError(f"{name}: `states` is for airborne only")
    if mapped.states is not None and (mapped.unit is not None or mapped.scale != 1.0 or mapped.offset != 0.0):
        raise ValueError(f"{name}: `states` says what the numbers mean; unit, scale and offset have no place beside it")
    if mapped.resample == "slerp" and not attitude:
        raise ValueError(f"{name}: slerp is for attitudes only")
    if mapped.resample in ("linear", "mean") and attitude:
        raise ValueError(f"{name}: an attitude is resampled by slerp, hold or sample")


def _check_count(name: str, mapped: ChannelMap) -> None:
    """ValueError where fields, `pick` and `mix` do not give the channel's columns."""
    channel = CHANNELS[name]
    stars = [f for f in mapped.fields if "*" in f]
    if stars and len(mapped.fields) > 1:
        raise ValueError(f"{name}: either one field with `*` or a list without it")
    if stars and not channel.numbered and mapped.pick is None and mapped.mix is None:
        raise ValueError(f"{name}: `*` needs `pick` or `mix` here, because its columns are not numbered")
    count = None if stars else len(mapped.fields)
    if mapped.pick is not None:
        if count is not None and max(mapped.pick) >= count:
            raise ValueError(f"{name}: pick {max(mapped.pick)}, but there are {count} fields, counted from 0")
        count = len(mapped.pick)
    if mapped.mix is not None:
        if count is not None and len(mapped.mix[0]) != count:
            raise ValueError(f"{name}: mix has {len(mapped.mix[0])} weights a list for {count} fields")
        count = len(mapped.mix)
    wanted = 3 if mapped.euler else len(channel.columns)
    if not channel.numbered and count != wanted:
        raise ValueError(f"{name}: {count} fields, expected {wanted}")


def dimension_of(name: str, mapped: ChannelMap) -> str:
    """The dimension of a mapped channel's fields."""
    return "angle" if mapped.euler else CHANNELS[name].dimension


def unit_of(name: str, mapped: ChannelMap) -> str:
    """The unit of a mapped channel's fields; SI where the mapping names none."""
    return mapped.unit if mapped.unit is not None else SI[dimension_of(name, mapped)]


def frame_matrix(frame: Axes | None, which: Literal["world", "body"]) -> Array | None:
    """(3, 3) from the log's axes to the table's, of a named frame or of written-out axes. ValueError if unknown."""
    if frame is None:
        return None
    if isinstance(frame, str):
        known = WORLD_FRAMES if which == "world" else BODY_FRAMES
        if frame not in known:
            raise ValueError(f"{which} frame {frame!r} is none of {', '.join(known)} and no list of three axes")
        return axes_matrix(known[frame])
    return axes_matrix(frame)
