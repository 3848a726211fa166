"""What a design says, for people and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.design.design import Design, Told
from infotraj.design.hardly import beside_the_box, hardly_worth
from infotraj.flight import sha256

_DRAWN = 400  # rows of the reference that a picture needs


def as_text(made: Design, output: str) -> str:
    """What the flight is, what it will tell, and what stands against it."""
    r = made.reference
    size = " x ".join(f"{x:.3g}" for x in np.ptp(r.position, axis=0))
    speed, turn = np.linalg.norm(r.velocity, axis=1).max(), np.linalg.norm(r.rate, axis=1).max()
    lines = [
        f"{output}: {r.t[-1] - r.t[0]:.0f} s within {size} m, at most {speed:.2g} m/s and {turn:.2g} rad/s; "
        f"the best of {made.tried} motions"
    ]
    if made.inputs.size and np.isfinite(made.limits.high).all():
        share = (made.inputs - made.limits.low) / (made.limits.high - made.limits.low)
        low, high = 100 * share.min(), 100 * share.max()
        lines.append(f"rotors: {low:.0f} % to {high:.0f} % of the range between least and greatest input")
    lines += [line for t in made.told for line in _told(t)]
    if hardly_worth(made):
        lines.append(f"hardly worth flying for this: {hardly_worth(made)}")
    if made.flown is not None and not made.not_flown:
        how = "simulated with the model as found, by a plain controller"
        away = f"{made.flown.away(r):.2g} m"
        lines.append(f"{how}: {away} from the reference at most; leave that much room around the motion")
    if _warned(made):
        lines.append(f"warning: {_warned(made)}")
    return "\n".join(lines) + "\n"


def following(made: Design, output: str, diagnose: str) -> str:
    """What to do with it: not to fly what went wrong in simulation. diagnose: the command for afterwards."""
    if _went_wrong(made):
        return "do not fly it as it is; ask again with a smaller --box, --max-speed or --max-tilt"
    return f"{'if you fly it all the same, ' if hardly_worth(made) else ''}fly {output}, then {diagnose}"


def _went_wrong(made: Design) -> bool:
    """In simulation; a vehicle that nobody can simulate may be flown."""
    return bool(made.not_flown) and made.flown is not None


def _warned(made: Design) -> str:
    return made.not_flown or beside_the_box(made)


def _told(t: Told) -> list[str]:
    if t.after is not None and t.again is not None:
        now = "; it is told already" if t.now else ""
        return [
            f"telling {t.words}: {_probability(t.after)} probable after it, "
            f"{_probability(t.again)} after another flight like the last one{now}"
        ]
    rows = zip(t.numbers, t.errors_now, t.shares_now, t.errors_again, t.errors_after, strict=True)
    return [
        f"{name}: standard error {now:.2g} now{_of_effect(share)}, {after:.2g} after it, "
        f"{again:.2g} after another flight like the last one"
        for name, now, share, again, after in rows
    ]


def _of_effect(share: float) -> str:
    return f" ({100 * share:.2g} % of the effect)" if share < 1.0 else ""


def _probability(x: float) -> str:
    return "more than 99 %" if x > 0.99 else "less than 1 %" if x < 0.01 else f"{100 * x:.0f} %"


def as_dict(made: Design, output: str, model: Path, flown: Sequence[Path]) -> dict[str, Any]:
    """The same for programs. Probabilities and standard errors: now, after a flight like the last one, after this.

    model, flown: the files that were asked. `drawn`: the reference, and how it was followed in simulation.
    """
    r = made.reference
    return {
        "model": _file(model),
        "flown": [_file(f) for f in flown],
        "reference": output,
        "seconds": float(r.t[-1] - r.t[0]),
        "room": {"size": made.room.size.tolist(), "center": made.room.center.tolist()},
        "greatest": {
            "speed": float(np.linalg.norm(r.velocity, axis=1).max()),
            "rate": float(np.linalg.norm(r.rate, axis=1).max()),
            "input": made.inputs.max(axis=0).tolist() if made.inputs.size else [],
        },
        "told": [
            {
                "question": t.words,
                "decided": None if t.after is None else {"now": t.now, "again": t.again, "after": t.after},
                "numbers": [
                    {"name": n, "standard_error": {"now": a, "again": b, "after": c}, "share_of_effect": _finite(s)}
                    for n, a, b, c, s in zip(
                        t.numbers, t.errors_now, t.errors_again, t.errors_after, t.shares_now, strict=True
                    )
                ],
            }
            for t in made.told
        ],
        "simulated": None
        if made.flown is None
        else {"from_reference": _finite(made.flown.away(r)), "at_limit": made.flown.at_limit},
        "warning": _warned(made) or None,
        "hardly_worth": hardly_worth(made) or None,
        "fly": not _went_wrong(made),
        "tried": made.tried,
        "drawn": _drawn(made),
    }


def _file(path: Path) -> dict[str, str | None]:
    return {"path": str(path), "sha256": sha256(path) if path.is_file() else None}


def _drawn(made: Design) -> dict[str, Any]:
    """Time (s), place (m), speed (m/s) and rate (rad/s) of the reference in some 400 rows, and the simulated place."""
    r = made.reference
    some = slice(None, None, max(1, len(r.t) // _DRAWN))
    size = {"speed": np.linalg.norm(r.velocity, axis=1), "rate": np.linalg.norm(r.rate, axis=1)}
    followed = made.flown.position if made.flown is not None else np.full(3, np.nan)
    return {
        "t": np.round(r.t[some], 3).tolist(),
        "position": np.round(r.position[some], 4).tolist(),
        **{name: np.round(values[some], 4).tolist() for name, values in size.items()},
        "simulated": np.round(followed[some], 4).tolist() if np.isfinite(followed).all() else None,
    }


def _finite(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None
