#!/usr/bin/env python3
"""Exact bounded biharmonic weights on meshes, solver by solver: docs/results-exact.md.

    results_exact.py [--program P] [--data D] [--only GLOB] [--nodes N] [--sections S,S]

In the style of table 1 of the convex-duality paper: size, handles, seconds and energy of the primal
solver, of the dual at two gaps, of decoupled weights and of 8 iterations of active sets without
partition of unity. Then the energy of every other method, the tetrahedra as referee of the point
domain, and the dual's convergence (figure 9, as a picture beside the page, where matplotlib is).
Energies are those of the weights as given out, 1/2 tr(W' K M^-1 K W) in file units.
"""

import fnmatch
import json
import sys

import numpy as np

import judge
import meshes
from results import arguments, at, checked, last_line, machine, run
from results_page import escape, number, table

# The paper's tolerances 1e-6 and 5e-8 left these gaps on its 7,234-vertex hand (57461.5 and 57450.4
# over 57448.3): the dual is stopped there.
GAPS = (2e-4, 4e-5)
SOLVERS = {
    "primal": ["--method", "bbw", "--tolerance", "1e-4"],
    "dual": ["--method", "bbw", "--solver", "dual", "--tolerance", str(GAPS[0])],
    "dual-tight": ["--method", "bbw", "--solver", "dual", "--tolerance", str(GAPS[1])],
    "decoupled": ["--method", "bbw-decoupled", "--tolerance", "1e-4"],
    "unboxed": ["--method", "bbw-decoupled", "--solver", "dual-unboxed", "--tolerance",
                str(GAPS[1])],
    "boxed": ["--method", "bbw-decoupled", "--solver", "dual", "--tolerance", str(GAPS[1])],
    "active-8": ["--method", "bbw-decoupled", "--solver", "active-set", "--iterations", "8"],
}
OTHERS = {
    "quasi-harmonic": ["--method", "quasi-harmonic"],
    "monotonic": ["--method", "monotonic"],
    "harmonic": ["--method", "harmonic"],
    "biharmonic": ["--method", "biharmonic"],
}
SURFACES = ("spot", "fish", "penguin", "mushroom", "plane", "hand_closed")
PLANAR = ("alligator.obj", "star.svg", "comb.svg", "annulus.svg", "snake.svg")


def rods(data, out):
    """tibiman's handles: rows of its constrained vertices, as paint."""
    fem = data / "fem"
    def dense(path):
        lines = [l for l in path.read_text().splitlines() if not l.startswith("%")]
        rows, columns = (int(x) for x in lines[0].split()[:2])
        return np.array([float(x) for l in lines[1:] for x in l.split()]).reshape(columns, rows).T
    index = dense(fem / "tibiman-B.mtx").ravel().astype(np.int64) - 1
    paint = out / "tibiman-rods.npz"
    np.savez(paint, index=index, weights=dense(fem / "tibiman-BC.mtx"))
    return paint


def mixed(bones, points, out):
    """A skeleton with the bones of one TGF file and the points of another."""
    def parts(path):
        vertices, _, edges = path.read_text().partition("#")
        return ([" ".join(l.split()[1:4]) for l in vertices.splitlines() if l.split()],
                [l.split()[:2] for l in edges.replace("#", "").splitlines() if l.split()])
    V, E = parts(bones)
    P, _ = parts(points)
    lines = [f"{i + 1} {v}" for i, v in enumerate(P + V)] + ["#"]
    lines += [f"{int(a) + len(P)} {int(b) + len(P)} 1 0 0" for a, b in E]
    out.write_text("\n".join(lines) + "\n")
    return out


