#!/usr/bin/env python3
"""Runs the built program over the shared data and writes what it reaches into docs/results.md.

    results.py [--program P] [--data D] [--only GLOB] [--sections cases,hand,fork,soup]
               [--jobs N] [--pictures]

Everything else it makes (weights, reports, pictures) stays under results/. Weights are judged by
tools/judge.py, independently of the program; a case that fails is a line in the tables, not an end.
Timings are only fair with --jobs 1.
"""

import argparse
import concurrent.futures
import fnmatch
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import judge

ROOT = Path(__file__).resolve().parent.parent
REFUSED = {"draco_astronaut.glb": "Draco", "meshopt_no_skin.glb": "meshopt and no skin",
           "node_animated_no_skin.glb": "no skin"}

# Blender 3.4's bone heat (ARMATURE_AUTO), the better of its two leaf-tail variants, character scaled
# to a diagonal of 2 units: TV to the artist's weights, motion RMS in % of the diagonal. Measured
# once with Blender itself, in the study that chose the algorithms (docs/decisions).
BLENDER = {
    "alpaca": (.17, .35), "cesium_man": (.14, .37), "farmer": (.10, .07), "fox": (.27, .77),
    "frog": (.04, .61), "greenman": (.08, .70), "kaykit_barbarian": (.12, .21),
    "kaykit_mage": (.11, .18), "koi": (.02, .07), "manta_ray": (.14, .13), "mech": (.41, 4.06),
    "robot_expressive": (.03, .05), "snake": (.74, 3.98), "spider": (.23, 1.86),
    "stag": (.03, .11), "trex": (.01, .09), "wasp_nan_weights": (.14, 2.21),
    "webxr_hand_left": (.46, 1.10), "witch": (.12, 1.28)}


