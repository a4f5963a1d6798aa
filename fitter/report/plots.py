"""The plots of the report. Needs matplotlib, an optional extra."""

import re

METRICS = ("rmse", "mae", "mre")
_FEATURED = ("felt", "leather", "aluminum foil", "Krylon Blue")


def draw(results, out):
    """Write the plots to a folder: their file names, none where matplotlib is not installed."""
    try:
        import matplotlib as mpl
    except ImportError:
        return []
    mpl.use("Agg")
    materials = {}
    for row in results["errors"]:
        materials.setdefault((row["material"], row["source"]), {})[row["method"]] = row
    featured = [key for key in materials if key[0] in _FEATURED] or list(materials)[:4]
    return [_draw_errors(key[0], materials[key], results["levels"], out / f"errors_{number}_{_plain(key[0])}.png")
            for number, key in enumerate(featured)]


def _draw_errors(name, methods, levels, path):
    """Errors against level, the baselines as lines across: the paper's Figure 1."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, len(METRICS), figsize=(12, 3.6), constrained_layout=True)
    for metric, axis in zip(METRICS, axes, strict=True):
        axis.semilogy(levels, [methods[f"level {level}"][metric] for level in levels], "o-", label="MBA")
        for row, style in ((methods["Koenderink 8"], "--"), (methods["Lafortune 3"], ":")):
            axis.axhline(row[metric], color="black", linestyle=style, label=row["method"])
        axis.set_xlabel("level")
        axis.set_title(metric.upper())
        axis.set_xticks(levels, [f"{level}\n{methods[f'level {level}']['coefficients']:,}" for level in levels],
                        fontsize=6)
    axes[0].legend()
    figure.suptitle(f"{name}: error against level and number of coefficients")
    figure.savefig(path, dpi=90)
    pyplot.close(figure)
    return path.name


def _plain(name):
    """A name as part of a file's name."""
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_") or "material"
