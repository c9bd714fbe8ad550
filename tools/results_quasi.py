#!/usr/bin/env python3
"""Quasi-harmonic and monotonic weights beside exact ones: docs/results-quasi.md.

    results_quasi.py [--program P] [--data D] [--only GLOB]
                     [--sections table,convergence,brick,cactus,cost,pictures,image]

In the style of the quasi-harmonic paper's table 2 and figures 2, 3, 4, 6 and 10. Energies are those
of the weights as given out, 1/2 tr(W' K M^-1 K W) in file units. Every case is stored as it is done,
so that a run can be interrupted and a section renewed alone.
"""

import fnmatch
import json
import sys
from pathlib import Path

import numpy as np

import judge
import meshes
import results_quasi_shapes as shapes
from results import arguments, at, checked, last_line, machine, run
from results_exact import mixed, rods
from results_quasi_page import page

QUASI = ["--method", "quasi-harmonic"]
METHODS = {
    "bbw": ["--method", "bbw", "--tolerance", "1e-4"],
    "decoupled": ["--method", "bbw-decoupled", "--tolerance", "1e-4"],
    "monotonic": ["--method", "monotonic"],
    "monotonic decoupled": ["--method", "monotonic", "--solver", "decoupled"],
    "k = 10": QUASI + ["--solver", "restarted-adam", "--iterations", "10"],
    "k = 20": QUASI + ["--solver", "restarted-adam", "--iterations", "20", "--tolerance", "1e-12"],
    "default": QUASI,
}
OPTIMISERS = {"lbfgs": "L-BFGS", "adam": "Adam", "restarted-adam": "customised Adam",
              "adam-lbfgs": "the default"}
SURFACES = ("spot", "penguin", "mushroom")


def stored_mesh(options, name, V, elements):
    path = options.out / f"{name}.{'mesh' if elements.shape[1] == 4 else 'obj'}"
    (meshes.write if elements.shape[1] == 4 else judge.write_obj)(path, V, elements)
    return path


def brick(options):
    V, T = shapes.brick(60, 15, 15)
    regions = options.out / "brick-ends.npy"
    np.save(regions, shapes.ends(V))
    return stored_mesh(options, "brick", V, T), ["--regions", regions]


def cactus(options):
    skeleton = meshes.write_tgf(options.out / "cactus.tgf", shapes.CACTUS_HANDLES, [])
    surface = stored_mesh(options, "cactus", *shapes.cactus())
    mesh = options.out / "cactus.mesh"
    run([options.program, "tetrahedralise", surface, "--skeleton", skeleton, "--nodes", 8000, "-o",
         mesh, "--quiet"])
    return mesh if mesh.exists() else None, ["--skeleton", skeleton]


def flat_cactus(options):
    mesh = stored_mesh(options, "cactus-plane", *shapes.cactus_in_the_plane())
    skeleton = meshes.write_tgf(options.out / "cactus.tgf", shapes.CACTUS_HANDLES, [])
    return mesh, ["--skeleton", skeleton]


def cases(options):
    """(name, a function that gives the mesh and the options that say where its handles are)"""
    fem, planar, surface = (options.data / d for d in ("fem", "planar", "surface"))
    given = lambda mesh, *more: lambda: (mesh, list(more))
    yield ("tibiman (authors' masses)",
           lambda: (fem / "tibiman.mesh", ["--paint", rods(options.data, options.out), "--mass",
                                           fem / "tibiman-mv.mtx"]))
    for stem in ("hand", "arm", "octopus-low"):
        yield stem, given(fem / f"{stem}.mesh", "--skeleton", fem / f"{stem}.tgf")
    yield "brick", lambda: brick(options)
    yield "cactus", lambda: cactus(options)
    for stem in SURFACES:
        def filled(stem=stem):
            skeleton, mesh = surface / f"{stem}.tgf", options.out / f"{stem}.mesh"
            run([options.program, "tetrahedralise", surface / f"{stem}.obj", "--skeleton", skeleton,
                 "--nodes", 8000, "-o", mesh, "--quiet"])
            return mesh if mesh.exists() else None, ["--skeleton", skeleton]
        yield f"{stem}, filled", filled
    yield "cactus, plane grid", lambda: flat_cactus(options)
    yield "alligator", given(planar / "alligator.obj", "--skeleton", planar / "alligator.tgf")
    yield ("alligator (points)", given(planar / "alligator.obj", "--skeleton",
                                       planar / "alligator-points.tgf"))
    for stem in ("comb", "snake", "star"):
        yield stem, given(planar / f"{stem}.svg", "--skeleton", planar / f"{stem}.tgf", "--nodes",
                          6000)


