"""Photographs of a flat sample from files, by a description in TOML."""

import tomllib

import numpy as np
import pytest

import fitter
from fitter.photographs.description.capture_setup import CaptureSetup, Shot
from fitter.photographs.description.parsing import parse, read
from fitter.photographs.flat.maps import coarse, texel_points
from fitter.photographs.flat.photograph import find_pixels, observe
from fitter.photographs.flat.reading import order_corners, read_sample
from fitter.photographs.pictures import Pictures
from fitter.photographs.rig import camera
from support import ball_files, flat_files, flat_scene, wrong_values

LAMPS = flat_scene.lamps(5)
NAMES = [f"lamp{number}.exr" for number in range(1, 6)]
PLACES = flat_files.corners()


def flat(path):
    return read_sample(read(path))


def lambertian(samples, albedo=0.3):
    return fitter.fit(fitter.Samples(*samples.directions, np.full_like(samples.values, albedo / np.pi),
                                     samples.channels), **fitter.PRESETS["Draft"])


@pytest.fixture(scope="module")
def paper(glossy):
    return flat_scene.Sample((lambertian(glossy),), lambda u, v: np.ones((len(u), 1)),
                             lambda u, v: np.zeros((len(u), 2)))


@pytest.fixture(scope="module")
def written(openimageio, paper, tmp_path_factory):
    return flat_files.write(tmp_path_factory.mktemp("flat"), paper, LAMPS, noise=0)


@pytest.fixture
def described(written):
    """Write a description beside the photographs: its path."""
    def write(**how):
        path = written.with_name("other.toml")
        path.write_text(flat_files.description(NAMES, LAMPS, **how), "utf-8")
        return path
    return write


def angle(a, b):
    """Degrees between unit vectors (..., 3)."""
    return np.degrees(np.arccos(np.clip((a * b).sum(axis=-1), -1, 1)))


def seen(shot):
    """Where a photograph shows the sample's corners: (4, 2), pixels from the left and the top."""
    return find_pixels(shot.rays, flat_scene.corners() - shot.camera)[:, ::-1] + 0.5


def test_the_camera_stands_where_the_corners_say(written):
    found = flat(written)
    assert (found.name, found.shape, found.materials) == ("flat sample (synthetic)", (63, 79), ())
    np.testing.assert_allclose(found.corners, flat_scene.corners())
    shot = found.photographs[2]
    assert np.linalg.norm(shot.camera - flat_scene.CAMERA) < 1e-3
    assert angle(shot.rays, flat_scene.rays(flat_files.SIZE)).max() < 0.1
    np.testing.assert_allclose(shot.lamp, LAMPS[2], atol=1e-6)
    np.testing.assert_allclose(shot.intensity, flat_scene.INTENSITY)
    assert shot.name == "lamp3.exr"


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 1, 3]])
def test_corners_that_are_drawn_stand_for_those_of_the_description(order):
    """As shares of the longer side of 100 pixels, of 90 x 100, from the middle to the right and upward."""
    drawn = (PLACES - [50, 45]) * [0.01, -0.01]
    np.testing.assert_allclose(order_corners(drawn[order], flat_files.SIZE), PLACES, atol=1e-9)


def test_the_dark_beside_the_sample_is_not_in_its_edge(written):
    """Of photographs that see the edge within a pixel, and texels as small as pixels."""
    found = flat(written)
    texels = observe(found.photographs, texel_points(found.corners, found.shape), np.array([0.0, 0, 1]))
    albedo = np.pi * texels.radiance / texels.lit.brought / texels.lit.light[..., 2:]
    assert texels.good.all()
    assert albedo.min() > 0.28
    assert albedo.max() < 0.32


@pytest.mark.parametrize("camera", ["", "position = [0.035, -0.125, 0.49]\n"])
def test_corners_half_a_pixel_off_put_the_sample_less_than_a_pixel_off(described, camera):
    places = PLACES + np.random.default_rng(3).uniform(-0.5, 0.5, (4, 2))
    found = flat(described(camera=f"{camera}field_of_view = {flat_files.ANGLE}",
                           sample=f"width = 0.1\nheight = 0.08\ncorners = {places.tolist()}"))
    assert np.linalg.norm(seen(found.photographs[0]) - PLACES, axis=1).max() < 0.8
    if camera:
        assert np.linalg.norm(found.photographs[0].camera - flat_scene.CAMERA) < 0.015


