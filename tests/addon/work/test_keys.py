"""A key names all that the result depends on: each input of each key is changed, and another key is seen."""

from dataclasses import fields, replace
from itertools import combinations

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.storage import outcomes
from measured_brdf.addon.work import queries, tasks
from measured_brdf.fitter import Samples

from fitter.formats.reading import OPTIONS
from fitter.methods.extrapolation import MeasuredDomain
from fitter.optics.subsurface import Subsurface

DIRECTIONS = "theta_i", "phi_i", "theta_o", "phi_o"
OF_NO_FIT = "name", "source", "notes", "saturated"      # fields of samples that no fit depends on


@pytest.fixture
def samples(extension, glossy):
    return Samples(*glossy.directions, glossy.values, glossy.channels, deviation=np.full(len(glossy), 0.1))


def assert_differ(keys):
    for (one, key), (other, same) in combinations(keys.items(), 2):
        assert key != same, f"{one} and {other} have one key"


def changed_at(array, place, factor):
    changed = np.array(array)
    changed[place] *= factor
    return changed


def test_the_digest_of_measurements_names_all_that_a_fit_depends_on(samples):
    faintest = np.unravel_index(samples.values.argmin(), samples.values.shape)
    others = {
        **{field: {field: changed_at(getattr(samples, field), 7, 0.999)} for field in ("theta_i", "theta_o", "phi_o")},
        "phi_i": {"phi_i": samples.phi_i + 0.001},
        "values": [{"values": factor * samples.values} for factor in (2, 10, 1000, 1e-3, 1 + 1e-5)]
                  + [{"values": changed_at(samples.values, faintest, 1 + 1e-5)}, {"values": -samples.values}],
        "channels": [{"channels": ("B", "G", "R")}, {"values": samples.values[:, ::-1]}],
        "colours": {"colours": "ACEScg"}, "isotropic": {"isotropic": False},
        "subsurface": [{"subsurface": Subsurface(np.array([0.5, 0.4, last]), np.array([1, path, 1]), index)}
                       for last, path, index in ((0.3, 1, 1.3), (0.301, 1, 1.3), (0.3, 1.01, 1.3), (0.3, 1, 1.4),
                                                 (0.3, 1e-7, 1.3), (0.3, 2e-7, 1.3), (1 - 1e-8, 1, 1.3),
                                                 (1 - 2e-8, 1, 1.3))],
        "deviation": [{"deviation": None}, {"deviation": changed_at(samples.deviation, 3, 1.01)}]}
    assert {*others, *OF_NO_FIT} == {field.name for field in fields(samples)}
    keys = {"as they are": tasks.digest(samples)}
    for field, changes in others.items():
        for number, change in enumerate(changes if isinstance(changes, list) else [changes]):
            keys[f"{field} {number}"] = tasks.digest(replace(samples, **change))
    assert_differ(keys)


def test_the_digest_does_not_depend_on_names_and_on_how_a_computer_rounds(samples, random):
    alike = [{"name": "another"}, {"source": "another"}, {"notes": ("another",)},
             {"saturated": np.ones(len(samples), bool)},
             {"values": samples.values * (1 + 2e-16 * random.standard_normal(samples.values.shape))}]
    assert {tasks.digest(replace(samples, **each)) for each in alike} == {tasks.digest(samples)}
    powers = replace(samples, values=2.0 ** np.round(np.log2(samples.values)))
    assert tasks.digest(replace(powers, values=powers.values * (1 - 1e-16))) == tasks.digest(powers)
    nothing = changed_at(samples.values, (3, 1), 0.0)
    nearly = nothing.copy()
    nearly[3, 1] = -1e-17 * nothing.max()
    assert tasks.digest(replace(samples, values=nothing)) == tasks.digest(replace(samples, values=nearly))


