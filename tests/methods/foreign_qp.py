"""Solve a weights' program with SciPy's non-negative and bounded least squares.

    foreign_qp.py IN OUT

IN: lines "n m f", the (n,n) matrix A with energy 1/2 |A W|^2, then f lines "node w_1 .. w_m".
OUT: (n,m) weights with row sums in the problem (Lawson and Hanson's active sets, the sums as heavy
rows), then (n,m) with bounds alone (Stark and Parker's). Exit code 77 where SciPy is absent.
"""
import sys

try:
    import numpy as np
    from scipy.optimize import lsq_linear, nnls
except ImportError:
    sys.exit(77)

with open(sys.argv[1]) as file:
    n, m, f = (int(word) for word in file.readline().split())
    numbers = np.array(file.read().split(), float)
A = numbers[: n * n].reshape(n, n)
given = numbers[n * n :].reshape(f, 1 + m)
A /= np.abs(A).max()
node = given[:, 0].astype(int)
free = np.setdiff1d(np.arange(n), node)
F, b = A[:, free], -A[:, node] @ given[:, 1:]

heavy = 1e4 * np.hstack([np.eye(len(free))] * m)
system = np.vstack([np.kron(np.eye(m), F), heavy])
right = np.concatenate([b.T.ravel(), 1e4 * np.ones(len(free))])
coupled = nnls(system, right, maxiter=100000)[0].reshape(m, -1).T
decoupled = np.column_stack(
    [lsq_linear(F, b[:, j], bounds=(0, 1), method="bvls", tol=1e-14).x for j in range(m)]
)
with open(sys.argv[2], "w") as file:
    for solution in coupled, decoupled:
        W = np.zeros((n, m))
        W[node] = given[:, 1:]
        W[free] = solution
        np.savetxt(file, W, fmt="%.17g")
