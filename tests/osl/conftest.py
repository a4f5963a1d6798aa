import pytest

import fitter
from support.osl_probe import probe_osl


@pytest.fixture
def probe(blender):
    return probe_osl


@pytest.fixture(scope="session")
def standard(curet, cornell):
    """Standard's fit of a sample of CURET, or of a file of Cornell, by its name."""
    def fit(name):
        samples = cornell(name) if name in ("krylon_blue_RGB", "cayman") else curet(name)
        return fitter.fit(samples, **fitter.PRESETS["Standard"])
    return fit
