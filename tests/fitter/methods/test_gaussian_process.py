"""The Gaussian process, against the textbook's formulas written out, SciPy's densities, and fits without a sample."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from fitter.coordinates import stretch
from fitter.methods import gaussian_process
from fitter.methods.gaussian_process import CHOICES, RECIPROCITY, Kernel, Search, krige, log_likelihood

KERNELS = [Kernel(), Kernel(length=0.2, elongation=2.5, ratio=6.0, share=0.5), Kernel(length=1.3, elongation=0.7)]
every_kernel = pytest.mark.parametrize("kernel", KERNELS, ids=range(len(KERNELS)))
IMAGES = (1, 1, 1), (1, 1, -1), (-1, -1, 1), (-1, -1, -1)


@pytest.fixture
def mu(random):
    """Coordinates as directions have them: (40, 3)."""
    return random.random((40, 3)) * [1, 2, 1] - [0, 1, 0]


def matern(r):
    """Rasmussen and Williams, equation 4.17, of length 1."""
    return (1 + np.sqrt(5) * r + 5 * r ** 2 / 3) * np.exp(-np.sqrt(5) * r)


def brute_correlation(a, b, kernel):
    """The covariance of one pair of points, image by image."""
    total = 0.0
    for image in IMAGES:
        for exchange, weight in ((1, 1 - RECIPROCITY / 2), (-1, RECIPROCITY / 2)):
            other = b[0] * image[0], b[1] * image[1] * exchange, b[2] * image[2]
            lengths = kernel.length * kernel.elongation, kernel.length, kernel.length
            distance = sum(((p - q) / length) ** 2 for p, q, length in zip(a, other, lengths, strict=True)) ** 0.5
            far = (1 - kernel.share) * matern(distance / kernel.ratio)
            total += weight / 4 * (kernel.share * matern(distance) + far)
    return total


def covariance(mu, kernel, noise=0.0):
    return np.array([[brute_correlation(a, b, kernel) for b in mu] for a in mu]) + noise * np.eye(len(mu))


@every_kernel
def test_the_correlation_is_the_sum_over_images(mu, random, kernel):
    other = random.random((7, 3)) * [1, 2, 1] - [0, 1, 0]
    expected = [[brute_correlation(a, b, kernel) for b in other] for a in mu]
    np.testing.assert_allclose(kernel.correlation(mu, other), expected, atol=1e-7)
    single = kernel.correlation(mu.astype(np.float32), other.astype(np.float32))
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, expected, atol=1e-3)


@every_kernel
def test_a_kernel_is_a_covariance(mu, kernel):
    found = kernel.correlation(mu, mu)
    np.testing.assert_allclose(found, found.T, atol=1e-12)
    assert np.linalg.eigvalsh(found + 1e-9 * np.eye(len(mu))).min() > 0


@every_kernel
def test_kriging_is_the_textbooks_formula_and_has_the_symmetries_of_the_lattice(mu, random, kernel):
    probe = random.random((5, 3)) * [1, 2, 1] - [0, 1, 0]
    z, noise = random.standard_normal((len(mu), 2)), 0.01 + 0.1 * random.random(len(mu))
    cross = np.array([[brute_correlation(a, b, kernel) for b in mu] for a in probe])
    field, _ = krige(mu, z, kernel, noise)
    np.testing.assert_allclose(field.at(probe), cross @ np.linalg.inv(covariance(mu, kernel) + np.diag(noise)) @ z,
                               atol=1e-5)
    for image in IMAGES:
        np.testing.assert_allclose(field.at(probe * image), field.at(probe), atol=1e-9)


def test_a_field_is_nearly_that_of_the_exchanged_directions(mu, random):
    """One sample far from its images: the reciprocal pair follows it by the ratio of the weights."""
    kernel = Kernel(length=0.05, ratio=1.0)
    field, _ = krige(np.array([[0.6, 0.5, 0.5]]), np.array([[1.0]]), kernel, np.zeros(1))
    there, exchanged = field.at(np.array([[0.6, 0.5, 0.5], [0.6, -0.5, 0.5]]))[:, 0]
    assert there == pytest.approx(1)
    assert exchanged == pytest.approx(RECIPROCITY / (2 - RECIPROCITY), rel=1e-3)


@every_kernel
def test_what_is_said_of_left_out_samples_is_the_fit_without_each(mu, random, kernel):
    z, noise = random.standard_normal((len(mu), 2)), 0.01 + 0.1 * random.random(len(mu))
    _, left_out = krige(mu, z, kernel, noise)
    for number in range(len(mu)):
        others = np.arange(len(mu)) != number
        field, _ = krige(mu[others], z[others], kernel, noise[others])
        np.testing.assert_allclose(field.at(mu[[number]])[0], left_out[number], rtol=1e-6, atol=1e-8)


@every_kernel
@pytest.mark.parametrize("channels", [1, 3])
def test_the_likelihood_is_scipys_at_the_likeliest_variance(mu, random, kernel, channels):
    matrix = covariance(mu, kernel, 0.05)
    z = random.standard_normal((len(mu), channels)) * 10.0 ** np.arange(channels)

    def log_density(variance, values):
        """Of each value, without the constants."""
        of_all = stats.multivariate_normal(cov=variance * matrix).logpdf(values)
        return of_all / len(mu) + 0.5 * np.log(2 * np.pi) + 0.5

    likeliest = [values @ np.linalg.solve(matrix, values) / len(mu) for values in z.T]
    best = [log_density(variance, values) for variance, values in zip(likeliest, z.T, strict=True)]
    assert log_likelihood(matrix, z) == pytest.approx(np.mean(best), rel=1e-6, abs=1e-9)
    for factor in (0.9, 1.1):
        assert all(log_density(factor * variance, values) < value
                   for variance, values, value in zip(likeliest, z.T, best, strict=True))


def test_a_matrix_that_is_no_covariance_is_infinitely_unlikely():
    assert log_likelihood(np.array([[1.0, 2.0], [2.0, 1.0]]), np.ones((2, 1))) == -np.inf


def drawn(random, kernel, count, channels=3):
    """Points, and values of a field that has the kernel: (count, 3) and (count, channels)."""
    mu = random.random((count, 3)) * [1, 2, 1] - [0, 1, 0]
    root = np.linalg.cholesky(kernel.correlation(mu, mu) + kernel.noise * np.eye(count))
    return mu, root @ random.standard_normal((count, channels))


@pytest.mark.parametrize("noise", [1e-5, 1e-2])
def test_a_search_finds_a_kernel_as_likely_as_the_one_that_made_the_samples(random, noise):
    truth = Kernel(stretch=0.0, length=0.8, elongation=1.0, ratio=3.5, share=0.5, noise=noise)
    mu, z = drawn(random, truth, 250)
    value, found, number = Search(lambda _: mu, [z], [0.0], np.zeros(len(mu))).best(Kernel())
    assert number == 0

    def likelihood(kernel):
        return log_likelihood(kernel.correlation(mu, mu) + kernel.noise * np.eye(len(mu)), z)

    assert value == pytest.approx(likelihood(found), abs=2e-3)          # the search is in single precision
    assert value >= likelihood(Kernel())
    assert value > likelihood(truth) - 0.03                             # and its steps are of one number at a time
    assert noise / 10.1 <= found.noise <= noise * 10.1


def test_a_search_finds_the_stretch_that_made_the_samples(random):
    """The field is one of stretched coordinates: its variation is near 0."""
    x = 10 ** (-2 * random.random(200)) * np.where(random.random(200) < 0.5, -1, 1)
    plain = np.stack([random.random(200), x, 0 * x], axis=1)

    def encode(k):
        return np.stack([plain[:, 0], *stretch.stretched(plain[:, 1], plain[:, 2], k)], axis=1)

    truth = Kernel(stretch=33.0, length=0.5, elongation=2.5, noise=1e-4)
    root = np.linalg.cholesky(truth.correlation(encode(33.0), encode(33.0)) + 1e-4 * np.eye(200))
    search = Search(encode, [root @ random.standard_normal((200, 3))], [0.0], np.zeros(200))
    assert search.best(Kernel())[1].stretch >= 12


def test_a_search_takes_the_likelier_prior_unless_its_penalty_is_larger(random):
    mu, z = drawn(random, Kernel(length=0.8, noise=1e-3), 150)
    candidates = [z + 0.3 * random.standard_normal(z.shape), z]
    for penalty, expected in ((0.0, 1), (100.0, 0)):
        search = Search(lambda _: mu, candidates, [0.0, penalty], np.zeros(len(mu)))
        value, _, number = search.best(Kernel())
        assert number == expected
        assert value > -100


def test_noise_of_single_samples_counts(random):
    """A sample of much noise hardly changes the likelihood of a kernel, whatever its value."""
    mu, z = drawn(random, Kernel(length=0.8, noise=1e-3), 100, 1)
    wrong = z.copy()
    wrong[7] += 100
    noise = np.where(np.arange(100) == 7, 1e8, 0.0)
    values = [Search(lambda _: mu, [values], [0.0], noise).best(Kernel())[0] for values in (z, wrong)]
    assert values[0] == pytest.approx(values[1], abs=1e-2)


def test_each_number_of_a_kernel_moves_among_its_choices():
    kernel = Kernel()
    for name, choices in CHOICES.items():
        assert list(choices) == sorted(choices)
        at = choices.index(getattr(kernel, name))
        assert getattr(kernel.moved(name, 1), name) == choices[at + 1]
        assert getattr(kernel.moved(name, -1), name) == choices[at - 1]
        assert replace(kernel, **{name: choices[-1]}).moved(name, 1) is None
        assert replace(kernel, **{name: choices[0]}).moved(name, -1) is None
    assert {name for name, _ in kernel.neighbours()} == set(CHOICES)


def test_large_sets_are_subsampled_without_repetition():
    most = gaussian_process.MOST_SAMPLES
    chosen = gaussian_process.choice(most + 1000)
    assert len(set(chosen.tolist())) == most
    assert (np.diff(chosen) > 0).all()
    np.testing.assert_array_equal(chosen, gaussian_process.choice(most + 1000))


def test_between_samples_of_very_different_values_a_field_does_not_overshoot(random):
    """A step from -3 to 11, as at a peak of 3,000 / sr: the plain mean exceeds both by more than log 2."""
    mu = random.random((150, 3))
    z = np.where(np.linalg.norm(mu - 0.5, axis=1) < 0.3, 11.0, -3.0)[:, None]
    kernel = Kernel(length=0.8, elongation=1.0, share=0.05, noise=1e-6)
    field, _ = krige(mu, z, kernel, np.full(len(mu), kernel.noise))
    probe = random.random((2000, 3))
    plain, bounded = kernel.correlation(probe, mu) @ field.weights, field.at(probe)
    highest, lowest = field.at_samples.max() + np.log(2), field.at_samples.min() - np.log(2)
    assert bounded.max() < highest + 1e-9 < plain.max()
    assert bounded.min() > lowest - 1e-9 > plain.min()
    moderate = (plain > -3) & (plain < 0)
    assert moderate.any()
    np.testing.assert_allclose(bounded[moderate], plain[moderate], atol=1e-9)


def test_the_nearest_samples_are_those_of_a_brute_search_over_their_images(mu, random):
    kernel, probe = Kernel(length=0.3, elongation=2.5), random.random((9, 3)) * [1, 2, 1] - [0, 1, 0]
    scale = kernel.length * np.array([kernel.elongation, 1, 1])
    images = [np.array(image) * [1, exchange, 1] for image in IMAGES for exchange in (1, -1)]
    for point, found in zip(probe, kernel.nearest(probe, mu, 5), strict=True):
        distance = [min(np.linalg.norm((point - sample * image) / scale) for image in images) for sample in mu]
        assert set(found) == set(np.argsort(distance)[:5])
