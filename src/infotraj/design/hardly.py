"""Whether a design is worth its flight: one judgement, from the numbers that are told."""

from __future__ import annotations

from infotraj.design.design import Design, Told

_KNOWN = 0.01  # of an effect: no number of a vehicle file is asked for better (docs/vehicle.md: mass to 1 %)
_LITTLE = (
    0.05  # of a probability, twice what its 400 draws leave open; of a standard error, which is told in two digits
)


def hardly_worth(made: Design) -> str:
    """Why the flight would tell little that is not known, or no more than the last one again; empty where it does."""
    if not made.told:
        return "nothing is open, and nothing was found beyond the model: the flight narrows the file's own numbers"
    if all(t.now for t in made.told):
        return "what is asked is told already"
    if all(t.shares_now and max(t.shares_now) < _KNOWN for t in made.told):
        return f"what was found is known to better than {100 * _KNOWN:g} % of itself"
    still = [t for t in made.told if not t.now]
    if all(_nothing(t) for t in still):
        other = "" if all(_as_good(t, back=True) for t in still) else "; flying the last one again tells more"
        return (
            f"it tells almost nothing of what is asked{other}; a larger --box or --max-speed, or a longer --within, may"
        )
    if all(_as_good(t) for t in still):
        most = f"at most {100 * _LITTLE:g} % more than another flight like the last one"
        return f"it tells {most}: flying that again is as good"
    return ""


def _nothing(t: Told) -> bool:
    """Neither decided, but by chance, nor any number narrowed."""
    if t.after is not None:
        return t.after < _LITTLE
    return all(after > (1 - _LITTLE) * now for now, after in zip(t.errors_now, t.errors_after, strict=True))


def _as_good(t: Told, back: bool = False) -> bool:
    """Whether the last flight again tells as much, or with `back` the design as much as that."""
    if t.after is not None and t.again is not None:
        return (t.again - t.after if back else t.after - t.again) < _LITTLE
    pairs = [(t.errors_again, t.errors_after), (t.errors_after, t.errors_again)][back]
    return all(mine > (1 - _LITTLE) * other for other, mine in zip(*pairs, strict=True))


def beside_the_box(made: Design) -> str:
    """What the room must leave beside the box, where that is much against the box; empty where it is not."""
    if made.flown is None or made.not_flown:
        return ""
    away, least = made.flown.away(made.reference), float(made.room.size.min())
    if not away > least / 2:
        return ""
    strays = f"in simulation it strays by {away:.2g} m, more than half of the box's smallest side of {least:.2g} m"
    return f"{strays}: the room must leave that much beside the box"
