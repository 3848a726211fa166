"""The frames of one blackbox log, decoded by compiled code: prediction, what makes a frame believable, and recovery.

Format: "Blackbox logging internals" (Cleanflight, Betaflight and INAV developer documentation). A frame is complete
where the next one, or the end of the log, begins right behind it; otherwise it is damaged and the search for a frame
goes on one byte behind its start. Frames coded as differences (P) are left out until the next complete one (I) after
damage to a main frame, and after a main frame whose loop count or time goes back or leaps. Damage that began at another
frame took no main frame with it as far as can be told: there P frames are left out until any other whole frame.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from infotraj.importing.blackbox_bytes import byte, coded, little_endian, signed, unsigned

# Predictors
PREVIOUS, STRAIGHT, AVERAGE, MIN_THROTTLE, MOTOR_0, COUNT, HOME, NEUTRAL, BATTERY, TIME, MIN_MOTOR = range(1, 12)
# What a frame may span or leap at most, as the firmwares' own decoder has it: bytes, loop iterations, us.
LONGEST, LEAP, LEAP_US = 256, 5000, 10_000_000
_I, _P, _S, _G, _H, _E = 73, 80, 83, 71, 72, 69
# counts: main, slow, gps, home, events, damaged stretches, main frames left out, ended by its own end mark
MAIN, SLOW, GPS, HOMES, EVENTS, DAMAGED, SKIPPED, ENDED = range(8)


@njit(cache=True)
def wrapped(value: int, is_signed: bool) -> int:
    """32 bits, as the firmware has them."""
    value &= 0xFFFFFFFF
    return value - 0x100000000 if is_signed and value >> 31 else value


@njit(cache=True)
def predicted(
    which: int, k: int, last: Any, before: Any, current: Any, home: Any, known: Any, skipped: int, is_signed: bool
) -> int:
    """What is added to a coded number; `known` is (minthrottle, vbatref, least motor, motor[0]'s place, last time)."""
    if which == PREVIOUS:
        return int(last[k])
    if which == STRAIGHT:
        return int(2 * last[k] - before[k])
    if which == AVERAGE:
        total = wrapped(last[k] + before[k], is_signed)
        return -(-total // 2) if total < 0 else total // 2  # towards zero, as C divides
    if which == MIN_THROTTLE:
        return int(known[0])
    if which == MOTOR_0:
        return int(current[known[3]]) if known[3] >= 0 else 0
    if which == COUNT:
        return int(last[k]) + skipped + 1
    if which == HOME:
        return int(home[k & 1])
    if which == NEUTRAL:
        return 1500
    if which == BATTERY:
        return int(known[1])
    if which == TIME:
        return int(known[4])
    if which == MIN_MOTOR:
        return int(known[2])
    return 0


@njit(cache=True)
def event(data: Any, place: Any, out: Any) -> bool:
    """An event's kind and numbers into `out` (4,); False where it is of no known kind, and so of unknown length."""
    out[:] = 0
    kind = byte(data, place)
    out[0] = kind
    if kind == 0 or kind == 15 or kind == 40:  # beep, disarm, IMU failure
        out[1] = unsigned(data, place)
    elif kind == 13:  # adjustment in flight
        out[1] = byte(data, place)
        out[2] = little_endian(data, place, 4) if out[1] & 128 else signed(data, place)
    elif kind == 14 or kind == 30:  # logging resumes (iteration, time); flight mode (now, before)
        out[1] = unsigned(data, place)
        out[2] = unsigned(data, place)
    elif kind == 10 or kind == 11:  # automatic tuning
        for _ in range(5 if kind == 10 else 4):
            byte(data, place)
    elif kind == 12:
        for _ in range(2):
            little_endian(data, place, 2)
        byte(data, place)
    elif kind == 20:
        byte(data, place)
        signed(data, place)
        little_endian(data, place, 2)
    elif kind == 255:
        # "End of log", in later firmware with the reason in brackets, closed by a zero
        for expected in (69, 110, 100, 32, 111, 102, 32, 108, 111, 103):
            if byte(data, place) != expected:
                return False
        for _ in range(64):
            if byte(data, place) == 0:
                return place[1] == 0
        return False
    else:
        return False
    return True


@njit(cache=True)
def grown(rows: Any, used: int) -> Any:
    """`rows` with room for one more."""
    if used < rows.shape[0]:
        return rows
    larger = np.zeros((2 * rows.shape[0], rows.shape[1]), dtype=rows.dtype)
    larger[:used] = rows
    return larger


@njit(cache=True)
def begins(code: int) -> bool:
    """True for a byte that begins a frame."""
    return code in (_I, _P, _S, _G, _H, _E)


@njit(cache=True)
def should_log(iteration: int, every: int, numerator: int, denominator: int) -> bool:
    """True where the firmware logs this loop iteration: all I frames, and `numerator` of `denominator` others."""
    return (iteration % every + numerator - 1) % denominator < numerator


@njit(cache=True)
def decode(
    data: Any,
    i_coding: Any,  # (3, n): predictor, encoding, signed, of I frames; likewise below
    p_coding: Any,
    s_coding: Any,
    g_coding: Any,
    h_coding: Any,
    known: Any,  # (5,): see `predicted`
    interval: Any,  # (3,): I interval, P numerator, P denominator
    version: int,
) -> Any:
    """(main (n, fields), slow (n, fields + 1), gps (n, fields + 1), events (n, 5), counts (8,)), all int64.

    The last column of slow, gps and events is the index of the main frame that follows.
    """
    fields = i_coding.shape[1]
    main = np.zeros((1024, fields), dtype=np.int64)
    slow = np.zeros((64, s_coding.shape[1] + 1), dtype=np.int64)
    gps = np.zeros((64, g_coding.shape[1] + 1), dtype=np.int64)
    events = np.zeros((64, 5), dtype=np.int64)
    counts = np.zeros(8, dtype=np.int64)
    most = max(fields, s_coding.shape[1], g_coding.shape[1], h_coding.shape[1])
    raw = np.zeros(most + 8, dtype=np.int64)
    current = np.zeros(most + 8, dtype=np.int64)
    last = np.zeros(fields, dtype=np.int64)
    before = np.zeros(fields, dtype=np.int64)
    home = np.zeros(2, dtype=np.int64)
    happened = np.zeros(4, dtype=np.int64)
    place = np.zeros(2, dtype=np.int64)
    nothing = np.zeros((3, 0), dtype=np.int64)
    in_step, in_ruin, resumable = False, False, False
    iteration, time = -1, -1
    while place[0] < data.size:
        start = place[0]
        code = byte(data, place)
        good = begins(code)
        skipped = 0
        coding = nothing
        if code == _I:
            coding = i_coding
        elif code == _P:
            # behind damage no P frame is looked for: any bytes would pass for one
            coding, good = p_coding, not in_ruin
            if in_step:
                while skipped < LEAP and not should_log(last[0] + skipped + 1, interval[0], interval[1], interval[2]):
                    skipped += 1
        elif code == _S:
            coding = s_coding
        elif code == _G:
            coding = g_coding
        elif code == _H:
            coding = h_coding
        if code == _E:
            good = event(data, place, happened)
        elif begins(code):
            readable = coding.shape[1] > 0 and coded(data, place, coding[1], version, raw)
            good = good and readable
            if good:
                for k in range(coding.shape[1]):
                    expected = predicted(coding[0, k], k, last, before, current, home, known, skipped, coding[2, k] > 0)
                    current[k] = wrapped(raw[k] + expected, coding[2, k] > 0)
        complete = (
            good
            and place[1] == 0
            and place[0] - start <= LONGEST
            and (place[0] == data.size or begins(data[place[0]]) or (code == _E and happened[0] == 255))
        )
        if not complete:
            if not in_ruin:
                counts[DAMAGED] += 1
                resumable = in_step and code in (_S, _G, _H, _E)
            in_step, in_ruin = False, True
            place[0], place[1] = start + 1, 0
            continue
        if in_ruin:
            in_ruin, in_step = False, resumable
        if code in (_I, _P):
            # both count in 32 bits; the time starts again after 71 minutes
            believable = iteration < 0 or (
                (current[0] - iteration) & 0xFFFFFFFF < LEAP and (current[1] - time) & 0xFFFFFFFF < LEAP_US
            )
            if believable and (code == _I or in_step):
                iteration, time = current[0], current[1]
                known[4] = time
                main = grown(main, counts[MAIN])
                main[counts[MAIN]] = current[:fields]
                counts[MAIN] += 1
                in_step = True
            else:
                counts[SKIPPED] += 1
                in_step = False
            if code == _I:
                last[:] = current[:fields]
                before[:] = current[:fields]
            elif in_step:
                before[:] = last
                last[:] = current[:fields]
        elif code == _S:
            slow = grown(slow, counts[SLOW])
            slow[counts[SLOW], :-1] = current[: s_coding.shape[1]]
            slow[counts[SLOW], -1] = counts[MAIN]
            counts[SLOW] += 1
        elif code == _G:
            gps = grown(gps, counts[GPS])
            gps[counts[GPS], :-1] = current[: g_coding.shape[1]]
            gps[counts[GPS], -1] = counts[MAIN]
            counts[GPS] += 1
        elif code == _H:
            home[:] = current[:2]
            counts[HOMES] += 1
        else:
            events = grown(events, counts[EVENTS])
            events[counts[EVENTS], :4] = happened
            events[counts[EVENTS], 4] = counts[MAIN]
            counts[EVENTS] += 1
            if happened[0] == 14:
                iteration, time = happened[1], happened[2]
            elif happened[0] == 255:
                counts[ENDED] = 1
                break
    return main[: counts[MAIN]], slow[: counts[SLOW]], gps[: counts[GPS]], events[: counts[EVENTS]], counts