def test_light_positions_of_a_camera_far_away_turn_with_the_sample(written, described):
    """The sample's x runs upward in the picture: its lamps are where x of the picture is -y of the sample."""
    written.with_name("dome.lp").write_text("5\n" + "".join(f"{name} 0.6 {y} 0.8\n" for name, y in zip(
        NAMES, (0, 0.1, 0.2, -0.1, -0.2), strict=True)), "utf-8")
    path = described(camera="position = 'far'", shots=["exposures = [1]"] * 5,
                     sample="width = 0.1\nheight = 0.08\ncorners = [[74, 80], [74, 20], [26, 20], [26, 80]]")
    path.write_text(path.read_text("utf-8") + "[lamp]\npositions = 'dome.lp'\n", "utf-8")
    found = flat(path)
    shot = found.photographs[1]
    np.testing.assert_allclose(seen(shot), [[74, 80], [74, 20], [26, 20], [26, 80]], atol=0.05)
    assert angle(shot.lamp / np.linalg.norm(shot.lamp), np.array([0.1, -0.6, 0.8]) / np.sqrt(1.01)) < 1
    # the irradiance is what was given
    np.testing.assert_allclose(shot.intensity / (shot.lamp @ shot.lamp), flat_scene.INTENSITY)


def test_the_scale_is_a_guess_or_by_a_card(described):
    guessed = flat(described(scale="albedo = 0.3"))
    np.testing.assert_allclose(guessed.photographs[0].intensity, 1.5, rtol=0.01)
    assert any(note.startswith("The scale is a guess") for note in guessed.notes)
    lamp = LAMPS[0].tolist()
    carded = flat(described(scale=f"card = {{file = 'lamp1.exr', albedo = 0.3, lamp = {lamp}, "
                                  f"region = [30, 30, 36, 36]}}"))
    np.testing.assert_allclose(carded.photographs[0].intensity, flat_scene.INTENSITY, rtol=0.01)


def with_corners(places, size="width = 0.1\nheight = 0.08"):
    return {"sample": f"{size}\ncorners = {np.asarray(places).tolist()}"}


@pytest.mark.parametrize(("how", "message"), [
    (with_corners(PLACES + [60, 0]), "sample.corners .*not whole in them"),
    (with_corners(PLACES[[0, 2, 1, 3]]), "sample.corners .*crossed"),
    (with_corners(PLACES[::-1]), "sample.corners .*counter-clockwise: bottom left"),
    (with_corners(PLACES[:3]), "sample.corners .*expected four places"),
    ({"sample": "width = 0.1\nheight = 0.08\ncorners = [[1, 80], [90, 80], [90, 5], [1, 5], 7]"},
     "sample.corners is .*expected four places"),
    ({"camera": f"field_of_view = {flat_files.ANGLE}\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1], 2]"},
     "camera.matrix is .*expected three rows of three numbers"),
    (with_corners(PLACES, "width = 0.1\nheight = 0.03"), "a rectangle of 0.1 x 0.03 m that this lens sees"),
    ({"camera": "encoding = 'linear'"}, "camera.field_of_view is missing"),
    ({"camera": "position = [0, 0, -1]\nfield_of_view = 14"}, "camera.position .*one above the sample"),
    ({"scale": "ball = {file = 'lamp1.exr', albedo = 0.9, lamp = [0, 0, 1]}"}, "scale.ball is not known"),
    ({"shots": ["lamp = [0, 0, 1]"] * 4 + ["lamp = [0.1, 0, -1]"]}, "lamp5.exr: the lamp is behind the sample"),
    ({"shots": ["lamp = [0, 0, 1]"] * 4 + ["direction = [0.1, 0, 1]"]}, "some lamps have a place"),
    ({"top": "texels = 1000000"}, "texels .*expected 1 to 4096"),
    ({"top": "materials = 30"}, "materials is 30"),
])
def test_what_cannot_be_is_refused(described, how, message):
    path = described(**how)
    with pytest.raises(fitter.DatasetError, match=message) as error:
        flat(path)
    assert path.name in str(error.value) or "lamp5" in str(error.value)


