"""The findings of the report, in words. Each is computed from the tables."""

from collections.abc import Mapping, Sequence
from pathlib import PurePath
from statistics import median

from . import times as times_table
from .methods import BASELINES, RIVALS
from .rows import Results, Row


def claims(results: Results) -> str:
    """Section 3.4: level 6 is at least 4 times better than the baselines, level 4 is comparable."""
    rows = results["claims"]
    if not rows:
        return "Levels 4 and 6 were not both asked for.\n\n"
    fine, coarse = (sum(row[key] for row in rows) for key in ("level_6_holds", "level_4_holds"))
    text = (f"Level 6 is at least 4 times better in RMSE than the better baseline for {fine} of {len(rows)} "
            f"materials; level 4 is comparable (within a factor of 2) for {coarse}.")
    fails = [f"{row['material']} ({row['level_6_factor']:.2g})" for row in rows if not row["level_6_holds"]]
    return text + (f" Where level 6 is not (times better): {', '.join(fails)}." if fails else "") + "\n\n"


def times(results: Results) -> str:
    """Section 3.5: evaluation takes as long at any level."""
    found = results["times"]
    return f"{found['calls']:,} calls, {found['material']}. {flatness(found['rows'])}\n\n"


def flatness(rows: list[Row]) -> str:
    """How much longer evaluation takes at finer levels."""
    slower = [100 * (times_table.spread(rows, {f"level {level}" for level in range(times_table.LEVELS[0], last + 1)})
                     or 0.0) for last in times_table.LEVELS[-2:]]
    return (f"Among levels {times_table.LEVELS[0]} to {times_table.LEVELS[-2]} the slowest takes {slower[0]:.0f} % "
            f"more than the fastest, with level {times_table.LEVELS[-1]} {slower[1]:.0f} %: the arithmetic is the "
            "same at every level, but not how much of the lattice a processor's cache holds.")


def compressed(results: Results) -> str:
    """Section 4.3.1: fits with a diffuse level of 1 suffer."""
    rows = results["compressed"]
    worse: dict[str, int] = {}
    text = []
    for other in ("(3,6,90)", "(4,6,95)"):
        ratios = [row[f"over {other}"] for row in rows]
        worse[other] = sum(ratio > 1 for ratio in ratios)
        text.append(f"its RMSE is larger than that of {other} for {worse[other]} of {len(rows)} materials, "
                    f"{median(ratios):.2g} times in the median")
    good = sum(row["beats_baselines"] for row in rows)
    return (f"(1,6,90) suffers: {'; '.join(text)}. It is as good as both baselines or better for {good}, the paper's "
            f"\"almost all\".\n\n")


def ringing(results: Results) -> str:
    """Section 4.3.1: a larger diffuse component eliminates ringing."""
    by_material: dict[str, dict[str, float]] = {}
    for row in results["ringing"]:
        by_material.setdefault(row["material"], {})[row["method"]] = row["ringing"]
    falls = [f"{name} ({values['(1,6,90)']:.3g} to {values['(4,6,90)']:.3g})" for name, values in by_material.items()
             if values["(4,6,90)"] < values["(1,6,90)"]]
    rises = [f"{name} ({values['(1,6,90)']:.3g} to {values['(4,6,90)']:.3g})" for name, values in by_material.items()
             if values["(4,6,90)"] >= values["(1,6,90)"]]
    text = ("Ringing is the variation of the fit between neighbouring samples beyond that of a monotone one: the total "
            "variation along the lines between them less the difference of the ends, summed, over the summed "
            "differences of the measured ends. It is 0 if the fit is monotone between any two neighbours. ")
    if falls:
        text += f"From diffuse level 1 to 4 it falls for {', '.join(falls)}. "
    if rises:
        text += f"It does not for {', '.join(rises)}: there the specular lattice has peaks to carry at any D. "
    least = min(row["ringing"] for row in results["ringing"])
    by_method: dict[str, list[float]] = {}
    for row in results["comparison"]:
        by_method.setdefault(row["method"], []).append(row["ringing"])
    return (text + f"The smallest value in the table is {least:.2g}: reduced, not eliminated. The median of all "
            "materials, and the largest: " + "; ".join(f"{name} {median(found):.3g} and {max(found):.3g}"
                                            for name, found in by_method.items()) + ".\n\n")


def held_out(results: Results) -> str:
    """Which method predicts held-out samples best."""
    wins: dict[str, int] = {}
    materials: dict[tuple[str, str], list[Row]] = {}
    for row in results["comparison"]:
        materials.setdefault((row["material"], row["source"]), []).append(row)
    for rows in materials.values():
        best = min(rows, key=lambda row: row["held_out_cube_root_rmse"])["method"]
        wins[best] = wins.get(best, 0) + 1
    counted = ", ".join(f"{name} {count}" for name, count in sorted(wins.items(), key=lambda item: -item[1]))
    text = f"Smallest in the latter, of {len(materials)} materials: {counted}.\n"
    return text + _against_rivals(materials) + "\n"