def solve(options, mesh, handles, more, stem):
    weights, report = options.out / f"{stem}.npz", options.out / f"{stem}.report.json"
    # The mesh's own triangles or tetrahedra, for every method.
    domain = ["--domain", "tets" if Path(mesh).suffix == ".mesh" else "tris"]
    ran = run([options.program, "bind", mesh, *handles, *domain, *more, "-o", weights, "--report",
               report, "--quiet"])
    if ran["code"] != 0:
        return dict(failure=last_line(ran["err"]) or f"exit {ran['code']}")
    document = json.loads(report.read_text())
    columns = judge.read_npz(weights).shape[1]
    history = [row[1] for row in at(document, "solve", "history", "rows") or []]
    return dict(nodes=at(document, "domain", "nodes"), elements=at(document, "domain", "elements"),
                split=at(document, "domain", "split_nodes"),
                handles=columns, cpu=at(document, "cpu_s", "solve"),
                wall=at(document, "timings_s", "solve"),
                steps=at(document, "timings_s", "solve_steps"),
                linear=at(document, "timings_s", "solve_linear"),
                energy=at(document, "solve", "biharmonic_energy"),
                gap=at(document, "solve", "relative_gap"),
                iterations=at(document, "solve", "iterations"),
                status=at(document, "solve", "status"), history=history,
                extrema=at(document, "weights", "extrema"),
                before=at(document, "weights", "extrema_before_projection"))


def elements_of(mesh):
    """Vertices and elements of a mesh whose rows are those of its weights; (None, None) for outlines."""
    mesh = Path(mesh)
    if mesh.suffix == ".mesh":
        return judge.read_medit(mesh)
    return judge.read_obj(mesh) if mesh.suffix == ".obj" else (None, None)


def one_case(options, name, make):
    mesh, handles = make()
    if mesh is None:
        return dict(name=name, failure="no tetrahedra (a build without TetGen)")
    row = dict(name=name, methods={})
    V, elements = elements_of(mesh)
    edges = None if elements is None else judge.edges_of(elements)
    row["triangles" if elements is None or elements.shape[1] == 3 else "tets"] = (
        0 if elements is None else len(elements))
    W = {}
    for key, more in METHODS.items():
        one = solve(options, mesh, handles, more, "table")
        one.pop("history", None)
        if "failure" not in one:
            W[key] = judge.read_npz(options.out / "table.npz")
        row["methods"][key] = one
    if edges is not None and "bbw" in W and "k = 10" in W:
        # Where such different weights are the same, they are prescribed.
        prescribed = np.abs(W["bbw"] - W["k = 10"]).max(1) < 1e-12
        for key, weights in W.items():
            hills = [h for h in judge.prominent_extrema(weights, edges) if not prescribed[h[0]]]
            row["methods"][key].update(
                judged=int((judge.local_extrema(weights, edges) != 0).sum()), hills=len(hills),
                highest=max((min(h[2], 1) for h in hills), default=0.0))
    print(f"table, {name}: done", file=sys.stderr, flush=True)
    return row


def convergence(options):
    """Energies against iterations of all optimisers, on the same objective from the same start."""
    rows = []
    made = dict(cases(options))
    for name in ("tibiman (authors' masses)", "hand", "arm", "brick"):
        mesh, handles = made[name]()
        exact = solve(options, mesh, handles, METHODS["bbw"], "convergence")
        row = dict(name=name, exact=exact["energy"], curves={})
        for solver in OPTIMISERS:
            one = solve(options, mesh, handles, QUASI + ["--solver", solver, "--iterations", "100",
                                                         "--tolerance", "1e-12"], "convergence")
            row["curves"][solver] = {k: one[k] for k in ("history", "cpu", "energy")}
        rows.append(row)
        print(f"convergence, {name}: done", file=sys.stderr, flush=True)
    return rows


