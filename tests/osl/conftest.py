import pytest

from support.osl_probe import probe_osl


@pytest.fixture
def probe(blender):
    return probe_osl
