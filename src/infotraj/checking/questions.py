"""What a log cannot answer, whatever its quality, because a channel is not in it."""

from __future__ import annotations

from dataclasses import dataclass

from infotraj.checking.finding import Finding
from infotraj.flight import (
    ATTITUDE,
    COMMANDED_WRENCH,
    POSITION,
    RATE,
    REFERENCE_POSITION,
    SPECIFIC_FORCE,
    VELOCITY,
    Flight,
)


@dataclass(frozen=True)
class Question:
    """`needs` lists groups of columns, any one of which is enough for that need; all needs must be met."""

    name: str
    needs: tuple[tuple[tuple[str, ...], ...], ...]


_POSE = ((POSITION,), (ATTITUDE,))
_INPUT = (("cmd_rotor_0",), ("rotor_0",), COMMANDED_WRENCH)
QUESTIONS: tuple[Question, ...] = (
    Question("rollouts (open-loop prediction from a recorded state)", (*_POSE, _INPUT)),
    Question("whether the attitude means what it says (frame, order, direction)", ((ATTITUDE,), (RATE,))),
    Question("whether rates are in rad/s and in the body frame", ((ATTITUDE,), (RATE,))),
    Question("whether the clocks of pose and IMU agree", ((ATTITUDE, POSITION), (RATE, SPECIFIC_FORCE))),
    Question("force errors", ((SPECIFIC_FORCE, VELOCITY, POSITION), _INPUT)),
    Question("torque errors", ((RATE, ATTITUDE), _INPUT)),
    Question("drag (needs a velocity and an attitude)", ((VELOCITY, POSITION), (ATTITUDE,), _INPUT)),
    Question("steady_force and wind (need the world's axes)", ((ATTITUDE,), _INPUT)),
    Question("ground_effect (needs a height)", ((POSITION,), _INPUT)),
    Question("suspended_load (needs the world's axes)", ((ATTITUDE,), _INPUT)),
    Question("gyro_bias (needs an attitude beside the gyro)", ((ATTITUDE,), (RATE,))),
    Question("rotor_lag, servo_lag and actuation_delay (need commands)", ((("cmd_rotor_0",), COMMANDED_WRENCH),)),
    Question("the experiment (needs the commanded wrench)", ((COMMANDED_WRENCH,),)),
    Question("battery_sag by voltage", ((("battery",),),)),
    Question("tracking errors", ((REFERENCE_POSITION,), (POSITION,))),
)


def unanswerable(flight: Flight) -> dict[str, list[str]]:
    """For each question that this log cannot answer, the columns that would help (one of each entry)."""
    out: dict[str, list[str]] = {}
    for question in QUESTIONS:
        missing = [need for need in question.needs if not any(flight.has(*g) for g in need)]
        if missing:
            out[question.name] = [" or ".join(_name(g) for g in need) for need in missing]
    return out


def question_findings(flight: Flight) -> list[Finding]:
    """One note that names the unanswerable questions; a rejection where the log holds nothing that a model predicts."""
    missing = unanswerable(flight)
    if not missing:
        return []
    nothing = not any(flight.has(*g) for g in (POSITION, ATTITUDE, VELOCITY, RATE, SPECIFIC_FORCE))
    return [
        Finding(
            "nothing_measured" if nothing else "cannot_answer",
            "reject" if nothing else "note",
            "no motion is in this log" if nothing else "this log cannot answer: " + "; ".join(missing),
            "no model can be compared with it" if nothing else "answers about these will be Not testable here",
            "map more channels: " + ", ".join(sorted({m for needs in missing.values() for m in needs})),
            values={"missing": missing},
        )
    ]


def _name(group: tuple[str, ...]) -> str:
    return group[0] if len(group) == 1 else f"{group[0]}..{group[-1]}"
