"""Measures of weights, made without the program that computed them; shapes for `make results`.

Needs numpy. Distances: the total variation (TV) of two weight matrices is the mean over vertices of
half the sum of absolute differences of their rows.
"""

import heapq
import json
import struct
from pathlib import Path

import numpy as np


# ---- weights -------------------------------------------------------------------------------------

def read_npz(path):
    """Weights (n,m) of an NPZ as skinfield writes it: `weights`, or CSR parts."""
    with np.load(path, allow_pickle=False) as z:
        if "weights" in z:
            return np.asarray(z["weights"], float)
        n, m = (int(v) for v in z["shape"])
        W = np.zeros((n, m))
        rows = np.repeat(np.arange(n), np.diff(z["indptr"]))
        np.add.at(W, (rows, z["indices"]), z["data"])
        return W


def read_gltf(path):
    """The document and its binary buffers."""
    path = Path(path)
    blob = path.read_bytes()
    binary = None
    if blob[:4] == b"glTF":
        length = struct.unpack_from("<I", blob, 12)[0]
        document = json.loads(blob[20:20 + length])
        at = 20 + length
        if at + 8 <= len(blob):
            binary = blob[at + 8:at + 8 + struct.unpack_from("<I", blob, at)[0]]
    else:
        document = json.loads(blob)
    buffers = []
    for buffer in document.get("buffers", []):
        uri = buffer.get("uri")
        if uri is None:
            buffers.append(binary)
        elif uri.startswith("data:"):
            import base64
            buffers.append(base64.b64decode(uri.split(",", 1)[1]))
        else:
            buffers.append((path.parent / uri).read_bytes())
    return document, buffers


def accessor(document, buffers, index):
    """Values of one accessor (count, components), normalised integers turned to fractions."""
    a = document["accessors"][index]
    kind = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
    dtype = np.dtype("<" + kind[a["componentType"]])
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[a["type"]]
    if "bufferView" not in a:
        return np.zeros((a["count"], width))
    view = document["bufferViews"][a["bufferView"]]
    start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
    stride = view.get("byteStride") or width * dtype.itemsize
    data = np.frombuffer(buffers[view["buffer"]], np.uint8)
    take = start + stride * np.arange(a["count"])[:, None] + np.arange(width * dtype.itemsize)
    values = np.ascontiguousarray(data[take]).view(dtype).reshape(a["count"], width).astype(float)
    return values / np.iinfo(dtype).max if a.get("normalized") else values


def gltf_row_faults(path):
    """(vertices, largest row-sum error, negative entries, non-finite entries, empty rows) over every
    skinned primitive of a glTF."""
    document, buffers = read_gltf(path)
    vertices, error, negative, broken, empty = 0, 0.0, 0, 0, 0
    for mesh in {n["mesh"] for n in document.get("nodes", []) if "mesh" in n and "skin" in n}:
        for primitive in document["meshes"][mesh]["primitives"]:
            names = sorted(k for k in primitive["attributes"] if k.startswith("WEIGHTS_"))
            if not names:
                empty += document["accessors"][primitive["attributes"]["POSITION"]]["count"]
                continue
            W = np.hstack([accessor(document, buffers, primitive["attributes"][k]) for k in names])
            sums = W.sum(1)
            vertices += len(W)
            broken += int((~np.isfinite(W)).sum())
            negative += int((W < 0).sum())
            empty += int((np.nan_to_num(sums) < 0.5).sum())
            error = max(error, float(np.abs(sums - 1).max()))
    return vertices, error, negative, broken, empty


def row_faults(W):
    sums = W.sum(1)
    return (len(W), float(np.abs(sums - 1).max()), int((W < 0).sum()),
            int((~np.isfinite(W)).sum()), int((np.nan_to_num(sums) < 0.5).sum()))


def row_distances(A, B):
    """Half the L1 difference of each pair of rows."""
    return 0.5 * np.abs(A - B).sum(1)


# ---- meshes --------------------------------------------------------------------------------------

def read_medit(path):
    words = Path(path).read_text().split()
    def block(key, width, kind):
        at = words.index(key)
        count = int(words[at + 1])
        return np.array(words[at + 2:at + 2 + count * width], kind).reshape(count, width)
    return block("Vertices", 4, float)[:, :3], block("Tetrahedra", 5, int)[:, :4] - 1