def cases(options):
    """(name, mesh, options that say where the handles are)"""
    data, out = options.data, options.out
    fem, surface, planar = data / "fem", data / "surface", data / "planar"
    yield "hand", fem / "hand.mesh", ["--skeleton", fem / "hand.tgf"]
    yield "arm", fem / "arm.mesh", ["--skeleton", fem / "arm.tgf"]
    rod_paint = rods(data, out)
    yield "tibiman (rods)", fem / "tibiman.mesh", ["--paint", rod_paint]
    yield ("tibiman (rods, authors' masses)", fem / "tibiman.mesh",
           ["--paint", rod_paint, "--mass", fem / "tibiman-mv.mtx"])
    yield "octopus-low", fem / "octopus-low.mesh", ["--skeleton", fem / "octopus-low.tgf"]
    yield ("octopus-low (bones and points)", fem / "octopus-low.mesh",
           ["--skeleton", mixed(fem / "octopus-low.tgf", fem / "octopus-low-points.tgf",
                                out / "octopus-mixed.tgf")])
    for name in PLANAR:
        stem = name.split(".")[0]
        yield name, planar / name, ["--skeleton", planar / f"{stem}.tgf", "--nodes", 6000]
        if (planar / f"{stem}-points.tgf").exists():
            yield (f"{name} (points)", planar / name,
                   ["--skeleton", planar / f"{stem}-points.tgf", "--nodes", 6000])
    for stem in SURFACES:
        skeleton = surface / f"{stem}.tgf"
        if stem in ("spot", "fish"):
            skeleton = mixed(skeleton, surface / f"{stem}-points.tgf", out / f"{stem}-mixed.tgf")
        mesh = out / f"{stem}.mesh"
        made = run([options.program, "tetrahedralise", surface / f"{stem}.obj", "--skeleton",
                    skeleton, "--nodes", options.nodes, "-o", mesh, "--quiet"])
        label = f"{stem}, tets" + (" (bones and points)" if stem in ("spot", "fish") else "")
        yield label, mesh if made["code"] == 0 else None, ["--skeleton", skeleton]


def solve(options, mesh, handles, more, stem):
    weights, report = options.out / f"{stem}.npz", options.out / f"{stem}.report.json"
    ran = run([options.program, "bind", mesh, *handles, *more, "-o", weights, "--report", report,
               "--quiet"])
    if ran["code"] != 0:
        return dict(failure=last_line(ran["err"]) or f"exit {ran['code']}")
    document = json.loads(report.read_text())
    W = judge.read_npz(weights)
    _, error, negative, broken, empty = judge.row_faults(W)
    return dict(nodes=at(document, "domain", "nodes"), handles=at(document, "input", "handles"),
                columns=int(W.shape[1]),
                cpu=at(document, "cpu_s", "solve"), wall=at(document, "timings_s", "solve"),
                energy=at(document, "solve", "biharmonic_energy"),
                gap=at(document, "solve", "relative_gap"), kkt=at(document, "solve", "kkt_residual"),
                status=at(document, "solve", "status"), peak=ran["peak"],
                extrema=at(document, "weights", "extrema"),
                iterations=at(document, "solve", "iterations"),
                valid=error <= 1e-6 and negative + broken + empty == 0)


def evaluated(options):
    """The shared judge's own figures on the hand, for the primal and the tight dual."""
    script = options.data.parent / "tools" / "evaluate_weights.py"
    fem = options.data / "fem"
    rows = []
    for label, more in (("primal, tolerance 1e-6", ["--tolerance", "1e-6"]),
                        ("dual, gap 1e-4", ["--solver", "dual"]),
                        ("dual, gap 1e-6", ["--solver", "dual", "--tolerance", "1e-6"])):
        stem = "hand-judged-" + label.split(",")[0] + label.split()[-1]
        row = dict(label=label, **solve(options, fem / "hand.mesh",
                                        ["--skeleton", fem / "hand.tgf"], more, stem))
        judged = run([sys.executable, script, fem / "hand.mesh", options.out / f"{stem}.npz",
                      "--reference", options.out / "hand-judged-primal1e-6.npz", "--json"])
        if judged["code"] == 0:
            row["judge"] = json.loads(judged["out"])
        rows.append(row)
    return rows


