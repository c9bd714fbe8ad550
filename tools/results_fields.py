#!/usr/bin/env python3
"""Geometric fields: the paper's ablations, its table 1 and what they cost: docs/results-fields.md.

    results_fields.py [--program P] [--data D] [--sections S,S] [--only GLOB] [--note TEXT]

Weights are judged by tools/judge.py; energies by the program's own `--judge-step` (the axis-aligned
estimator on samples that no optimiser uses). What was measured is stored after every row, so that a
run can be stopped, and one section renewed alone. Everything else it makes stays under
results/fields. Pictures need matplotlib.
"""

import fnmatch
import json
import sys
from pathlib import Path

import numpy as np

import judge
import meshes
import results_fields_page as pages
import shapes
from results import arguments, at, checked, last_line, machine, run

ADAM = ["--solver", "adam", "--samples-per-step", 256]
POOL = ["--solver", "adam-pool", "--samples-per-step", 512]
STEP = 0.01  # of --judge-step: half of sigma at some 2^14 points
POINTS = 1 << 13


def bind(options, mesh, skeleton, stem, *more, method="geometric-fields"):
    """Binds; W and what the tables need, or the failure."""
    weights, report = options.out / f"{stem}.npz", options.out / f"{stem}.report.json"
    for stale in (weights, report):
        stale.unlink(missing_ok=True)
    ran = run([options.program, "bind", mesh, "--skeleton", skeleton, "--method", method, "-o",
               weights, "--report", report, "--quiet", *more], limit=options.limit)
    row = dict(wall=ran["wall"], cpu=ran["cpu"])
    if ran["code"] != 0:
        row["failure"] = (last_line(ran["err"]) or f"exit {ran['code']}").replace(str(mesh),
                                                                                Path(mesh).name)
        return None, row
    document = json.loads(report.read_text())
    W = judge.read_npz(weights)
    _, error, negative, broken, empty = judge.row_faults(W)
    row.update(peak=at(document, "peak_memory_bytes"), vertices=len(W), bones=W.shape[1], rung=at(document, "domain", "rung"),
               nodes=at(document, "domain", "nodes"), route=at(document, "domain", "route"),
               energy=at(document, "solve", "judged", "energy"),
               status=at(document, "solve", "status"), iterations=at(document, "solve", "iterations"),
               curve=at(document, "solve", "judged", "rows"),
               valid=bool(error <= 1e-6 and negative + broken + empty == 0))
    return W, row


def distances(W, exact):
    d = judge.row_distances(W, exact)
    return dict(tv=float(d.mean()), p95=float(np.quantile(d, .95)), largest=float(d.max()))


class Hand:
    """The hand's surface with its exact weights."""

    def __init__(self, options):
        self.mesh = options.out / "hand.obj"
        kept = judge.hand_surface(options.data, self.mesh)
        self.skeleton = options.data / "fem" / "hand.tgf"
        self.exact = judge.read_npz(options.data / "fem" / "hand-refined-bbw.npz")[kept]
        _, self.bones = judge.read_tgf(self.skeleton)

    def bind(self, options, stem, *more):
        W, row = bind(options, self.mesh, self.skeleton, "hand-" + stem, *more)
        if W is not None:
            row.update(distances(W, self.exact), bleeding=judge.bleeding(W, self.exact, self.bones))
        return W, row


def across_teeth(W, mesh, teeth):
    """The largest weight of another tooth's bone on the outer half of a tooth."""
    V, _ = judge.read_obj(mesh)
    own = (np.arctan2(V[:, 1], V[:, 0]) % (2 * np.pi) / (2 * np.pi) * teeth).astype(int) % teeth
    outer = np.hypot(V[:, 0], V[:, 1]) > 0.35
    others = W[:, 1:].copy()
    others[np.arange(len(V)), own] = 0
    return float(others[outer].max())


# ---- ablations -----------------------------------------------------------------------------------

