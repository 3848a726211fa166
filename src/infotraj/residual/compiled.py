"""The Gaussian process at one input, for compiled time loops: mean with Jacobian, one posterior draw, a marginal draw.

Scalar queries without heap allocation, callable from other `numba.njit` code. The inner loops run over points (or
Fourier features), which is why points are stored (d, n) and frequencies (m, d, features): contiguous, so that they
become vector instructions. numba's own exp and cos would keep them scalar, hence the polynomials here.

numba caches a caller with the code of this module inside and does not see that this module changed: after an edit here
delete the *.nbi and *.nbc files of its callers.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

# Values of a block of points or features stay in 1 KiB of stack. Loop indices are unsigned: numba wraps a signed index
# that may be negative, which costs the inner loops a factor of 3.
_BLOCK = np.uint64(128)
_ZERO, _ONE, _TWO, _THREE = np.uint64(0), np.uint64(1), np.uint64(2), np.uint64(3)

_LOG2_E = 1.4426950408889634
_LN_2_HIGH = 6.93147180369123816490e-01  # ln 2 split, so that k * high is exact (Cody and Waite, 1980)
_LN_2_LOW = 1.90821492927058770002e-10

# sin(2 pi s) = s (c1 + c3 s^2 + ...), Taylor up to s^11: 6e-8 at s = 1/4, the resolution of single precision
_S1, _S3, _S5, _S7, _S9, _S11 = (
    np.float32(c)
    for c in (
        6.283185307179586,
        -41.34170224039975,
        81.60524927607504,
        -76.70585975306136,
        42.05869394489765,
        -15.094642576822984,
    )
)
_HALF, _QUARTER = np.float32(0.5), np.float32(0.25)


@intrinsic
def _as_double(typing_context, bits):
    """The double whose bit pattern is the given 64-bit integer."""

    def codegen(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), codegen


def _stack(numba_type, llvm_type):
    @intrinsic
    def block(typing_context):
        """A block of _BLOCK numbers on the caller's stack."""

        def codegen(context, builder, signature, arguments):
            memory = cgutils.alloca_once(builder, ir.ArrayType(llvm_type, int(_BLOCK)))
            return builder.bitcast(memory, llvm_type.as_pointer())

        return types.CPointer(numba_type)(), codegen

    return block


_doubles = _stack(types.float64, ir.DoubleType())
_singles = _stack(types.float32, ir.FloatType())


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def _exp(x):
    """exp(x) for x <= 0 to 4e-16 of its value; 0 or a number below 1e-300 where x < -700."""
    x = max(x, -700.0)
    k = np.floor(x * _LOG2_E + 0.5)
    r = (x - k * _LN_2_HIGH) - k * _LN_2_LOW
    p = 1.0 / 6227020800.0
    p = p * r + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = p * r + 1.0
    p = p * r + 1.0
    return p * _as_double(np.int64(np.int32(k) + 1023) << 52)


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def _cos_turns(t):
    """cos(2 pi t) in single precision to about 2e-7."""
    t = t - np.floor(t + _HALF)
    s = _QUARTER - abs(t)
    q = s * s
    return s * (_S1 + q * (_S3 + q * (_S5 + q * (_S7 + q * (_S9 + q * _S11)))))


@njit(cache=True, fastmath=True, error_model="numpy")
def _exponents(u, points, inverse_lengthscales_squared, o, start, size, w):
    """w[j] = -1/2 (u - x)^T Lambda^-2 (u - x) of output o for `size` points from `start` on."""
    d = np.uint64(points.shape[0])
    for j in range(size):
        w[j] = 0.0
    for i in range(d):
        ui, c = u[i], -0.5 * inverse_lengthscales_squared[o, i]
        for j in range(size):
            w[j] += c * (ui - points[i, start + j]) ** 2


@njit(cache=True, fastmath=True, error_model="numpy")
def mean_and_jacobian(
    u, points, alpha, inverse_lengthscales_squared, signal_variance, constant, slopes, out_mean, out_jacobian
):
    """Posterior mean (m,) and its derivative (m, d) at u (d,), into out_mean and out_jacobian.

    The arrays between are `GaussianProcess.mean_arrays`, in its order: points (d, n), alpha (m, n), (m, d), (m,), and
    the affine part, (m,) and (m, d).
    """
    d, n = np.uint64(points.shape[0]), np.uint64(points.shape[1])
    w = carray(_doubles(), (_BLOCK,))
    for o in range(alpha.shape[0]):
        total = 0.0
        for i in range(d):
            out_jacobian[o, i] = 0.0
        for start in range(_ZERO, n, _BLOCK):
            size = min(_BLOCK, n - start)
            _exponents(u, points, inverse_lengthscales_squared, o, start, size, w)
            block = 0.0
            for j in range(size):
                w[j] = alpha[o, start + j] * _exp(w[j])
                block += w[j]
            total += block
            for i in range(d):
                ui, slope = u[i], 0.0
                for j in range(size):
                    slope += w[j] * (points[i, start + j] - ui)
                out_jacobian[o, i] += slope
        out_mean[o] = constant[o] + signal_variance[o] * total
        for i in range(d):
            out_mean[o] += slopes[o, i] * u[i]
            out_jacobian[o, i] *= signal_variance[o] * inverse_lengthscales_squared[o, i]
            out_jacobian[o, i] += slopes[o, i]


