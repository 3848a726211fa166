"""Each encoding of a blackbox log is read back from bytes put together here as the format's page draws them."""

import itertools

import numpy as np
import pytest

from infotraj.importing import blackbox_bytes as read
from infotraj.importing.blackbox_header import parse_header

WIDTHS = {0: 0, 1: 4, 2: 8, 3: 16}
RNG = np.random.default_rng(8)


def numbers(sizes):
    """A number of each width, the extremes among them."""
    out = []
    for size in sizes:
        half = (1 << WIDTHS[size]) // 2
        out.append(int(RNG.choice([-half, half - 1, RNG.integers(-half, half)])) if size else 0)
    return out


def decoded(function, data, count, *settings):
    place, out = np.zeros(2, dtype=np.int64), np.full(count, 99, dtype=np.int64)
    function(np.array([*data], dtype=np.uint8), place, out, *settings)
    assert list(place) == [len(data), 0]
    return list(out)


def tag(sizes):
    return sum(size << (2 * k) for k, size in enumerate(sizes))


def test_four_numbers_of_data_version_2_are_half_bytes_in_a_row_the_high_half_first():
    for sizes in itertools.product(range(4), repeat=4):
        values = numbers(sizes)
        digits = "".join(f"{v % (1 << WIDTHS[s]):0{WIDTHS[s] // 4}x}" for v, s in zip(values, sizes, strict=True) if s)
        data = bytes.fromhex(digits + "0" * (len(digits) % 2))
        assert decoded(read.four, [tag(sizes), *data], 4, 2) == values, sizes


def test_four_numbers_of_data_version_1_are_bytes_and_pairs_of_four_bits_the_low_half_first():
    """A number of four bits shares its byte with the next one."""
    parts = [s for n in (2, 3, 4) for s in itertools.product(((0,), (2,), (3,), (1, 1)), repeat=n)]
    for sizes in (s for s in parts if sum(map(len, s)) == 4):
        flat = tuple(itertools.chain(*sizes))
        values, data, k = numbers(flat), [], 0
        for size in sizes:
            if size == (1, 1):
                data.append(values[k] % 16 | values[k + 1] % 16 << 4)
            else:
                data += (values[k] % 65536).to_bytes(2, "little")[: WIDTHS[size[0]] // 8]
            k += len(size)
        assert decoded(read.four, [tag(flat), *data], 4, 1) == values, sizes


@pytest.mark.parametrize(
    ("variable", "widths", "lead", "count"),
    [
        (False, (2, 2, 2), 0, 1),
        (False, (4, 4, 4), 1, 2),
        (False, (6, 6, 6), 2, 3),
        (True, (2, 2, 2), 0, 1),
        (True, (5, 5, 4), 1, 2),
        (True, (8, 7, 7), 2, 3),
    ],
)
def test_three_small_numbers_are_packed_behind_their_width(variable, widths, lead, count):
    for _ in range(20):
        values = [int(RNG.integers(-(1 << (w - 1)), 1 << (w - 1))) for w in widths]
        bits = 0
        for value, width in zip(values, widths, strict=True):
            bits = bits << (8 if width == 6 else width) | value % (1 << width)  # six bits have a byte each
        data = (lead << (8 * count - 2) | bits).to_bytes(count, "big")
        assert decoded(read.three, data, 3, variable) == values


def test_three_large_numbers_say_their_bytes():
    for bytes_each in itertools.product((1, 2, 3, 4), repeat=3):
        values = [int(RNG.integers(-(1 << (8 * n - 1)), 1 << (8 * n - 1))) for n in bytes_each]
        lead = 3 << 6 | sum((n - 1) << (2 * k) for k, n in enumerate(bytes_each))
        data = b"".join(v.to_bytes(n, "little", signed=True) for v, n in zip(values, bytes_each, strict=True))
        assert decoded(read.three, [lead, *data], 3, False) == values, bytes_each


@pytest.mark.parametrize("value", [0, -1, 1, 63, -64, 64, 8191, -8192, 2**31 - 1, -(2**31)])
def test_a_number_of_seven_bits_a_byte_has_its_sign_in_the_lowest(value):
    zigzag, data = (value << 1 ^ value >> 63) % (1 << 32), []
    while zigzag > 127:
        data.append(zigzag & 127 | 128)
        zigzag >>= 7
    place = np.zeros(2, dtype=np.int64)
    assert read.signed(np.array([*data, zigzag], dtype=np.uint8), place) == value
    assert list(place) == [len(data) + 1, 0]


def test_a_read_past_the_end_is_marked():
    place = np.zeros(2, dtype=np.int64)
    assert read.byte(np.zeros(0, dtype=np.uint8), place) == 0
    assert place[1] == 1


LINES = {
    "I name": "loopIteration,time,axis",
    "I signed": "0,0,1",
    "I predictor": "0,0,0",
    "I encoding": "1,1,0",
    "P predictor": "6,2,1",
    "P encoding": "9,0,7",
}


def header(**changed):
    lines = LINES | {k.replace("_", " "): v for k, v in changed.items()}
    return parse_header("".join(f"H Field {k}:{v}\n" for k, v in lines.items() if v is not None).encode())[0]


def test_signs_are_those_of_complete_frames_and_may_be_left_out():
    assert header().coding["I"].tolist() == [[0, 0, 0], [1, 1, 0], [0, 0, 1]]
    assert header().coding["P"].tolist() == [[6, 2, 1], [9, 0, 7], [0, 0, 1]]
    assert header(I_signed=None).coding["P"].tolist() == [[6, 2, 1], [9, 0, 7], [0, 0, 0]]


@pytest.mark.parametrize(
    ("line", "given", "said"),
    [
        ("P encoding", None, "lists 0 of 3 encodings of P frames"),
        ("I predictor", "0,0", "lists 2 of 3 predictors of I frames"),
        ("I signed", "0,0", "lists 2 of 3 signeds of I frames"),
        ("I encoding", "1,x,0", "has a encoding of I frames that is no number"),
        ("I encoding", "1,256,0", "has a encoding of I frames that is no number"),
        ("I name", "time,loopIteration,axis", "names no loopIteration and time"),
    ],
)
def test_a_header_by_which_no_frame_can_be_decoded_is_refused(line, given, said):
    with pytest.raises(ValueError, match=said):
        header(**{line.replace(" ", "_"): given})
