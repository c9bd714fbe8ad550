"""docs/results-quasi.md from what tools/results_quasi.py collected."""

from results_page import escape, table


def table_part(rows, keys):
    good = [r for r in rows if "failure" not in r and "energy" in r["methods"].get("bbw", {})]
    text = ["## Energies\n",
            "Exact energy, and the others over it. k: steps of the paper's customised Adam; the "
            "default goes on by L-BFGS where the maximum principle holds (steps in brackets).\n"]
    cells, broken = [], []
    for r in good:
        m, base = r["methods"], r["methods"]["bbw"]
        line = [r["name"], f"{base['nodes']:,}", f"{base['elements'] or r.get('triangles', 0):,}",
                base["handles"], f"{base['energy']:.6g}"]
        for key in keys[1:]:
            one = m[key]
            if "failure" in one:
                line.append("failed")
                continue
            steps = f" ({one['iterations']})" if key == "default" else ""
            line.append(f"{one['energy'] / base['energy']:.4f}{steps}")
            if one["energy"] < base["energy"] * (1 - max(1e-6, 2 * base["gap"])):
                broken.append(f"{r['name']}: {key}")
        cells.append(line)
    text.append(table(["mesh", "vertices", "elements", "handles", "bbw"] + keys[1:], cells))
    text.append("E(bbw) is at most the energy of every other weights, on every mesh here.\n"
                if not broken else f"**E(bbw) is above the energy of {'; '.join(broken)}.**\n")
    for r in rows:
        if "failure" in r:
            text.append(f"{r['name']}: **failed**: {escape(r['failure'])}\n")

    text.append("## Seconds\n")
    text.append("CPU / wall of the solve alone, all of it: symbolic work, start, steps.\n")
    text.append(table(["mesh"] + keys, [[r["name"]] + [
        "failed" if "failure" in r["methods"][k] else
        f"{r['methods'][k]['cpu']:.2f} / {r['methods'][k]['wall']:.2f}" for k in keys]
        for r in good]))

    text.append("## Extrema\n")
    text.append("Vertices whose weight is above (below) all neighbours' by more than 1e-4, as the "
                "report counts them; for quasi-harmonic weights before / after the projection. In "
                "brackets hills and hollows with a prominence above 1e-4 (tools/judge.py): how far a "
                "weight has to fall before it can go on to a higher one. They count smooth extrema, "
                "which do not stand out from their neighbours, and leave handles' own vertices out; "
                "their largest prominence follows.\n")
    cells = []
    for r in good:
        line = [r["name"]]
        for key in keys:
            one = r["methods"][key]
            if "failure" in one:
                line.append("failed")
                continue
            count = (f"{one['before']} / {one['extrema']}" if one.get("before") is not None
                     else f"{one['extrema']}")
            if "hills" in one:
                count += f" ({one['hills']}" + (f", {one['highest']:.1g})" if one["hills"] else ")")
            line.append(count)
        cells.append(line)
    text.append(table(["mesh"] + keys, cells))
    for r in good:
        split = r["methods"]["bbw"].get("split")
        if split:
            text.append(f"{r['name']}: {split} nodes were made for handles without a vertex. They are "
                        "not among the mesh's own, so that extrema which stand at handles seem to "
                        "stand beside them.\n")
    apart = [f"{r['name']}, {k}" for r in good for k in keys
             if "judged" in r["methods"][k] and r["methods"][k]["judged"] != r["methods"][k]["extrema"]]
    text.append("tools/judge.py counts the same vertices wherever it has the mesh.\n" if not apart
                else f"**tools/judge.py counts otherwise on {'; '.join(apart)}.**\n")

    text.append("## A step\n")
    text.append("Milliseconds of wall time of a step, of the one factorisation and two back "
                "substitutions of all handles in it, measured in the same run of 20 steps, and their "
                "ratio (wanted: 1.5 at most).\n")
    text.append(table(["mesh", "step ms", "linear ms", "ratio"],
                      [[r["name"], f"{1e3 * q['steps'] / q['iterations']:.2f}",
                        f"{1e3 * q['linear'] / q['iterations']:.2f}",
                        f"{q['steps'] / q['linear']:.2f}"]
                       for r in good for q in [r["methods"]["k = 20"]] if q.get("linear")]))
    return text


