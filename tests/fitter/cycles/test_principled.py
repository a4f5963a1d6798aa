"""The Principled BSDF that is closest to a fit: those that are known, materials whose kind is known, albedos."""

import numpy as np
import pytest

import fitter
from benchmarks.report.baselines import neural
from fitter.arrays import unit_vectors
from fitter.cycles import principled
from fitter.cycles.principled import Principled, albedo
from fitter.quality.physics import directional_albedo
from support.cases import quick, release
from support.checkout import measurements

COLOR = np.array([0.6, 0.3, 0.1])
KNOWN = {"plastic": Principled(COLOR, 0.4, 0.0, 0.5), "chalk": Principled(COLOR, 0.8, 0.0, 0.2),
         "metal": Principled(COLOR, 0.3, 1.0, 0.5),
         "cloth": Principled(COLOR, 0.5, 0.0, 0.5, np.array([0.5, 0.3, 0.2]), 0.4),
         "lacquer": Principled(COLOR, 0.6, 0.0, 0.5, coat_weight=0.8, coat_roughness=0.15),
         "car": Principled(COLOR, 0.5, 1.0, 0.5, coat_weight=0.8, coat_roughness=0.1)}


def error(fit, close):
    """The error that is made small: the root of the mean square, relative to the mean's cube root."""
    return principled._error(close, principled._target(fit))


@pytest.mark.parametrize("name", KNOWN)
def test_a_principled_comes_back(name):
    known = KNOWN[name]
    closest = principled.principled(known)
    assert closest.metallic == known.metallic
    np.testing.assert_allclose(closest.base_color, known.base_color, atol=0.01)
    np.testing.assert_allclose(closest.sheen_tint, known.sheen_tint, atol=0.01)
    assert closest.roughness == pytest.approx(known.roughness, abs=0.01)
    assert closest.specular_level == pytest.approx(known.specular_level, abs=0.01)
    assert closest.coat_weight == pytest.approx(known.coat_weight, abs=0.01)
    if known.sheen_weight:
        assert closest.sheen_roughness == pytest.approx(known.sheen_roughness, abs=0.01)
    if known.coat_weight:
        assert closest.coat_roughness == pytest.approx(known.coat_roughness, abs=0.01)
    assert error(known, closest) < 0.005


def test_grey_scattered_data_give_a_grey_principled():
    class Grey:
        def evaluate(self, *directions):
            return KNOWN["plastic"].evaluate(*directions)[..., :1]

    closest = principled.principled(Grey())
    assert closest.base_color == pytest.approx([0.6, 0.6, 0.6], abs=0.01)
    assert closest.sheen_tint == pytest.approx([0, 0, 0])


class Textbook:
    """A Lambertian and microfacets with Schlick's Fresnel term, by vectors, not a Principled BSDF."""

    def __init__(self, color, f0, roughness):
        self.color, self.f0, self.alpha = np.array(color), f0, roughness ** 2

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        wi, wo = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)
        h = (wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True)
        tan2 = 1 / h[..., 2] ** 2 - 1
        d = 1 / (np.pi * self.alpha ** 2 * h[..., 2] ** 4 * (1 + tan2 / self.alpha ** 2) ** 2)
        hidden = [(np.sqrt(1 + self.alpha ** 2 * (1 / w[..., 2] ** 2 - 1)) - 1) / 2 for w in (wi, wo)]
        fresnel = self.f0 + (1 - self.f0) * (1 - (wi * h).sum(axis=-1)) ** 5
        lobe = d * fresnel / (1 + sum(hidden)) / (4 * wi[..., 2] * wo[..., 2])
        return self.color / np.pi + lobe[..., None]


@pytest.mark.parametrize(("color", "f0", "roughness"), [((0.4, 0.2, 0.1), 0.04, 0.4), ((0.05, 0.1, 0.5), 0.06, 0.7)])
def test_the_principled_of_a_dielectric_is_that_dielectric(color, f0, roughness):
    closest = principled.principled(Textbook(color, f0, roughness))
    # what its surface reflects does not reach the Lambertian, so that has a lighter colour
    np.testing.assert_allclose(closest.base_color, np.array(color) * 1.05, rtol=0.02, atol=0.015)
    assert closest.roughness == pytest.approx(roughness, abs=0.03)
    assert (closest.metallic, closest.sheen_weight) == (0, 0)
    assert closest.specular_level == pytest.approx(f0 / 0.08, abs=0.3)     # hard to see where it is rough


