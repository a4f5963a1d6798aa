import numpy as np
import pytest

from support import ball_files
from support.cases import release


@release
def test_a_ball_is_photographed_measured_and_rendered(extension, tmp_path):
    import bpy

    from demo_scenes import ball

    ball.draw(tmp_path / "ball.png", 112, "Draft")
    picture = bpy.data.images.load(str(tmp_path / "ball.png"))
    assert tuple(picture.size) == (4 * 112 + 3 * 4, 2 * (112 + 28) + 4)
    assert {path.suffix for path in (tmp_path / "ball").iterdir()} == {".exr", ".toml", ".npz"}


@release
def test_a_card_is_photographed_measured_and_rendered(extension, tmp_path):
    import bpy

    from demo_scenes import card

    card.draw(tmp_path / "card.png", 64, 2)
    picture = bpy.data.images.load(str(tmp_path / "card.png"))
    assert tuple(picture.size) == (5 * 64 + 4 * 4, 2 * (64 + 28) + 4)


def test_a_carving_in_real_photographs_is_closer_to_those_left_out_than_their_mean_is(extension):
    """The mean of them, scaled to each, knows how bright it is."""
    from demo_scenes import carving

    if not carving.LION.is_file():
        pytest.skip(f"{carving.LION} is absent")
    ball_files.add_openimageio()
    pairs = carving.measured()
    mean = np.mean([photograph for photograph, _ in pairs], axis=0)
    for photograph, shown in pairs:
        scaled = mean * (mean * photograph).sum() / (mean ** 2).sum()
        assert ((shown - photograph) ** 2).sum() < 0.8 * ((scaled - photograph) ** 2).sum()
