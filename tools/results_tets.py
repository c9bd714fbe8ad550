#!/usr/bin/env python3
"""Binds the shared surfaces, wild cases and tet meshes with --domain tets: docs/results-tets.md.

    results_tets.py [--program P] [--data D] [--only GLOB] [--nodes N] [--pictures]

Every case ends in weights (by which route: given, split, tetgen, wrap) or in a clear message. Meshes,
weights, reports and pictures stay under results/tets. TV is the distance to the weights of the point
domain on the same input: mean over vertices of half the L1 difference of two rows.
"""

import fnmatch
import json
import sys

import judge
from results import arguments, at, checked, find_cases, last_line, machine, run
from results_page import escape, number, table


def bind_case(case, options):
    group, name, path, skeleton = case
    folder = options.out / group
    folder.mkdir(parents=True, exist_ok=True)
    stem = name.replace(" (points)", "-points")
    weights, report = folder / (stem + ".npz"), folder / (stem + ".report.json")
    tets, points = folder / (stem + ".mesh"), folder / (stem + ".points.npz")
    for stale in (weights, report, tets, points):
        stale.unlink(missing_ok=True)
    common = [path, "--skeleton", skeleton, "--quiet", "--nodes", str(options.nodes)]
    made = run([options.program, "tetrahedralise", *common, "-o", tets, "--json"])
    row = dict(group=group, name=name, code=made["code"])
    if made["code"] == 0:
        row["mesh"] = json.loads(made["out"])
    bound = run([options.program, "bind", *common, "--domain", "tets", "-o", weights,
                 "--report", report])
    row.update(bind_code=bound["code"], wall=bound["wall"], cpu=bound["cpu"], peak=bound["peak"])
    if bound["code"] != 0:
        row["failure"] = (last_line(bound["err"]) or f"exit {bound['code']}").replace(
            str(path), name)
        return row
    row["report"] = json.loads(report.read_text())
    W = judge.read_npz(weights)
    row["faults"] = judge.row_faults(W)
    other = run([options.program, "bind", *common, "--domain", "points", "-o", points])
    if other["code"] == 0:
        distance = judge.row_distances(W, judge.read_npz(points))
        row.update(tv=float(distance.mean()), tv_max=float(distance.max()))
    if options.pictures and group != "fem":
        pictures = options.out / "pictures"
        pictures.mkdir(exist_ok=True)
        for kind in ("dominant", "posed"):
            run([options.program, "render", path, "--skeleton", skeleton, "--weights", weights,
                 "--kind", kind, *(["--pose", "demo"] if kind == "posed" else ["--bones"]),
                 "--caption", f"{name}: tets, {kind}", "-o", pictures / f"{stem}-{kind}.png",
                 "--quiet"])
    return row


def page(results):
    text = ["# Tetrahedra of every case\n",
            f"Made by `make results` with {results['version']} on {results['machine']}, "
            f"`--domain tets --nodes {results['nodes']}`. Route: see "
            "[methods/tet_domain.md](methods/tet_domain.md). Volume: of the tets over what the "
            "surface (or its wrap) encloses. Seconds are wall and CPU of `bind`, all of it; meshing "
            "is that stage's wall. TV: against the point domain with as many nodes.\n"]
    for group in ("surface", "wild", "fem"):
        rows = []
        for r in (r for r in results["cases"] if r["group"] == group):
            if "failure" in r:
                rows.append([r["name"], "none", "", "", "", "", "", number(r["wall"], "{:.1f}"),
                             number(r["cpu"], "{:.1f}"), "", escape(r["failure"])])
                continue
            d, mesh = r["report"]["domain"], r.get("mesh", {})
            broken = sum(r["faults"][2:]) if len(r["faults"]) > 2 else 0
            notes = [] if broken == 0 else [f"{broken} bad rows"]
            outside = len(at(r["report"], "input", "handles_outside", default=[]))
            if outside:
                notes.append(f"{outside} handles outside")
            if at(r["report"], "solve", "status") != "converged":
                notes.append("iteration limit")
            if mesh.get("why_not_direct"):
                notes.append(mesh["why_not_direct"])
            ratio = (mesh["volume"] / mesh["surface_volume"] if mesh.get("surface_volume") else None)
            rows.append([r["name"], d["route"], f"{d['nodes']:,}", f"{d['elements']:,}",
                         number(ratio, "{:.4f}"), number(mesh.get("min_dihedral_degrees"), "{:.1f}"),
                         number(at(r["report"], "timings_s", "domain"), "{:.1f}"),
                         number(r["wall"], "{:.1f}"), number(r["cpu"], "{:.1f}"),
                         number(r.get("tv"), "{:.4f}"), escape("; ".join(notes))])
        if rows:
            text += [f"## {group}\n",
                     table(["case", "route", "vertices", "tets", "volume", "min dihedral°",
                            "meshing s", "s", "CPU s", "TV", "notes"], rows)]
    return "\n".join(text)


def main():
    parser = arguments(__doc__, "tets")
    parser.add_argument("--only", default="*", metavar="GLOB", help="cases, as group/name")
    parser.add_argument("--nodes", type=int, default=16000)
    parser.add_argument("--pictures", action="store_true", help="into results/tets/pictures")
    options = checked(parser)

    store = options.out / "results.json"
    old = json.loads(store.read_text())["cases"] if store.exists() else []
    cases = [c for c in find_cases(options.data) if c[0] in ("surface", "wild", "fem")]
    order = {(c[0], c[1]): i for i, c in enumerate(cases)}
    version = run([options.program, "--version"])["out"].splitlines()[0]
    fresh = []
    for case in cases:
        if not fnmatch.fnmatch(f"{case[0]}/{case[1]}", options.only):
            continue
        fresh.append(bind_case(case, options))
        made = {(r["group"], r["name"]) for r in fresh}
        kept = [r for r in old if (r["group"], r["name"]) not in made]
        results = dict(version=version, machine=machine(), nodes=options.nodes,
                       cases=sorted((r for r in kept + fresh if (r["group"], r["name"]) in order),
                                    key=lambda r: order[r["group"], r["name"]]))
        store.write_text(json.dumps(results, indent=1))
        options.document.write_text(page(results))
        print(f"results_tets: {case[0]}/{case[1]}: "
              f"{fresh[-1].get('failure') or fresh[-1]['report']['domain']['route']}", flush=True)
    print(f"results_tets: wrote {options.document}")


if __name__ == "__main__":
    main()
