"""Shapes made by code for docs/results-fields.md, in the place of the geometric-fields paper's: a gear
with thin gaps, a ribbon drawing, a flag and a skirt of loose patches, a character with floating ears.

Every function writes OBJ and TGF beside each other and returns the OBJ's path. Needs numpy.
"""

from pathlib import Path

import numpy as np

import judge
import meshes


def written(path, V, F, joints, bones):
    path = Path(path)
    judge.write_obj(path, np.asarray(V, float), np.asarray(F, int))
    meshes.write_tgf(path.with_suffix(".tgf"), joints, bones)
    return path


def extruded(V2, F2, zs):
    """A flat triangulation (counterclockwise) made solid between the heights zs."""
    n = len(V2)
    V = np.vstack([np.c_[V2, np.full(n, z)] for z in zs])
    edges = np.vstack([F2[:, [0, 1]], F2[:, [1, 2]], F2[:, [2, 0]]])
    known = {tuple(e) for e in edges}
    rim = np.array([e for e in edges if (e[1], e[0]) not in known])
    faces = [F2[:, ::-1], F2 + (len(zs) - 1) * n]
    for k in range(len(zs) - 1):
        a, b = rim[:, 0] + k * n, rim[:, 1] + k * n
        faces += [np.stack([a, b, b + n], 1), np.stack([a, b + n, a + n], 1)]
    return V, np.vstack(faces)


def gear(path, teeth=16, gap=0.004):
    """A hub and long teeth, `gap` apart at their roots; one bone a tooth and one in the hub."""
    inner, outer, across, along = 0.2, 0.5, 4, 10
    step = 2 * np.pi / teeth
    V, F, root = [[0.0, 0.0]], [], []
    for t in range(teeth):
        # Parallel flanks: the gap stays what it is.
        first = len(V)
        for i in range(along + 1):
            r = inner + (outer - inner) * i / along
            # As wide as the root allows, so that the gaps open outward only a little.
            half = 0.5 * (step * r - gap)
            half = min(half, 0.5 * (step * inner - gap) * (1 + 0.9 * (r / inner - 1)))
            for j in range(across + 1):
                angle = step * (t + 0.5) + (2 * j / across - 1) * half / r
                V.append([r * np.cos(angle), r * np.sin(angle)])
        for i in range(along):
            for j in range(across):
                a = first + i * (across + 1) + j
                b = a + across + 1
                F += [[a, b, b + 1], [a, b + 1, a + 1]]
        root += list(range(first, first + across + 1))
    for k, a in enumerate(root):
        F.append([0, a, root[(k + 1) % len(root)]])
    V3, F3 = extruded(np.array(V), np.array(F), np.linspace(0, 0.12, 4))
    joints, bones = [[0, 0, 0.03], [0, 0, 0.09]], [(0, 1)]
    for t in range(teeth):
        u = np.array([np.cos(step * (t + 0.5)), np.sin(step * (t + 0.5)), 0])
        bones.append((len(joints), len(joints) + 1))
        joints += [0.26 * u + [0, 0, 0.06], 0.46 * u + [0, 0, 0.06]]
    return written(path, V3, F3, joints, bones)


def ribbons(path, count=260, seed=3):
    """Strips laid over an ellipsoid as drawn by hand in virtual reality: each a piece of its own,
    none closed, crossing each other; three bones along the body."""
    rng = np.random.default_rng(seed)
    axes = np.array([0.5, 0.24, 0.22])
    V, F = [], []
    for _ in range(count):
        p = rng.standard_normal(3)
        p /= np.linalg.norm(p)
        t = np.cross(p, rng.standard_normal(3))
        t /= np.linalg.norm(t)
        side = np.cross(p, t)
        length, width, lift = rng.uniform(0.5, 1.4), rng.uniform(0.05, 0.1), rng.normal(0, 0.01)
        steps, first = 14, len(V)
        for i in range(steps + 1):
            angle = length * (i / steps - 0.5)
            at = np.cos(angle) * p + np.sin(angle) * t
            for s in (-1, 1):
                q = at + s * width * side
                V.append((1 + lift) * q / np.linalg.norm(q) * axes)
        for i in range(steps):
            a = first + 2 * i
            F += [[a, a + 2, a + 1], [a + 2, a + 3, a + 1]]
    V, F = np.array(V), np.array(F)
    centre = V[F].mean(1)
    normal = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    inward = np.einsum("ij,ij->i", normal, centre / axes**2) < 0
    F[inward] = F[inward][:, ::-1]
    joints = [[-0.42, 0, 0], [-0.14, 0, 0], [0.14, 0, 0], [0.42, 0, 0]]
    return written(path, V, F, joints, [(0, 1), (1, 2), (2, 3)])


