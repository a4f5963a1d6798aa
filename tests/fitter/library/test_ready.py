"""Fits that are made beforehand: close to the published formula, and the same when they are read again."""

import numpy as np
import pytest

import fitter
from fitter.library import ready
from fitter.model import published
from support.cases import quick
from support.faults import albedo_error, swapped_error

# RMSE of the cube root of values times cosine, as a share of its mean: what Standard has, or 0.01 where
# that is better
LARGEST_ERRORS = {"red-plastic": 0.01, "white-marble": 0.01, "gold-paint": 0.01, "specular-blue-phenolic": 0.01,
                  "polyurethane-foam": 0.03, "two-layer-gold": 0.04}
# fits of which were off their models by most, and one of each other tag
OF_ALL_KINDS = ("specular-white-phenolic", "black-fabric", "light-brown-fabric", "green-plastic", "two-layer-gold",
                "black-soft-plastic", "fruitwood-241", "gold-polished", "espresso")


@pytest.fixture(scope="module")
def made():
    return ready.make("red-plastic")


def at_random(model, random, count=4000):
    """Directions up to 80 degrees, half of them in and about the highlight."""
    theta_i, theta_o = np.arccos(np.sqrt(random.uniform(np.cos(np.radians(80)) ** 2, 1, (2, count))))
    phi_o = random.uniform(0, 2 * np.pi, count)
    near = random.random(count) < 0.5
    theta_o = np.where(near, np.abs(theta_i + np.sqrt(2 / model.b) * random.standard_cauchy(count)), theta_o)
    kept = theta_o < np.radians(80)
    return theta_i[kept], np.zeros(kept.sum()), theta_o[kept], np.where(near, np.pi, phi_o)[kept]


@pytest.mark.parametrize("name", quick(LARGEST_ERRORS, "red-plastic"))
def test_a_ready_fit_is_close_to_the_published_formula_where_it_has_no_samples(name, random):
    model = published.find(name).model
    at = at_random(model, random)
    expected, found = (np.cbrt(each.evaluate(*at) * np.cos(at[2])[:, None]) for each in (model, ready.find(name).fit))
    assert np.sqrt(np.mean((expected - found) ** 2)) < LARGEST_ERRORS[name] * expected.mean()


@pytest.mark.parametrize("name", quick([each.name for each in published.list_offered()], *OF_ALL_KINDS))
def test_a_ready_fit_reflects_as_much_as_its_model_whichever_way_the_light_goes(name):
    """Each material is sampled with the light the steeper direction: the other half of directions is the fit's own."""
    fit = ready.fit(name)
    assert albedo_error(name, fit) < 0.02
    assert swapped_error(name, fit) < 0.02


def test_what_is_read_is_what_was_written(made, tmp_path):
    path = tmp_path / "a.npz"
    ready.write(made, path)
    back = ready.read(path)
    assert back.fit.to_bytes() == made.fit.to_bytes()
    assert path.stat().st_size < 24_000
    assert back.nodes.walk is made.nodes.walk is None
    for mixture, before in zip(back.nodes[:2], made.nodes[:2], strict=True):
        assert mixture.kinds == before.kinds
        assert mixture.turn is before.turn is None
        for name in ("theta", "colour", "error", "worst", "albedo_error"):
            np.testing.assert_allclose(getattr(mixture, name), getattr(before, name), rtol=1e-6)
        for one, two in zip((*mixture.shape, *(mixture.sampling or ())), (*before.shape, *(before.sampling or ())),
                            strict=True):
            assert one.shape == two.shape
            np.testing.assert_allclose(one, two, rtol=1e-6)
    assert back.nodes.cycles.sampling is not None
    at = 0.3, 0, np.linspace(0, 1.4, 8), np.pi
    np.testing.assert_allclose(back.principled.evaluate(*at), made.principled.evaluate(*at), rtol=1e-5)
    assert type(back.principled.roughness) is float


def test_a_fit_that_is_there_is_read_and_another_is_made(made, tmp_path, monkeypatch):
    monkeypatch.setattr(ready, "FOLDER", tmp_path)
    monkeypatch.setattr(ready, "make", lambda name: f"made {name}")
    assert not ready.is_there("red-plastic")
    assert ready.find("red-plastic") == "made red-plastic"
    ready.write(made, tmp_path / "red-plastic.npz")
    assert ready.is_there("red-plastic")
    assert ready.find("red-plastic").fit.name == "Red plastic"
    with pytest.raises(fitter.DatasetError, match="did you mean red-plastic"):
        ready.find("red-plastics")


@pytest.mark.parametrize("damage", [lambda content: content[:-30], lambda content: b"", lambda content: content.replace(
    b"cycles_kinds", b"cycles_kindz")])
def test_a_damaged_file_is_refused(made, tmp_path, damage):
    path = tmp_path / "a.npz"
    ready.write(made, path)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(fitter.DatasetError, match=r"a\.npz"):
        ready.read(path)


def test_a_file_of_another_state_of_the_code_is_refused(made, tmp_path):
    """Its mixture lacks a column that the shader reads."""
    path, sampling = tmp_path / "a.npz", made.nodes.cycles.sampling
    fewer = made.nodes.cycles._replace(sampling=sampling._replace(balance=sampling.balance[:, :0]))
    ready.write(made._replace(nodes=made.nodes._replace(cycles=fewer)), path)
    with pytest.raises(fitter.DatasetError, match=r"a\.npz.*a mixture of \d+ columns found, expected \d+"):
        ready.read(path)


def test_metals_that_look_black_are_not_offered():
    """What is reflected of the light that falls straight on the surface: the integral of the formula."""
    out = {each.name for each in published.materials().values()} - {each.name for each in published.list_offered()}
    assert len(out) == 11
    assert {"chrome", "steel", "brass", "aluminium"} <= out
    for name in out:
        model = published.find(name).model
        theta_o = np.concatenate([[0], np.geomspace(1e-5, np.pi / 2 - 1e-9, 20_000)])
        light = model.evaluate(0, 0, theta_o, 0).max(axis=-1) * np.cos(theta_o) * np.sin(theta_o)
        reflected = 2 * np.pi * (np.diff(theta_o) * (light[1:] + light[:-1]) / 2).sum()
        assert reflected < 0.25, name               # a metal reflects more than half
        assert reflected > 0.02, name
