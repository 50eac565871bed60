"""Vectors as tuples, which stay in registers; `A[i]` of an array is loaded and put."""

import numpy as np

from orbident.loops import looped


@looped
def load(A, i):
    """`A[i]`."""
    return A[i, 0], A[i, 1], A[i, 2]


@looped
def put(A, i, a):
    """`A[i] = a`."""
    A[i, 0], A[i, 1], A[i, 2] = a


@looped
def add(A, i, a):
    """`A[i] += a`."""
    A[i, 0] += a[0]
    A[i, 1] += a[1]
    A[i, 2] += a[2]


@looped
def plus(a, b):
    """`a + b`."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@looped
def times(k, a):
    """`k a`."""
    return k * a[0], k * a[1], k * a[2]


@looped
def dot(a, b):
    """`a . b`."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@looped
def cross(a, b):
    """`a x b`."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@looped
def rotated(R, i, a):
    """`R[i] a`."""
    return (
        R[i, 0, 0] * a[0] + R[i, 0, 1] * a[1] + R[i, 0, 2] * a[2],
        R[i, 1, 0] * a[0] + R[i, 1, 1] * a[1] + R[i, 1, 2] * a[2],
        R[i, 2, 0] * a[0] + R[i, 2, 1] * a[1] + R[i, 2, 2] * a[2],
    )


@looped
def rotated_back(R, i, a):
    """`R[i]^T a`."""
    return (
        R[i, 0, 0] * a[0] + R[i, 1, 0] * a[1] + R[i, 2, 0] * a[2],
        R[i, 0, 1] * a[0] + R[i, 1, 1] * a[1] + R[i, 2, 1] * a[2],
        R[i, 0, 2] * a[0] + R[i, 1, 2] * a[1] + R[i, 2, 2] * a[2],
    )


@looped
def row(R, i, j):
    """`R[i, j]`."""
    return R[i, j, 0], R[i, j, 1], R[i, j, 2]


@looped
def six(A, i, k):
    """`A[i, k:k + 6]`."""
    return A[i, k], A[i, k + 1], A[i, k + 2], A[i, k + 3], A[i, k + 4], A[i, k + 5]


@looped
def symmetric(J, a):
    """`J a`, of `J = [Jxx, Jxy, Jyy, Jxz, Jyz, Jzz]`."""
    xx, xy, yy, xz, yz, zz = J
    return (
        xx * a[0] + xy * a[1] + xz * a[2],
        xy * a[0] + yy * a[1] + yz * a[2],
        xz * a[0] + yz * a[1] + zz * a[2],
    )


@looped
def quaternion_matrix(x, y, z, w):
    """`R_WB` of a quaternion of any nonzero norm."""
    s = 2 / (x * x + y * y + z * z + w * w)
    R = np.empty((1, 3, 3))
    put(R[0], 0, (1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)))
    put(R[0], 1, (s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)))
    put(R[0], 2, (s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)))
    return R