def pyplot():
    try:
        import matplotlib
    except ImportError:
        return None
    matplotlib.use("Agg")
    from matplotlib import pyplot as plots
    return plots


def plotted_convergence(rows, path):
    plots = pyplot()
    if not plots:
        return False
    figure, panels = plots.subplots(1, len(rows), figsize=(3.2 * len(rows), 3.1))
    for axes, row in zip(panels, rows):
        for solver, label in OPTIMISERS.items():
            energy = np.array(row["curves"][solver]["history"])
            axes.semilogy(energy / row["exact"] - 1, label=label,
                          linestyle="--" if solver == "adam-lbfgs" else "-")
        axes.set_title(row["name"].split()[0], fontsize=9)
        axes.set_xlabel("iteration")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("energy over bbw's, less 1")
    panels[-1].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    return True


def brick_differences(options):
    """Figure 3, at two resolutions and with ever more iterations."""
    rows = []
    for cells in (40, 60):
        V, T = shapes.brick(cells, cells // 4, cells // 4)
        mesh, regions = stored_mesh(options, "brick-section", V, T), options.out / "section.npy"
        np.save(regions, shapes.ends(V))
        handles, W = ["--regions", regions], {}
        for key, more in (("bbw", METHODS["bbw"]), ("decoupled", METHODS["decoupled"]),
                          ("monotonic", METHODS["monotonic decoupled"])):
            W[key] = (solve(options, mesh, handles, more, "brick"),
                      judge.read_npz(options.out / "brick.npz"))
        for label, more in (("default", []),
                            ("customised Adam, 24", ["--solver", "restarted-adam"]),
                            ("customised Adam, 200", ["--solver", "restarted-adam", "--iterations",
                                                      "200", "--tolerance", "1e-12"]),
                            ("Adam, 100", ["--solver", "adam", "--tolerance", "1e-12"]),
                            ("L-BFGS, 100", ["--solver", "lbfgs", "--iterations", "100",
                                             "--tolerance", "1e-12"])):
            one = solve(options, mesh, handles, QUASI + more, "brick")
            mine = judge.read_npz(options.out / "brick.npz")
            rows.append(dict(vertices=len(V), tets=len(T), label=label, iterations=one["iterations"],
                             energy=one["energy"] / W["bbw"][0]["energy"], cpu=one["cpu"],
                             differences={k: float(np.abs(mine - w).max())
                                          for k, (_, w) in W.items()}))
    return rows


def along_arms(options):
    """What the cactus's weights of the upper handle are at the joints and ends of its arms."""
    rows = []
    places = {"left arm's root": (0, -0.1, 0), "its elbow": (-0.62, -0.1, 0),
              "its end": (-0.62, 0.66, 0), "right arm's root": (0, 0.2, 0),
              "its elbow ": (0.58, 0.2, 0), "its end ": (0.58, 0.9, 0)}
    for label, make in (("in space", cactus), ("in the plane", flat_cactus)):
        mesh, handles = make(options)
        if mesh is None:
            continue
        V, elements = elements_of(mesh)
        edges = judge.edges_of(elements)
        for key in METHODS:
            one = solve(options, mesh, handles, METHODS[key], "cactus-arms")
            W = judge.read_npz(options.out / "cactus-arms.npz")
            hills = judge.prominent_extrema(W, edges)
            rows.append(dict(shape=label, method=key, energy=one["energy"], hills=len(hills),
                             highest=max((h[2] for h in hills), default=0.0),
                             weights=[float(W[np.argmin(((V - p) ** 2).sum(1)), 1])
                                      for p in places.values()]))
    return dict(places=[p.strip() for p in places], rows=rows)


def costs(options):
    """Seconds against vertices: the penguin with 15 bones, filled ever more finely."""
    surface = options.data / "surface"
    bones = meshes.first_bones(surface / "penguin.tgf", 15, options.out / "penguin-15.tgf")
    for nodes in (5000, 10000, 20000, 40000, 70000, 100000):
        mesh = options.out / "cost.mesh"
        made = run([options.program, "tetrahedralise", surface / "penguin.obj", "--skeleton", bones,
                    "--nodes", nodes, "-o", mesh, "--quiet"])
        if made["code"] != 0:
            yield dict(failure=last_line(made["err"]))
            continue
        row = dict(methods={})
        for key in ("k = 10", "k = 20", "default"):
            one = solve(options, mesh, ["--skeleton", bones], METHODS[key], "cost")
            if "failure" in one:
                row["failure"] = one["failure"]
                break
            row.update(nodes=one["nodes"], elements=one["elements"])
            row["methods"][key] = {k: one[k] for k in ("cpu", "wall", "steps", "linear",
                                                       "iterations")}
        print(f"cost, {nodes}: done", file=sys.stderr, flush=True)
        yield row


def plotted_costs(rows, path):
    plots = pyplot()
    rows = [r for r in rows if "failure" not in r]
    if not plots or not rows:
        return False
    figure, axes = plots.subplots(figsize=(5, 3.4))
    x = np.array([r["nodes"] for r in rows], float)
    for key in ("k = 10", "k = 20", "default"):
        axes.loglog(x, [r["methods"][key]["cpu"] for r in rows], "o-", label=key)
    first = rows[0]["methods"]["k = 10"]["cpu"]
    axes.loglog(x, first * x / x[0], "k:", label="linear")
    axes.loglog(x, first * (x / x[0]) ** 2, "k--", alpha=0.4, label="quadratic")
    axes.set_xlabel("vertices")
    axes.set_ylabel("CPU seconds")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3, which="both")
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    return True