def test_no_value_of_a_wrong_kind_is_more_than_an_error_of_its_key(written):
    given = tomllib.loads(written.read_text("utf-8"))
    given |= {"materials": ["gold.npz"], "texels": 10, "scale": {"card": {
        "file": "lamp1.exr", "exposures": [1], "albedo": 0.18, "lamp": LAMPS[0].tolist(), "normal": [0, 0, 1],
        "region": [40, 40, 50, 50]}}}
    given["photograph"] = [{**each, "exposures": [1]} for each in given["photograph"][:2]]
    given["camera"] |= {"matrix": np.eye(3).tolist(), "encoding": "linear", "position": flat_scene.CAMERA.tolist()}

    said = wrong_values.refusals(lambda described: read_sample(parse(described, written)), given)
    assert len(said) > 200
    assert all(str(written.parent) in text for _, text in said), said


def test_photographs_of_several_sizes_and_a_dark_sample_are_refused(described):
    path = described(scale="albedo = 0.5")
    beside = np.zeros((90, 100, 3))
    beside[:3] = 1
    for here, picture, message in ((["lamp4.exr"], np.ones((9, 9, 3)), "photographs of several sizes"),
                                   (["lamp4.exr"], 0 * beside, r"lamp4\.exr: a black photograph"),
                                   (NAMES, beside, "no sample is in the picture")):
        kept = {each: path.with_name(each).read_bytes() for each in here}
        for each in here:
            ball_files.write_picture(path.with_name(each), picture)
        with pytest.raises(fitter.DatasetError, match=message):
            flat(path)
        for each, content in kept.items():
            path.with_name(each).write_bytes(content)


def test_directions_hold_where_the_ball_stood(described):
    """Lamps of a dome of .7 m, whose directions a ball .2 m beside the sample has shown."""
    ball = np.array([0.2, 0.05, 0.01])
    lamps = LAMPS / np.linalg.norm(LAMPS, axis=1, keepdims=True) * 0.7
    toward = (lamps - ball) / np.linalg.norm(lamps - ball, axis=1, keepdims=True)
    path = described(shots=[f"direction = {each.tolist()}\ndistance = 0.7" for each in toward])
    text = path.read_text("utf-8")
    path.write_text(f"{text}[lamp]\nball = {ball.tolist()}\ndistance = 0.7\n", "utf-8")
    found = flat(path)
    np.testing.assert_allclose([each.lamp for each in found.photographs], lamps, atol=1e-9)
    path.write_text(f"{text}[lamp]\nball = [0.8, 0, 0]\ndistance = 0.7\n", "utf-8")
    with pytest.raises(fitter.DatasetError, match=r"lamp.ball is .*nearer to the sample's middle than the lamps"):
        flat(path)


def even(lamp, size, ball, radius):
    """A Lambertian plane under a lamp, in a picture of this height and width, with a chrome ball: it shines where it
    mirrors to within 6 degrees of the lamp."""
    toward = flat_scene.rays(size)
    place = flat_scene.CAMERA - toward * (flat_scene.CAMERA[2] / toward[..., 2:])
    away = lamp - place
    far = np.linalg.norm(away, axis=2, keepdims=True)
    picture = 0.2 * away[..., 2:] / far ** 3 * np.ones(3)
    picture[(np.abs(place[..., :2]) > np.array([0.05, 0.04])).any(axis=2)] = 0.01
    back = flat_scene.CAMERA - ball
    half = (toward * back).sum(axis=2)
    root = half ** 2 - back @ back + radius ** 2
    hit = root > 0
    point = flat_scene.CAMERA + toward * (-half - np.sqrt(np.maximum(root, 0)))[..., None]
    normal = (point - ball) / radius
    mirrored = toward - 2 * (toward * normal).sum(axis=2, keepdims=True) * normal
    to_lamp = (lamp - point) / np.linalg.norm(lamp - point, axis=2, keepdims=True)
    shines = hit & ((mirrored * to_lamp).sum(axis=2) > np.cos(np.radians(6)))
    picture[hit] = 0.02
    picture[shines] = 20.0
    return picture, hit


