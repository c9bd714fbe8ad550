"""docs/results-fields.md and its pictures, from what tools/results_fields.py collected."""

import colorsys

import numpy as np

import judge
from results import run
from results_page import escape, number, table

RULES = {"counted": "counted (default)", "any-hit": "any hit (the paper's)", "none": "none"}
PICTURES = {
    "visibility": "results-fields-visibility.png", "slice": "results-fields-slice.png",
    "widths": "results-fields-widths.png", "boundary": "results-fields-boundary.png",
    "multiscale": "results-fields-multiscale.png", "degradation": "results-fields-torn.png",
    "painting": "results-fields-painting.png", "cost": "results-fields-cost.png"}


def plotting():
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        return pyplot
    except ImportError:
        return None


# ---- pictures ------------------------------------------------------------------------------------

def colours(count):
    """Alike for neighbours in number as little as may be."""
    hues = [(0.61803 * k) % 1 for k in range(count)]
    return np.array([colorsys.hsv_to_rgb(h, 0.45 + 0.5 * (k % 2), 0.95 - 0.25 * (k // 2 % 2))
                     for k, h in enumerate(hues)])


def blended(W):
    return np.clip(W @ colours(W.shape[1]), 0, 1)


def winding(V, F, X):
    """Generalised winding numbers, triangle by triangle (van Oosterom and Strackee)."""
    total = np.zeros(len(X))
    for a, b, c in V[F]:
        A, B, C = a - X, b - X, c - X
        la, lb, lc = (np.linalg.norm(P, axis=1) for P in (A, B, C))
        det = np.einsum("ij,ij->i", A, np.cross(B, C))
        low = (la * lb * lc + np.einsum("ij,ij->i", A, B) * lc + np.einsum("ij,ij->i", B, C) * la
               + np.einsum("ij,ij->i", C, A) * lb)
        total += np.arctan2(det, low)
    return total / (2 * np.pi)


def slice_grid(V, axis, level, pixels):
    """Points of a plane across an axis, and the picture's extent."""
    u, v = (k for k in range(3) if k != axis)
    low, high = V.min(0), V.max(0)
    rim = 0.04 * (high - low).max()
    width = pixels
    height = max(8, round(pixels * (high[v] - low[v] + 2 * rim) / (high[u] - low[u] + 2 * rim)))
    x = np.linspace(low[u] - rim, high[u] + rim, width)
    y = np.linspace(low[v] - rim, high[v] + rim, height)
    X = np.zeros((width * height, 3))
    X[:, u], X[:, v] = (g.ravel() for g in np.meshgrid(x, y))
    X[:, axis] = level
    return X, (height, width), (x[0], x[-1], y[0], y[-1])


def on_slice(options, field, X, stem):
    """A saved field's weights at points."""
    cloud, out = options.out / f"{stem}-slice.ply", options.out / f"{stem}-slice.npz"
    with open(cloud, "w") as f:
        f.write("ply\nformat ascii 1.0\n" + f"element vertex {len(X)}\n" +
                "".join(f"property double {c}\n" for c in "xyz") + "end_header\n")
        np.savetxt(f, X, fmt="%.9g")
    ran = run([options.program, "transfer", field, cloud, "-o", out, "--quiet"])
    return judge.read_npz(out) if ran["code"] == 0 else None


def shots(options, path, cells, columns, size=420):
    """Pictures by the program itself, side by side; a cell is (title, arguments of render)."""
    pyplot = plotting()
    if not pyplot:
        return
    rows = (len(cells) + columns - 1) // columns
    figure, axes = pyplot.subplots(rows, columns, figsize=(3 * columns, 3.1 * rows), squeeze=False)
    for panel in axes.ravel():
        panel.axis("off")
    for panel, (title, arguments) in zip(axes.ravel(), cells):
        shot = options.out / "shot.png"
        shot.unlink(missing_ok=True)
        run([options.program, "render", *arguments, "--width", size, "--height", size, "-o", shot,
             "--quiet"])
        if shot.exists():
            panel.imshow(pyplot.imread(shot))
        panel.set_title(title, fontsize=9)
    figure.tight_layout()
    figure.savefig(path, dpi=80)


def gear_slices(results, options, folder):
    pyplot = plotting()
    mesh = options.out / "gear.obj"
    if not pyplot or not mesh.exists():
        return
    V, F = judge.read_obj(mesh)
    X, shape, extent = slice_grid(V, 2, 0.05, 340)
    w = winding(V, F, X)
    inside = (w > 0.5).reshape(shape)
    pictures = {}
    for rule in RULES:
        W = on_slice(options, options.out / f"gear-{rule}.sfield", X, f"gear-{rule}")
        if W is None:
            return
        image = blended(W).reshape(*shape, 3)
        image[~inside] = 1
        pictures[rule] = image
    figure, axes = pyplot.subplots(1, 2, figsize=(8, 4.2))
    drawn = axes[0].imshow(w.reshape(shape), origin="lower", extent=extent, cmap="viridis")
    axes[0].set_title("winding number", fontsize=9)
    figure.colorbar(drawn, ax=axes[0], shrink=0.8)
    axes[1].imshow(pictures["counted"], origin="lower", extent=extent)
    axes[1].set_title("weights, handles' colours blended", fontsize=9)
    for panel in axes:
        panel.axis("off")
    figure.tight_layout()
    figure.savefig(folder / PICTURES["slice"], dpi=90)
    figure, axes = pyplot.subplots(1, 3, figsize=(9, 3.4))
    for panel, rule in zip(axes, RULES):
        panel.imshow(pictures[rule], origin="lower", extent=extent)
        panel.set_xlim(0.1, 0.5), panel.set_ylim(-0.2, 0.2)
        panel.set_title(RULES[rule], fontsize=9)
        panel.axis("off")
    figure.tight_layout()
    figure.savefig(folder / PICTURES["visibility"], dpi=90)


def boundary_slices(results, options, folder):
    pyplot = plotting()
    if not pyplot:
        return
    V, F = judge.read_obj(options.data / "surface" / "fish.obj")
    axis = int(np.argmin(np.ptp(V, axis=0)))
    middle = 0.5 * (V[:, axis].min() + V[:, axis].max())
    X, shape, extent = slice_grid(V, axis, middle, 420)
    inside = (winding(V, F, X) > 0.5).reshape(shape)
    figure, axes = pyplot.subplots(1, 2, figsize=(10, 10.5 * shape[0] / shape[1] / 2 + 0.6))
    for panel, kind in zip(axes, ("natural", "neumann")):
        W = on_slice(options, options.out / f"fish-{kind}.sfield", X, f"fish-{kind}")
        if W is None:
            return
        image = blended(W).reshape(*shape, 3)
        image[~inside] = 1
        panel.imshow(image, origin="lower", extent=extent)
        for column in range(W.shape[1]):
            values = np.where(inside, W[:, column].reshape(shape), np.nan)
            if np.nanmax(values) > 0.3:
                panel.contour(values, [.2, .4, .6, .8], origin="lower", extent=extent,
                              colors="black", linewidths=0.6)
        panel.set_title(f"{kind}: level lines of the weights", fontsize=9)
        panel.axis("off")
    figure.tight_layout()
    figure.savefig(folder / PICTURES["boundary"], dpi=90)


def curves(results, folder):
    pyplot = plotting()
    names = list(dict.fromkeys(r["name"] for r in results["multiscale"]))
    if not pyplot or not names:
        return
    figure, axes = pyplot.subplots(1, len(names), figsize=(5 * len(names), 3.6), squeeze=False)
    for panel, name in zip(axes[0], names):
        for r in results["multiscale"]:
            if r["name"] == name and r.get("curve"):
                points = np.array(r["curve"], float)
                panel.semilogy(points[:, 0], points[:, 2], label=r["label"], linewidth=1)
        panel.set_title(name, fontsize=9)
        panel.set_xlabel("step of adam")
        panel.set_ylabel("energy, judged")
        panel.grid(alpha=0.3, which="both")
        panel.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(folder / PICTURES["multiscale"], dpi=90)


def shares(row):
    """Of the stages' wall time: preparing the solid, evaluating the vertices, all else."""
    stages = row["stages"]
    total = sum(stages.values())
    solid, evaluation = (stages.get(f"field_{k}", 0) / total for k in ("solid", "evaluation"))
    return solid, evaluation, 1 - solid - evaluation


def cost_plots(results, folder):
    pyplot = plotting()
    if not pyplot:
        return
    figure, axes = pyplot.subplots(1, 2, figsize=(9, 3.4))
    for panel, kind in zip(axes, ("bones", "triangles")):
        rows = [r for r in results["cost"] if r["kind"] == kind and "failure" not in r]
        count = [r["count"] for r in rows]
        panel.plot(count, [r["cpu"] for r in rows], "o-", label="whole program")
        panel.plot(count, [r["solve_cpu"] * shares(r)[2] for r in rows], "s--",
                   label="sampling, rows, minimising")
        panel.set_xlabel(kind)
        panel.set_ylabel("CPU s")
        panel.set_ylim(bottom=0)
        if kind == "triangles":
            panel.set_xscale("log")
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(folder / PICTURES["cost"], dpi=90)


def pictures(name, results, options):
    """Beside the page; none where matplotlib or what they show is missing."""
    folder = options.document.parent
    surface = options.data / "surface"
    if name == "visibility":
        gear_slices(results, options, folder)
    if name == "boundary":
        boundary_slices(results, options, folder)
    if name == "multiscale":
        curves(results, folder)
    if name == "cost":
        cost_plots(results, folder)
    if name == "widths":
        hand = [options.out / "hand.obj", "--skeleton", options.data / "fem" / "hand.tgf"]
        shots(options, folder / PICTURES["widths"],
              [(f"sigma x {r['width']}, h x {r['step']}",
                [*hand, "--kind", "dominant", "--weights",
                 options.out / f"hand-width-{r['width']}-{r['step']}.npz"])
               for r in results["widths"] if "failure" not in r], 3, 300)
    if name == "painting":
        eared = options.out / "eared.obj"
        shots(options, folder / PICTURES["painting"],
              [(title, [eared, "--skeleton", eared.with_suffix(".tgf"), "--kind", "dominant",
                        "--weights", options.out / f"eared-{stem}.npz"])
               for title, stem in (("20 steps, no paint", "convex-before"),
                                   ("tips painted, resumed", "convex-after"))], 2)
    if name == "degradation":
        cells = []
        for r in results["degradation"]:
            mesh = options.out / f"{r['name']}-torn-{r['removed']:g}.obj"
            common = [mesh, "--skeleton", surface / f"{r['name']}.tgf", "--weights",
                      options.out / f"{mesh.stem}.npz"]
            cells.append((f"{r['name']}, {r['removed']:.0%} removed",
                          [*common, "--kind", "posed", "--pose", "demo"]))
        shots(options, folder / PICTURES["degradation"], cells, 5, 300)


# ---- the page ------------------------------------------------------------------------------------

def figure(folder, name, text):
    return [f"![{text}]({PICTURES[name]})\n"] if (folder / PICTURES[name]).exists() else []


def failed(row, cells):
    return ["**failed**: " + escape(row["failure"])] + [""] * (cells - 1)


def three(row):
    if row.get("tv") is None:
        return ""
    return f"{row['tv']:.4f} / {row['p95']:.3f} / {row['largest']:.3f}"


def ablations(results, folder):
    text = []
    if results.get("visibility"):
        text += ["## Visibility (figures 3 and 5)\n",
                 "What blocks the view between two places. Hand: bleeding is the largest weight of one "
                 "finger's bones on another finger's tip. Gear: teeth 0.004 apart at the root; the "
                 "largest weight of another tooth's bone on a tooth's outer half. `convex`, 2^13 "
                 "points.\n",
                 table(["rule", "hand: TV to exact, mean / 95% / largest", "bleeding",
                        "gear: across the gaps", "CPU s"],
                       [[RULES[r["rule"]], *failed(r, 4)] if "failure" in r else
                        [RULES[r["rule"]], three(r), f"{r['bleeding']:.4f}",
                         number(r.get("teeth"), "{:.4f}"), f"{r['cpu']:.1f}"]
                        for r in results["visibility"]])]
        text += figure(folder, "visibility", "Weights of the gear on a slice, by rule")
        text += figure(folder, "slice", "Winding number and weights on a slice of the gear")
    if results.get("widths"):
        text += ["## Sigma and h (figure 11)\n",
                 "The hand, `convex`, 2^13 points; sigma and h halved and doubled about their "
                 "defaults. The conditions' radii are half of sigma, as in the paper. Energies by "
                 "one estimator, step 0.01.\n",
                 table(["sigma", "h", "TV to exact, mean / 95% / largest", "energy", "CPU s"],
                       [[f"x {r['width']}", f"x {r['step']}", *failed(r, 3)] if "failure" in r else
                        [f"x {r['width']}", f"x {r['step']}", three(r),
                         number(r.get("energy"), "{:,.0f}"), f"{r['cpu']:.1f}"]
                        for r in results["widths"]])]
        text += figure(folder, "widths", "The bone that each vertex follows most")
    if results.get("multiscale"):
        text += ["## Coarse to fine (figures 12 and 13)\n",
                 "`adam`, all 6,000 steps, 256 samples a step, natural boundaries; the same number of "
                 "steps at four levels up to 2^13 points, with all points at once, and with 2^10 "
                 "alone. Energies along the solve by the axis-aligned estimator, step 0.01: they fall with "
                 "the conditions' radii, which are half of sigma, wherever the levels change, and what "
                 "is far from handles weighs little in them; the distance to exact weights says how "
                 "that has settled.\n",
                 table(["shape", "levels", "points", "energy", "TV to exact, mean / 95% / largest",
                        "CPU s"],
                       [[r["name"], r["label"], f"{r['points']:,}", *failed(r, 3)]
                        if "failure" in r else
                        [r["name"], r["label"], f"{r['points']:,}", number(r["energy"], "{:,.1f}"),
                         three(r), f"{r['cpu']:.0f}"] for r in results["multiscale"]])]
        text += figure(folder, "multiscale", "Energy along the solve")
    if results.get("boundary"):
        text += ["## Natural and zero Neumann boundaries (figures 7 and 16)\n",
                 "The hand, `convex`. The reference's stiffness has zero Neumann built in.\n",
                 table(["boundary", "points", "TV to exact, mean / 95% / largest", "energy", "CPU s"],
                       [[r["kind"], f"{r['points']:,}", *failed(r, 3)] if "failure" in r else
                        [r["kind"], f"{r['points']:,}", three(r), number(r["energy"], "{:,.0f}"),
                         f"{r['cpu']:.1f}"] for r in results["boundary"]])]
        text += figure(folder, "boundary", "Level lines on a slice of the fish")
    if results.get("degradation"):
        text += ["## Torn shapes (figure 14)\n",
                 "Faces removed at random, each corner of the rest moved on its own (Gaussian, share of "
                 "the box's largest side). TV: the torn shape's field read off on the clean surface, "
                 "against the clean shape's; 0%: the whole shape with other random numbers. `convex`, 2^13 "
                 "points.\n",
                 table(["shape", "removed", "jitter", "valid", "TV, mean / 95% / largest", "rung",
                        "CPU s"],
                       [[r["name"], f"{r['removed']:.0%}", r["jitter"], *failed(r, 4)]
                        if "failure" in r else
                        [r["name"], f"{r['removed']:.0%}", r["jitter"], "yes" if r["valid"] else "no",
                         three(r), r["rung"], f"{r['cpu']:.1f}"] for r in results["degradation"]])]
        text += figure(folder, "degradation", "Torn shapes in the demo pose")
    if results.get("painting"):
        text += ["## Painting (figures 6 and 17)\n",
                 "Two ears that float above a head: no bone reaches them, and they hold on to what is "
                 "nearest. A solve stops and is saved; one ear's tip is painted with the head's bone, "
                 "the other's with the tail's; the solve goes on, the ears now part of the shape. Mean "
                 "weights of each ear's vertices (tail, middle, head):\n",
                 table(["stage", "first ear", "second ear", "steps"],
                       [[r["stage"], *failed(r, 3)] if "failure" in r else
                        [r["stage"], *(" / ".join(f"{v:.2f}" for v in ear) for ear in r["ears"]),
                         r["iterations"]] for r in results["painting"]])]
        text += figure(folder, "painting", "Before and after")
    return text


def table_one(rows, shapes):
    names = {"convex-natural": "convex", "convex-neumann": "convex, Neumann",
             "adam-pool-natural": "adam-pool", "adam-pool-neumann": "adam-pool, Neumann",
             "adam-natural": "adam"}
    seconds, quality = [], []
    missing = [name for name in shapes if name not in {r["name"] for r in rows}]
    for r in rows:
        m = r["methods"]
        tets = m.get("tets", {})
        known = next((v for v in m.values() if v.get("vertices")), {})
        cells = [r["name"], number(known.get("vertices"), "{:,}"), number(known.get("bones"), "{}"),
                 "failed: " + escape(tets["failure"])[:90] if "failure" in tets else
                 f"{tets['cpu']:.1f} ({tets['route'] or tets['rung']})"]
        for key in names:
            one = m.get(key)
            if one is None:
                cells.append("")
            elif "failure" in one:
                cells.append("failed: " + escape(one["failure"])[:60])
            else:
                cells.append(f"{one['cpu']:.1f}"
                             + ("" if one["rung"] == "volume" else f" ({one['rung']})")
                             + ("" if one["valid"] else " **invalid**"))
        seconds.append(cells)
        if any(m.get(key, {}).get("energy") for key in names):
            quality.append([r["name"], *(number(m.get(key, {}).get("energy"), "{:,.4g}")
                                         for key in names),
                            *(number(m.get(key, {}).get("tv"), "{:.4f}")
                              for key in ("tets", *names))])
    return ["## Table 1\n",
            "CPU seconds of the whole program, end to end: `bbw --domain tets --nodes 16000` "
            "(in brackets how the tetrahedra were made) beside geometric fields with 2^13 points; "
            "`adam-pool` with 512 and `adam` with 256 samples a step, all steps. A rung in brackets: "
            "no inside worth the name, weights from there. gear, ribbons, flag and skirt are made by "
            "`tools/shapes.py`.\n",
            table(["shape", "vertices", "bones", "tets + bbw", *names.values()], seconds),
            *(["Not run this time: " + ", ".join(missing) + " (`--sections table --resume` goes on).\n"]
              if missing else []),
            "Energy by the axis-aligned estimator (step 0.01 of the box, samples that no optimiser "
            "uses), file units; then TV to exact weights on tetrahedra refined 1:8, where there are "
            "any.\n",
            table(["shape", *("energy: " + n for n in names.values()), "TV: tets",
                   *("TV: " + n for n in names.values())], quality)]


def cost_part(rows, folder):
    text = ["## Cost against bones and triangles\n",
            "`convex`, 2^13 points: the hand with its first bones, its 20, and those split; a penguin "
            "with ever finer triangles. Shares of the stages' wall time: preparing the solid (repair, "
            "parts, trees) and evaluating every vertex grow with the shape; sampling, rows and "
            "minimising, the last column (CPU s by its share), hardly do.\n",
            table(["against", "bones", "triangles", "vertices", "CPU s", "peak MB", "solid",
                   "evaluation", "all else, CPU s"],
                  [[r["kind"], *failed(r, 8)] if "failure" in r else
                   [r["kind"], r["bones"],
                    f"{r['count']:,}" if r["kind"] == "triangles" else "", f"{r['vertices']:,}",
                    f"{r['cpu']:.1f}",
                    number(r["peak"] and r["peak"] / 2**20, "{:.0f}"),
                    *(f"{s:.0%}" for s in shares(r)[:2]),
                    f"{r['solve_cpu'] * shares(r)[2]:.1f}"] for r in rows])]
    return text + figure(folder, "cost", "CPU seconds against bones and triangles")


def page(results, folder):
    text = ["# Geometric fields: ablations, table 1, cost\n",
            f"Made by `make results` with {results.get('version', '')} on "
            f"{results.get('machine', '')}. {results.get('note', '')} TV is the mean over vertices of "
            "half the L1 difference of two weight rows; exact means bounded biharmonic weights on "
            "tetrahedra refined 1:8. Figures and equations are those of the paper "
            "([methods/geometric_fields.md](methods/geometric_fields.md)).\n"]
    text += ablations(results, folder)
    if results.get("table"):
        text += table_one(results["table"], results.get("shapes", []))
    if results.get("cost"):
        text += cost_part(results["cost"], folder)
    return "\n".join(text)
