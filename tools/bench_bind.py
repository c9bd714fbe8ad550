#!/usr/bin/env python3
"""Times `skinfield bind` end to end: the hand at three qualities, every stage with one thread and
with two, a character of 60 bones refined to 500,000 triangles, and exact weights on tetrahedra from
7,000 to 145,000 vertices. CPU seconds beside wall seconds, and what must be reached.

    bench_bind.py [--program P] [--data D] [--out FOLDER] [--rounds N] [--only PART]
"""

import argparse
import hashlib
import json
import os
import sys
from pathlib import Path

import numpy as np

import judge
import meshes
from results import ROOT, at, last_line, machine, run


def bind(options, source, output, *more):
    """A bind with its report: measures, or a failure line."""
    report = output.with_suffix(".report.json")
    ran = run([options.program, "bind", source, "-o", output, "--report", report, "--quiet",
               *more])
    row = dict(wall=ran["wall"], cpu=ran["cpu"], peak=ran["peak"])
    if ran["code"] != 0:
        row["failure"] = last_line(ran["err"]) or f"exit {ran['code']}"
        return row
    row["report"] = json.loads(report.read_text())
    row["bytes"] = hashlib.sha256(output.read_bytes()).hexdigest()
    return row


def show(label, row, target=""):
    if "failure" in row:
        print(f"{label:34} failed: {row['failure']}")
        return
    print(f"{label:34} {row['wall']:7.2f} s wall {row['cpu']:7.2f} s CPU "
          f"{row['peak'] / 2**20:6.0f} MB  {target}")
    stages = at(row["report"], "cpu_s", default={})
    if stages:
        print("    CPU s: " + ", ".join(f"{name} {seconds:.2f}" for name, seconds in stages.items()))


def hand(options):
    if not options.data.exists():
        print("hand: no shared data, left out")
        return
    mesh = options.out / "hand.obj"
    kept = judge.hand_surface(options.data, mesh)
    skeleton = ["--skeleton", options.data / "fem" / "hand.tgf"]
    reference = judge.read_npz(options.data / "fem" / "hand-refined-bbw.npz")[kept]
    targets = {"draft": "(at most 0.8 CPU s, TV 0.04)", "normal": "(at most 8 CPU s)",
               "high": "(at most 50 CPU s, 2000 MB)"}
    for quality, target in targets.items():
        output = options.out / f"bench-{quality}.npz"
        row = bind(options, mesh, output, *skeleton, "--quality", quality)
        show(f"hand, {quality}", row, target)
        if "failure" not in row:
            tv = judge.row_distances(judge.read_npz(output), reference).mean()
            print(f"    TV to exact weights on refined tets: {tv:.4f}")


def threads(options):
    """Stage by stage, one thread against two: the least of several alternating runs, since other
    work on the machine only ever adds."""
    mesh = options.data / "fem" / "hand.mesh"
    if not mesh.exists():
        return
    best, same = {}, set()
    for _ in range(options.rounds):
        for count in (1, 2):
            row = bind(options, mesh, options.out / f"bench-threads{count}.npz", "--skeleton",
                       mesh.with_suffix(".tgf"), "--domain", "points", "--threads", count)
            if "failure" in row:
                return show(f"hand, {count} thread(s)", row)
            same.add(row["bytes"])
            stages = {name: (wall, at(row["report"], "cpu_s", name, default=None))
                      for name, wall in row["report"]["timings_s"].items()}
            for name, (wall, cpu) in {**stages, "all": (row["wall"], row["cpu"])}.items():
                old = best.setdefault(name, {}).get(count, (np.inf, np.inf))
                best[name][count] = (min(old[0], wall), cpu and min(old[1], cpu))
    print(f"hand, normal, by threads (least of {options.rounds}):\n"
          f"    {'stage':22} {'wall 1':>8} {'wall 2':>8} {'ratio':>6} {'CPU 1':>8} {'CPU 2':>8}")
    for name, row in best.items():
        (wall1, cpu1), (wall2, cpu2) = row[1], row[2]
        cpu = f"{cpu1:8.3f} {cpu2:8.3f}" if cpu1 else ""
        print(f"    {name:22} {wall1:8.3f} {wall2:8.3f} {wall1 / wall2:6.2f} {cpu}")
    print(f"    (all: at least 1.6; {'the same' if len(same) == 1 else 'DIFFERENT'} bytes; machine "
          f"load {os.getloadavg()[0]:.1f})")


def split_skeleton(sample, bones, output):
    """A TGF skeleton of a sample character whose longest bones are halved until there are so many.
    The samples' nodes have translations alone."""
    data = sample.read_bytes()
    nodes = json.loads(data[20:20 + int.from_bytes(data[12:16], "little")])["nodes"]
    place, edges = {}, []
    children = {child for node in nodes for child in node.get("children", [])}
    stack = [(k, np.zeros(3)) for k, node in enumerate(nodes)
             if k not in children and "mesh" not in node]
    while stack:
        k, origin = stack.pop()
        place[k] = origin + np.array(nodes[k].get("translation", [0, 0, 0]))
        for child in nodes[k].get("children", []):
            edges.append((k, child))
            stack.append((child, place[k]))
    while len(edges) < bones:
        longest = max(edges, key=lambda e: np.linalg.norm(place[e[0]] - place[e[1]]))
        middle = len(nodes) + len(place)
        place[middle] = (place[longest[0]] + place[longest[1]]) / 2
        edges.remove(longest)
        edges += [(longest[0], middle), (middle, longest[1])]
    number = {k: i + 1 for i, k in enumerate(place)}
    lines = ["{} {} {} {}".format(number[k], *x) for k, x in place.items()]
    lines += ["#"] + [f"{number[a]} {number[b]}" for a, b in edges]
    output.write_text("\n".join(lines) + "\n")


