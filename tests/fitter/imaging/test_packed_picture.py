"""Small pictures as text."""

import base64
import zlib

import numpy as np
import pytest

from fitter.imaging import packed_picture, pictures
from fitter.methods import prior


def test_a_sphere_comes_back_to_eight_bits():
    sphere = pictures.lit_sphere(prior.lambertian(np.array([[0.3, 0.2, 0.6]])), packed_picture.SIZE)
    text = packed_picture.pack(sphere)
    picture = packed_picture.unpack(text)
    np.testing.assert_allclose(picture[..., :3], np.clip(sphere[..., :3], 0, 1), atol=0.5 / 255 + 1e-6)
    np.testing.assert_allclose(picture[..., 3], sphere[..., 3], atol=1e-6)
    assert len(text) < 30_000


@pytest.mark.parametrize("text", ["", "no picture", "é", base64.b85encode(zlib.compress(b"short")).decode(),
                                  base64.b85encode(b"not compressed").decode()])
def test_anything_else_is_no_picture(text):
    assert packed_picture.unpack(text) is None
