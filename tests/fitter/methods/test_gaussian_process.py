"""The Gaussian process, against the textbook's formulas written out, SciPy's densities, and fits without a sample."""

import numpy as np
import pytest
from scipy import stats

from fitter.coordinates import stretch
from fitter.methods import gaussian_process
from fitter.methods.gaussian_process import LENGTHS, NOISES, RECIPROCITIES, TREND, Kernel, Search, krige, likelihood

KERNELS = [Kernel(), Kernel(length=0.3, noise=0.01), Kernel(length=2.8, noise=0.0, reciprocity=1.0)]
every_kernel = pytest.mark.parametrize("kernel", KERNELS, ids=range(len(KERNELS)))
IMAGES = (1, 1, 1), (1, 1, -1), (-1, -1, 1), (-1, -1, -1)


@pytest.fixture
def mu(random):
    """Coordinates as directions have them: (40, 3)."""
    return random.random((40, 3)) * [1, 2, 1] - [0, 1, 0]


def matern(r):
    """Rasmussen and Williams, equation 4.17, of length 1."""
    return (1 + np.sqrt(5) * r + 5 * r ** 2 / 3) * np.exp(-np.sqrt(5) * r)


def trend(a, b, kernel):
    """The part of the covariance that is no Matern kernel, of two points."""
    return TREND * (1 + a[0] * b[0] + (1 - kernel.reciprocity) * a[1] * b[1] + a[2] * b[2])


def brute_covariance(a, b, kernel):
    """The covariance of one pair of points, image by image."""
    total = trend(a, b, kernel)
    for image in IMAGES:
        for exchange, weight in ((1, 1 - kernel.reciprocity / 2), (-1, kernel.reciprocity / 2)):
            other = b[0] * image[0], b[1] * image[1] * exchange, b[2] * image[2]
            distance = np.linalg.norm(np.subtract(a, other)) / kernel.length
            total += weight / 4 * matern(distance)
    return total


def covariance(mu, kernel, noise=0.0):
    return np.array([[brute_covariance(a, b, kernel) for b in mu] for a in mu]) + noise * np.eye(len(mu))


@every_kernel
def test_the_covariance_is_the_sum_over_images(mu, random, kernel):
    other = random.random((7, 3)) * [1, 2, 1] - [0, 1, 0]
    expected = [[brute_covariance(a, b, kernel) for b in other] for a in mu]
    np.testing.assert_allclose(kernel.covariance(mu, other), expected, atol=1e-12)


def test_of_four_axes_exchanged_directions_have_one_value(random):
    """Exchanging the directions turns the difference vector, the last two of the coordinates."""
    mu, probe = random.uniform(-1, 1, (2, 9, 4))
    exchanged = probe * [1, 1, -1, -1]
    np.testing.assert_allclose(Kernel().covariance(mu, exchanged), Kernel().covariance(mu, probe), atol=1e-12)


@every_kernel
def test_a_kernel_is_a_covariance(mu, kernel):
    found = kernel.covariance(mu, mu)
    np.testing.assert_allclose(found, found.T, atol=1e-12)
    many = np.concatenate([mu] * 10)
    np.testing.assert_allclose(kernel.gram(many), kernel.covariance(many, many), atol=1e-12)
    assert np.linalg.eigvalsh(found + 1e-9 * np.eye(len(mu))).min() > 0


@every_kernel
def test_kriging_is_the_textbooks_formula(mu, random, kernel):
    probe = random.random((5, 3)) * [1, 2, 1] - [0, 1, 0]
    z, known = random.standard_normal((len(mu), 2)), 0.01 + 0.1 * random.random(len(mu))
    cross = np.array([[brute_covariance(a, b, kernel) for b in mu] for a in probe])
    matrix = covariance(mu, kernel, kernel.noise + gaussian_process._TINY) + np.diag(known)
    field, _ = krige(mu, z, kernel, known)
    np.testing.assert_allclose(field.predict(probe), cross @ np.linalg.inv(matrix) @ z, atol=1e-5)
    without = matrix - np.diag(known)
    np.testing.assert_allclose(field.at_samples, without @ np.linalg.inv(matrix) @ z, atol=1e-5)