@pytest.mark.parametrize("by", ["mask = 'ball.png'", "centre = [0.056, 0.005, 0.005]\nradius = 0.005"])
def test_a_chrome_ball_in_the_photographs_says_where_the_lamps_are(openimageio, tmp_path, by):
    """In one of the photographs it is in a shadow, and the first says itself how far its lamp is."""
    size, ball = (540, 600), np.array([0.056, 0.005, 0.005])
    for number, (name, lamp) in enumerate(zip(NAMES, LAMPS, strict=True)):
        picture, hit = even(lamp, size, ball, 0.005)
        picture[hit] *= number != 3
        ball_files.write_picture(tmp_path / name, picture)
    ball_files.write_picture(tmp_path / "ball.png", hit[..., None].astype(float))
    distance = np.linalg.norm(LAMPS[0])
    path = tmp_path / "setup.toml"
    text = flat_files.description(NAMES, LAMPS, size=size, top="texels = 60", shots=[
        f"exposures = [1]\ndistance = {1.02 * distance}", *["exposures = [1]"] * 4])
    path.write_text(f"{text}[chrome]\n{by}\n[lamp]\ndistance = {distance}\n", "utf-8")
    found = flat(path)
    assert [each.name for each in found.photographs] == [NAMES[k] for k in (0, 1, 2, 4)]
    assert "Left out, for the chrome ball shows no lamp there: lamp4.exr" in found.notes
    places = np.array([each.lamp for each in found.photographs])
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), distance * np.array([1.02, 1, 1, 1]))
    wanted = LAMPS[[0, 1, 2, 4]] / np.linalg.norm(LAMPS[[0, 1, 2, 4]], axis=1, keepdims=True)
    toward = places / np.linalg.norm(places, axis=1, keepdims=True)
    print(angle(toward, wanted))
    assert angle(toward, wanted).max() < 2.5       # a pixel is 5


def test_what_a_mask_leaves_out_is_unknown(written, described):
    """The left half of the pictures is white in the mask."""
    mask = np.zeros((*flat_files.SIZE, 1))
    mask[:, :50] = 1
    ball_files.write_picture(written.with_name("mask.png"), mask)
    found = flat(described(sample=f"width = 0.1\nheight = 0.08\ncorners = {PLACES.tolist()}\nmask = 'mask.png'"))
    seen = observe(found.photographs, texel_points(found.corners, found.shape), np.array([0.0, 0, 1]))
    column = find_pixels(found.photographs[0].rays, texel_points(found.corners, found.shape)
                         - found.photographs[0].camera)[:, 1]
    assert seen.good[column < 48].all()      # at its rim a pixel may be seen in a neighbour
    assert not seen.good[column > 50].any()
    ball_files.write_picture(written.with_name("mask.png"), mask[:9, :9])
    with pytest.raises(fitter.DatasetError, match=r"mask.png: 9 x 9 pixels found, expected 100 x 90"):
        flat(written.with_name("other.toml"))


def test_what_is_beside_an_outline_is_unknown(described):
    """Of a triangle, whose centre of area is inside, and one that is around no pixel."""
    rows = f"width = 0.1\nheight = 0.08\ncorners = {PLACES.tolist()}\noutline = "
    found = flat(described(sample=rows + "[[0, 0], [100, 0], [50, 90]]"))
    seen = observe(found.photographs, texel_points(found.corners, found.shape), np.array([0.0, 0, 1]))
    y, x = (find_pixels(found.photographs[0].rays, texel_points(found.corners, found.shape)
                        - found.photographs[0].camera) + 0.5).T
    off = np.minimum(90 * x - 50 * y, 90 * (100 - x) - 50 * y) / np.hypot(90, 50)       # pixels within the sides
    assert seen.good[off > 2.5].all()       # at the sample's edge what is seen is that of 3 pixels within
    assert not seen.good[off < -2].any()
    with pytest.raises(fitter.DatasetError, match=r"sample.outline is .*around pixels of pictures of 100 x 90"):
        flat(described(sample=rows + "[[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]]"))