# (name, yaw, the column shown or None for the one with the largest extremum, height of a tile)
PICTURED = (("hand", "0", None, 340), ("arm", "0", None, 200), ("cactus", "15", 1, 340))


def pictures(options, folder):
    """Heat maps with extrema marked, and poses, of bbw, monotonic and quasi-harmonic weights side by
    side: a PNG a shape."""
    plots = pyplot()
    if not plots:
        return []
    made, rows = dict(cases(options)), []
    for name, yaw, column, height in PICTURED:
        mesh, handles = made[name]()
        if mesh is None:
            continue
        tiles, counts, W = {}, {}, {}
        for key in ("bbw", "monotonic", "default"):
            solve(options, mesh, handles, METHODS[key], f"picture-{name}-{key}")
            W[key] = judge.read_npz(options.out / f"picture-{name}-{key}.npz")
        edges = judge.edges_of(elements_of(mesh)[1])
        if column is None:
            hills = judge.prominent_extrema(W["bbw"], edges)
            column = max(hills, key=lambda h: min(h[2], 1))[1] if hills else 0
        with np.load(options.out / f"picture-{name}-bbw.npz", allow_pickle=False) as file:
            bone = str(file["handle_names"][column])
        for key in W:
            label = "quasi-harmonic" if key == "default" else key
            counts[label] = sum(h[1] == column for h in judge.prominent_extrema(W[key], edges))
            base = [options.program, "render", mesh, *handles, "--weights",
                    options.out / f"picture-{name}-{key}.npz", "--width", "320", "--height", height,
                    "--yaw", yaw, "--pitch", "5", "--quiet"]
            for kind, more in (("heat", ["--kind", "heat", "--bone", bone, "--extrema"]),
                               ("posed", ["--pose", "demo", "--kind", "dominant"])):
                out = options.out / f"picture-{name}-{key}-{kind}.png"
                ran = run([*base, *more, "--caption", label, "-o", out])
                if ran["code"] != 0:
                    return [dict(name=name, failure=last_line(ran["err"]))]
                tiles.setdefault(kind, []).append(plots.imread(out)[:, :, :3])
        sheet = np.vstack([np.hstack(tiles["heat"]), np.hstack(tiles["posed"])])
        picture = folder / f"results-quasi-{name}.png"
        # 32 levels a channel: half the bytes, and no difference to be seen.
        plots.imsave(picture, np.round(sheet * 31) / 31)
        rows.append(dict(name=name, bone=bone, counts=counts, picture=picture.name))
        print(f"pictures, {name}: done", file=sys.stderr, flush=True)
    return rows