def run(arguments, limit=900):
    """Runs the program: exit code, output, messages, wall and CPU seconds, peak bytes."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        begin = time.monotonic()
        child = subprocess.Popen([str(a) for a in arguments], stdout=out, stderr=err,
                                 stdin=subprocess.DEVNULL)
        while True:
            pid, status, usage = os.wait4(child.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - begin > limit:
                child.kill()
            time.sleep(0.005)
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return dict(code=child.returncode, out=out.read(), err=err.read(),
                    wall=time.monotonic() - begin, cpu=usage.ru_utime + usage.ru_stime,
                    peak=usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024))


def last_line(text):
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1].strip() if lines else ""


# ---- cases ---------------------------------------------------------------------------------------

def find_cases(data):
    """(group, name, input, skeleton or None)."""
    cases = []
    for path in sorted((data / "rigged").glob("*.gl*")):
        cases.append(("rigged", path.name, path, None))
    for group in ("surface", "wild", "fem"):
        for path in sorted((data / group).iterdir()):
            if path.suffix not in {".obj", ".ply", ".stl", ".off", ".mesh", ".msh"}:
                continue
            for skeleton in (path.with_suffix(".tgf"), path.with_name(path.stem + "-points.tgf")):
                if skeleton.exists():
                    points = " (points)" if skeleton.stem.endswith("-points") else ""
                    cases.append((group, path.name + points, path, skeleton))
    return cases


def at(tree, *path, default=None):
    for key in path:
        if not isinstance(tree, dict) or key not in tree:
            return default
        tree = tree[key]
    return tree


def count(value):
    """A count, however the report puts it: a number, a list, or numbers by cause."""
    if isinstance(value, dict):
        return sum(count(v) or 0 for v in value.values())
    return len(value) if isinstance(value, list) else value


def summary(report):
    """What the tables need of a report; of several characters: sums, and the worst gap."""
    parts = report.get("characters") or [report]
    def total(*path):
        return sum(count(at(part, *path)) or 0 for part in parts)
    return dict(rung=", ".join(dict.fromkeys(str(at(part, "domain", "rung")) for part in parts)),
                nodes=total("domain", "nodes"),
                gap=max((at(part, "solve", "relative_gap") or 0 for part in parts)),
                limit=any(at(part, "solve", "status") != "converged" for part in parts),
                idle=total("weights", "handles_without_vertices"),
                filled=total("weights", "vertices_filled"))


def bind_case(case, options):
    group, name, path, skeleton = case
    folder = options.out / group
    folder.mkdir(parents=True, exist_ok=True)
    stem = name.replace(" (points)", "-points")
    output = folder / (stem + "-bound.glb" if group == "rigged" else stem + ".npz")
    report_path = folder / (stem + ".report.json")
    for stale in (output, report_path):
        stale.unlink(missing_ok=True)
    command = [options.program, "bind", path, "-o", output, "--report", report_path, "--quiet"]
    if skeleton:
        command += ["--skeleton", skeleton]
    ran = run(command)
    row = dict(group=group, name=name, code=ran["code"], wall=ran["wall"], cpu=ran["cpu"],
               peak=ran["peak"])
    if ran["code"] != 0:
        row["failure"] = (last_line(ran["err"]) or f"exit {ran['code']}").replace(str(path), name)
        return row
    try:
        report = json.loads(report_path.read_text())
        row.update(summary(report), peak=at(report, "peak_memory_bytes", default=ran["peak"]))
        faults = (judge.gltf_row_faults(output) if group == "rigged"
                  else judge.row_faults(judge.read_npz(output)))
        row.update(zip(("vertices", "row_error", "negative", "broken", "empty"), faults))
        row["valid"] = (row["row_error"] <= 1e-6 and
                        row["negative"] + row["broken"] + row["empty"] == 0)
    except (OSError, ValueError, KeyError) as error:
        row["failure"] = f"output cannot be judged: {error}"
        return row
    if group == "rigged":
        compared = run([options.program, "compare", output, path, "--json"])
        try:
            distances = json.loads(compared["out"])
            row.update(tv=at(distances, "tv_mean"), motion=at(distances, "motion_rms"))
        except ValueError:
            row["compare_failure"] = last_line(compared["err"])
        validator = ROOT / "tools" / "gltf_validate.js"
        if shutil.which("node") and (ROOT / "node_modules" / "gltf-validator").exists():
            found = run(["node", validator, output, path])
            row["validator"] = "clean" if found["code"] == 0 else last_line(found["out"])
    if options.pictures:
        pictures = options.out / "pictures"
        pictures.mkdir(exist_ok=True)
        if group == "rigged":
            run([options.program, "render", output, "-o", pictures / (stem + ".png"), "--quiet"])
            run([options.program, "render", output, "--pose", "demo",
                 "-o", pictures / (stem + "-posed.png"), "--quiet"])
    return row


# ---- the hand, the fork, the soup ----------------------------------------------------------------

def weights_of(options, mesh, skeleton, output, *more):
    ran = run([options.program, "bind", mesh, "--skeleton", skeleton, "-o", output, "--quiet",
               *more])
    if ran["code"] != 0:
        return None, ran
    return judge.read_npz(output), ran


def hand_section(options):
    """TV to exact weights on refined tets, at four sizes and three seeds."""
    surface = options.out / "hand.obj"
    kept = judge.hand_surface(options.data, surface)
    skeleton = options.data / "fem" / "hand.tgf"
    _, bones = judge.read_tgf(skeleton)
    reference = judge.read_npz(options.data / "fem" / "hand-refined-bbw.npz")[kept]
    tasks = [(nodes, seed) for nodes in (4000, 8000, 16000, 32000) for seed in (0, 1, 2)]

    def one(task):
        nodes, seed = task
        W, ran = weights_of(options, surface, skeleton,
                            options.out / f"hand-{nodes}-{seed}.npz",
                            "--nodes", nodes, "--seed", seed)
        row = dict(nodes=nodes, seed=seed, wall=ran["wall"], cpu=ran["cpu"], peak=ran["peak"])
        if W is None:
            row["failure"] = last_line(ran["err"])
        else:
            d = judge.row_distances(W, reference)
            row.update(tv=float(d.mean()), p99=float(np.quantile(d, .99)), worst=float(d.max()),
                       bleeding=judge.bleeding(W, reference, bones))
        return row

    return parallel(options, one, tasks)


def fork_section(options):
    """The other prong's weight on a prong's inner wall."""
    def one(gap):
        mesh = options.out / f"fork-{gap:g}.obj"
        left, right = judge.fork(gap, mesh)
        W, ran = weights_of(options, mesh, mesh.with_suffix(".tgf"), mesh.with_suffix(".npz"))
        if W is None:
            return dict(gap=gap, failure=last_line(ran["err"]))
        return dict(gap=gap, across=float(max(W[left, 2].max(), W[right, 1].max())))

    return parallel(options, one, [0.02, 0.01, 0.001, 0.0002, 0.00005])


def soup_section(options):
    """The hand with faces removed and corners moved: the torn hand's weights carried to the clean
    surface, against the clean result there; its own rows are judged for validity alone, since its
    vertices have moved."""
    surface = options.out / "hand.obj"
    judge.hand_surface(options.data, surface)
    skeleton = options.data / "fem" / "hand.tgf"
    clean, ran = weights_of(options, surface, skeleton, options.out / "hand-clean.npz",
                            "--nodes", 8000)
    if clean is None:
        return [dict(removed=0, seed=0, failure=last_line(ran["err"]))]
    V, F = judge.read_obj(surface)
    levels = [(.1, .004), (.2, .0075), (.3, .0105), (.5, .0105), (.7, .0105)]
    tasks = [(removed, jitter, seed) for removed, jitter in levels for seed in range(5)]

    def one(task):
        removed, jitter, seed = task
        mesh = options.out / f"soup-{removed:g}-{seed}.obj"
        corners, faces, _ = judge.torn(V, F, removed, jitter, seed)
        judge.write_obj(mesh, corners, faces)
        W, ran = weights_of(options, mesh, skeleton, mesh.with_suffix(".npz"), "--nodes", 8000)
        row = dict(removed=removed, jitter=jitter, seed=seed, wall=ran["wall"])
        if W is None:
            row["failure"] = last_line(ran["err"])
        else:
            _, error, negative, broken, empty = judge.row_faults(W)
            carried = mesh.with_name(mesh.stem + "-carried.npz")
            moved = run([options.program, "transfer", mesh, surface, "--skeleton", skeleton, "-o",
                         carried, "--nodes", 8000, "--quiet"])
            if moved["code"] != 0:
                return dict(row, failure=last_line(moved["err"]))
            d = judge.row_distances(judge.read_npz(carried), clean)
            row.update(valid=error <= 1e-6 and negative + broken + empty == 0, tv=float(d.mean()),
                       p99=float(np.quantile(d, .99)), worst=float(d.max()))
        return row

    return parallel(options, one, tasks)


# ---- running -------------------------------------------------------------------------------------

def parallel(options, work, items):
    rows = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for item, row in zip(items, pool.map(work, items)):
            rows.append(row)
            label = row.get("name") or " ".join(
                str(v) for v in (item if isinstance(item, tuple) else (item,)))
            print(f"{label}: {row.get('failure') or 'done'}", file=sys.stderr, flush=True)
    return rows


def machine():
    model = next((line.split(":", 1)[1].strip() for line in
                  Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")),
                 platform.processor()) if Path("/proc/cpuinfo").exists() else platform.processor()
    return f"{os.cpu_count()} cores, {model}"


def arguments(doc, part=""):
    """What every page's script takes; part: its own name after `results`."""
    parser = argparse.ArgumentParser(description=doc.split("\n")[0])
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/skinfield")
    parser.add_argument("--data", type=Path, default=Path(
        os.environ.get("SKINFIELD_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--out", type=Path, default=ROOT / "results" / part)
    page = f"results-{part}.md" if part else "results.md"
    parser.add_argument("--document", type=Path, default=ROOT / "docs" / page)
    return parser


def checked(parser):
    """The options, with data and program there and a folder for what is kept."""
    options = parser.parse_args()
    options.program = options.program.resolve()
    name = Path(sys.argv[0]).stem
    if not options.data.exists():
        sys.exit(f"{name}: no shared data at {options.data} (set SKINFIELD_DATA)")
    if not options.program.exists():
        sys.exit(f"{name}: {options.program} is not built (make build)")
    options.out.mkdir(parents=True, exist_ok=True)
    return options


def main():
    parser = arguments(__doc__)
    parser.add_argument("--only", default="*", metavar="GLOB", help="cases, as group/name")
    parser.add_argument("--sections", default="cases,hand,fork,soup")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--pictures", action="store_true", help="into results/pictures")
    parser.add_argument("--note", default="", help="for the page's head: what else ran, say")
    options = checked(parser)

    # Earlier sections stay, so that one can be renewed alone.
    store = options.out / "results.json"
    results = json.loads(store.read_text()) if store.exists() else {}
    sections = options.sections.split(",")
    if "cases" in sections:
        chosen = [c for c in find_cases(options.data)
                  if fnmatch.fnmatch(f"{c[0]}/{c[1]}", options.only)]
        fresh = parallel(options, lambda c: bind_case(c, options), chosen)
        names = {(r["group"], r["name"]) for r in fresh}
        old = [r for r in results.get("cases", []) if (r["group"], r["name"]) not in names]
        order = {(c[0], c[1]): i for i, c in enumerate(find_cases(options.data))}
        results["cases"] = sorted(
            (r for r in old + fresh if (r["group"], r["name"]) in order),
            key=lambda r: order[r["group"], r["name"]])
    for name, section in (("hand", hand_section), ("fork", fork_section), ("soup", soup_section)):
        if name in sections:
            results[name] = section(options)
    version = run([options.program, "--version"])["out"].strip()
    results["made"] = dict(machine=machine(), version=version.splitlines()[0] if version else "",
                           note=options.note)
    store.write_text(json.dumps(results, indent=1))

    import results_page
    options.document.write_text(results_page.page(results, BLENDER, REFUSED))
    print(f"results: wrote {options.document}")


if __name__ == "__main__":
    main()