def test_the_principled_of_a_metal_is_that_metal():
    closest = principled.principled(Textbook((0, 0, 0), 0.8, 0.4))
    assert closest.metallic == 1
    assert closest.roughness == pytest.approx(0.4, abs=0.03)
    np.testing.assert_allclose(closest.base_color, 0.8, atol=0.05)


@pytest.mark.parametrize("roughness", [0.3, 0.7, 1.0])
def test_a_white_principled_reflects_all_light(roughness):
    for metallic in (0.0, 1.0):
        white = Principled(np.ones(3), roughness, metallic, 0.5)
        for theta in (0.2, 0.9, 1.3):
            np.testing.assert_allclose(directional_albedo(white, theta), 1, atol=0.03)


def test_a_sheen_and_a_coat_take_from_what_is_below():
    for layered in (KNOWN["cloth"], KNOWN["lacquer"]):
        below = Principled(np.ones(3), layered.roughness, 0.0, 0.5, layered.sheen_tint, layered.sheen_roughness,
                           layered.coat_weight, layered.coat_roughness)
        for theta in (0.2, 0.9, 1.3):
            assert (directional_albedo(below, theta) < 1.03).all()


@pytest.fixture(scope="module")
def close(data):
    """The fit of a real material, as the panel makes it, and the closest Principled BSDF."""
    found = {}

    def of(path, sample=None):
        if (path, sample) not in found:
            fit = fitter.fit(fitter.load(data / path, sample), **fitter.PRESETS["Standard"])
            found[path, sample] = fit, principled.principled(fit)
        return found[path, sample]
    return of


@release
def test_cloth_and_stone_are_no_metals_and_foil_is_one(close):
    for sample in ("felt", "velvet", "brick a", "brick b", "polyester", "sponge", "frosted glass"):
        assert close("curet/abrdf.dat", sample)[1].metallic == 0, sample
    assert close("curet/abrdf.dat", "aluminum foil")[1].metallic == 1


def test_velvet_has_sheen(close):
    assert close("curet/abrdf.dat", "velvet")[1].sheen_tint.min() > 0.2


@pytest.mark.parametrize(("path", "sample"), quick([
    ("curet/abrdf.dat", "felt"), ("curet/abrdf.dat", "velvet"), ("curet/abrdf.dat", "brick a"),
    ("curet/abrdf.dat", "aluminum foil"), ("cornell/cayman.astm", None), ("cornell/krylon_blue.astm", None),
    ("cornell/garnet_red.astm", None)],
    ("curet/abrdf.dat", "felt"), ("curet/abrdf.dat", "aluminum foil")))
def test_the_albedo_of_a_real_material_is_kept(close, path, sample):
    fit, found = close(path, sample)
    assert albedo(found) == pytest.approx(albedo(fit), abs=0.025)
    assert found.base_color.max() > 0.3 * albedo(fit).max()


METALS = ("aluminium", "alum-bronze", "brass", "chrome", "chrome-steel", "nickel", "ss440", "steel", "tungsten-carbide",
          "grease-covered-steel", "silver-metallic-paint", "gold-metallic-paint")
OTHERS = ("beige-fabric", "black-fabric", "blue-fabric", "blue-rubber", "white-fabric", "red-fabric2", "pink-felt",
          "teflon", "white-marble", "delrin", "green-plastic", "maroon-plastic", "red-phenolic", "cherry-235",
          "black-obsidian", "white-paint", "yellow-matte-plastic", "nylon", "pvc", "polyurethane-foam")


@pytest.mark.parametrize("name", quick([*METALS, *OTHERS], METALS[0], OTHERS[0]))
def test_what_is_called_a_metal_is_metallic(name):
    nets = measurements() / "merl" / "nbrdf_nets.npz"
    if not nets.is_file():
        pytest.skip(f"{nets} is absent")
    closest = principled.principled(neural.published(nets, name))
    assert closest.metallic == (name in METALS)