def patches(surface, rows, columns, shrink, cut=3):
    """Loose quads of a surface (u, v) -> point, each shrunk about its middle."""
    V, F = [], []
    for r in range(rows):
        for c in range(columns):
            first = len(V)
            for i in range(cut + 1):
                for j in range(cut + 1):
                    u = (c + 0.5 + shrink * (j / cut - 0.5)) / columns
                    v = (r + 0.5 + shrink * (i / cut - 0.5)) / rows
                    V.append(surface(u, v))
            for i in range(cut):
                for j in range(cut):
                    a = first + i * (cut + 1) + j
                    F += [[a, a + 1, a + cut + 2], [a, a + cut + 2, a + cut + 1]]
    return np.array(V), np.array(F)


def flag(path):
    """A waving sheet of loose patches with bones along it: no inside."""
    height = lambda u: 0.05 * np.sin(7 * u) * u
    V, F = patches(lambda u, v: [u, 0.6 * v, height(u)], 12, 20, 0.92)
    joints = [[u, 0.3, height(u)] for u in np.linspace(0.02, 0.98, 5)]
    return written(path, V, F, joints, [(k, k + 1) for k in range(4)])


def skirt(path):
    """A cone of loose patches, open above and below; a bone at the waist and four around."""
    def surface(u, v):
        angle, r = 2 * np.pi * u, 0.2 + 0.3 * v
        return [r * np.cos(angle), 0.8 * (1 - v), -r * np.sin(angle)]
    V, F = patches(surface, 10, 36, 0.9)
    joints, bones = [[0, 0.78, 0], [0, 0.6, 0]], [(0, 1)]
    for k in range(4):
        u = np.array([np.cos(np.pi / 2 * k), 0, np.sin(np.pi / 2 * k)])
        bones.append((len(joints), len(joints) + 1))
        joints += [0.15 * u + [0, 0.55, 0], 0.36 * u + [0, 0.1, 0]]
    return written(path, V, F[:, [0, 2, 1]], joints, bones)


def ball(centre, radii, rings=12, around=20):
    V = [[0, 0, 1.0]]
    for i in range(1, rings):
        a = np.pi * i / rings
        V += [[np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)]
              for b in 2 * np.pi * np.arange(around) / around]
    V.append([0, 0, -1.0])
    F, last = [], len(V) - 1
    for j in range(around):
        k = (j + 1) % around
        F += [[0, 1 + j, 1 + k], [last, last - around + k, last - around + j]]
        for i in range(rings - 2):
            a, b = 1 + i * around + j, 1 + i * around + k
            F += [[a, a + around, b + around], [a, b + around, b]]
    return np.array(V) * radii + centre, np.array(F)


def eared(path):
    """A body with a head, and two ears that float above it: no bone reaches them. Returns the path
    and for each ear (its vertices, those of its tip)."""
    parts = [ball([0, 0, 0], [0.5, 0.22, 0.22]), ball([0.55, 0.0, 0.22], [0.17, 0.17, 0.17])]
    ears = [ball([0.55, y, 0.53], [0.035, 0.05, 0.12]) for y in (-0.09, 0.09)]
    V, F, groups, first = [], [], [], 0
    for k, (P, T) in enumerate(parts + ears):
        if k >= len(parts):
            own = first + np.arange(len(P))
            groups.append((own, own[P[:, 2] > 0.6]))
        V.append(P)
        F.append(T + first)
        first += len(P)
    joints = [[-0.42, 0, 0], [-0.05, 0, 0], [0.35, 0, 0.05], [0.6, 0, 0.25]]
    return (written(path, np.vstack(V), np.vstack(F), joints, [(0, 1), (1, 2), (2, 3)]), groups)