@njit(cache=True, fastmath=True, error_model="numpy")
def _add_kernel_sum(u, points, weights, inverse_lengthscales_squared, signal_variance, out):
    """out (m,) += k(u, points) weights."""
    n = np.uint64(points.shape[1])
    w = carray(_doubles(), (_BLOCK,))
    for o in range(weights.shape[0]):
        total = 0.0
        for start in range(_ZERO, n, _BLOCK):
            size = min(_BLOCK, n - start)
            _exponents(u, points, inverse_lengthscales_squared, o, start, size, w)
            block = 0.0
            for j in range(size):
                block += weights[o, start + j] * _exp(w[j])
            total += block
        out[o] += signal_variance[o] * total


@njit(cache=True, fastmath=True, error_model="numpy")
def prior_draw_value(u, frequencies, phases, amplitudes, out):
    """A draw of the zero-mean prior at u (d,), into out (m,): sum of amplitude cos(2 pi (frequency . u + phase)).

    frequencies (m, d, F) in turns a unit of u, phases (m, F) in turns, amplitudes (m, F): single precision.
    """
    d, features = np.uint64(frequencies.shape[1]), np.uint64(frequencies.shape[2])
    t = carray(_singles(), (_BLOCK,))
    for o in range(out.shape[0]):
        total = 0.0
        for start in range(_ZERO, features, _BLOCK):
            size = min(_BLOCK, features - start)
            for j in range(size):
                t[j] = phases[o, start + j]
            for i in range(_ZERO, d, _THREE):
                # three inputs a pass, so that t is loaded and stored a third as often
                i1, i2 = min(i + _ONE, d - _ONE), min(i + _TWO, d - _ONE)
                u0 = np.float32(u[i])
                u1 = np.float32(u[i1]) if i + _ONE < d else np.float32(0.0)
                u2 = np.float32(u[i2]) if i + _TWO < d else np.float32(0.0)
                for j in range(size):
                    k = start + j
                    t[j] += u0 * frequencies[o, i, k] + u1 * frequencies[o, i1, k] + u2 * frequencies[o, i2, k]
            block = np.float32(0.0)
            for j in range(size):
                block += amplitudes[o, start + j] * _cos_turns(t[j])
            total += block
        out[o] = total


@njit(cache=True, error_model="numpy")
def draw_value(
    u,
    frequencies,
    phases,
    amplitudes,
    update,
    points,
    inverse_lengthscales_squared,
    signal_variance,
    constant,
    slopes,
    out,
):
    """One posterior draw at u (d,), into out (m,): prior draw plus exact kernel update (pathwise conditioning).

    The arrays between are `PosteriorDraws.one(k)`, in its order; update (m, n) are the draw's own weights.
    """
    prior_draw_value(u, frequencies, phases, amplitudes, out)
    for o in range(out.shape[0]):
        out[o] += constant[o]
        for i in range(u.shape[0]):
            out[o] += slopes[o, i] * u[i]
    _add_kernel_sum(u, points, update, inverse_lengthscales_squared, signal_variance, out)


@njit(cache=True, fastmath=True, error_model="numpy")
def marginal_value(
    u, points, alpha, L, inverse_lengthscales_squared, signal_variance, prior_mean, normal, scratch, out
):
    """mean + standard deviation * normal at u (d,), into out (m,): a draw that remembers no earlier query.

    normal (m,) are standard normal numbers of the caller; L (m, n, n) as in `GaussianProcess`; scratch (n,) holds the
    forward substitution. n^2 / 2 operations an output.
    """
    n = np.uint64(points.shape[1])
    for o in range(alpha.shape[0]):
        _exponents(u, points, inverse_lengthscales_squared, o, _ZERO, n, scratch)
        mean = 0.0
        for j in range(n):
            scratch[j] = signal_variance[o] * _exp(scratch[j])
            mean += alpha[o, j] * scratch[j]
        explained = 0.0
        for j in range(n):
            below = 0.0
            for i in range(j):
                below += L[o, j, i] * scratch[i]
            v = (scratch[j] - below) / L[o, j, j]
            scratch[j] = v
            explained += v * v
        spread = np.sqrt(max(signal_variance[o] - explained, 0.0))
        out[o] = prior_mean[o] + mean + spread * normal[o]