def _against_rivals(materials: Mapping[tuple[str, str], list[Row]], own: str = "Standard",
                    rivals: Sequence[str] = ("level 6", *BASELINES, *RIVALS)) -> str:
    """For how many materials both held-out errors are below the rivals', and the ratio to the first rival's."""
    behind: list[str] = []
    ratios: dict[tuple[str, str], float] = {}
    for (material, source), rows in materials.items():
        errors = {row["method"]: (row["held_out_rmse"], row["held_out_cube_root_rmse"]) for row in rows}
        if not {own, *rivals} <= errors.keys():
            return ""
        most = [max(errors[own][kind] / errors[rival][kind] for rival in rivals) for kind in (0, 1)]
        if max(most) >= 1:
            behind.append(f"{material} ({most[0]:.3g} and {most[1]:.3g} times the best of them)")
        ratios[material, source] = errors[own][1] / errors[rivals[0]][1]
    alone = [key for key in ratios if sum(other[1] == key[1] for other in ratios) == 1]
    text = (f"{own} is below {', '.join(rivals[:-1])} and {rivals[-1]} in both errors for "
            f"{len(materials) - len(behind)} of {len(materials)} materials")
    text += f"; not for {', '.join(behind)}" if behind else ""
    text += f". By the cube root it has {median(ratios.values()):.2g} of {rivals[0]}'s error in the median"
    text += "".join(f", {ratios[key]:.2g} for {key[0]} ({PurePath(key[1]).name})" for key in alone)
    return text + ".\n"


def physics(results: Results) -> str:
    """Reciprocity, conservation of energy, and negative values."""
    text = ["Reciprocity error: mean |f(i,o) - f(o,i)| over mean |f|, directions uniform in projected solid angle. "
            "Negative: share of values below 0, which `Fit.evaluate` returns and the shader clamps to 0. Albedo: "
            "directional albedo of the clamped values, the largest over the view angles; above 1 is unphysical.\n"]
    for method in dict.fromkeys(row["method"] for row in results["comparison"]):
        rows = [row for row in results["comparison"] if row["method"] == method]
        over = sum(max(row["albedo"]) > 1 for row in rows)
        signed = sum(row["negative_fraction"] > 0 for row in rows)
        text.append(f"- {method}: reciprocity error {median(row['reciprocity_error'] for row in rows):.2g} in the "
                    f"median; negative somewhere for {signed} of {len(rows)} materials, up to "
                    f"{100 * max(row['negative_fraction'] for row in rows):.2g} % of the directions; "
                    f"clamping adds up to {100 * max(row['negative_energy'] for row in rows):.2g} % of the energy; "
                    f"albedo above 1 for {over}, at most {max(max(row['albedo']) for row in rows):.2g}.")
    return "\n".join(text) + "\n\n"


def differences(results: Results) -> str:
    """Where results differ from the paper's, and why."""
    rows = results["claims"]
    curet = [row for row in rows if _is_curet(results, row)]
    others = [row for row in rows if not _is_curet(results, row)]
    points = []
    for name, group in (("files of many materials (CURET)", curet), ("single files (Cornell)", others)):
        if group:
            held = sum(row["level_6_holds"] for row in group)
            points.append(f"**Level 6 four times better than the baselines**: {name}, {held} of {len(group)}, "
                          f"{median(row['level_6_factor'] for row in group):.2g} times in the median."
                          + _where(results, group))
    table = results["storage"][-2:]
    points.append("**Storage**: " + "; ".join(
        f"{row['fit']} takes {row['bytes']:,} bytes where the paper's takes {row['paper_bytes']:,}" for row in table)
        + ". The paper's sizes add up to 4 bytes a coefficient, and one byte for each of the 300,763 control points "
          "of the level-6 lattice, kept or not; and two symmetries of an isotropic reflectance leave a quarter of the "
          "dense lattice to store.")
    points.append("**What the paper does not measure**: errors at held-out samples. "
                  f"{_against_baselines(results)} The paper's lattice meets every sample, and nothing guides it "
                  "between them; Standard starts from an estimate there.")
    ring: dict[str, list[float]] = {row["method"]: [] for row in results["ringing"]}
    for row in results["ringing"]:
        ring[row["method"]].append(row["ringing"])
    points.append(f"**\"Ringing can be eliminated\"**: in the median of the materials below it goes from "
                  f"{median(ring['(1,6,90)']):.3g} for (1,6,90) to {median(ring['(4,6,90)']):.3g} for (4,6,90): "
                  "reduced, not eliminated.")
    return "\n## Where they differ from the paper\n\n" + "\n".join(f"- {point}" for point in points) + "\n"


def _where(results: Results, claimed: list[Row]) -> str:
    """Where the error of level 6 is, for the materials for which the claim fails."""
    failing = {(row["material"], row["source"]) for row in claimed if not row["level_6_holds"]}
    rows = [row for row in results["where"] if (row["material"], row["source"]) in failing]
    if not rows:
        return ""
    crowded, bright = (100 * median(row[key] for row in rows) for key in ("crowded_share", "bright_share"))
    text = " Where it is not, {:.3g} % of the squared error of level 6 (the median) is at {}."
    if crowded > bright:
        return text.format(crowded, f"the {rows[0]['crowded']} of {rows[0]['samples']} samples that have another "
                           "within the width of a cell, and differ from it by more than a cell can follow")
    return text.format(bright, "the brightest twentieth of the samples: peaks narrower than a cell")


def _against_baselines(results: Results) -> str:
    """For how many materials each of our methods has smaller errors than both baselines."""
    rows: dict[str, list[Row]] = {}
    for row in results["comparison"]:
        rows.setdefault(row["method"], []).append(row)
    baselines = [rows.pop(name) for name in BASELINES]
    text = []
    for name, ours in rows.items():
        if name in RIVALS:
            continue
        seen, unseen, unseen_cube = (
            sum(one[key] < min(b[key] for b in others) for one, *others in zip(ours, *baselines, strict=True))
            for key in ("rmse", "held_out_rmse", "held_out_cube_root_rmse"))
        text.append(f"{name} {seen} at the samples, {unseen} at unseen samples ({unseen_cube} by the cube root)")
    return f"Smaller RMSE than both baselines, of {len(baselines[0])} materials: {'; '.join(text)}."


def _is_curet(results: Results, row: Row) -> bool:
    """Whether a row is of a file with several materials."""
    return sum(other["source"] == row["source"] for other in results["claims"]) > 1