def convergence(history, path):
    """Figure 9: objectives and constraint violation of the dual, as a picture."""
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        return False
    rows = np.array([[np.nan if x is None else x for x in r] for r in history["rows"]], float)
    best = np.nanmax(rows[:, 2])
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 3.6))
    left.loglog(rows[:, 0] + 1, rows[:, 1], label="energy of the recovered W")
    left.loglog(rows[:, 0] + 1, np.maximum(rows[:, 3], 1e-16), label="|min(W, 0)|")
    left.legend()
    right.loglog(rows[:, 0] + 1, np.maximum((best - rows[:, 2]) / best, 1e-16),
                 label="dual objective, share below its best")
    right.legend()
    for axes in (left, right):
        axes.set_xlabel("iteration")
        axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    return True


def referee(options):
    """TV of the point domain to exact weights on tetrahedra refined 1:8, beside the tetrahedra
    themselves: over the vertices of their surface."""
    fem = options.data / "fem"
    shapes = [("hand", fem / "hand.mesh", fem / "hand.tgf"),
              ("arm", fem / "arm.mesh", fem / "arm.tgf")]
    for stem in ("fish", "spot", "penguin"):
        mesh, skeleton = options.out / f"{stem}-referee.mesh", options.data / "surface" / f"{stem}.tgf"
        run([options.program, "tetrahedralise", options.data / "surface" / f"{stem}.obj",
             "--skeleton", skeleton, "--nodes", 6000, "-o", mesh, "--quiet"])
        shapes.append((stem, mesh, skeleton))
    rows = []
    for name, mesh, skeleton in shapes:
        if not mesh.exists():
            continue
        V, T = judge.read_medit(mesh)
        fine = options.out / f"{name}-fine.mesh"
        meshes.write(fine, *meshes.refined(V, T))
        surface = np.unique(judge.boundary(T))
        handles = ["--skeleton", skeleton]
        reference = solve(options, fine, handles, ["--tolerance", "1e-4"], f"referee-{name}-fine")
        if "failure" in reference:
            rows.append(dict(name=name, failure=reference["failure"]))
            continue
        exact = judge.read_npz(options.out / f"referee-{name}-fine.npz")[surface]
        row = dict(name=name, vertices=len(V), fine=reference["nodes"], cpu=reference["cpu"])
        for key, more in (("points_8k", ["--domain", "points", "--nodes", 8000]),
                          ("points_16k", ["--domain", "points", "--nodes", 16000]),
                          ("tets", ["--domain", "tets"])):
            one = solve(options, mesh, handles, more, f"referee-{name}-{key}")
            if "failure" in one:
                continue
            d = judge.row_distances(
                judge.read_npz(options.out / f"referee-{name}-{key}.npz")[surface], exact)
            row[key] = [float(d.mean()), float(np.quantile(d, .95)), float(d.max())]
        rows.append(row)
        print(f"referee, {name}: done", file=sys.stderr, flush=True)
    return rows


def unity(options):
    """What leaving partition of unity out of the problem changes, on the alligator."""
    planar = options.data / "planar"
    rows = []
    for label, stem in (("bones", "alligator"), ("points", "alligator-points")):
        W = []
        for method in ("bbw", "bbw-decoupled"):
            name = f"unity-{stem}-{method}"
            one = solve(options, planar / "alligator.obj", ["--skeleton", planar / f"{stem}.tgf"],
                        ["--method", method, "--tolerance", "1e-5"], name)
            if "failure" in one:
                return []
            W.append(judge.read_npz(options.out / f"{name}.npz"))
        d = np.abs(W[0] - W[1]).max(axis=1)
        rows.append(dict(label=label, difference=d.tolist()))
    return rows


def plotted_unity(rows, options, path):
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        return False
    if not rows:
        return False
    V, F = judge.read_obj(options.data / "planar" / "alligator.obj")
    figure, panels = pyplot.subplots(1, 2, figsize=(11, 3.4))
    for axes, row in zip(panels, rows):
        drawn = axes.tripcolor(V[:, 0], V[:, 1], F, np.array(row["difference"]), shading="gouraud",
                               cmap="viridis")
        figure.colorbar(drawn, ax=axes)
        axes.set_aspect("equal")
        axes.axis("off")
        axes.set_title(f"{row['label']}: largest difference {max(row['difference']):.3f}")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    return True


