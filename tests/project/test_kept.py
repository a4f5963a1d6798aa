"""What tests keep is what would be made anew, and nothing is kept whose meaning may change."""

import numpy as np
import pytest

import fitter
from fitter.samples import subset
from support import cases, kept


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A kept function of samples that fits them, and how often it has."""
    monkeypatch.setattr(kept, "FOLDER", tmp_path / "kept")
    monkeypatch.setattr(kept, "_on", True)
    calls = []

    def fit(samples, *_more):
        calls.append(samples)
        return fitter.Fit(*_parts(samples), name=samples.name, source=samples.source)
    return kept.kept(fit, lambda: b"code"), calls


def _parts(samples):
    found = fitter.fit(samples, 1, None)
    return found.coordinates, found.diffuse


def test_a_fit_is_made_once_and_has_the_names_of_the_samples(made, glossy):
    from dataclasses import replace

    fit, calls = made
    samples = subset(glossy, slice(50))
    first, again = fit(samples), fit(replace(samples, name="other", source="elsewhere"))
    assert len(calls) == 1
    assert (again.name, again.source) == ("other", "elsewhere")
    np.testing.assert_array_equal(again.diffuse.control_points, first.diffuse.control_points)
    assert again.transform is None
    fit(subset(glossy, slice(51)))
    fit(samples, 1)
    assert len(calls) == 3


def test_what_cannot_be_told_by_its_pickle_is_made_anew(made, glossy):
    fit, calls = made
    for _ in range(2):
        fit(subset(glossy, slice(50)), lambda: 1)
    with kept.fresh():
        fit(subset(glossy, slice(50)))
        fit(subset(glossy, slice(50)))
    assert len(calls) == 4


def test_other_code_makes_another_fit(tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "FOLDER", tmp_path)
    monkeypatch.setattr(kept, "_on", True)

    def twice(number):
        return 2 * number
    assert kept.kept(twice, lambda: b"old")(3) == 6
    twice.__code__ = (lambda number: 3 * number).__code__
    assert kept.kept(twice, lambda: b"old")(3) == 6, "only the code that is given tells"
    assert kept.kept(twice, lambda: b"new")(3) == 9


def test_cases_beside_the_kept_ones_are_for_releases():
    first, second, third = cases.quick(["a", "b", ("c", "d")], "b")
    assert second == "b"
    assert [(each.values, [mark.name for mark in each.marks]) for each in (first, third)] == [
        (("a",), ["release"]), (("c", "d"), ["release"])]
    with pytest.raises(ValueError, match="no such cases"):
        cases.quick(["a"], "x")


def test_the_sphere_of_the_tests_is_that_of_blenders_operator(blender):
    from support.stage import add_sphere

    blender.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    theirs, ours = blender.context.object.data, add_sphere(32, 16).data
    assert len(ours.edges) == len(theirs.edges)
    assert not ours.validate()

    def faces(mesh):
        uv = mesh.uv_layers[0].data
        return sorted((*np.round(face.center, 4) + 0.0, *np.round(np.mean([uv[loop].uv for loop in face.loop_indices],
                                                                          axis=0), 4), *np.round(face.normal, 3) + 0.0)
                      for face in mesh.polygons)
    np.testing.assert_allclose(faces(ours), faces(theirs), atol=2e-3)
    assert all(face.use_smooth for face in ours.polygons)
