"""docs/results.md from what tools/results.py collected."""

import statistics


def number(value, form="{:.3g}"):
    return "" if value is None else form.format(value)


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(c) for c in row) + " |" for row in rows]) + "\n"


def escape(text):
    return text.replace("|", "\\|")


def cases_part(rows, refused):
    text = ["## Every case\n",
            "Row error: the largest |sum − 1| of a row in the written file. Idle: handles without "
            "vertices. Filled: vertices that a lower rung of the ladder gave their weights. Gap: "
            "certified, of the discrete problem; \"limit\" where the iterations ran out before "
            "the tolerance. Seconds are wall and CPU, of the whole program.\n"]
    for group in ("rigged", "surface", "wild", "fem"):
        mine = [r for r in rows if r["group"] == group and r["name"] not in refused]
        if not mine:
            continue
        text.append(f"### {group}\n")
        cells = []
        for r in mine:
            if "failure" in r:
                cells.append([r["name"], "**failed**", "", number(r["wall"], "{:.1f}"),
                              number(r["cpu"], "{:.1f}"), "", "", "", "", escape(r["failure"])])
                continue
            cells.append([
                r["name"], r.get("rung") or "", number(r.get("nodes"), "{:,}"),
                number(r["wall"], "{:.1f}"), number(r["cpu"], "{:.1f}"),
                number(r["peak"] / 2**20, "{:.0f}"),
                number(r.get("row_error"), "{:.0e}") + ("" if r.get("valid") else " **invalid**"),
                number(r.get("idle"), "{}"), number(r.get("filled"), "{}"),
                number(r.get("gap"), "{:.1e}") + (" (limit)" if r.get("limit") else "")])
        text.append(table(["case", "rung", "nodes", "s", "CPU s", "MB", "row error", "idle",
                           "filled", "gap"], cells))
    good = sum(1 for r in rows if r.get("valid") and r["name"] not in refused)
    total = sum(1 for r in rows if r["name"] not in refused)
    text.append(f"{good} of {total} valid: no NaN, no negative weight, every row's sum within 1e-6 "
                "of one, every vertex weighted.\n")
    turned_down = [r for r in rows if r["name"] in refused]
    if turned_down:
        text.append("Refused on purpose, or for want of a skeleton:\n")
        text.append(table(["case", "has", "exit", "message"],
                          [[r["name"], refused[r["name"]], r["code"],
                            escape(r.get("failure", "was bound"))] for r in turned_down]))
    return text


def artists_part(rows, blender):
    mine = [r for r in rows if r["group"] == "rigged" and "tv" in r]
    if not mine:
        return []
    cells = []
    for r in mine:
        theirs = blender.get(r["name"].rsplit(".", 1)[0], (None, None))
        motion = r.get("motion")
        cells.append([r["name"], number(r["tv"], "{:.3f}"), number(theirs[0], "{:.2f}"),
                      number(motion * 100 if motion is not None else None, "{:.2f}"),
                      number(theirs[1], "{:.2f}"), escape(r.get("validator", "not run"))])
    both = [(r, blender[r["name"].rsplit(".", 1)[0]]) for r in mine
            if r["name"].rsplit(".", 1)[0] in blender]
    text = ["## The artists' own weights\n",
            "TV over the deforming joints, and the RMS distance of vertices over the file's own "
            "animations in % of the bounding box's diagonal (without an animation: over the demo "
            "pose), beside Blender 3.4's bone heat (its better variant; see tools/results.py). "
            "Most of these artists kept Blender's bone heat, so nearness here measures likeness to "
            "Blender more than quality: fox, webxr_hand and mech are independent of it, and mech, "
            "snake, spider and wasp are rigid by part.\n",
            table(["case", "TV", "Blender", "motion %", "Blender", "validator, against the source"],
                  cells)]
    if both:
        median = lambda values: statistics.median(list(values))
        text.append(
            f"Median of {len(both)}: TV {median(r['tv'] for r, _ in both):.3f}, Blender "
            f"{median(b[0] for _, b in both):.2f}.\n")
    return text


def hand_part(rows):
    text = ["## The hand against exact weights\n",
            "`fem/hand.mesh`'s surface (4,780 vertices, 20 bones) against exact bounded biharmonic "
            "weights on its tetrahedra refined 1:8. The given tetrahedra themselves are at 0.0258. "
            "Bleeding: the largest weight of one finger's bones on another finger's tip.\n"]
    cells = []
    for nodes in sorted({r["nodes"] for r in rows}):
        mine = [r for r in rows if r["nodes"] == nodes]
        good = [r for r in mine if "tv" in r]
        if not good:
            cells.append([nodes, "**failed**", escape(mine[0].get("failure", "")), "", "", "", "",
                          ""])
            continue
        mean = lambda key: statistics.mean(r[key] for r in good)
        cells.append([f"{nodes:,}", " ".join(f"{r['tv']:.4f}" for r in good), f"{mean('tv'):.4f}",
                      f"{mean('p99'):.3f}", f"{max(r['worst'] for r in good):.3f}",
                      f"{max(r['bleeding'] for r in good):.4f}", f"{mean('cpu'):.1f}",
                      f"{mean('peak') / 2**20:.0f}"])
    text.append(table(["nodes", "TV, three seeds", "mean", "99%", "max", "bleeding", "CPU s", "MB"],
                      cells))
    return text


def fork_part(rows):
    return ["## The fork\n",
            "Two prongs with a gap between: the largest weight of one prong's bone on the other's "
            "inner wall.\n",
            table(["gap", "across"],
                  [[r["gap"], escape(r["failure"]) if "failure" in r else f"{r['across']:.1e}"]
                   for r in rows])]


def soup_part(rows):
    cells = []
    for removed in sorted({r["removed"] for r in rows}):
        mine = [r for r in rows if r["removed"] == removed]
        good = [r for r in mine if "tv" in r]
        if not good:
            cells.append([f"{removed:.0%}", "", "**failed**", "", "", "", ""])
            continue
        mean = lambda key: statistics.mean(r[key] for r in good)
        cells.append([f"{removed:.0%}", good[0]["jitter"],
                      f"{sum(r['valid'] for r in good)} of {len(mine)}", f"{mean('tv'):.4f}",
                      f"{mean('p99'):.3f}", f"{max(r['p99'] for r in good):.3f}",
                      f"{max(r['worst'] for r in good):.2f}"])
    return ["## The hand torn to a soup\n",
            "Faces removed at random and the corners of the rest moved on their own (Gaussian, "
            "share of the box's largest side), five seeds, 8,000 nodes. The torn hand's weights, "
            "carried to the clean surface, against the clean hand's own.\n",
            table(["removed", "jitter", "valid", "TV", "99%", "worst 99%", "max"], cells)]


def page(results, blender, refused):
    made = results.get("made", {})
    text = ["# Results\n",
            f"Made by `make results` with {made.get('version', '')} on {made.get('machine', '')}. "
            "Weights are judged by `tools/judge.py`, independently of the program. TV is the mean "
            "over vertices of half the L1 difference of two weight rows. "
            f"{made.get('note', '')}\n"]
    if results.get("cases"):
        text += cases_part(results["cases"], refused)
        text += artists_part(results["cases"], blender)
    for name, part in (("hand", hand_part), ("fork", fork_part), ("soup", soup_part)):
        if results.get(name):
            text += part(results[name])
    return "\n".join(text)
