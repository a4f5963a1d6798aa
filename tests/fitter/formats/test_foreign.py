"""Files that users drop and that cannot be read are named in the message, and none that can be read is refused."""

import gzip
import io
import zipfile

import numpy as np
import pytest

from fitter import DatasetError
from support import hostile_fits, zemax_files

FILE = "dropped.bsdf"


def zipped(**members):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as file:
        for name, content in members.items():
            file.writestr(name.replace("__", "/").replace("_dot_", "."), content)
    return stream.getvalue()


def png():
    from matplotlib import image

    stream = io.BytesIO()
    image.imsave(stream, np.zeros((2, 2, 3)), format="png")
    return stream.getvalue()


@pytest.mark.parametrize(("content", "expected"), [
    (b"\x89HDF\r\n\x1a\n" + bytes(200), "HDF5"), (b"OPTIS - brdf surface file v8.0\n0 1\n", "Speos"),
    (b"TracePro Surface Property Data\nFile Name\tmine\n", "TracePro.*Zemax"),
    (b"!!EDS10\n1 2 3\n0.1 0.2 0.3\n", "RPC Photonics.*which are not read; .*Zemax"),
    (b"EDC-20\r\n!!BSDF Data\r\n0 0.1\r\n5 0.2\r\n", "RPC Photonics"),
    (b"analytic\n::begin parameters\nfloat n 1 1000 100\n", "Disney.*a formula"),
    (b"#DIM 2 1\n#PARAM_IN ISOTROPIC_TV_TL_DPHI\n#PARAM_OUT INV_STERADIAN\n0.1 0.2 0.3\n", "ALTA.*column names"),
    (b"#ALTA HEADER BEGIN\n#DIM 2 1\n0.1 0.2 0.3\n", "ALTA"),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600), r"\.xls.*as CSV"),
    (zemax_files.made().replace("DataBegin\nTIS", "DataBegin\nAOI 10\nPOI 0\nSide Front\nTIS").encode(),
     "LightTools.*Zemax"),
    (b'<?xml version="1.0"?>\n<WindowElement xmlns="http://windows.lbl.gov">', "Radiance"),
    (b"\n<!DOCTYPE html>\n<html><body>Log in</body></html>", "a web page"),
    (b'<?xml version="1.0"?>\n<materialx version="1.38">', "MaterialX"),
    (b'<?xml version="1.0"?>\n<scene version="3.0.0">', "Mitsuba"), (b"<?xml version='1.0'?><a/>", "XML"),
    (b"version https://git-lfs.github.com/spec/v1\noid sha256:1\n", "Git LFS"), (b"IESNA:LM-63-2002\n", "lamp"),
    (b"mdl 1.7;\nimport df::*;\n", "MDL"), (b"%PDF-1.7\n%\xe2\xe3", "PDF"),
    (b'{\n  "asset": {"version": "2.0"}}', "JSON"),
    (png(), "a picture"), (b"\x76\x2f\x31\x01\x02\0\0\0", "a picture"),
    (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "picture"),
    (b"BLENDER-v420RENDH\0\0", r"\.blend"),
    (zipped(**{"_Content_Types__dot_": "", "xl__workbook_dot_xml": "<x/>"}), "Excel"),
    (hostile_fits.in_order(), "a fit that this extension saved"), (zipped(readme="x"), "an archive"),
    (gzip.compress(b"theta_i,theta_o,phi,BRDF\n", mtime=0), "an archive"), (bytes(3 * 288 * 288 * 8), "UTIA"),
    ("theta_i,theta_o,phi,BRDF\n".encode("utf-32"), "UTF-32"),
    (b"\0\0\xfe\xff" + "theta_i,theta_o,phi,BRDF\n".encode("utf-32-be"), "UTF-32"),
    (b"theta_i,theta_o,phi,BTDF\n30,30,0,1\n", "'BTDF' found.*transmitted light")])
def test_a_foreign_file_is_named(load, content, expected):
    with pytest.raises(DatasetError, match=rf"dropped\.bsdf:(\d+:)? .*{expected}") as refused:
        load(content)
    assert "in no known format" not in str(refused.value)


@pytest.mark.parametrize("content", [b"\x01\x02\0\x03" * 40, b"a scan of paper\nand its words\n"])
def test_a_file_whose_content_tells_nothing_is_named_by_its_extension(load, content):
    with pytest.raises(DatasetError, match=r"paper\.JDV: .*REFLET.*export it as ASTM"):
        load(content, "paper.JDV")


def test_what_is_really_unknown_is_said_to_be(load):
    with pytest.raises(DatasetError, match="in no known format; expected one of"):
        load("Dear diary,\ntoday I measured nothing.\n", "dropped.txt")