def grainy(folder, size, sample, random, grain=0.3, texels=64):
    """The description of photographs of an even surface, of which a sample as wide and high as this fills all."""
    height, width = size
    for name in NAMES:
        ball_files.write_picture(folder / name, 0.2 * (1 + grain * random.standard_normal((height, width, 1))))
    path = folder / "setup.toml"
    path.write_text(flat_files.description(
        NAMES, LAMPS, top=f"texels = {texels}", camera="position = 'far'", sample="width = {}\nheight = {}\n"
        "corners = {}".format(*sample, [[0, height], [width, height], [width, 0], [0, 0]]), scale="intensity = 1"))
    return path


@pytest.mark.parametrize("is_read", [True, False])
def test_a_texel_is_the_mean_of_its_pixels(openimageio, random, tmp_path, is_read):
    """30 % of grain in 100 pixels leaves 3 %. Dust, which is saturated, is not in the mean."""
    found = flat(grainy(tmp_path, (430, 640), (0.064, 0.043), random))
    shots = found.photographs
    if not is_read:
        rays = camera.rays(430, 640, np.radians(1))
        shots = coarse([fitter.FlatPhotograph(0.2 + 0.06 * random.standard_normal((430, 640, 1)), rays, shots[0].camera,
                                              lamp, np.ones(1)) for lamp in LAMPS], found.corners, found.shape)
    seen = observe(shots, texel_points(found.corners, found.shape), np.array([0.0, 0, 1]))
    assert seen.good.all()
    print(seen.radiance.std() / 0.2)
    assert 0.02 < seen.radiance.std() / 0.2 < 0.033
    assert abs(seen.radiance.mean() / 0.2 - 1) < 0.002
    assert max(each.radiance.size for each in shots) <= 64 * 43


def test_no_pixels_of_what_was_read_are_kept(written):
    """Nor by a view of none of them, which kept all in memory."""
    pictures = Pictures(CaptureSetup())
    pictures.light(Shot(files=(written.with_name("lamp1.exr"),)), "files")
    said, = pictures.said.values()
    assert said.stored.size == 0
    assert said.stored.base is None


def test_the_means_of_texels_are_in_their_places(openimageio, random, tmp_path):
    """A picture that grows to the right and downward: its texels grow along rows, and fall from row to row."""
    path = grainy(tmp_path, (430, 640), (0.064, 0.043), random, grain=0.0)
    y, x = np.mgrid[:430, :640] + 0.5
    for name in NAMES:
        ball_files.write_picture(tmp_path / name, 0.1 + 2e-4 * x[..., None] + 1e-3 * y[..., None])
    found = flat(path)
    seen = observe(found.photographs, texel_points(found.corners, found.shape), np.array([0.0, 0, 1]))
    v, u = np.mgrid[:43, :64] + 0.5
    expected = 0.1 + 2e-4 * 10 * u + 1e-3 * (430 - 10 * v)
    inner = np.s_[1:-1, 1:-1]       # at the edge what is within 1.5 pixels of it does not count
    np.testing.assert_allclose(seen.radiance[:, 0, 0].reshape(43, 64)[inner], expected[inner], rtol=1e-3)


def test_saturated_pixels_are_not_in_the_mean(openimageio, random, tmp_path):
    path = grainy(tmp_path, (430, 640), (0.064, 0.043), random, grain=0.0)
    picture = np.full((430, 640, 1), 0.5)
    picture[105, 105] = picture[206, 207] = picture[208, 301] = picture[302, 403] = 30.0      # in a texel each
    picture[52:56, 52:56] = 30.0
    ball_files.write_picture(tmp_path / NAMES[0], picture)
    shot = flat(path).photographs[0]
    assert (~shot.mask).sum() == 1
    np.testing.assert_allclose(shot.radiance[shot.mask], 0.5, rtol=1e-3)


