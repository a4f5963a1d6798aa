"""Measured materials as assets: thumbnail, catalogue, description and tags."""

import re
import uuid
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy

from ....fitter.arrays import SingleArray
from ....fitter.errors import DatasetError, printable
from ....fitter.model.published import find, parse_virtual_path
from ....fitter.storage.files import hold_lock, replace_file
from ..annotations import not_none
from ..blender import previews

CATALOGUE = "Measured BRDF"
_CATALOGUES = "blender_assets.cats.txt"
_NAMESPACE = uuid.UUID("6f0ae9a1-9d1b-4f5f-8f5e-6c0c7a3d2b10")      # gives the catalogue the same id in every library
_CATALOGUE_HEADER = "# Asset catalogues of this folder: UUID:path:simple name\nVERSION 1\n"
_SET_BY_USERS = ("catalog_id", "author", "copyright", "license")


def mark(material: bpy.types.Material, picture: SingleArray | None = None) -> None:
    """Make a material an asset, with description, tags, and a thumbnail, (size, size, 4) float32, or Blender's."""
    settings = material.measured_brdf
    material.asset_mark()
    data = not_none(material.asset_data)
    data.description = describe(settings)
    data.catalog_id = str(catalogue_id())
    published = parse_virtual_path(settings.filepath)
    for tag in ("mix", "BRDF") if not settings.coefficients else (
            "measured", "BRDF", settings.preset, printable(Path(settings.filepath).stem)) if published is None else (
            "published fit", "BRDF", settings.preset, published):
        data.tags.new(tag, skip_if_exists=True)
    if picture is not None:
        previews.fill(not_none(material.preview_ensure()), picture)


def describe(settings: Any) -> str:
    if not settings.coefficients:
        return f"{settings.id_data.name}: a mix of measured reflectance"
    published = parse_virtual_path(settings.filepath)
    what = "measured reflectance"
    if published is not None:
        try:
            what = find(published).description
        except DatasetError:            # the name of another version
            what = "not a measurement"
    return (f"{settings.name_of_data}: {what}, fit {settings.fitted_levels}, "
            f"{settings.coefficients:,} coefficients, RMSE {settings.rmse:.3g} / sr. "
            f"Needs Cycles with OSL; EEVEE shows an approximation")


@contextmanager
def unmarked_on_error(material: bpy.types.Material) -> Iterator[None]:
    """If the block raises, unmark a material that was no asset before."""
    was_asset, was_kept = material.asset_data is not None, material.use_fake_user
    try:
        yield
    except BaseException:
        if not was_asset:
            material.asset_clear()
            material.use_fake_user = was_kept
        raise


def remember(material: bpy.types.Material) -> tuple[str, bool] | None:
    """Of an asset, what `renew` is to know: its preset, and whether users left the description as it was."""
    if material.asset_data is None:
        return None
    settings = material.measured_brdf
    return settings.preset, material.asset_data.description == describe(settings)


def renew(material: bpy.types.Material, remembered: tuple[str, bool] | None,
          picture: SingleArray | None = None) -> None:
    """Update an asset after its material was fitted again, or make one. Changes by users stay."""
    if remembered is None:
        mark(material, picture)
        return
    data, settings, (preset, is_default) = not_none(material.asset_data), material.measured_brdf, remembered
    if is_default:
        data.description = describe(settings)
    tag = data.tags.get(preset)
    if tag is not None:
        data.tags.remove(tag)
        data.tags.new(settings.preset, skip_if_exists=True)
    if picture is not None:
        previews.fill(not_none(material.preview_ensure()), picture)


def inherit(material: bpy.types.Material, old: bpy.types.Material) -> None:
    """Copy to an asset what users have set on the one that it replaces."""
    data, before = material.asset_data, old.asset_data
    if data is None or before is None:
        return
    for name in _SET_BY_USERS:
        setattr(data, name, getattr(before, name))
    if before.description != describe(old.measured_brdf):
        data.description = before.description
    for tag in before.tags:
        if tag.name != old.measured_brdf.preset:
            data.tags.new(tag.name, skip_if_exists=True)


def write_catalogue(folder: Path, names: Sequence[str] = (CATALOGUE,)) -> None:
    """Add catalogues to a folder's file of catalogues; the others stay."""
    path = Path(folder) / _CATALOGUES
    with hold_lock(path, wait=True):
        text = path.read_bytes() if path.is_file() else b""        # undecoded: its encoding is unknown
        lines = [f"{catalogue_id(name)}:{name}:{name.replace('/', '-')}\n" for name in names
                 if text.find(str(catalogue_id(name)).encode()) < 0]
        if lines:
            header = b"" if text.find(b"VERSION") >= 0 else _CATALOGUE_HEADER.encode()
            with replace_file(path) as stream:
                stream.write(header + text.rstrip() + b"\n\n" + "".join(lines).encode())


def catalogue_id(name: str = CATALOGUE) -> uuid.UUID:
    """The same in every library, so that further runs and other machines do not add a second catalogue."""
    return uuid.uuid5(_NAMESPACE, name)


def file_name(name: str) -> str:
    """A name that every file system accepts."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "material"