def boundary(T):
    """Triangles that one tetrahedron alone has, oriented outward for positive tetrahedra."""
    faces = np.vstack([T[:, [0, 2, 1]], T[:, [0, 1, 3]], T[:, [0, 3, 2]], T[:, [1, 2, 3]]])
    _, first, count = np.unique(np.sort(faces, 1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def hand_surface(folder, out):
    """Writes the boundary of fem/hand.mesh as OBJ; returns the tet mesh's numbers of its vertices."""
    V, T = read_medit(Path(folder) / "fem" / "hand.mesh")
    corners = V[T]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    T = np.where(volume[:, None] < 0, T[:, [0, 2, 1, 3]], T)
    F = boundary(T)
    kept = np.unique(F)
    write_obj(out, V[kept], np.searchsorted(kept, F))
    return kept


def write_obj(path, V, F):
    with open(path, "w") as f:
        f.writelines("v %.17g %.17g %.17g\n" % tuple(v) for v in V)
        f.writelines("f %d %d %d\n" % tuple(t + 1) for t in F)


def read_obj(path):
    V, F = [], []
    for line in Path(path).read_text().splitlines():
        if line.startswith("v "):
            V.append([float(x) for x in line.split()[1:4]])
        elif line.startswith("f "):
            F.append([int(x.split("/")[0]) - 1 for x in line.split()[1:4]])
    return np.array(V), np.array(F)


def read_tgf(path):
    """Joints (k,3) and bones [(a, b)] 0-based; extra columns ignored."""
    ids, joints, bones, part = [], [], [], 0
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if words and words[0].startswith("#"):
            part += 1
        elif words and part == 0:
            ids.append(int(float(words[0])))
            joints.append([float(x) for x in words[1:4]])
        elif len(words) >= 2 and part == 1:
            bones.append((ids.index(int(words[0])), ids.index(int(words[1]))))
    return np.array(joints), bones


def fingers(bones):
    """Column sets of the chains that end in a leaf and begin where the skeleton branches."""
    tails = {}
    for column, (a, b) in enumerate(bones):
        tails.setdefault(a, []).append(column)
    heads = {b: column for column, (a, b) in enumerate(bones)}
    chains = []
    for column, (a, b) in enumerate(bones):
        if b in tails:
            continue
        chain = [column]
        while len(tails[bones[chain[-1]][0]]) == 1 and bones[chain[-1]][0] in heads:
            chain.append(heads[bones[chain[-1]][0]])
        chains.append(chain)
    return chains


def bleeding(W, reference, bones):
    """Largest weight of one finger's bones where another finger's tip bone has 0.9 or more."""
    worst = 0.0
    chains = fingers(bones)
    for mine in chains:
        tip = reference[:, mine[0]] >= 0.9
        for other in chains:
            if other is not mine and tip.any():
                worst = max(worst, float(W[tip][:, other].max()))
    return worst


def torn(V, F, removed, jitter, seed):
    """A triangle soup: a share of the faces gone, each corner of the rest moved on its own
    (Gaussian, share of the box's largest side). Returns (vertices, faces, clean vertex of each)."""
    rng = np.random.default_rng(seed)
    kept = F[rng.random(len(F)) >= removed]
    clean = kept.reshape(-1)
    step = jitter * (V.max(0) - V.min(0)).max()
    moved = V[clean] + step * rng.standard_normal((len(clean), 3))
    return moved, np.arange(len(clean)).reshape(-1, 3), clean


def fork(gap, path):
    """Two square prongs on a base, `gap` apart, as OBJ and TGF beside it: columns base, left, right.
    Returns the vertex numbers of the left prong's inner wall and of the right one's."""
    side, step = 0.3, 0.05
    line = lambda a, b: np.linspace(a, b, max(2, round((b - a) / step) + 1))
    xs = np.concatenate([line(-side - gap / 2, -gap / 2), line(gap / 2, side + gap / 2)])
    ys = np.concatenate([line(-0.4, 0.0), line(0.0, 1.0)[1:]])
    zs = line(0, side)
    full = np.ones((len(xs) - 1, len(ys) - 1, len(zs) - 1), bool)
    full[len(xs) // 2 - 1, ys[:-1] > -1e-9, :] = False
    padded = np.pad(full, 1)
    number, V, F = {}, [], []

    def vertex(ijk):
        if ijk not in number:
            number[ijk] = len(V)
            V.append([xs[ijk[0]], ys[ijk[1]], zs[ijk[2]]])
        return number[ijk]

    for i, j, k in zip(*np.nonzero(full)):
        for axis in range(3):
            for sign in (0, 1):
                neighbour = [i + 1, j + 1, k + 1]
                neighbour[axis] += 1 if sign else -1
                if padded[tuple(neighbour)]:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                corner = []
                for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    at = [i, j, k]
                    at[axis] += sign
                    at[u] += a
                    at[v] += b
                    corner.append(vertex(tuple(at)))
                if not sign:
                    corner.reverse()
                F += [[corner[0], corner[1], corner[2]], [corner[0], corner[2], corner[3]]]
    V, F = np.array(V), np.array(F)
    write_obj(path, V, F)
    middle = (side + gap) / 2
    Path(path).with_suffix(".tgf").write_text(
        f"1 0 -0.35 0.15\n2 0 -0.2 0.15\n3 {-middle} 0.1 0.15\n4 {-middle} 0.9 0.15\n"
        f"5 {middle} 0.1 0.15\n6 {middle} 0.9 0.15\n#\n1 2 1 0 0\n3 4 1 0 0\n5 6 1 0 0\n")
    high = V[:, 1] > 0.3
    return (np.nonzero(high & np.isclose(V[:, 0], -gap / 2, atol=1e-12))[0],
            np.nonzero(high & np.isclose(V[:, 0], gap / 2, atol=1e-12))[0])


def edges_of(elements):
    """Edges (e,2) of triangles or tetrahedra, each once."""
    k = elements.shape[1]
    pairs = np.vstack([elements[:, [i, j]] for i in range(k) for j in range(i + 1, k)])
    return np.unique(np.sort(pairs, 1), axis=0)


def local_extrema(W, edges, tolerance=1e-4):
    """(n,m): 1 where a weight is above all neighbours along the edges by more than the tolerance, -1
    where it is below all; weights within the tolerance of 1 (of 0) and lone vertices are neither."""
    both = np.vstack([edges, edges[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    vertices, first = np.unique(both[:, 0], return_index=True)
    around = W[both[:, 1]]
    mine = W[vertices]
    marks = np.zeros(W.shape, int)
    marks[vertices] = (((mine > np.maximum.reduceat(around, first) + tolerance) &
                        (mine < 1 - tolerance)).astype(int) -
                       ((mine < np.minimum.reduceat(around, first) - tolerance) &
                        (mine > tolerance)).astype(int))
    return marks


def prominent_extrema(W, edges, tolerance=1e-4):
    """Extrema (vertex, column, prominence) of W: how far a weight has to fall (rise) before it can go
    on to a higher (lower) one, where that is more than the tolerance; inf where it cannot. Flat hills
    count too, which are too smooth to stand out from their neighbours. Weights within the tolerance
    of 1 (of 0) are none."""
    n = len(W)
    both = np.vstack([edges, edges[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    start = np.searchsorted(both[:, 0], np.arange(n + 1))
    vertices, first = np.unique(both[:, 0], return_index=True)
    around = np.full(W.shape, np.inf)
    found = []
    for sign in (1, -1):
        S = sign * W
        around[vertices] = np.maximum.reduceat(S[both[:, 1]], first)
        peaks = (S >= around) & (W > tolerance if sign < 0 else W < 1 - tolerance)
        for v, j in zip(*np.nonzero(peaks)):
            seen, heap, lowest = {v}, [(-S[v, j], v)], S[v, j]
            prominence = np.inf
            while heap:
                value, u = heapq.heappop(heap)
                lowest = min(lowest, -value)
                # Of a plateau the first vertex stands for all.
                if -value > S[v, j] or (-value == S[v, j] and u < v):
                    prominence = S[v, j] - lowest
                    break
                for k in both[start[u]:start[u + 1], 1]:
                    if k not in seen:
                        seen.add(k)
                        heapq.heappush(heap, (-S[k, j], k))
            if prominence > tolerance:
                found.append((int(v), int(j), float(prominence)))
    return found
