#!/usr/bin/env python3
"""Prints the tables of docs/figures.md from finished bundles (Python's standard library alone).

  docs/figures.py DIR...            prints the tables of each bundle
  docs/figures.py --ranges DIR...   prints what storing costs by level: one table, bundles side by side
  docs/figures.py --times DIR...    prints the times and the memory of each, which no two runs share

DIR holds report.json (and run.json), as `meshcolor convert MODEL -o DIR` leaves them.
"""

import json
import pathlib
import sys


def table(heading, rows):
    """A Markdown table; every column but the first is figures, set to the right."""
    line = "| {} |".format
    rule = ["---"] + ["--:"] * (len(heading) - 1)
    return "\n".join(line(" | ".join(cells)) for cells in [heading, rule, *rows]) + "\n"


def number(value, digits=3):
    return "" if value is None else f"{value:.{digits}f}"


def count(value):
    return f"{value:,}".replace(",", " ")


def share(value):
    return "" if value is None else f"{100 * value:.1f} %"


def size(value):
    return f"{value[0]} × {value[1]}"


def channel_name(channel):
    slots = " + ".join(slot.removesuffix("Texture") for slot in channel["slots"])
    return f"{channel['material_name'] or 'material {}'.format(channel['material'])}, {slots}"


def figures(seams):
    seams = seams or {}
    return [number(seams.get(name)) for name in ("max", "p999", "mean")]


def seams(channel):
    heading = ["level", "size", "max", "99.9 %", "mean", "drift"]
    heading += ["source size", "source max", "source 99.9 %", "source mean", "source drift"]
    rows = []
    for level in channel["levels"]:
        row = [str(level["level"]), size(level["size"]), *figures(level["seams"]), number(level["drift"])]
        source = level["source"]
        if source:
            row += [size(source["size"]), *figures(source["seams"]), number(source["drift"])]
        rows.append(row + [""] * (len(heading) - len(row)))
    return f"**{channel_name(channel)}**, {channel['unit']}\n\n" + table(heading, rows)


def cuts(channels):
    heading = ["channel", "seam edges", "share of inner edge length", "joined", "cut", "cut edges"]
    return table(heading, [
        [channel_name(channel), count(cut["seam_edge_count"]), share(cut["seam_share"]),
         share(cut["welded_share"]), share(cut["cut_share"]), count(cut["cut_edge_count"])]
        for channel in channels for cut in [channel["cuts"]]
    ])


def fidelity(channels):
    heading = ["channel", "PSNR, dB", "yardstick, dB", "difference, dB", "RMS", "yardstick RMS", "unit"]
    return table(heading, [
        [channel_name(channel), number(own["psnr_db"], 1), number(own["yardstick_psnr_db"], 1),
         number(own["psnr_db"] - own["yardstick_psnr_db"], 1).replace("-", "−"), number(own["rms"], 2),
         number(own["yardstick_rms"], 2), channel["unit"]]
        for channel in channels for own in [channel["fidelity"]] if own
    ])


def solver(channels):
    heading = ["channel, level", "rules", "out of range", "steps", "left over", "mean change, codes", "largest"]
    return table(heading, [
        [f"{channel_name(channel)}, {level['level']}", count(level["row_count"]), count(level["violated_count"]),
         str(level["iteration_count"]), f"{level['residual']:.0e}" if level["residual"] else "0", number(level["change_mean_codes"]),
         number(level["change_max_codes"], 0)]
        for channel in channels for level in channel["solver"]
    ])


def layout(layouts):
    heading = ["material, level", "size", "texels", "waste", "efficiency"]
    return table(heading, [
        [f"{own['material_name'] or own['material']}, {level['level']}", size(level["size"]),
         count(level["allocated_texels"]), share(level["waste"]), share(level.get("efficiency"))]
        for own in layouts for level in own["levels"]
    ])


def growth(own):
    rows = [
        ["texels, level 0", own["source_texels"], own["converted_texels"]],
        ["texels, all levels", None, own["converted_texels_all_levels"]],
        ["vertices", own["source_vertices"], own["converted_vertices"]],
        ["bytes", own["source_bytes"], own["converted_bytes"]],
    ]
    return table(["", "source", "converted", "factor"], [
        [name, "" if a is None else count(a), count(b), "" if not a else f"{b / a:.2f}"] for name, a, b in rows
    ])


def times(run):
    """CPU seconds by stage, and each against decoding the sources plus encoding the levels."""
    steps = {step["step"]: step["cpu_seconds"] for stage in run["stages"] for step in stage["steps"]}
    yardstick = steps.get("decode", 0) + steps.get("encode", 0)
    rows = [[stage["stage"], number(stage["cpu_seconds"], 2), number(stage["cpu_seconds"] / yardstick, 1),
             number(stage["peak_memory_bytes"] / 2**20, 0)] for stage in run["stages"]]
    rows.append(["all", number(run["cpu_seconds"], 2), number(run["cpu_seconds"] / yardstick, 1),
                 number(run["peak_memory_bytes"] / 2**20, 0)])
    told = f"Decoding the source's images plus encoding the level images took {yardstick:.2f} CPU seconds, "
    told += f"the whole conversion {run['seconds']:.1f} seconds on {run['thread_count']} threads.\n\n"
    return told + table(["stage", "CPU seconds", "ratio", "peak memory, MiB"], rows)


def ranges(folders):
    """By channel and level: what the solver or the format changed, and seams with both kinds of weights."""
    heading = ["bundle, level", "stored as", "mean change, codes", "95 %", "largest",
               "seam 99.9 %", "seam max", "8-bit weights 99.9 %", "max"]
    tables = {}
    for folder in folders:
        for channel in json.loads((folder / "report.json").read_text())["channels"]:
            rows = tables.setdefault(channel_name(channel), [])
            for level in channel["levels"]:
                changes = channel["solver"] + channel.get("stored", [])
                change = next((own for own in changes if own["level"] == level["level"]), {})
                seams, coarse = level["seams"] or {}, level.get("seams_8bit_weights") or {}
                change = [change.get(f"change_{name}_codes", 0) for name in ("mean", "p95", "max")]
                rows.append([f"{folder.name}, {level['level']}", level.get("range", f"{channel['bits']} bits"),
                             *[number(value, 2) for value in change],
                             *[number(own.get(name), 2) for own in (seams, coarse) for name in ("p999", "max")]])
    by_level = lambda row: int(row[0].rsplit(", ", 1)[1])
    return "\n".join(f"**{name}**\n\n{table(heading, sorted(rows, key=by_level))}" for name, rows in tables.items())


def page(folder):
    report = json.loads((folder / "report.json").read_text())
    channels = report["channels"]
    parts = [("Seams and drift", "\n".join(map(seams, channels))), ("Cuts", cuts(channels)),
             ("Fidelity at level 0", fidelity(channels)), ("What the solver changed", solver(channels)),
             ("Layout", layout(report["layouts"])), ("Growth", growth(report["growth"]))]
    if not any(channel["solver"] for channel in channels):
        parts[3] = (parts[3][0], "Nothing: no texel was out of range.\n")
    return "\n".join(f"### {title}\n\n{text}" for title, text in parts)


def main(arguments):
    flags = {argument for argument in arguments if argument.startswith("--")}
    folders = [argument for argument in arguments if argument not in flags]
    if not folders or len(flags) > 1 or flags - {"--ranges", "--times"}:
        sys.exit(__doc__)
    if "--ranges" in flags:
        print(ranges(list(map(pathlib.Path, folders))), end="")
        return
    for folder in map(pathlib.Path, folders):
        print(times(json.loads((folder / "run.json").read_text())) if flags else page(folder), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
