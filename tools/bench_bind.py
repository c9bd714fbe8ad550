#!/usr/bin/env python3
"""Times `skinfield bind` end to end: the hand at three qualities, one thread against two, and a
character refined to 500,000 triangles. CPU seconds beside wall seconds, and what must be reached.

    bench_bind.py [--program P] [--data D] [--out FOLDER]
"""

import argparse
import hashlib
import json
import os
import sys
from pathlib import Path

import numpy as np

import judge
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

    rows = {}
    for threads in (1, 2):
        rows[threads] = bind(options, mesh, options.out / f"bench-threads{threads}.npz", *skeleton,
                             "--threads", threads)
        show(f"hand, normal, {threads} thread(s)", rows[threads])
    if not any("failure" in row for row in rows.values()):
        print(f"    two threads: {rows[1]['wall'] / rows[2]['wall']:.2f} times as fast (at least "
              f"1.6); {'the same' if rows[1]['bytes'] == rows[2]['bytes'] else 'DIFFERENT'} bytes")


def triangles(options):
    """Time against boundary triangles at fixed nodes."""
    measured = []
    for count in (16000, 60000, 125000, 500000):
        sample = options.out / f"gecko-{count}.glb"
        made = run([options.program, "sample", "gecko", "-o", sample, "--triangles", count,
                    "--quiet"])
        if made["code"] != 0:
            print(f"gecko, {count:,} triangles: {last_line(made['err'])}")
            continue
        row = bind(options, sample, options.out / f"gecko-{count}-bound.glb")
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/skinfield")
    parser.add_argument("--data", type=Path, default=Path(
        os.environ.get("SKINFIELD_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "bench")
    options = parser.parse_args()
    options.program = options.program.resolve()
    if not options.program.exists():
        sys.exit(f"bench: {options.program} is not built (make build)")
    options.out.mkdir(parents=True, exist_ok=True)
    print(f"on {machine()}")
    hand(options)
    triangles(options)


if __name__ == "__main__":
    main()