def costs(options):
    """CPU seconds and memory of the primal solver against vertices (the penguin, 15 bones) and
    against bones (the hand, 20,000 vertices, every bone split)."""
    fem, surface, out = options.data / "fem", options.data / "surface", options.out
    def row(mesh, skeleton, nodes, kind):
        tets = out / "cost.mesh"
        made = run([options.program, "tetrahedralise", mesh, "--skeleton", skeleton, "--nodes",
                    nodes, "-o", tets, "--quiet"])
        if made["code"] != 0:
            return dict(kind=kind, failure=last_line(made["err"]))
        return dict(kind=kind, **solve(options, tets, ["--skeleton", skeleton], [], "cost"))
    bones = meshes.first_bones(surface / "penguin.tgf", 15, out / "penguin-15.tgf")
    rows = [row(surface / "penguin.obj", bones, n, "vertices")
            for n in (2000, 6000, 15000, 40000, 80000, 150000)]
    hand = out / "hand.obj"
    judge.hand_surface(options.data, hand)
    for parts in (1, 2, 4):
        split = meshes.split_bones(fem / "hand.tgf", parts, out / f"hand-{parts}.tgf")
        rows.append(row(hand, split, 20000, "bones"))
    few = meshes.first_bones(fem / "hand.tgf", 5, out / "hand-5.tgf")
    rows.append(row(hand, few, 20000, "bones"))
    return rows


def plotted_costs(rows, _, path):
    """CPU seconds against vertices and against bones, as a picture."""
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        return False
    figure, panels = pyplot.subplots(1, 2, figsize=(10, 3.6))
    for axes, kind, key in zip(panels, ("vertices", "bones"), ("nodes", "handles")):
        points = sorted((r[key], r["cpu"]) for r in rows
                        if r["kind"] == kind and "failure" not in r)
        if points:
            x, y = np.array(points, float).T
            axes.loglog(x, y, "o-", label="measured")
            axes.loglog(x, y[0] * x / x[0], "--", label="linear")
        axes.set_xlabel(kind)
        axes.set_ylabel("CPU seconds")
        axes.legend()
        axes.grid(alpha=0.3, which="both")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    return True


