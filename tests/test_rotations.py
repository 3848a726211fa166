"""Rotations: group laws, frames, and agreement with scipy's independent implementation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from infotraj import rotation_matrices, rotations

finite = st.floats(-1.0, 1.0, allow_subnormal=False)
vectors = arrays(float, 3, elements=finite)
quaternions = (
    arrays(float, 4, elements=finite).filter(lambda q: np.linalg.norm(q) > 1e-3).map(lambda q: q / np.linalg.norm(q))
)


def random_attitudes(n: int) -> np.ndarray:
    return rotations.normalize(np.random.default_rng(1).normal(size=(n, 4)))


def scipy_rotation(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


@given(quaternions, quaternions, vectors)
def test_a_product_turns_by_the_second_factor_first(p, q, v):
    together = rotations.to_world(rotations.multiply(p, q), v)
    assert np.allclose(together, rotations.to_world(p, rotations.to_world(q, v)), atol=1e-12)


@given(quaternions, vectors)
def test_to_body_undoes_to_world_and_keeps_length(q, v):
    world = rotations.to_world(q, v)
    assert np.allclose(rotations.to_body(q, world), v, atol=1e-12)
    assert np.isclose(np.linalg.norm(world), np.linalg.norm(v), atol=1e-12)


@given(quaternions)
def test_the_conjugate_is_the_inverse(q):
    assert np.allclose(rotations.multiply(q, rotations.conjugate(q)), [1, 0, 0, 0], atol=1e-12)


@given(arrays(float, 3, elements=st.floats(-1.7, 1.7)))
def test_log_undoes_exp_below_half_a_turn(rotvec):
    q = rotations.exp(rotvec)
    assert np.isclose(np.linalg.norm(q), 1.0)
    assert np.allclose(rotations.log(q), rotvec, atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-13, 1e-8, 1e-4])
def test_log_and_exp_near_zero_keep_their_relative_precision(angle):
    rotvec = angle * np.array([0.6, 0.0, -0.8])
    assert np.allclose(rotations.log(rotations.exp(rotvec)), rotvec, rtol=1e-9, atol=0.0)


@given(quaternions)
def test_log_takes_the_short_way_round(q):
    rotvec = rotations.log(q)
    assert np.linalg.norm(rotvec) <= np.pi + 1e-12
    assert np.allclose(rotvec, rotations.log(-q), atol=1e-9) or np.isclose(np.linalg.norm(rotvec), np.pi, atol=1e-6)


def test_matrix_and_log_agree_with_scipy():
    q = random_attitudes(200)
    assert np.allclose(rotations.matrix(q), scipy_rotation(q).as_matrix(), atol=1e-12)
    assert np.allclose(rotations.log(q), scipy_rotation(q).as_rotvec(), atol=1e-9)


@settings(max_examples=50)
@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_euler_angles_go_there_and_back_and_agree_with_scipy(roll, pitch, yaw):
    q = rotations.from_euler(roll, pitch, yaw)
    assert np.allclose(rotations.to_euler(q), [roll, pitch, yaw], atol=1e-7)
    assert np.allclose(rotations.matrix(q), Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix(), atol=1e-12)


def test_pitching_up_a_quarter_turn_points_forward_down():
    q = rotations.from_euler(0.0, np.pi / 2, 0.0)
    assert np.allclose(rotations.to_world(q, [1.0, 0.0, 0.0]), [0.0, 0.0, -1.0], atol=1e-12)


@given(quaternions, quaternions, quaternions)
def test_the_angle_between_is_a_distance(p, q, r):
    pq, qr, pr = (rotations.angle_between(a, b) for a, b in ((p, q), (q, r), (p, r)))
    assert np.isclose(pq, rotations.angle_between(q, p), atol=1e-7)
    assert pr <= pq + qr + 1e-7
    assert np.isclose(rotations.angle_between(p, -p), 0.0, atol=1e-7)
    assert np.isclose(pq, (scipy_rotation(p).inv() * scipy_rotation(q)).magnitude(), atol=1e-7)


def test_continuous_gives_the_same_attitudes_without_jumps():
    t = np.linspace(0.0, 4.0 * np.pi, 400)
    smooth = rotations.exp(t[:, None] * np.array([0.0, 0.6, 0.8]))
    flipped = smooth * np.random.default_rng(3).choice([-1.0, 1.0], size=(400, 1))
    mended = rotations.continuous(flipped)
    assert np.allclose(rotations.matrix(mended), rotations.matrix(smooth), atol=1e-12)
    assert np.abs(np.diff(mended, axis=0)).max() < 0.05


def test_every_function_is_the_same_batched_and_looped():
    q, v = random_attitudes(12).reshape(3, 4, 4), np.random.default_rng(2).normal(size=(3, 4, 3))
    for function, arguments in [
        (rotations.matrix, (q,)),
        (rotations.log, (q,)),
        (rotations.to_euler, (q,)),
        (rotations.exp, (v,)),
        (rotations.to_world, (q, v)),
        (rotations.to_body, (q, v)),
        (rotations.multiply, (q, q[::-1])),
        (rotations.angle_between, (q, q[::-1])),
    ]:
        batched = function(*arguments)
        for index in np.ndindex(3, 4):
            assert np.allclose(batched[index], function(*(a[index] for a in arguments)), atol=1e-14)


def test_vectors_turned_by_matrices_are_those_turned_by_the_attitudes():
    q, v = random_attitudes(20), np.random.default_rng(2).normal(size=(20, 3))
    r = rotation_matrices.matrices(q)
    np.testing.assert_allclose(r, rotations.matrix(q), atol=1e-15)
    np.testing.assert_allclose(rotation_matrices.turned(r, v), scipy_rotation(q).apply(v), atol=1e-12)
    np.testing.assert_allclose(rotation_matrices.turned_back(r, v), scipy_rotation(q).inv().apply(v), atol=1e-12)
    np.testing.assert_allclose(rotation_matrices.turned_back(r, v[0]), scipy_rotation(q).inv().apply(v[0]), atol=1e-12)
