"""The baselines' OSL functions, which are timed, against NumPy."""

import numpy as np
import pytest

import fitter
from benchmarks import baselines_osl
from benchmarks.report.baselines import koenderink, lafortune
from support.cases import release
from support.osl_probe import probe_osl

COUNT = 2500


@release
@pytest.mark.parametrize(("baseline", "write"), [(koenderink, baselines_osl.koenderink),
                                                 (lafortune, baselines_osl.lafortune)])
def test_a_baseline_in_osl_is_that_in_numpy(blender, glossy, random, baseline, write):
    from measured_brdf.addon.core import osl_support

    assert not osl_support.missing()
    model = baseline.fit(glossy)
    z = random.random((2, COUNT))
    phi = random.random((2, COUNT)) * 2 * np.pi
    r = np.sqrt(1 - z**2)
    wi, wo = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).astype(np.float32)
    name = baseline.__name__.rpartition(".")[2]
    code = f"""
      if (pixel < {COUNT}) {{
        vector wi = vector(WI[3 * pixel], WI[3 * pixel + 1], WI[3 * pixel + 2]);
        vector wo = vector(WO[3 * pixel], WO[3 * pixel + 1], WO[3 * pixel + 2]);
        out = {name}(wi, wo) + 1.0;
      }}"""
    rendered = probe_osl(fitter.fit(glossy, 0, None), code, COUNT, write(model), WI=wi, WO=wo)
    expected = model.evaluate(np.arccos(z[0]), phi[0], np.arccos(z[1]), phi[1])[:, 0]
    np.testing.assert_allclose(rendered[:, 0] - 1, expected, atol=2e-5)
