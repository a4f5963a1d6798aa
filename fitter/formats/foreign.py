"""Files that users take for measurements of reflectance, or that hold some that cannot be read: what they are, and what
to do about it."""

import re
from pathlib import Path

from . import merl, utia

_MARK_BYTES = 4096          # bytes in which a mark is looked for
_AS_TABLE = "write its reflectance as a table with column names (see the manual, A table of your own)"


def _begins(mark: bytes, what: str, advice: str, anywhere: bool = False) -> tuple[re.Pattern[bytes], str, str]:
    """What begins like `mark` is `what`, and `advice` says what to do."""
    return re.compile((rb".*?" if anywhere else rb"\s*") + mark, re.DOTALL | re.IGNORECASE), what, advice


# in the order in which they are looked for
_FOREIGN_KINDS = (
    _begins(rb"\x89HDF\r\n\x1a\n", "an HDF5 file, as X-Rite's AxF and MATLAB's newer files are",
            "of AxF, the layout is not public: " + _AS_TABLE + " with the program that made it"),
    _begins(rb"OPTIS\b", "a surface file of Ansys Speos, of which the anisotropic BSDF is read (.anisotropicbsdf, as "
            "text)", "save it as one in Speos' BSDF viewer"),
    _begins(rb"TracePro\b", "a surface property of TracePro",
            "import the file that it was made from: TracePro takes Zemax's .bsdf and ASTM files, which are read here"),
    _begins(rb"(?:!!EDS\d|.*?!!BSDF Data)", "data of RPC Photonics (!!EDS, !!BSDF Data), which are not read",
            "take the same measurements as Zemax .bsdf, in which RPC Photonics has them too, or " + _AS_TABLE),
    _begins(rb"analytic\s", "a model of Disney's BRDF Explorer, a formula without measurements",
            "use the measurements that it was fitted to"),
    _begins(rb"(?:#[^\r\n]*[\r\n]+)*#[ \t]*(?:ALTA\b|ALTA_HEADER|DIM[ \t]+\d)", "data of the ALTA library",
            "write column names before its numbers, which its lines #PARAM_IN and #PARAM_OUT tell, or give them as the "
            "option columns of reading; of half-vector coordinates, convert it with ALTA's data2data first"),
    _begins(rb"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a workbook of an old Excel (.xls)", "save the sheet as CSV"),
    _begins(rb"<WindowElement|<Optical>|<WavelengthDataDirection", "a BSDF of Radiance and LBNL Window, in XML",
            "query it with Radiance's bsdfquery and " + _AS_TABLE, anywhere=True),
    _begins(rb"<!DOCTYPE html|<html|<head", "a web page", "the download failed, or has to be agreed to in a browser"),
    _begins(rb"<materialx", "a MaterialX document", "a model, not measurements", anywhere=True),
    _begins(rb"(?:<\?xml[^>]*>\s*)?(?:<!--.*?-->\s*)?<scene\b", "a scene of Mitsuba",
            "the measurements are in a file that it names"),
    _begins(rb"<\?xml", "an XML document", _AS_TABLE),
    _begins(rb"version https://git-lfs", "the pointer that Git LFS leaves for a file",
            "fetch the file itself with git lfs pull"),
    _begins(rb"IESNA", "the photometry of a lamp (IES)", "a lamp, not a surface"),
    _begins(rb"mdl \d", "source of NVIDIA's MDL", "the measurements are in an .mbsdf file beside it"),
    _begins(rb"%PDF-", "a PDF document", _AS_TABLE),
    _begins(rb"\{\s*\"", "a JSON document", _AS_TABLE),
    _begins(rb"\x89PNG\r\n|\xff\xd8\xff|II\*\0|MM\0\*|\x76\x2f\x31\x01|#\?RADIANCE|#\?RGBE|BM.{4}\0\0\0\0|8BPS",
            "a picture", "pictures say nothing of directions"),
    _begins(rb"BLENDER|\x28\xb5\x2f\xfd", "a .blend file, or another compressed with Zstandard",
            "append materials with File > Append"),
    _begins(rb"PK\x03\x04.{0,2000}(?:xl/|\[Content_Types\]\.xml)", "a workbook of Excel", "save the sheet as CSV"),
    _begins(rb"PK\x03\x04.{0,200}\.npy", "a fit that this extension saved, or other arrays of NumPy",
            "python -m fitter info FILE describes a fit"),
    _begins(rb"PK\x03\x04|\x1f\x8b|7z\xbc\xaf|Rar!|BZh|\xfd7zXZ", "an archive", "unpack it first"),
)
_BY_NAME = {
    ".jdv": ("a .jdv file, as Light Tec's REFLET goniophotometers write, whose layout is not public",
             "export it as ASTM or as Zemax .bsdf with the program that came with the instrument"),
    ".ltb": ("a file of LightTools", "export it as Zemax .bsdf")}


def describe_by_name(path: str | Path) -> str | None:
    """What a file is by its extension, where its content tells nothing; None if that is not known."""
    known = _BY_NAME.get(Path(path).suffix.lower())
    return None if known is None else "; ".join(known)


def describe(content: bytes) -> str | None:
    """What a file in no known format is, and what to do, as a part of a message; None if that is not known."""
    beginning = content[:_MARK_BYTES].removeprefix(b"\xef\xbb\xbf")
    if beginning.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        return "text in UTF-32; save it as UTF-8"
    for mark, what, advice in _FOREIGN_KINDS:
        if mark.match(beginning):
            return f"{what}; {advice}"
    if len(content) == utia.SIZE and b"\0" in content:
        return ("as large as the measurements of UTIA, but its numbers are no reflectances; expected finite float64, "
                "few of them negative")
    return merl.other_layout(content)
