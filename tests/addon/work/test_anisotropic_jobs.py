"""What panels ask about anisotropic measurements."""

import numpy as np
import pytest
from measured_brdf.addon.core.storage.outcomes import FitRequest, Fitted
from measured_brdf.addon.work import icons, queries, tasks

from support.anisotropic import STEEL, brushed_fit, few, write_table
from support.cases import release

CHEAP = {"diffuse_level": 2, "specular_level": 3, "compression": 90.0, "method": "mba"}


@pytest.fixture
def data(tmp_path):
    """Brushed steel at a few directions, read as the panel reads it."""
    path = write_table(tmp_path / "steel.csv", STEEL, directions=few())
    return tasks.read(str(path), None)


@release
def test_the_panel_draws_the_tangent_and_thumbnails_do_not(data, tmp_path):
    drawn = tasks.lit_sphere(FitRequest(data, CHEAP), None)
    thumbnail = tasks.asset(data.measured.path, None, CHEAP, str(tmp_path / "fits"))[1]
    assert drawn.shape == thumbnail.shape
    differ = (drawn != thumbnail).any(axis=-1).mean()
    assert 0.005 < differ < 0.1


def test_the_polar_plot_turns_with_the_light(data):
    there, shown = tasks.polar_plot([(FitRequest(data, CHEAP), ())], data, np.radians(30), 0.0)
    turned, shown_turned = tasks.polar_plot([(FitRequest(data, CHEAP), ())], data, np.radians(30), np.radians(60))
    assert shown == shown_turned == pytest.approx(np.radians(30))
    assert (there != turned).any()


def test_the_turned_plane_shows_which_way_the_grooves_run(data, monkeypatch):
    monkeypatch.setattr(tasks, "fit_data", lambda *_: Fitted(brushed_fit(0.12, 0.45, 0.0), None, 0.0))
    picture = tasks.turned_plane(FitRequest(data, CHEAP), np.radians(30)).mean(axis=-1)
    mirror = picture[int((0.5 + 60 / 180) * len(picture))]        # 30 degrees beyond the mirror direction
    along, across = mirror[[0, 128]].mean(), mirror[[64, 192]].mean()
    assert across > 1.3 * along


def test_panels_ask_for_each_azimuth_and_incidence_once(data, monkeypatch):
    keys = []
    monkeypatch.setattr(icons, "icon", lambda key, function: keys.append((key, function.args)))
    wanted = FitRequest(data, CHEAP)
    queries.polar_plot("mine", ((wanted, ()),), data, 0.5, 1.23456)
    queries.polar_plot("mine", ((wanted, ()),), data, 0.5, 1.2346)
    queries.polar_plot("mine", ((wanted, ()),), data, 0.5)
    queries.turned_plane("mine", wanted, 0.50001)
    assert keys[0] == keys[1] != keys[2]
    assert keys[0][0][-2:] == (0.5, 1.235)
    assert keys[3][0] == ("turned", "mine", wanted.digest, 0.5)
