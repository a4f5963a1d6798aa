"""The results in words and tables: what was wished for and for how many materials it holds, medians, and every row."""

import math
from statistics import median
from typing import NamedTuple

from ..harness import summary
from ..report.markdown import table
from . import image_errors, judging, sphere
from .materials import FAMILIES, MICROFACET, NEURAL, TURNED

JUDGED_BY = {"samples_cube_root_rmse": "cube-root RMSE at the samples",
             "samples_cube_root_mae": "cube-root MAE at the samples",
             "clipped_cube_root_rmse": "cube-root RMSE at the samples, negative ones as 0",
             "clipped_cube_root_mae": "cube-root MAE at the samples, negative ones as 0",
             "between_cube_root_rmse": "cube-root RMSE between them",
             "between_cube_root_mae": "cube-root MAE between them", "mae": "MAE of the picture"}
WISHED = {"as wished, at the samples and in the picture": ("samples_cube_root_rmse", "samples_cube_root_mae", "mae"),
          "with negative samples as 0": ("clipped_cube_root_rmse", "clipped_cube_root_mae", "mae"),
          "and between them too": tuple(JUDGED_BY)[2:]}
LIMITS = {"Draft": 6 << 10, "Standard": 16 << 10}           # bytes a channel


class Wish(NamedTuple):
    """That a preset's error is at most `factor` times the least of the rivals'."""

    family: str
    own: str
    rivals: tuple[str, ...]
    factor: float


WISHES = (Wish("RGL", "Standard", (NEURAL, TURNED), 0.5), Wish("RGL", "Draft", (NEURAL, TURNED), 1.0),
          Wish("MERL", "Standard", (MICROFACET,), 0.5), Wish("MERL", "Standard", (MICROFACET,), 1.0),
          Wish("MERL", "Draft", (MICROFACET,), 1.0))
CAPTION = (f"Fits to all samples (of MERL's million, Paper to {judging.PAPER_SAMPLES:,} at random): RGL's nodes, "
           "and MERL's cells of files written from the published nets, which are the truth there and no rival. "
           "Errors at all samples; at these where negative ones count as 0 (clipped), as RGL's files have them "
           "and no preset follows them; and between them, at directions to 85 degrees of which a third is near "
           "the mirror direction and a sixth near the light's, against the file's own function or the net. MAE "
           "is the *mean* absolute difference here; cube root: of cosine-weighted values. Neural is the "
           "published network of 675 weights (Sztrajman et al. 2021), turned: with the two directions exchanged; "
           "Microfacet the published fit (Low et al. 2012); RGL table the file itself, whose samples are its "
           f"nodes; GGX our own fit to {judging.GGX_SAMPLES:,} samples to 85 degrees. Pictures: a sphere of "
           f"{sphere.SIZE} pixels under Preetham's clear sky (1999); PSNR (dB), MAE and FLIP of sRGB as shown; "
           f"Delta E ITP (BT.2124) with white at {image_errors.WHITE:.0f} cd/m^2. Seconds are of the processor; "
           "the first of the presets that share a preparation bears it.\n")


def ratios(records, wish, error):
    """The preset's error over the least of the rivals', by material; infinite where the preset failed."""
    found = {record["name"]: summary.ratio(record["models"], wish.own, wish.rivals, error)
             for record in records if record["family"] == wish.family}
    return {name: ratio for name, ratio in found.items() if not math.isnan(ratio)}


def wishes_text(records):
    """For how many materials each wish holds, and where it does not, with the ratios."""
    lines = []
    for name, limit in LIMITS.items():
        sizes = {record["name"]: record["models"][name]["bytes"] / record["channels"] for record in records
                 if record["models"].get(name, {}).get("bytes") is not None}
        if sizes:
            above = {key: size for key, size in sizes.items() if size > limit}
            lines.append(f"- {name} takes at most {limit:,} bytes a channel: {_holds(sizes, above, '{:,.0f}')}")
    for wish in WISHES:
        at_most = "no larger than" if wish.factor == 1 else f"at most {wish.factor:g} of"
        rival = "the better of the neural fit's" if len(wish.rivals) > 1 else "the microfacet fit's"
        kinds = {error: found for error in JUDGED_BY if (found := ratios(records, wish, error))}
        if not kinds:
            continue
        lines.append(f"- {wish.family}, error of {wish.own} {at_most} {rival} (in brackets: times that):")
        lines += [f"  - {JUDGED_BY[error]}: " + _holds(
            found, {name: ratio for name, ratio in found.items() if not ratio <= wish.factor}, "{:.2f}")
            for error, found in kinds.items()]
        for told, errors in WISHED.items():
            worst = {name: max(kinds[error][name] for error in errors) for name in kinds["mae"]}
            lines.append(f"  - **all of these, {told}**: " + _holds(
                worst, {name: ratio for name, ratio in worst.items() if not ratio <= wish.factor}, "{:.2f}"))
    return "\n".join(lines) + "\n"


def _holds(found, without, form):
    told = ", ".join(f"{name} ({form.format(without[name])})"
                     for name in sorted(without, key=without.get, reverse=True))
    return f"{len(found) - len(without)} of {len(found)}" + (f"; not for {told}" if told else "")


def medians(records):
    """Size against error: medians over the materials of a family, by model, the smallest first."""
    rows = []
    for family in FAMILIES:
        of_family = [record for record in records if record["family"] == family]
        names = list(dict.fromkeys(name for record in of_family for name in record["models"]))
        for name in sorted(names, key=lambda name: _median(of_family, name, "bytes") or 0):
            rows.append((family, name, round(_median(of_family, name, "bytes") or 0),
                         *(_told(_median(of_family, name, error)) for error in (*judging.ERRORS, *judging.RENDERED))))
    return table(("set", "model", "bytes", *_heads()), rows)


def all_rows(records):
    """Every model of every material."""
    return table(("set", "material", "model", "bytes", *_heads(), "fit [s]"), [
        (record["family"], record["name"], name, "failed" if row["bytes"] is None else row["bytes"],
         *(_told(row[error]) for error in (*judging.ERRORS, *judging.RENDERED)), round(row["seconds"], 1))
        for record in records for name, row in record["models"].items()])


def text(results, pictures=()):
    """All of it as Markdown, without a heading of its own."""
    records = results["materials"]
    return summary.page(results, pictures, wishes_text(records), CAPTION, tables=[
        ("Medians", medians(records)), ("All materials", all_rows(records))])


def outcome(results):
    """What matters most: every row, medians, and what holds."""
    records = results["materials"]
    return f"{all_rows(records)}\n{medians(records)}\n{wishes_text(records)}"


def _heads():
    return (*(f"{error}, {place}" for place in judging.PLACES for error in ("RMSE", "cube-root RMSE", "cube-root MAE")),
            "PSNR", "MAE", "FLIP", "Delta E ITP")


def _median(records, name, key):
    found = [record["models"][name][key] for record in records
             if name in record["models"] and record["models"][name][key] is not None]
    return median(found) if found else None


def _told(value):
    return "" if value is None else value
