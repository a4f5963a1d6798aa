import numpy as np
import pytest

import fitter
from fitter.errors import SampleUnknownError
from fitter.formats import list_samples
from fitter.model import published

TABLE = """# of one's own
name,scattering,absorption,index,width

My marble,2.19 2.62 3.00,0.0021 0.0041 0.0071,1.5,0.1
,1,0,,
"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "media.csv"
    path.write_text(TABLE)
    return path


def test_a_row_is_a_material(path):
    assert list_samples(path) == [(1, "My marble"), (2, "Line 5")]
    first, second = fitter.load(path), fitter.load(path, 2)
    np.testing.assert_allclose(first.subsurface.albedo, published.find("marble").model.subsurface.albedo)
    assert (first.name, first.subsurface.index) == ("My marble", 1.5)
    assert second.subsurface.albedo.tolist() == [1, 1, 1]
    assert fitter.load(path, "my marble").name == "My marble"
    with pytest.raises(SampleUnknownError, match="no sample 3, expected a number from 1 to 2"):
        fitter.load(path, 3)


def test_the_librarys_own_table_is_one():
    path = published._DATA / "translucent.csv"
    assert [name for _, name in list_samples(path)] == [each.name for each in published.translucent()]
    np.testing.assert_array_equal(fitter.load(path, "ketchup").values, fitter.load("published:ketchup").values)


@pytest.mark.parametrize(("old", "new", "expected"), [
    ("2.62", "x", "media.csv:4: scattering '2.19 x 3.00', expected three numbers"),
    ("0.0041", "-1", "media.csv:4: scattering .* expected numbers of at least 0"),
    ("1.5", "0.5", r"media.csv:4: index \[0.5\], expected 1.1 to 2"),
    ("My marble,2.19 2.62 3.00,0.0021 0.0041 0.0071,1.5,0.1\n,1,0,,\n", "", "media.csv: no rows below the names")])
def test_a_damaged_row_is_refused_with_its_line(path, old, new, expected):
    path.write_text(TABLE.replace(old, new))
    with pytest.raises(fitter.DatasetError, match=expected):
        fitter.load(path)