def test_a_height_that_is_a_little_off_loses_no_texel_of_a_sample_that_fills_its_pictures(openimageio, random,
                                                                                          tmp_path):
    found = flat(grainy(tmp_path, (43, 64), (0.064, 0.043 * 1.001), random))
    assert found.shape == (43, 64)
    assert observe(found.photographs, texel_points(found.corners, found.shape), np.array([0.0, 0, 1])).good.all()


def test_a_photograph_without_a_light_is_left_out_and_told(written, described):
    """A project of relight within the folder of the photographs, one of whose lights was not found."""
    folder = written.parent / "output"
    folder.mkdir()
    lights = LAMPS / np.linalg.norm(LAMPS, axis=1, keepdims=True)
    lights[2] = 0
    (folder / "info.json").write_text(f'{{"lights": {lights.ravel().tolist()}}}', "utf-8")
    text = described(camera="position = 'far'").read_text("utf-8")
    path = written.with_name("project.toml")
    path.write_text(text[:text.index("[[photograph]]")] + "[lamp]\npositions = 'output/info.json'\n", "utf-8")
    for each in written.parent.glob("mask*"):
        each.unlink()
    ball_files.write_picture(written.with_name("sphere_0.png"), np.ones((9, 9, 3)))     # relight leaves it there
    found = flat(path)
    assert [each.name for each in found.photographs] == ["lamp1.exr", "lamp2.exr", "lamp4.exr", "lamp5.exr"]
    assert any("no light of them: lamp3.exr" in note for note in found.notes)
    shown = [each.lamp / np.linalg.norm(each.lamp) for each in found.photographs]
    assert angle(np.array(shown), lights[[0, 1, 3, 4]]).max() < 15


def test_a_description_says_how_many_materials_there_are_and_leaves_photographs_out(described):
    found = flat(described(top="materials = 2\nleave_out = ['lamp2.exr']"))
    assert (found.number, found.materials) == (2, ())
    assert [each.name for each in found.photographs] == ["lamp1.exr", "lamp3.exr", "lamp4.exr", "lamp5.exr"]
    np.testing.assert_allclose([each.lamp for each in found.photographs], LAMPS[[0, 2, 3, 4]], atol=1e-6)
    for top, message in (("materials = 5", "materials is 5, expected files, or a number of 1 to 4"),
                         ("leave_out = 'lamp9.exr'", "leave_out is \\['lamp9.exr'\\], expected .*lamp9.exr is none")):
        with pytest.raises(fitter.DatasetError, match=message):
            flat(described(top=top))
    with pytest.raises(fitter.DatasetError, match=r"scale.albedo is 50.*, expected .* at most 1"):
        flat(described(scale="albedo = 50"))


def test_how_bright_each_lamp_is_is_given_or_found(openimageio, paper, random, tmp_path):
    """Of bumpy paper, whose lamps differ by tens of percent in each colour. Found within 6 %."""
    lamps = flat_scene.lamps(12)
    bumpy = flat_scene.Sample(paper.fits, paper.weights, flat_scene.bumps)
    path = flat_files.write(tmp_path, bumpy, lamps)
    true = random.uniform(0.6, 1.5, (12, 3))
    for number, (lamp, by) in enumerate(zip(lamps, true, strict=True), start=1):
        ball_files.write_picture(tmp_path / f"lamp{number}.exr", by * flat_scene.photograph(bumpy, lamp, seed=number))
    text = path.read_text("utf-8")
    path.write_text(text + "[lamp]\nbrightness = 'found'\n", "utf-8")
    found = np.array([each.intensity for each in flat(path).photographs]) / flat_scene.INTENSITY
    np.testing.assert_allclose(found, true / np.exp(np.log(true).mean(axis=0)), rtol=0.08)
    path.write_text(f"{text}[lamp]\nbrightness = {true[:, 0].tolist()}\n", "utf-8")
    given = np.array([each.intensity for each in flat(path).photographs]) / flat_scene.INTENSITY
    np.testing.assert_allclose(given, true[:, :1] * np.ones(3))
    path.write_text(f"{text}[lamp]\nbrightness = [1, 2]\n", "utf-8")
    with pytest.raises(fitter.DatasetError, match=r"lamp.brightness is \[1.0, 2.0\], expected 12 numbers"):
        flat(path)
