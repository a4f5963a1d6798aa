"""Measured materials as assets: thumbnail, catalogue, description and tags, in the open file or in a library."""

import re
import uuid
from pathlib import Path

import bpy

from ..fitter import pictures
from ..fitter.files import replacing
from . import previews

CATALOGUE = "Measured BRDF"
_CATALOGUES = "blender_assets.cats.txt"
_NAMESPACE = uuid.UUID("6f0ae9a1-9d1b-4f5f-8f5e-6c0c7a3d2b10")      # one catalogue, one id: in every library
_HEADER = "# Asset catalogues of this folder: UUID:path:simple name\nVERSION 1\n"


def mark(material, picture=None):
    """Make a measured material an asset, with what can be said of it.

    Parameters
    ----------
    material : bpy.types.Material
    picture : (size, size, 4) float32, optional
        The thumbnail; without it Blender renders one.
    """
    settings = material.measured_brdf
    material.asset_mark()
    about = material.asset_data
    about.description = (f"{settings.name_of_data}: measured reflectance, fit {settings.fitted_levels}, "
                         f"{settings.coefficients:,} coefficients, RMSE {settings.rmse:.3g} / sr. "
                         f"Needs Cycles with OSL; EEVEE shows an approximation")
    about.catalog_id = str(catalogue_id())
    for tag in ("measured", "BRDF", settings.preset, Path(settings.filepath).stem):
        about.tags.new(tag, skip_if_exists=True)
    if picture is not None:
        previews.fill(material.preview_ensure(), picture)


def write(materials, path):
    """Write materials, marked as assets, into a .blend of their own, and its catalogue beside it."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.data.libraries.write(str(path), set(materials), fake_user=True, compress=True)
    write_catalogue(path.parent)


def write_catalogue(folder):
    """Add the catalogue to those of a folder, which are kept."""
    path = Path(folder) / _CATALOGUES
    text = path.read_text("utf-8") if path.is_file() else _HEADER
    if str(catalogue_id()) not in text:
        with replacing(path, "w") as stream:
            stream.write(f"{text.rstrip()}\n\n{catalogue_id()}:{CATALOGUE}:{CATALOGUE.replace('/', '-')}\n")


def catalogue_id():
    """The same in every library, so that a re-run or another machine makes no second one."""
    return uuid.uuid5(_NAMESPACE, CATALOGUE)


def file_name(name):
    """A name that every file system takes."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "material"


def thumbnail(fit):
    """The lit sphere, as a thumbnail."""
    return pictures.lit_sphere(fit)
