"""Shapes made by code, for results: a brick, and a cactus in space and in the plane."""

import itertools

import numpy as np


def brick(nx, ny, nz):
    """Tetrahedra of a box of nx x ny x nz cubes of side 1 / nx, six a cube, as (V, T)."""
    axes = np.meshgrid(range(nx + 1), range(ny + 1), range(nz + 1), indexing="ij")
    V = np.stack([a.ravel() for a in axes], 1) / nx
    number = lambda c: (c[:, 0] * (ny + 1) + c[:, 1]) * (nz + 1) + c[:, 2]
    cells = np.stack([a.ravel() for a in
                      np.meshgrid(range(nx), range(ny), range(nz), indexing="ij")], 1)
    T = []
    for path in itertools.permutations(range(3)):  # from corner 000 to corner 111
        corner = cells.copy()
        corners = [number(corner)]
        for axis in path:
            corner[:, axis] += 1
            corners.append(number(corner))
        T.append(np.stack(corners, 1))
    T = np.vstack(T)
    inverted = np.linalg.det(V[T[:, 1:]] - V[T[:, :1]]) < 0
    T[inverted] = T[inverted][:, [1, 0, 2, 3]]
    return V, T


def ends(V):
    """Regions: the vertices of either end of a brick."""
    x = V[:, 0]
    return np.stack([x < x.min() + 1e-9, x > x.max() - 1e-9], 1).astype(float)


# Tubes from point to point, with their radius: a trunk and an arm on either side.
CACTUS = [((0, -1, 0), (0, 1, 0), 0.22),
          ((0, -0.1, 0), (-0.62, -0.1, 0), 0.13), ((-0.62, -0.1, 0), (-0.62, 0.55, 0), 0.13),
          ((0, 0.2, 0), (0.58, 0.2, 0), 0.12), ((0.58, 0.2, 0), (0.58, 0.8, 0), 0.12)]
# Points near its bottom and its top.
CACTUS_HANDLES = [(0, -1.05, 0), (0, 1.05, 0)]


def cactus_distance(X):
    """Distance of points (n,3) to the cactus, negative inside."""
    distance = np.full(len(X), np.inf)
    for a, b, radius in CACTUS:
        a, b = np.array(a, float), np.array(b, float)
        t = np.clip((X - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        distance = np.minimum(distance, np.linalg.norm(X - a - t[:, None] * (b - a), axis=1) - radius)
    return distance


def surface(distance, low, high, step):
    """Triangles (V, F) of the zero level of a distance, outward: a vertex in every cell of a grid
    that the level crosses, at the mean of the crossings of its edges (Gibson 1998, "Constrained
    elastic surface nets")."""
    axes = [np.arange(a, b + step, step) for a, b in zip(low, high)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    value = distance(grid.reshape(-1, 3)).reshape(grid.shape[:3])
    cells = tuple(s - 1 for s in value.shape)
    total, count = np.zeros(cells + (3,)), np.zeros(cells)
    crossings = []
    for axis in range(3):
        first = [slice(None)] * 3
        second = [slice(None)] * 3
        first[axis], second[axis] = slice(0, -1), slice(1, None)
        a, b = value[tuple(first)], value[tuple(second)]
        crossed = (a < 0) != (b < 0)
        share = np.where(crossed, a / np.where(crossed, a - b, 1), 0)
        place = grid[tuple(first)] + share[..., None] * (grid[tuple(second)] - grid[tuple(first)])
        crossings.append((crossed, a < 0))
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for du, dv in itertools.product((0, 1), repeat=2):
            take = [slice(None)] * 3
            take[u], take[v] = slice(du, du + cells[u]), slice(dv, dv + cells[v])
            here = crossed[tuple(take)]
            count += here
            total += np.where(here[..., None], place[tuple(take)], 0)
    number = np.full(cells, -1)
    number[count > 0] = np.arange((count > 0).sum())
    V = total[count > 0] / count[count > 0][:, None]
    F = []
    for axis, (crossed, inside) in enumerate(crossings):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        at = np.stack(np.nonzero(crossed), 1)
        ring = []
        for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = at.copy()
            cell[:, u] -= du
            cell[:, v] -= dv
            ring.append(number[tuple(cell.T)])
        ring = np.stack(ring, 1)
        leaving = inside[crossed]
        ring[~leaving] = ring[~leaving][:, ::-1]
        F += [ring[:, [0, 1, 2]], ring[:, [0, 2, 3]]]
    return V, np.vstack(F)


def sheet(nx, ny):
    """nx x ny squares of side 1 in the plane, two triangles each, as (V, F)."""
    i, j = (a.ravel() for a in np.meshgrid(range(nx + 1), range(ny + 1), indexing="ij"))
    V = np.stack([i, j, 0 * i], 1).astype(float)
    i, j = (a.ravel() for a in np.meshgrid(range(nx), range(ny), indexing="ij"))
    number = lambda i, j: i * (ny + 1) + j
    return V, np.vstack([np.stack([number(i, j), number(i + 1, j), number(i + 1, j + 1)], 1),
                         np.stack([number(i, j), number(i + 1, j + 1), number(i, j + 1)], 1)])


def painting(width, height):
    """A picture (height, width, 3) with lines to see a warp by: a grid on a sky, and a sun."""
    y, x = np.mgrid[0:height, 0:width]
    t = y / height
    picture = np.stack([0.55 + 0.35 * t, 0.72 - 0.1 * t, 0.95 - 0.55 * t], -1)
    far = np.hypot(x - 0.3 * width, y - 0.35 * height)
    picture[far < 0.16 * height] = (0.98, 0.85, 0.3)
    hill = 0.72 * height + 0.08 * height * np.sin(3 * np.pi * x / width)
    picture[y > hill] = (0.3, 0.55, 0.3)
    picture[(x % (width // 16) < 2) | (y % (width // 16) < 2)] *= 0.75
    return picture


def cactus(step=0.06):
    return surface(cactus_distance, (-0.9, -1.4, -0.4), (0.9, 1.4, 0.4), step)


def cactus_in_the_plane(step=0.03):
    """Its section z = 0 as right triangles on a grid, whose stiffness is an M-matrix: (V, F)."""
    x, y = np.arange(-0.9, 0.9, step), np.arange(-1.26, 1.26, step)
    X, Y = np.meshgrid(x, y, indexing="ij")
    corners = np.stack([X.ravel(), Y.ravel(), np.zeros(X.size)], 1)
    inside = cactus_distance(corners + [step / 2, step / 2, 0]).reshape(X.shape)[:-1, :-1] < 0
    i, j = np.nonzero(inside)
    number = lambda i, j: i * len(y) + j
    F = np.vstack([np.stack([number(i, j), number(i + 1, j), number(i + 1, j + 1)], 1),
                   np.stack([number(i, j), number(i + 1, j + 1), number(i, j + 1)], 1)])
    kept, F = np.unique(F, return_inverse=True)
    return corners[kept], F.reshape(-1, 3)
