"""Measured materials as assets: thumbnail, catalogue, description and tags."""

import re
import uuid
from contextlib import contextmanager
from pathlib import Path

from ...fitter import pictures
from ...fitter.files import locked, replacing
from ..jobs import icons

CATALOGUE = "Measured BRDF"
_CATALOGUES = "blender_assets.cats.txt"
_NAMESPACE = uuid.UUID("6f0ae9a1-9d1b-4f5f-8f5e-6c0c7a3d2b10")      # one catalogue, one id: in every library
_HEADER = "# Asset catalogues of this folder: UUID:path:simple name\nVERSION 1\n"
_BY_HAND = ("catalog_id", "author", "copyright", "license")         # what users say of an asset


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
    about.description = describe(settings)
    about.catalog_id = str(catalogue_id())
    for tag in ("measured", "BRDF", settings.preset, Path(settings.filepath).stem):
        about.tags.new(tag, skip_if_exists=True)
    if picture is not None:
        icons.fill(material.preview_ensure(), picture)


def describe(settings):
    """What the description of an asset says by default."""
    return (f"{settings.name_of_data}: measured reflectance, fit {settings.fitted_levels}, "
            f"{settings.coefficients:,} coefficients, RMSE {settings.rmse:.3g} / sr. "
            f"Needs Cycles with OSL; EEVEE shows an approximation")


@contextmanager
def unmarked_on_error(material):
    """Let a material be no asset again if the block raises and it was none before."""
    was_asset, was_kept = material.asset_data is not None, material.use_fake_user
    try:
        yield
    except BaseException:
        if not was_asset:
            material.asset_clear()
            material.use_fake_user = was_kept
        raise


def remember(material):
    """What `renew` must know of an asset before its material is fitted again; None for what is no asset."""
    if material.asset_data is None:
        return None
    settings = material.measured_brdf
    return settings.preset, material.asset_data.description == describe(settings)


def renew(material, remembered, picture=None):
    """Bring an asset up to date after its material was fitted again, or make one. What users changed of it stays."""
    if remembered is None:
        mark(material, picture)
        return
    preset, is_described = remembered
    about, settings = material.asset_data, material.measured_brdf
    if is_described:
        about.description = describe(settings)
    tag = about.tags.get(preset)
    if tag is not None:
        about.tags.remove(tag)
        about.tags.new(settings.preset, skip_if_exists=True)
    if picture is not None:
        icons.fill(material.preview_ensure(), picture)


def inherit(material, old):
    """Give an asset what users said of the one that it replaces."""
    about, before = material.asset_data, old.asset_data
    if about is None or before is None:
        return
    for name in _BY_HAND:
        setattr(about, name, getattr(before, name))
    if before.description != describe(old.measured_brdf):
        about.description = before.description
    for tag in before.tags:
        if tag.name != old.measured_brdf.preset:
            about.tags.new(tag.name, skip_if_exists=True)


def write_catalogue(folder):
    """Add the catalogue to those of a folder, which are kept."""
    path = Path(folder) / _CATALOGUES
    with locked(path, wait=True):
        text = path.read_bytes() if path.is_file() else b""        # as it is, in whatever encoding
        line = f"{catalogue_id()}:{CATALOGUE}:{CATALOGUE.replace('/', '-')}\n".encode()
        if str(catalogue_id()).encode() not in text:
            header = b"" if b"VERSION" in text else _HEADER.encode()
            with replacing(path) as stream:
                stream.write(header + text.rstrip() + b"\n\n" + line)


def catalogue_id():
    """The same in every library, so that a re-run or another machine makes no second one."""
    return uuid.uuid5(_NAMESPACE, CATALOGUE)


def file_name(name):
    """A name that every file system takes."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "material"


def thumbnail(fit):
    """The lit sphere, as a thumbnail."""
    return pictures.lit_sphere(fit)
