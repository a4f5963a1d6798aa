"""Azimuths that are no angles, and those over many turns."""

import warnings

import numpy as np
import pytest

import fitter

FILES = {
    "scan.csv": "theta_i[deg],phi_i[deg],theta_o[deg],phi_o[deg],BRDF\n30,0,30,180,.2\n30,{0},45,{1},.1\n",
    "between.csv": "theta_i[deg],theta_o[deg],phi[deg],BRDF\n30,30,180,.2\n30,45,{0},.1\n",
    "radians.csv": "theta_i[rad],phi_i[rad],theta_o[rad],phi_o[rad],BRDF\n.3,0,.3,3.1,.2\n.3,{0},.4,{1},.1\n",
    "paint.astm": "VARS theta_i,phi_i,theta_s,phi_s,BRDF\n.5,0,.5,3.1,.2\n.5,{0},.6,{1},.1\n",
    "scan.txt": "type bsdf_data\nformat angles=deg bsdf=value scale=1\n10 0\n5 180 .02\n5 {0} .03\n",
    "red.brdf": "3\n400 550 700\n.3 0 .3 3.1 .1 .1 .1\n.3 {0} .4 {1} .1 .1 .1\n"}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("azimuths", [("1e300", "1e300"), ("-1.7e308", "1.7e308"), ("1000001", "0"), ("-1e7", "-1e7")])
def test_an_azimuth_that_is_no_angle_is_an_error_of_its_line(name, azimuths, load):
    last = len(FILES[name].splitlines())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(fitter.DatasetError, match=rf"{name}:{last}: an azimuth of .* at most 1,000,000"):
            load(FILES[name].format(*azimuths), name)


@pytest.mark.parametrize("turns", [-2700, -1, 1, 2700])
def test_azimuths_over_many_turns_are_the_same_directions(turns, load):
    expected, found = (load(FILES["scan.csv"].format(azimuth, 170), "scan.csv") for azimuth in (20, 20 + 360 * turns))
    np.testing.assert_allclose(np.exp(1j * (found.phi_o - found.phi_i)), np.exp(1j * (expected.phi_o - expected.phi_i)),
                               atol=1e-9)


@pytest.mark.parametrize("field", ["phi_i", "phi_o"])
def test_samples_refuse_such_azimuths_too(field):
    angles = {name: np.array([0.1, 0.2]) for name in ("theta_i", "phi_i", "theta_o", "phi_o")}
    angles[field] = np.array([0.1, -1e300])
    with pytest.raises(fitter.DatasetError, match=rf"{field}\[1\] is -1e\+300, expected at most 1,000,000 radians"):
        fitter.Samples(**angles, values=np.ones((2, 1)))
