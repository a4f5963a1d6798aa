"""Files that hold no reflected light: they are refused, whatever their format, and nothing is fitted to them."""

import numpy as np
import pytest

import fitter
from fitter import Samples, cli
from fitter.formats import saved_samples
from support import tensor_files

ANGLES = np.radians(np.stack(np.meshgrid([10, 30, 50], [0], [0, 20, 40, 60], [0, 90, 180]))).reshape(4, -1)


def as_text(path, values, names, angles):
    rows = np.column_stack([*angles, values])
    path.write_text(f"{names},R,G,B\n" + "".join(",".join(f"{x:.9g}" for x in row) + "\n" for row in rows))


def as_table(path, values):
    as_text(path, values, "theta_i[deg],phi_i[deg],theta_o[deg],phi_o[deg]", np.degrees(ANGLES))


def as_astm(path, values):
    as_text(path, values, "VARS theta_i,phi_i,theta_s,phi_s", ANGLES)


def as_saved(path, values):
    saved_samples.write(Samples(*ANGLES, values, ("R", "G", "B")), path)


def as_tensors(path, values):
    arrays = tensor_files.material()
    signs = np.sign(values.mean(axis=0)).astype(np.float32)
    path.write_bytes(tensor_files.pack(arrays | {"rgb": arrays["rgb"] * signs[:, None, None]}))


WRITERS = [as_table, as_astm, as_saved, as_tensors]


@pytest.fixture
def values(random):
    return random.uniform(0.1, 0.3, (ANGLES.shape[1], 3))


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize(("factor", "found"), [(0, "0"), (-1, "0 or below"), ((-1, 0, -1), "0 or below")])
def test_a_file_without_a_value_above_0_is_refused_in_one_line_that_names_it(tmp_path, values, capsys, write, factor,
                                                                             found):
    path, out = tmp_path / "nothing.bsdf", tmp_path / "fit.npz"
    write(path, values * factor)
    for command in (["info", str(path)], ["fit", str(path), "-o", str(out)]):
        assert cli.main(command) == 1
        told = capsys.readouterr().err
        assert told.startswith(f"error: {path}: all ")
        assert told.endswith(f"values are {found}, expected reflected light: some above 0\n")
    assert not out.exists()


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize("factor", [(0, 0, 1), (-1, 1, 0)])
def test_channels_that_are_black_or_below_0_are_data(tmp_path, values, write, factor):
    path = tmp_path / "black channels.bsdf"
    write(path, values * factor)
    signs = np.sign(fitter.load(path).values)
    np.testing.assert_array_equal(signs, np.broadcast_to(factor, signs.shape))


def test_one_value_above_0_is_enough(tmp_path, values):
    path = tmp_path / "dark.csv"
    as_table(path, np.where(np.arange(len(values))[:, None] == 7, 0.01, -0.001 * values))
    assert len(fitter.load(path)) == len(values)