def triangles(options):
    """Time against boundary triangles at fixed nodes, 60 bones."""
    measured = []
    for count in (16000, 60000, 125000, 500000):
        sample = options.out / f"gecko-{count}.glb"
        made = run([options.program, "sample", "gecko", "-o", sample, "--triangles", count,
                    "--quiet"])
        if made["code"] != 0:
            print(f"gecko, {count:,} triangles: {last_line(made['err'])}")
            continue
        skeleton = options.out / "gecko-60.tgf"
        split_skeleton(sample, 60, skeleton)
        row = bind(options, sample, options.out / f"gecko-{count}-bound.npz", "--skeleton",
                   skeleton)
        if "failure" not in row:
            faces = at(row["report"], "input", "faces", default=count)
            handles = at(row["report"], "input", "handles", default=0)
            measured.append((faces, row["cpu"]))
            label = f"gecko, {faces:,} triangles, {handles} bones"
        else:
            label = f"gecko, {count:,} triangles"
        show(label, row, "(at most 40 CPU s, 4000 MB)" if count == 500000 else "")
    if len(measured) > 1:
        (few, fast), (many, slow) = measured[0], measured[-1]
        power = np.log(slow / fast) / np.log(many / few)
        print(f"    CPU time grows as triangles^{power:.2f} (must stay below 1)")


def tets(options):
    """Exact weights on tetrahedra, one thread, solved to the tolerance that leaves errors of a few
    thousandths and to the default one. Seconds of everything after reading."""
    fem, surface = options.data / "fem", options.data / "surface"
    if not fem.exists():
        print("tets: no shared data, left out")
        return
    out = options.out

    def filled(mesh, skeleton, nodes, name):
        made = run([options.program, "tetrahedralise", mesh, "--skeleton", skeleton, "--nodes",
                    nodes, "-o", out / name, "--quiet"])
        if made["code"] != 0:
            print(f"{name}: {last_line(made['err'])}")
        return out / name

    def fine(surface, skeleton, nodes, name):
        """Filled behind a surface with every triangle in four: many vertices lie on it."""
        judge.write_obj(out / f"{name}.obj", *meshes.refined_surface(*judge.read_obj(surface)))
        return filled(out / f"{name}.obj", skeleton, nodes, f"{name}.mesh")

    judge.hand_surface(options.data, out / "hand.obj")
    bones15 = meshes.first_bones(surface / "penguin.tgf", 15, out / "penguin-15.tgf")
    meshes.write(out / "hand-refined.mesh", *meshes.refined(*judge.read_medit(fem / "hand.mesh")))
    meshes.write(out / "tibiman-refined.mesh", *meshes.refined(*judge.read_medit(fem / "tibiman.mesh")))
    closed = surface / "hand_closed.tgf"
    bones80 = meshes.split_bones(closed, 4, out / "hand-80.tgf")
    # With fewest vertices inside it, as many entries in the factor as the limits were set at.
    hand_fine = fine(surface / "hand_closed.obj", closed, 4000, "hand-fine")
    hand_filled = filled(out / "hand-fine.obj", closed, 30000, "hand-filled.mesh")
    cases = [("hand", fem / "hand.mesh", fem / "hand.tgf", "at most 0.6 CPU s"),
             ("penguin, fine surface", fine(surface / "penguin.obj", bones15, 45000, "penguin-fine"),
              bones15, "at most 6 CPU s"),
             ("hand, refined 1:8", out / "hand-refined.mesh", fem / "hand.tgf", ""),
             ("hand, fine surface", hand_fine, closed, "at most 11 CPU s, 600 MB"),
             ("hand, fine surface", hand_fine, bones80, "at most 17 CPU s, 1000 MB"),
             ("hand, fine surface, filled", hand_filled, closed, ""),
             ("tibiman, refined 1:8", out / "tibiman-refined.mesh", fem / "tibiman.tgf",
              "at most 50 CPU s, 2000 MB")]
    for label, mesh, skeleton, target in cases:
        for tolerance in ("2e-2", "1e-3"):
            row = bind(options, mesh, out / "bench-tets.npz", "--skeleton", skeleton,
                       "--tolerance", tolerance, "--threads", 1)
            if "failure" in row:
                show(label, row)
                continue
            report = row["report"]
            print(f"{label}, {at(report, 'domain', 'nodes'):,} nodes, "
                  f"{at(report, 'input', 'handles')} handles, tolerance {tolerance}: "
                  f"{sum(report['cpu_s'].values()):.2f} CPU s "
                  f"(solve {report['cpu_s']['solve']:.2f}), {row['peak'] / 2**20:.0f} MB, "
                  f"factor {at(report, 'solve', 'factor_entries') / 1e6:.0f}M, "
                  f"{at(report, 'solve', 'iterations')} iterations, gap "
                  f"{at(report, 'solve', 'relative_gap'):.0e} "
                  f"{f'({target})' if target and tolerance == '2e-2' else ''}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/skinfield")
    parser.add_argument("--data", type=Path, default=Path(
        os.environ.get("SKINFIELD_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--rounds", type=int, default=3, help="runs with each number of threads")
    parser.add_argument("--only", choices=["hand", "threads", "triangles", "tets"])
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "bench")
    options = parser.parse_args()
    options.program = options.program.resolve()
    if not options.program.exists():
        sys.exit(f"bench: {options.program} is not built (make build)")
    options.out.mkdir(parents=True, exist_ok=True)
    print(f"on {machine()}")
    for part in (hand, threads, triangles, tets):
        if options.only in (None, part.__name__):
            part(options)


if __name__ == "__main__":
    main()
