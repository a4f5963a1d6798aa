"""Dense measurements: pictures against integrals, their errors against standards, published models against formulas."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.dense import bench, image_errors, judging, materials, sheet, sky, sphere, summary
from benchmarks.harness.judging import directions
from fitter.formats import merl
from fitter.methods.prior import lambertian
from fitter.model.microfacet import Microfacet
from fitter.quality import cross_validation
from fitter.samples import RGB, Samples
from support import merl_files

WHITE = lambertian(np.full((1, 3), 0.8 / np.pi))
GLOSSY = Microfacet(np.array([0.02, 0.03, 0.05]), np.full((1, 3), 4.0), np.array([0.1]), np.array([2.0]),
                    np.array([0.05]))
SMALL = 16                  # pixels


@pytest.fixture(scope="module")
def clear():
    return sky.clear(40)


def by_hand(image, normal):
    """The irradiance of a surface: the sum over the pixels of the sky, each divided into 9."""
    rows = 3 * len(image.radiance)
    toward = sky.directions(rows).reshape(-1, 3)
    area = np.repeat(np.sin(np.pi * (np.arange(rows) + 0.5) / rows) * (np.pi / rows) ** 2, 2 * rows)
    return (np.maximum(toward @ normal, 0) * area) @ image.at(toward)


def test_a_white_sphere_shows_the_irradiance(clear):
    of = sphere.scene(lambda: clear, SMALL, 3)
    picture = sphere.render(WHITE, of)
    normal, inside, _ = sphere.sphere(SMALL)
    expected = np.array([by_hand(clear, each) for each in normal]) * 0.8 / np.pi
    np.testing.assert_allclose(picture[inside], expected, rtol=0.03)
    np.testing.assert_allclose(picture[inside].mean(axis=0), expected.mean(axis=0), rtol=0.004)
    assert not picture[~inside].any()


def test_under_an_even_sky_a_pixel_is_the_directional_albedo():
    of = sphere.scene(sky.even, SMALL, 5)
    normal, inside, _ = sphere.sphere(SMALL)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    cosine, phi = (nodes + 1) / 2, (np.arange(200) + 0.5) / 200 * np.pi
    grid = np.meshgrid(np.arccos(cosine), phi, indexing="ij")
    for pixel in np.argsort(normal[:, 2])[[5, 100, -1]]:
        theta = np.arccos(normal[pixel, 2])
        value = GLOSSY.evaluate(grid[0], 0, theta, grid[1])
        expected = np.einsum("ijc,i->c", value, weights / 2 * cosine) * 2 * np.pi / 200
        np.testing.assert_allclose(sphere.render(GLOSSY, of)[inside][pixel], expected, rtol=0.02)


def test_other_numbers_give_the_same_picture_of_a_narrow_peak(clear):
    peak = replace(GLOSSY, alpha=np.array([0.01]), ks=np.full((1, 3), 400.0))
    one, other = (sphere.scene(lambda: clear, SMALL, 1, seed) for seed in (1, 2))
    found = image_errors.errors(sphere.render(peak, one), sphere.render(peak, other), one.inside)
    assert found["psnr"] > 42
    assert found["mae"] < 0.005


def test_the_sky_is_preethams():
    """Luminance of the zenith by hand at turbidity 3 and a sun of 45 degrees; and it is blue, and bright at the sun."""
    sun = np.array([np.sqrt(0.5), np.sqrt(0.5), 0])
    zenith = sky.preetham(np.array([0.0, 1, 0]), sun, 3.0)
    by_hand = (4.0453 * 3 - 4.971) * np.tan((4 / 9 - 3 / 120) * (np.pi - np.pi / 2)) - 0.2155 * 3 + 2.4192
    assert zenith @ sky.LUMINANCE == pytest.approx(by_hand, rel=2e-3)
    assert zenith[2] > 1.5 * zenith[0]
    assert sky.preetham(sun, sun, 3.0)[0] > 3 * zenith[0]


def test_the_sun_has_its_share(clear):
    toward = sky.directions(len(clear.radiance))
    _, area = sky._chances(clear.radiance)
    disk = (toward @ sky.SUN > np.cos(sky.SUN_RADIUS)) * area[:, None]
    up = np.maximum(toward[..., 1], 0) * area[:, None]
    rest = np.where(disk[..., None] > 0, sky.preetham(toward, sky.SUN, sky.TURBIDITY), clear.radiance)
    sun = np.einsum("ij,ijc->c", disk, clear.radiance - rest) @ sky.LUMINANCE
    assert sun == pytest.approx(sky.SUN_SHARE * np.einsum("ij,ijc->c", up, rest) @ sky.LUMINANCE, rel=1e-6)


def itp_by_hand(r, g, b):
    """BT.2100's formulas for one colour of BT.2020 in cd/m^2, and BT.2124's T."""
    lms = ((1688 * r + 2146 * g + 262 * b) / 4096, (683 * r + 2951 * g + 462 * b) / 4096,
           (99 * r + 309 * g + 3688 * b) / 4096)
    m1, m2, c1, c2, c3 = 0.1593017578125, 78.84375, 0.8359375, 18.8515625, 18.6875
    l, m, s = (((c1 + c2 * (v / 1e4) ** m1) / (1 + c3 * (v / 1e4) ** m1)) ** m2 for v in lms)
    return (l + m) / 2, (6610 * l - 13613 * m + 7003 * s) / 4096 / 2, (17933 * l - 17390 * m - 543 * s) / 4096


def test_delta_e_itp_is_that_of_the_recommendations_formulas():
    first, second = (100.0, 50.0, 20.0), (90.0, 60.0, 10.0)
    wide = [(0.6274 * r + 0.3293 * g + 0.0433 * b, 0.0691 * r + 0.9195 * g + 0.0114 * b,
             0.0164 * r + 0.0880 * g + 0.8956 * b) for r, g, b in (first, second)]
    i, t, p = (a - b for a, b in zip(*(itp_by_hand(*each) for each in wide), strict=True))
    expected = 720 * (i ** 2 + t ** 2 + p ** 2) ** 0.5
    assert expected > 10
    assert image_errors.delta_e_itp(np.array(first), np.array(second)) == pytest.approx(expected, rel=1e-9)
    # the signals that BT.2408 tabulates: 100 cd/m^2 is 51 %, 1,000 are 75 %
    np.testing.assert_allclose(image_errors.pq([100, 1000]), [0.508, 0.752], atol=5e-4)


def test_errors_of_pictures(random):
    truth = random.random((20, 20, 3))
    inside = np.ones((20, 20), dtype=bool)
    inside[:3] = False
    same = image_errors.errors(truth, truth, inside)
    assert (same["psnr"], same["mae"], same["flip"], same["delta_e_itp"]) == (np.inf, 0, pytest.approx(0, abs=1e-6), 0)
    outside = truth.copy()
    outside[0] += 1
    assert image_errors.errors(truth, outside, inside)["mae"] == 0
    found = image_errors.errors(truth, 0 * truth, inside)
    shown = image_errors.srgb(image_errors.exposure(truth[inside]) * truth[inside])
    assert found["mae"] == pytest.approx(shown.mean())
    assert found["psnr"] == pytest.approx(-20 * np.log10(np.sqrt((shown ** 2).mean())))
    assert found["flip"] > 0.3


def test_a_file_of_merl_made_of_a_model_reads_as_the_model():
    samples = merl.read("made.binary", merl_files.of_model(GLOSSY, 9))
    np.testing.assert_allclose(samples.values, GLOSSY.evaluate(*samples.directions), rtol=1e-6)
    assert len(samples) > 600
    assert samples.theta_o.max() > 1.3


def opened():
    """A cheap material: a hundred directions of a synthetic gloss."""
    theta_i, theta_o, phi_o = np.random.default_rng(4).random((3, 100)) * [[1.4], [1.4], [np.pi]]
    at = theta_i, 0 * theta_i, theta_o, phi_o
    rivals = {materials.NEURAL: WHITE, materials.TURNED: materials.Turned(GLOSSY)}
    return materials.Opened(Samples(*at, GLOSSY.evaluate(*at), RGB), GLOSSY, rivals, {materials.TABLE: 659_000})


def made(name="paint"):
    return materials.Material(name, "RGL", opened)


@pytest.fixture(scope="module")
def scene():
    return sphere.scene(lambda: sky.clear(40), SMALL)


@pytest.fixture(scope="module")
def judged(scene):
    return judging.judge(made(), ("Draft",), scene)


def test_a_record_holds_the_errors_of_each_model(judged):
    record, pictures = judged
    samples = opened().samples
    white = record["models"][materials.NEURAL]
    errors = cross_validation.errors(samples, WHITE.evaluate(*samples.directions))
    assert (white["samples_rmse"], white["samples_cube_root_rmse"]) == pytest.approx(tuple(errors))
    at = directions()
    cubes = [cross_validation.cube_root(at[2], of.evaluate(*at)) for of in (GLOSSY, WHITE)]
    assert white["between_cube_root_mae"] == pytest.approx(np.abs(cubes[0] - cubes[1]).mean())
    reciprocal = record["models"][materials.TURNED]
    assert reciprocal["between_rmse"] < 1e-9
    assert reciprocal["flip"] == pytest.approx(0, abs=1e-4)
    assert record["models"][materials.TABLE]["bytes"] == 659_000
    assert record["models"]["Draft"]["samples_cube_root_rmse"] < white["samples_cube_root_rmse"] / 5
    assert record["models"]["Draft"]["psnr"] > white["psnr"] + 5
    assert set(pictures) == {"truth", "Draft", materials.NEURAL, materials.TURNED, "GGX"}
    brightest = np.percentile(pictures["truth"], 99)
    assert brightest > 3 * np.median(pictures["truth"][pictures["truth"] > 0])


def test_negative_samples_count_as_they_are_and_as_0(scene):
    values = opened().samples.values.copy()
    values[7] = -1.0
    samples = replace(opened().samples, values=values)
    record, _ = judging.judge(materials.Material("dark", "RGL", lambda: replace(opened(), samples=samples)), (), scene)
    row = record["models"]["GGX"]
    assert row["samples_rmse"] > row["clipped_rmse"]
    assert row["samples_cube_root_mae"] > row["clipped_cube_root_mae"]


def test_a_model_that_fails_is_recorded_and_the_others_go_on(monkeypatch, scene):
    monkeypatch.setattr(judging.ggx, "fit", lambda samples: 1 / 0)
    record, _ = judging.judge(made(), (), scene)
    assert "ZeroDivisionError" in record["models"]["GGX"]["failed"]
    assert record["models"][materials.NEURAL]["mae"] > 0
    assert "failed" in summary.all_rows([record])


def test_the_pictures_of_a_material_are_kept_and_drawn(judged, tmp_path, monkeypatch):
    monkeypatch.setattr(judging, "judge", lambda material: judged)
    record = bench.BENCH.judge(made(), tmp_path)
    assert bench.BENCH.is_whole(record, tmp_path)
    np.testing.assert_array_equal(np.load(sheet.pictures_of(record, tmp_path))["truth"], judged[1]["truth"])
    results = {"materials": [record], "left_out": ["steel: why"]}
    text = bench.BENCH.text(results, bench.BENCH.draw(results, tmp_path))
    assert f"![dense_spheres]({sheet.NAME})" in text
    assert "Left out: steel: why." in text
    assert (tmp_path / sheet.NAME).stat().st_size > 10_000
    sheet.pictures_of(record, tmp_path).unlink()
    assert not bench.BENCH.is_whole(record, tmp_path)


def row(error, size=3000):
    return {"bytes": size, "seconds": 0.0, **dict.fromkeys((*judging.ERRORS, *judging.RENDERED), error)}


def test_the_wishes_are_judged_by_the_better_reading_of_the_net():
    records = [{"name": name, "family": "RGL", "samples": 9, "channels": 3, "seconds": 1.0, "models": {
        "Draft": row(0.9, 18_000), "Standard": row(own, size), materials.NEURAL: row(net),
        materials.TURNED: row(other)}}
        for name, own, net, other, size in (("a", 0.4, 1.0, 0.9, 40_000), ("b", 0.4, 0.7, 9.0, 60_000))]
    found = summary.ratios(records, summary.WISHES[0], "mae")
    assert found == {"a": pytest.approx(0.4 / 0.9), "b": pytest.approx(0.4 / 0.7)}
    text = summary.wishes_text(records)
    assert "- Standard takes at most 16,384 bytes a channel: 1 of 2; not for b (20,000)\n" in text
    assert "- Draft takes at most 6,144 bytes a channel: 2 of 2\n" in text
    assert "at most 0.5 of the better of the neural fit's" in text
    assert "  - MAE of the picture: 1 of 2; not for b (0.57)\n" in text
    assert "  - **all of these, as wished, at the samples and in the picture**: 1 of 2; not for b (0.57)\n" in text
    assert "MERL" not in text
    failed = records[0]["models"] | {"Standard": row(None)}
    assert summary.ratios([records[0] | {"models": failed}], summary.WISHES[0], "mae") == {"a": np.inf}