def page(results):
    text = ["# Exact weights on meshes\n",
            f"Made by `make results` on {results['machine']}. Seconds are CPU seconds of the solve "
            "alone, after the mesh is there. Energies are those of the weights as given out. The "
            f"dual is stopped at certified gaps of {GAPS[0]:g} and {GAPS[1]:g}, where the paper's "
            "program stood after its tolerances 1e-6 and 5e-8 on its hand. Decoupled weights "
            "leave partition of unity out of the problem and are normalised after; \"8 active\" is "
            "what most programs run: 8 iterations of active sets, the same way. "
            f"{results['note']}\n",
            "## Solver by solver\n"]
    head = ["case", "nodes", "handles", "primal s", "energy", "gap", "dual s", "energy", "tight s",
            "energy", "decoupled s", "energy", "8 active s", "energy"]
    cells, broken = [], []
    for row in results.get("table", []):
        s = row["solvers"]
        first = s.get("primal", {})
        if "failure" in row or "failure" in first:
            cells.append([row["name"], "**failed**: " + escape(row.get("failure") or
                                                               first["failure"])] + [""] * 12)
            continue
        line = [row["name"], number(first["nodes"], "{:,}"), first["columns"]]
        for key in SOLVERS:
            if key in ("boxed", "unboxed"):
                continue
            one = s[key]
            if "failure" in one:
                line += ["failed", ""] + ([""] if key == "primal" else [])
                continue
            line += [number(one["cpu"], "{:.2f}"), number(one["energy"], "{:.7g}")]
            if key == "primal":
                line.append(number(one["gap"], "{:.0e}"))
        cells.append(line)
        for key in list(SOLVERS) + list(OTHERS):
            one = s.get(key, {})
            least = first["energy"] * (1 - max(1e-6, 2 * first["gap"]))
            if one.get("energy") is not None and one["energy"] < least:
                broken.append(f"{row['name']}: {key}")
    text.append(table(head, cells))
    text.append("E(bbw) is at most the energy of every other valid weights here, on every case.\n"
                if not broken else
                "**E(bbw) is above the energy of: " + "; ".join(broken) + ".**\n")
    text.append("## Other weights on the same meshes\n")
    text.append("Energy over that of bbw; in brackets the spurious local extrema (tolerance 1e-4) "
                "over the mesh's own edges.\n")
    cells = []
    for row in results.get("table", []):
        s = row["solvers"]
        if "energy" not in s.get("primal", {}):
            continue
        base = s["primal"]["energy"]
        def ratio(key):
            one = s.get(key, {})
            if one.get("energy") is None or not base:
                if "no masses" in one.get("failure", ""):
                    return "takes no masses"
                return "failed" if "failure" in one else ""
            return f"{one['energy'] / base:.4g} ({one['extrema']})"
        cells.append([row["name"], f"1 ({s['primal']['extrema']})", ratio("decoupled")] +
                     [ratio(k) for k in OTHERS])
    text.append(table(["case", "bbw", "decoupled"] + list(OTHERS), cells))
    text.append("## Decoupled weights with and without W <= 1\n")
    text.append("By the dual of decoupled weights (the paper's appendix A), to a certified gap of "
                f"{GAPS[1]:g}. Energies are those of the normalised weights, over the coupled "
                "optimum's.\n")
    cells = []
    for row in results.get("table", []):
        s = row["solvers"]
        if "energy" not in s.get("primal", {}) or not s["primal"]["energy"]:
            continue
        cells.append([row["name"]])
        for key in ("boxed", "unboxed"):
            one = s.get(key, {})
            cells[-1] += [number(one.get("cpu"), "{:.2f}"), number(one.get("iterations"), "{}"),
                          "failed" if one.get("energy") is None
                          else f"{one['energy'] / s['primal']['energy']:.4g}"]
    text.append(table(["case", "boxed s", "iterations", "energy", "unboxed s", "iterations",
                       "energy"], cells))
    if results.get("unity_picture"):
        text.append("Largest difference of a vertex's weights that leaving partition of unity out "
                    "makes, after normalising:\n")
        text.append(f"![difference]({results['unity_picture']})\n")
    text.append("## The hand, by an independent judge\n")
    text.append("Optimum 13288.1427. The last columns are distances to the first row's weights.\n")
    text.append(table(["solver", "CPU s", "energy, judged", "gap", "KKT", "row error", "negative",
                       "mean", "largest"],
                      [[r["label"], number(r.get("cpu"), "{:.2f}"),
                        number(at(r, "judge", "energy_raw"), "{:.6f}"), number(r.get("gap"), "{:.0e}"),
                        number(r.get("kkt"), "{:.0e}"),
                        number(at(r, "judge", "row_sum_error"), "{:.0e}"),
                        number(at(r, "judge", "negative"), "{}"),
                        number(at(r, "judge", "difference_mean"), "{:.1e}"),
                        number(at(r, "judge", "difference_max"), "{:.1e}")]
                       for r in results.get("judged", [])]))
    text.append("## Points refereed by tetrahedra\n")
    text.append("TV over the surface's vertices (mean / 95% / largest) to exact weights on the "
                "tetrahedra refined 1:8, of the point domain and of the tetrahedra unrefined.\n")
    def three(values):
        return "" if values is None else "/".join(f"{v:.4f}" if k == 0 else f"{v:.3f}"
                                                  for k, v in enumerate(values))
    text.append(table(["shape", "vertices", "refined", "CPU s", "8,000 points", "16,000 points",
                       "tetrahedra"],
                      [[r["name"], "**failed**: " + escape(r["failure"]), "", "", "", "", ""]
                       if "failure" in r else
                       [r["name"], f"{r['vertices']:,}", f"{r['fine']:,}",
                        number(r["cpu"], "{:.1f}"), three(r.get("points_8k")),
                        three(r.get("points_16k")), three(r.get("tets"))]
                       for r in results.get("referee", [])]))
    if results.get("cost"):
        text.append("## Cost\n")
        text.append("The primal solver at its default tolerance: a penguin with 15 bones filled "
                    "with ever more vertices, and the hand at 20,000 vertices with bones split.\n")
        text.append(table(["against", "vertices", "bones", "CPU s", "iterations", "peak MB"],
                          [[r["kind"], "**failed**: " + escape(r["failure"]), "", "", "", ""]
                           if "failure" in r else
                           [r["kind"], f"{r['nodes']:,}", r["handles"], f"{r['cpu']:.2f}",
                            r["iterations"], f"{r['peak'] / 2**20:.0f}"]
                           for r in results["cost"]]))
        if results.get("cost_picture"):
            text.append(f"![cost]({results['cost_picture']})\n")
    if results.get("picture"):
        text.append("## Convergence of the dual\n")
        text.append("The alligator, 13 bones, to a certified gap of "
                    f"{GAPS[1]:g} (the paper's figure 9).\n")
        text.append(f"![convergence]({results['picture']})\n")
    return "\n".join(text)


