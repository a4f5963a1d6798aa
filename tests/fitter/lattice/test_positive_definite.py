"""Inverses by Cholesky factors against NumPy's inverse."""

import numpy as np
import pytest

from fitter.lattice.positive_definite import inverse_root


@pytest.mark.parametrize("size", [1, 5, 97, 400])
def test_the_root_of_the_inverse_is_a_triangle_whose_square_is_the_inverse(random, size):
    factor = random.standard_normal((size, size + 3))
    matrix = factor @ factor.T
    root = inverse_root(matrix)
    assert (root == np.tril(root)).all()
    np.testing.assert_allclose(matrix @ root.T @ root, np.eye(size), atol=1e-6)


def test_a_matrix_that_is_not_positive_definite_is_refused():
    with pytest.raises(np.linalg.LinAlgError):
        inverse_root(np.array([[1.0, 2.0], [2.0, 1.0]]))
