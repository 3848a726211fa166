"""The numbers of the vehicle file in the order in which they are told: what is one finding stands together."""

from __future__ import annotations

from collections.abc import Sequence

from infotraj.diagnosis.judge.numbers import FileNumber

ONE_FINDING = "one finding with the ratio above"
_OF_A_ROTOR = ("thrust_coefficient", ".thrust, factor")  # how names end that tell one rotor's thrust


def by_ratio(file: Sequence[FileNumber]) -> list[tuple[FileNumber, bool]]:
    """Each number, and whether it is a part of the ratio above it: thrust over mass, then mass and thrust coefficients.

    Accelerations tell the ratio; a mass that is off beside it is the same error told again, but where it is out of line
    and the ratio is not.
    """
    ratio = [n for n in file if n.ratio]
    same = [n for n in file if n.name == "mass" or n.name.endswith(_OF_A_ROTOR)]
    parts = [n for n in same if ratio and (n.ordinary or not all(r.ordinary for r in ratio))]
    others = [n for n in file if n not in ratio and n not in parts]
    return [(n, n in parts) for n in (*ratio, *parts, *others)]