def image(options, folder):
    """Figures 1, 5 and 9: a picture on a sheet, warped by points and a bone, by bbw and
    quasi-harmonic weights side by side with the picture itself."""
    plots = pyplot()
    if not plots:
        return None
    mesh = stored_mesh(options, "sheet", *shapes.sheet(64, 48))
    points = [(4, 4, 0), (60, 4, 0), (4, 44, 0), (60, 44, 0), (19, 31, 0), (40, 12, 0), (40, 36, 0)]
    skeleton = meshes.write_tgf(options.out / "sheet.tgf", points, [(5, 6)])
    turn = np.deg2rad(25) / 2
    pose = options.out / "sheet.json"
    pose.write_text(json.dumps({"4": {"translation": [4, -3, 0]},
                                "5": {"rotation": [0, 0, float(np.sin(turn)), float(np.cos(turn))]}}))
    given = options.out / "painting.png"
    plots.imsave(given, shapes.painting(384, 288))
    tiles, solved = [plots.imread(given)[:, :, :3]], {}
    for key in ("bbw", "default"):
        solved[key] = solve(options, mesh, ["--skeleton", skeleton], METHODS[key], "sheet")
        out = options.out / "painting-warped.png"
        ran = run([options.program, "pose", mesh, "--skeleton", skeleton, "--weights",
                   options.out / "sheet.npz", "--pose", pose, "--image", given, "-o", out])
        if ran["code"] != 0:
            return dict(failure=last_line(ran["err"]))
        tiles.append(plots.imread(out)[:, :, :3])
    height, width = (max(t.shape[k] for t in tiles) for k in (0, 1))
    sheet = np.ones((height, 3 * width, 3))
    for k, tile in enumerate(tiles):
        sheet[:tile.shape[0], k * width:k * width + tile.shape[1]] = tile
    picture = folder / "results-quasi-image.png"
    plots.imsave(picture, np.round(sheet * 31) / 31)
    return dict(picture=picture.name, energy=solved["default"]["energy"] / solved["bbw"]["energy"],
                cpu=solved["default"]["cpu"], bbw_cpu=solved["bbw"]["cpu"],
                extrema=[solved[k]["extrema"] for k in ("bbw", "default")])


def main():
    parser = arguments(__doc__, "quasi")
    parser.add_argument("--sections", default="table,convergence,brick,cactus,cost,pictures,image")
    parser.add_argument("--only", default="*", metavar="GLOB", help="cases of the table")
    parser.add_argument("--note", default="", help="for the page's head: what else ran, say")
    options = checked(parser)
    store = options.out / "results.json"
    results = json.loads(store.read_text()) if store.exists() else {}
    results.update(machine=machine(), note=options.note)

    def keep(**more):
        results.update(more)
        store.write_text(json.dumps(results, indent=1))
        options.document.write_text(page(results, list(METHODS), OPTIMISERS))

    folder = options.document.parent
    sections = options.sections.split(",")
    if "table" in sections:
        order = [name for name, _ in cases(options)]
        for name, make in cases(options):
            if fnmatch.fnmatch(name, options.only):
                row = one_case(options, name, make)
                kept = [r for r in results.get("table", []) if r["name"] != name] + [row]
                keep(table=sorted((r for r in kept if r["name"] in order),
                                  key=lambda r: order.index(r["name"])))
    if "convergence" in sections:
        rows = convergence(options)
        picture = folder / "results-quasi-convergence.png"
        keep(convergence=rows,
             convergence_picture=picture.name if plotted_convergence(rows, picture) else None)
    if "brick" in sections:
        keep(brick=brick_differences(options))
    if "cactus" in sections:
        keep(cactus=along_arms(options))
    if "cost" in sections:
        rows, picture = [], folder / "results-quasi-cost.png"
        for row in costs(options):
            rows.append(row)
            keep(cost=rows, cost_picture=picture.name if plotted_costs(rows, picture) else None)
    if "pictures" in sections:
        keep(pictures=pictures(options, folder))
    if "image" in sections:
        keep(image=image(options, folder))
    print(f"results: wrote {options.document}")


if __name__ == "__main__":
    main()