@every_kernel
def test_what_is_said_of_left_out_samples_is_the_fit_without_each(mu, random, kernel):
    z, known = random.standard_normal((len(mu), 2)), 0.01 + 0.1 * random.random(len(mu))
    _, left_out = krige(mu, z, kernel, known)
    for number in range(len(mu)):
        others = np.arange(len(mu)) != number
        field, _ = krige(mu[others], z[others], kernel, known[others])
        np.testing.assert_allclose(field.predict(mu[[number]])[0], left_out[number], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("channels", [1, 3])
def test_the_likelihood_is_scipys_at_the_likeliest_variance(random, channels):
    """Of uncorrelated values: a search turns samples into these by the eigenvectors of their covariance."""
    variances = 10.0 ** random.uniform(-3, 1, 40)
    z = random.standard_normal((40, channels)) * 10.0 ** np.arange(channels)

    def log_density(variance, values):
        """Of each value, without the constants."""
        of_all = stats.norm(scale=np.sqrt(variance * variances)).logpdf(values).sum()
        return of_all / 40 + 0.5 * np.log(2 * np.pi) + 0.5

    likeliest = (z ** 2 / variances[:, None]).mean(axis=0)
    best = [log_density(variance, values) for variance, values in zip(likeliest, z.T, strict=True)]
    assert likelihood(variances, z ** 2) == pytest.approx(np.mean(best), rel=1e-9)
    for factor in (0.9, 1.1):
        assert all(log_density(factor * variance, values) < value
                   for variance, values, value in zip(likeliest, z.T, best, strict=True))


def drawn(random, kernel, mu, channels=3):
    """Values of a field that has the kernel, at points (n, 3): (n, channels)."""
    root = np.linalg.cholesky(covariance(mu, kernel, kernel.noise + 1e-9))
    return root @ random.standard_normal((len(mu), channels))


def full_likelihood(mu, z, kernel):
    """The mean over channels of SciPy's log-density of each value, at the likeliest variance, without the constants."""
    matrix = covariance(mu, kernel, kernel.noise)
    found = [stats.multivariate_normal(cov=matrix * (values @ np.linalg.solve(matrix, values) / len(mu))).logpdf(values)
             for values in z.T]
    return np.mean(found) / len(mu) + 0.5 * np.log(2 * np.pi) + 0.5


@pytest.mark.parametrize("noise", [1e-4, 1e-2])
def test_a_search_finds_the_kernel_that_made_the_samples(random, noise):
    truth, mu = Kernel(1.0, noise), random.random((150, 3)) * [1, 2, 1] - [0, 1, 0]
    z = drawn(random, truth, mu)
    likeliest = Search([mu], [z], [0.0], np.zeros(150)).maximise([0])
    assert likeliest.value == pytest.approx(full_likelihood(mu, z, likeliest.kernel), abs=1e-5)
    assert likeliest.value > full_likelihood(mu, z, truth) - 1e-3
    assert noise / 10.1 <= likeliest.kernel.noise <= noise * 10.1
    assert abs(LENGTHS.index(likeliest.kernel.length) - LENGTHS.index(1.0)) <= 1


@pytest.mark.parametrize("reciprocity", RECIPROCITIES)
def test_a_search_finds_whether_samples_are_reciprocal(random, reciprocity):
    half = random.random((100, 3))
    mu = np.concatenate([half, half * [1, -1, 1]])
    z = drawn(random, Kernel(1.0, 1e-3, reciprocity), mu)
    assert Search([mu], [z], [0.0], np.zeros(200)).maximise([0]).kernel.reciprocity == reciprocity


def test_a_search_finds_the_stretch_that_made_the_samples(random):
    """The field is one of stretched coordinates: its variation is near 0."""
    x = 10 ** (-2 * random.random(150)) * np.where(random.random(150) < 0.5, -1, 1)
    plain = np.stack([random.random(150), x, 0 * x], axis=1)

    def encode(k):
        return np.stack([plain[:, 0], *stretch.stretch_half_vector(plain[:, 1], plain[:, 2], k)], axis=1)

    stretches = 0.0, 2.0, 5.0, 12.0, 33.0
    z = drawn(random, Kernel(1.0, 1e-4), encode(33.0))
    search = Search([encode(k) for k in stretches], [z], [0.0], np.zeros(150))
    assert stretches[search.maximise(range(5)).system] >= 12


def test_a_search_takes_the_likelier_prior_unless_its_penalty_is_larger(random):
    mu = random.random((100, 3)) * [1, 2, 1] - [0, 1, 0]
    z = drawn(random, Kernel(0.8, 1e-3), mu)
    candidates = [z + 0.3 * random.standard_normal(z.shape), z]
    for penalty, expected in ((0.0, 1), (100.0, 0)):
        likeliest = Search([mu], candidates, [0.0, penalty], np.zeros(100)).maximise([0])
        assert likeliest.prior == expected
        assert likeliest.value > -100


def test_noise_of_single_samples_counts(random):
    """A sample of much noise hardly changes the likelihood of a kernel, whatever its value."""
    mu = random.random((100, 3)) * [1, 2, 1] - [0, 1, 0]
    z = drawn(random, Kernel(0.8, 1e-3), mu, 1)
    wrong = z.copy()
    wrong[7] += 100
    noise = np.where(np.arange(100) == 7, 1e8, 0.0)
    values = [Search([mu], [each], [0.0], noise).maximise([0]).value for each in (z, wrong)]
    assert values[0] == pytest.approx(values[1], abs=1e-2)


def test_choices_are_in_ascending_order():
    for choices in (LENGTHS, NOISES, RECIPROCITIES):
        assert list(choices) == sorted(choices)
        assert min(choices) > 0
