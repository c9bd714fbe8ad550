"""Tet meshes and skeletons made of others, for benchmarks and results."""

from pathlib import Path

import numpy as np

import judge


def write(path, V, T):
    with open(path, "w") as out:
        out.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(V)}\n")
        np.savetxt(out, np.c_[V, np.zeros(len(V))], fmt="%.17g %.17g %.17g %d")
        out.write(f"Tetrahedra\n{len(T)}\n")
        np.savetxt(out, np.c_[T + 1, np.zeros(len(T), int)], fmt="%d")
        out.write("End\n")


def refined(V, T):
    """Every tetrahedron in eight: four corners, and the octahedron between edge middles in four."""
    ends = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
    edges, which = np.unique(np.sort(T[:, ends].reshape(-1, 2), axis=1), axis=0,
                             return_inverse=True)
    a, b, c, d = T.T
    ab, ac, ad, bc, bd, cd = (which.reshape(-1, 6) + len(V)).T
    V = np.vstack([V, (V[edges[:, 0]] + V[edges[:, 1]]) / 2])
    T = np.vstack([np.stack(t, 1) for t in (
        (a, ab, ac, ad), (ab, b, bc, bd), (ac, bc, c, cd), (ad, bd, cd, d),
        (ab, ac, ad, bd), (ab, ac, bc, bd), (ac, ad, bd, cd), (ac, bc, bd, cd))])
    x = V[T]
    volume = np.einsum("ij,ij->i", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]),
                       x[:, 3] - x[:, 0])
    T[volume < 0] = T[volume < 0][:, [1, 0, 2, 3]]
    return V, T


def refined_surface(V, F):
    """Every triangle in four."""
    ends = np.array([(0, 1), (1, 2), (2, 0)])
    edges, which = np.unique(np.sort(F[:, ends].reshape(-1, 2), axis=1), axis=0,
                             return_inverse=True)
    a, b, c = F.T
    ab, bc, ca = (which.reshape(-1, 3) + len(V)).T
    V = np.vstack([V, (V[edges[:, 0]] + V[edges[:, 1]]) / 2])
    F = np.vstack([np.stack(t, 1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return V, F


def write_tgf(path, V, E):
    lines = ["{} {:.17g} {:.17g} {:.17g}".format(i + 1, *v) for i, v in enumerate(V)] + ["#"]
    lines += [f"{a + 1} {b + 1} 1 0 0" for a, b in E]
    Path(path).write_text("\n".join(lines) + "\n#\n")
    return path


def first_bones(source, count, path):
    """The first bones of a skeleton and their joints."""
    V, E = judge.read_tgf(source)
    E = E[:count]
    used = sorted({joint for bone in E for joint in bone})
    return write_tgf(path, [V[j] for j in used],
                     [(used.index(a), used.index(b)) for a, b in E])


def split_bones(source, parts, path):
    """Every bone in so many equal ones."""
    V, E = judge.read_tgf(source)
    V, bones = V.tolist(), []
    for a, b in E:
        chain = [a]
        for k in range(1, parts):
            chain.append(len(V))
            V.append([p + (q - p) * k / parts for p, q in zip(V[a], V[b])])
        chain.append(b)
        bones += list(zip(chain, chain[1:]))
    return write_tgf(path, V, bones)