def solved_cases(options):
    rows = []
    for name, mesh, handles in cases(options):
        if not fnmatch.fnmatch(name, options.only):
            continue
        row = dict(name=name, solvers={})
        rows.append(row)
        if mesh is None:
            row["failure"] = "no tetrahedra"
            continue
        for key, more in (SOLVERS | OTHERS).items():
            stem = "case"
            if name == "alligator.obj" and key == "dual-tight":
                stem = "dual-history"
            row["solvers"][key] = solve(options, mesh, handles, more, stem)
        print(f"{name}: " + ", ".join(key + " " + (number(one.get("cpu"), "{:.2f}") or "failed")
                                      for key, one in row["solvers"].items()),
              file=sys.stderr, flush=True)
    return rows


def main():
    parser = arguments(__doc__, "exact")
    parser.add_argument("--only", default="*", metavar="GLOB")
    parser.add_argument("--sections", default="table,judged,referee,unity,cost")
    parser.add_argument("--nodes", type=int, default=8000, help="of surfaces made into tets")
    parser.add_argument("--note", default="", help="for the page's head: what else ran, say")
    options = checked(parser)
    # Earlier sections stay, so that one can be renewed alone.
    store = options.out / "results.json"
    results = json.loads(store.read_text()) if store.exists() else {}
    results.update(machine=machine(), note=options.note)
    pictures = options.document.parent

    def keep():
        store.write_text(json.dumps(results, indent=1))
        options.document.write_text(page(results))

    sections = options.sections.split(",")
    # After each section, so that what stops the run costs one at most.
    if "table" in sections:
        results["table"] = solved_cases(options)
        report = options.out / "dual-history.report.json"
        history = at(json.loads(report.read_text()), "solve", "history") if report.exists() else None
        picture = pictures / "results-dual-convergence.png"
        if history and convergence(history, picture):
            results["picture"] = picture.name
        keep()
    for name, section, plot in (("judged", evaluated, None), ("referee", referee, None),
                                ("unity", unity, plotted_unity), ("cost", costs, plotted_costs)):
        if name not in sections:
            continue
        results[name] = section(options)
        picture = pictures / f"results-exact-{name}.png"
        if plot and plot(results[name], options, picture):
            results[f"{name}_picture"] = picture.name
        keep()
    keep()  # the page alone, where no section was asked for
    print(f"results: wrote {options.document}")


if __name__ == "__main__":
    main()