def visibility(options):
    hand, gear = Hand(options), shapes.gear(options.out / "gear.obj")
    for rule in ("counted", "any-hit", "none"):
        more = ["--nodes", POINTS, "--visibility", rule]
        _, row = hand.bind(options, f"visibility-{rule}", *more)
        W, other = bind(options, gear, gear.with_suffix(".tgf"), f"gear-{rule}", *more, "--save-field",
                        options.out / f"gear-{rule}.sfield")
        if W is not None:
            row["teeth"] = across_teeth(W, gear, 16)
        row["gear_cpu"] = other["cpu"]
        yield dict(rule=rule, **row)


def widths(options):
    hand = Hand(options)
    for width in (0.5, 1, 2):
        for step in (0.5, 1, 2):
            # The option counts h in sigmas, which the width changes.
            _, row = hand.bind(options, f"width-{width}-{step}", "--nodes", POINTS, "--kernel-width", width,
                               "--difference-step", 0.5 * step / width, "--judge-step", STEP)
            yield dict(width=width, step=step, **row)


def multiscale(options):
    """Figures 12 and 13: steps at all levels against as many at one."""
    hand = Hand(options)
    spot = options.data / "surface" / "spot.obj"
    for name in ("hand", "spot"):
        for label, points, levels in (("four levels", POINTS, 4), ("all points at once", POINTS, 1),
                                      ("few points alone", POINTS // 8, 1)):
            more = [*ADAM, "--nodes", points, "--levels", levels, "--judge-step", STEP]
            stem = f"multiscale-{name}-{label.replace(' ', '-')}"
            if name == "hand":
                _, row = hand.bind(options, stem, *more)
            else:
                _, row = bind(options, spot, spot.with_suffix(".tgf"), stem, *more)
            yield dict(name=name, label=label, points=points, **row)


def boundary(options):
    hand = Hand(options)
    for kind in ("natural", "neumann"):
        for points in (1 << 12, 1 << 13, 1 << 14):
            _, row = hand.bind(options, f"boundary-{kind}-{points}", "--nodes", points, "--boundary",
                               kind, "--judge-step", STEP)
            yield dict(kind=kind, points=points, **row)
    fish = options.data / "surface" / "fish.obj"
    for kind in ("natural", "neumann"):
        bind(options, fish, fish.with_suffix(".tgf"), f"fish-{kind}", "--nodes", POINTS, "--boundary",
             kind, "--save-field", options.out / f"fish-{kind}.sfield")


def degradation(options):
    """Figure 14: faces go, corners move; the torn shape's weights on the clean surface."""
    for name in ("spot", "human_man"):
        mesh = options.data / "surface" / f"{name}.obj"
        skeleton = mesh.with_suffix(".tgf")
        clean, _ = bind(options, mesh, skeleton, f"{name}-clean", "--nodes", POINTS)
        V, F = judge.read_obj(mesh)
        for removed, jitter in ((0, 0), (.1, .002), (.3, .005), (.5, .0075), (.7, .01)):
            torn = options.out / f"{name}-torn-{removed:g}.obj"
            if removed == 0:
                judge.write_obj(torn, V, F)
            else:
                P, T, _ = judge.torn(V, F, removed, jitter, 1)
                judge.write_obj(torn, P, T)
            field = torn.with_suffix(".sfield")
            # Whole shapes with other random numbers: what is no fault of the tearing.
            W, row = bind(options, torn, skeleton, torn.stem, "--nodes", POINTS, "--save-field",
                          field, "--seed", 1)
            carried = torn.with_name(torn.stem + "-carried.npz")
            moved = run([options.program, "transfer", field, mesh, "-o", carried, "--quiet"])
            if W is not None and clean is not None and moved["code"] == 0:
                row.update(distances(judge.read_npz(carried), clean))
            yield dict(name=name, removed=removed, jitter=jitter, **row)


def painting(options):
    """Figures 6 and 17: stop, paint the ears' tips, go on."""
    mesh, ears = shapes.eared(options.out / "eared.obj")
    skeleton = mesh.with_suffix(".tgf")
    paint = options.out / "eared-paint.csv"
    # One ear's tip to the head, the other's to the tail.
    with open(paint, "w") as out:
        for (_, tip), column in zip(ears, (2, 0)):
            for v in tip:
                out.write(f"{v}," + ",".join("1" if k == column else "0" for k in range(3)) + "\n")
    def means(W):
        return None if W is None else [W[own].mean(0).tolist() for own, _ in ears]
    for solver, steps, more in (("convex", 20, []), ("adam-pool", 500, POOL)):
        field = options.out / f"eared-{solver}.sfield"
        W, row = bind(options, mesh, skeleton, f"eared-{solver}-before", *more, "--nodes", 1 << 12,
                      "--iterations", steps, "--save-field", field)
        yield dict(stage=f"{solver}, {steps} steps, no paint", **row, ears=means(W))
        W, row = bind(options, mesh, skeleton, f"eared-{solver}-after", "--resume", field, "--paint",
                      paint)
        yield dict(stage=f"{solver}, painted, resumed to the end", **row, ears=means(W))


# ---- table 1 -------------------------------------------------------------------------------------

REFEREED = ("spot", "fish", "penguin")
EVERY_OPTIMISER = ("spot", "fish", "penguin", "gear", "hand")
BY_ADAM = ("spot", "hand")


def table_cases(options):
    yield "hand", options.out / "hand.obj", options.data / "fem" / "hand.tgf"
    for name in ("spot", "penguin", "fish", "mushroom", "scorpion", "cow", "armadillo"):
        mesh = options.data / "surface" / f"{name}.obj"
        yield name, mesh, mesh.with_suffix(".tgf")
    for make in (shapes.gear, shapes.ribbons, shapes.flag, shapes.skirt):
        mesh = make(options.out / f"{make.__name__}.obj")
        yield make.__name__, mesh, mesh.with_suffix(".tgf")
    for mesh in sorted((options.data / "wild").iterdir()):
        skeleton = mesh.with_suffix(".tgf")
        if mesh.suffix in (".obj", ".ply", ".stl", ".off") and skeleton.exists():
            yield mesh.stem, mesh, skeleton


def exact_weights(options, name, mesh, skeleton, hand):
    """Of the surface's vertices, on tetrahedra refined 1:8; None where there are none."""
    if name == "hand":
        return hand.exact
    if name not in REFEREED:
        return None
    stored = options.out / f"{name}-exact.npy"
    if stored.exists():
        return np.load(stored)
    tets, fine = options.out / f"{name}.mesh", options.out / f"{name}-fine.mesh"
    made = run([options.program, "tetrahedralise", mesh, "--skeleton", skeleton, "--nodes", 5000,
                "-o", tets, "--quiet"])
    if made["code"] != 0:
        return None
    V, T = meshes.refined(*judge.read_medit(tets))
    meshes.write(fine, V, T)
    W, _ = bind(options, fine, skeleton, f"{name}-fine", method="bbw")
    if W is None:
        return None
    number = {tuple(np.round(v, 9)): k for k, v in enumerate(V)}
    P, _ = judge.read_obj(mesh)
    found = [number.get(tuple(np.round(p, 9)), -1) for p in P]
    if min(found) < 0:
        return None
    np.save(stored, W[found])
    return W[found]


def table_one(options):
    hand = Hand(options)
    for name, mesh, skeleton in table_cases(options):
        if not fnmatch.fnmatch(name, options.only) or name in options.known:
            continue
        row = dict(name=name, methods={})
        exact = exact_weights(options, name, mesh, skeleton, hand)
        W, row["methods"]["tets"] = bind(options, mesh, skeleton, f"table-{name}-tets", "--domain",
                                         "tets", "--nodes", 16000, method="bbw")
        if W is not None and exact is not None:
            row["methods"]["tets"].update(distances(W, exact))
        for kind in ("natural", "neumann"):
            solvers = [("convex", [])]
            if name in EVERY_OPTIMISER or kind == "natural" and mesh.parent.name != "wild":
                solvers.append(("adam-pool", POOL))
            if kind == "natural" and name in BY_ADAM:
                solvers.append(("adam", ADAM))
            for solver, more in solvers:
                W, one = bind(options, mesh, skeleton, f"table-{name}-{solver}-{kind}", *more,
                              "--nodes", POINTS, "--boundary", kind, "--judge-step", STEP)
                if W is not None and exact is not None:
                    one.update(distances(W, exact))
                one.pop("curve", None)
                row["methods"][f"{solver}-{kind}"] = one
        row["exact"] = exact is not None
        yield row


# ---- cost ----------------------------------------------------------------------------------------

def cost(options):
    hand = Hand(options)
    def measured(kind, mesh, skeleton, **more):
        _, row = bind(options, mesh, skeleton, "cost", "--nodes", POINTS)
        row["kind"] = kind
        row.update(more)
        stages = json.loads((options.out / "cost.report.json").read_text())
        row["solve_cpu"] = at(stages, "cpu_s", "solve")
        row["stages"] = {k: v for k, v in at(stages, "timings_s").items()
                         if k.startswith("field_")}
        return row
    for count in (5, 10, 20, 40, 80):
        skeleton = options.out / "cost.tgf"
        if count < 20:
            meshes.first_bones(hand.skeleton, count, skeleton)
        else:
            meshes.split_bones(hand.skeleton, count // 20, skeleton)
        yield measured("bones", hand.mesh, skeleton, count=count)
    penguin = options.data / "surface" / "penguin.obj"
    V, F = judge.read_obj(penguin)
    mesh = options.out / "cost.obj"
    for _ in range(5):
        judge.write_obj(mesh, V, F)
        yield measured("triangles", mesh, penguin.with_suffix(".tgf"), count=len(F))
        V, F = meshes.refined_surface(V, F)


SECTIONS = dict(visibility=visibility, widths=widths, boundary=boundary, painting=painting,
                degradation=degradation, cost=cost, multiscale=multiscale, table=table_one)


def main():
    parser = arguments(__doc__, "fields")
    parser.add_argument("--sections", default=",".join(SECTIONS), help="in this order; none: page")
    parser.add_argument("--only", default="*", metavar="GLOB", help="shapes of the table")
    parser.add_argument("--resume", action="store_true", help="leave out shapes that are stored")
    parser.add_argument("--limit", type=float, default=900, help="seconds for one run")
    parser.add_argument("--note", default="", help="for the page's head: what else ran, say")
    options = checked(parser)
    store = options.out / "results.json"
    results = json.loads(store.read_text()) if store.exists() else {}
    version = run([options.program, "--version"])["out"].splitlines()[0]
    results.update(machine=machine(), version=version, note=options.note or results.get("note", ""))

    def save():
        store.write_text(json.dumps(results, indent=1))
        options.document.write_text(pages.page(results, options.document.parent))

    judge.hand_surface(options.data, options.out / "hand.obj")
    results["shapes"] = [case[0] for case in table_cases(options)]
    for name in (s for s in options.sections.split(",") if s in SECTIONS):
        old = {r["name"]: r for r in results.get(name, [])} if name == "table" else {}
        options.known = set(old) if options.resume else set()
        rows = []
        for row in SECTIONS[name](options):
            rows.append(row)
            label = " ".join(str(v) for v in list(row.values())[:3] if not isinstance(v, dict))
            print(f"{name}: {label}: {row.get('failure') or 'done'}", file=sys.stderr, flush=True)
            merged = {**old, **{r["name"]: r for r in rows}} if name == "table" else rows
            results[name] = list(merged.values()) if name == "table" else merged
            save()
        pages.pictures(name, results, options)
    save()
    print(f"results: wrote {options.document}")


if __name__ == "__main__":
    main()
