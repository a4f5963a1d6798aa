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