def test_the_keys_of_saved_fits_and_of_assets(monkeypatch):
    given = ("name", "0123", {"diffuse_level": 3, "method": "mba"})
    keys = {"as it is": tasks.fit_key(*given), "name": tasks.fit_key("other", *given[1:]),
            "digest": tasks.fit_key(given[0], "4567", given[2]),
            **{f"arguments {number}": tasks.fit_key(*given[:2], arguments) for number, arguments in enumerate(
                ({}, {"diffuse_level": 4, "method": "mba"}, {"diffuse_level": 3, "method": "kriging"}))}}
    for module, name, value in ((tasks.fit_file, "VERSION", -1), (tasks.versions, "CURRENT", "0.0.0")):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            keys[name] = tasks.fit_key(*given)
    assert_differ(keys)
    keys = {"as it is": tasks.asset_key("fit", "AUTO"), "fit": tasks.asset_key("other", "AUTO"),
            "rendering": tasks.asset_key("fit", "NODES")}
    monkeypatch.setattr(tasks, "SHADER_VERSION", -1)
    assert_differ(keys | {"SHADER_VERSION": tasks.asset_key("fit", "AUTO")})


def keep(fit):
    return outcomes.EmbeddedFit(fit, "name", "Linear Rec.709")


def variants(item, changes):
    return {"as it is": item, **{field: item._replace(**{field: value}) for field, value in changes.items()}}


def test_the_digests_of_what_is_shown():
    kept = variants(keep(b"fit"), {"fit": b"other", "name": "other", "colours": "ACEScg"})
    assert_differ({name: each.digest for name, each in kept.items()})
    measured = outcomes.Measurement("path", "sample", "{}", "name", ("R",), "Linear Rec.709", "0123")
    wanted = outcomes.FitRequest(outcomes.Data(measured, None), {"method": "mba"})
    assert_differ({"as it is": wanted.digest, "arguments": wanted._replace(arguments={}).digest,
                   "data": wanted._replace(data=outcomes.Data(measured._replace(digest="4567"), None)).digest})
    one, other = kept["as it is"], kept["fit"]
    assert_differ({str(number): outcomes.KeptMix(*parts).digest for number, parts in enumerate(
        ((one, other, 0.5), (other, one, 0.5), (one, one, 0.5), (one, other, 0.6), (one, other, None),
         (outcomes.KeptMix(one, other, 0.5), other, 0.5)))})


def test_the_keys_of_pictures_in_panels(monkeypatch):
    """Each picture that a panel asks for, by each argument; `shown` and `data` are told by their digests."""
    asked = []
    monkeypatch.setattr(queries.icons, "icon", lambda key, *more, **options: asked.append(key) or (0, None))
    one, other = (keep(fit) for fit in (b"one", b"other"))
    data = [outcomes.Data(outcomes.Measurement(*[""] * 6, digest), None) for digest in "01"]
    ask = queries
    seconds = (), ((one, ()),), ((other, ()),), ((one, (MeasuredDomain(1.2, 1.0),)),)
    fits = [((first, reaches), *second) for first in (one, other) for reaches in ((), (MeasuredDomain(1.2, 1.0),))
            for second in seconds]
    for function, arguments in ((ask.lit_sphere, ((1, 2), (one, other), (None, {"a": 1}, {"a": 2}))),
                                (ask.polar_plot, ((1, 2), fits, (None, *data), (0.1, 0.2), (0.1, 0.2))),
                                (ask.turned_plane, ((1, 2), (one, other), (0.1, 0.2)))):
        asked.clear()
        function(*(choices[0] for choices in arguments))
        for place, choices in enumerate(arguments):
            for choice in choices[1:]:
                function(*(each[0] if number != place else choice for number, each in enumerate(arguments)))
        assert_differ({str(number): key for number, key in enumerate(asked)})


def test_a_panel_asks_anew_about_measurements_that_are_read_otherwise(monkeypatch):
    asked = []
    monkeypatch.setattr(queries.queue, "ask", lambda key, *more, **options: asked.append(key))
    material = bpy.data.materials.new("read")
    settings = material.measured_brdf
    try:
        queries.data(material)
        for name, value in (("filepath", "other.csv"), ("sample", "other"), ("angles", "radians"),
                            ("quantity", "brdf_percent"), ("illuminant", "A"), ("isotropic", "isotropic"),
                            ("symmetry", "mirror"), ("encoding", "srgb"), ("keep_unmeasured", True), ("columns", "1")):
            setattr(settings, name, value)
            queries.data(material)
        monkeypatch.setattr("measured_brdf.addon.work.queries.load_arguments", lambda choices: {"colours": "ACEScg"})
        queries.data(material)
    finally:
        bpy.data.materials.remove(material)
    assert len(asked) == 2 + 2 + len(OPTIONS)
    assert_differ({str(number): key for number, key in enumerate(asked)})