def page(results, methods, optimisers):
    """Methods: keys of the table's columns; optimisers: names by key, as in tools/results_quasi.py."""
    text = ["# Quasi-harmonic and monotonic weights\n",
            f"Made by `make results` on {results['machine']}. {results['note']}\n"]
    if results.get("table"):
        text += table_part(results["table"], methods)
    if results.get("convergence"):
        text.append("## Convergence\n")
        text.append("100 iterations of each optimiser on the same objective, from the same start. An "
                    "iteration of L-BFGS has a line search: the seconds tell.\n")
        rows = results["convergence"]
        text.append(table(["mesh"] + list(optimisers.values()),
                          [[r["name"]] + [f"{r['curves'][s]['energy'] / r['exact']:.4f} in "
                                          f"{r['curves'][s]['cpu']:.1f} s" for s in optimisers]
                           for r in rows]))
        if results.get("convergence_picture"):
            text.append(f"![convergence]({results['convergence_picture']})\n")
    if results.get("brick"):
        text.append("## The brick\n")
        text.append("Held at its end faces; there is a tensor field that generates the exact weights. "
                    "Largest pointwise differences (the paper: 0.0039 and 0.0038).\n")
        text.append(table(["vertices", "tets", "optimiser", "steps", "energy", "CPU s", "to bbw",
                           "to decoupled", "to monotonic"],
                          [[f"{r['vertices']:,}", f"{r['tets']:,}", r["label"], r["iterations"],
                            f"{r['energy']:.4f}", f"{r['cpu']:.2f}"] +
                           [f"{r['differences'][k]:.4f}" for k in ("bbw", "decoupled", "monotonic")]
                           for r in results["brick"]]))
    if results.get("cactus"):
        text.append("## The cactus\n")
        text.append("Two handles, at its bottom and at its top; weights of the upper one. Exact "
                    "weights fall on towards the left arm's end and rise on towards the right one's: "
                    "local extrema, away from any handle. Monotonic and quasi-harmonic weights stay "
                    "what they are where the arm begins.\n")
        c = results["cactus"]
        text.append(table(["cactus", "weights", "energy", "extrema by prominence", "largest"] +
                          c["places"],
                          [[r["shape"], r["method"], f"{r['energy']:.4g}", r["hills"],
                            f"{r['highest']:.1g}" if r["hills"] else ""] +
                           [f"{w:.3f}" for w in r["weights"]] for r in c["rows"]]))
    if results.get("cost"):
        text.append("## Cost\n")
        text.append("The penguin with 15 bones, filled with ever more vertices.\n")
        keys = ("k = 10", "k = 20", "default")
        text.append(table(["vertices", "tets"] + [f"{k}: CPU s / wall" for k in keys] +
                          ["step over linear"],
                          [["**failed**: " + escape(r["failure"])] + [""] * 5 if "failure" in r else
                           [f"{r['nodes']:,}", f"{r['elements']:,}"] +
                           [f"{r['methods'][k]['cpu']:.2f} / {r['methods'][k]['wall']:.2f}"
                            for k in keys] +
                           [f"{r['methods']['k = 20']['steps'] / r['methods']['k = 20']['linear']:.2f}"]
                           for r in results["cost"]]))
        if results.get("cost_picture"):
            text.append(f"![cost]({results['cost_picture']})\n")
    if results.get("pictures"):
        text.append("## Pictures\n")
        text.append("Above: the weights of a handle that has extrema with bbw, marked where they "
                    "stand out from their neighbours (maxima light, minima dark). Below: the demo "
                    "pose.\n")
        for r in results["pictures"]:
            if "failure" in r:
                text.append(f"{r['name']}: **failed**: {escape(r['failure'])}\n")
                continue
            counts = ", ".join(f"{k} {v}" for k, v in r["counts"].items())
            text.append(f"{r['name']}, handle {r['bone']}, its extrema by prominence: {counts}.\n")
            text.append(f"![{r['name']}]({r['picture']})\n")
    if results.get("image"):
        r = results["image"]
        text.append("## A warped picture\n")
        text.append(f"**failed**: {escape(r['failure'])}\n" if "failure" in r else
                    "Four points near the corners stay, one moves, and a bone turns: the picture, and "
                    "warped by bbw and by quasi-harmonic weights (energy over bbw's "
                    f"{r['energy']:.3f}; {r['cpu']:.2f} CPU seconds, bbw {r['bbw_cpu']:.2f}; extrema "
                    f"{r['extrema'][1]}, bbw {r['extrema'][0]}).\n")
        if "picture" in r:
            text.append(f"![warped picture]({r['picture']})\n")
    return "\n".join(text)
