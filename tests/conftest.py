"""What the tests share: real data, synthetic truths, and the extension loaded as Blender loads it."""

import numpy as np
import pytest

from support import ball_files, checkout, kept

kept.keep("fitter")

collect_ignore = ["project/habits.py"]           # a script of its own; doctests would import it

MEASUREMENTS = ("curet/abrdf.dat", "curet/table.txt", "cornell/cayman.astm", "cornell/garnet_red.astm",
                "cornell/garnet_red.brdf", "cornell/garnet_red_RGB.astm", "cornell/krylon_blue.astm",
                "cornell/krylon_blue_RGB.astm")
# and what a command names to run them
APART = {"test_mitsuba": "tests/mitsuba", "test_rgl_values": "tests/mitsuba",
         "test_ball_in_mitsuba": "tests/mitsuba", "test_window": "tests/window"}


def pytest_ignore_collect(collection_path, config):
    """Leave out the tests that install something or take long, unless the command names them."""
    if collection_path.stem in APART and not any(APART[collection_path.stem] in argument for argument in config.args):
        return True
    return None


def pytest_sessionstart():
    """What no test has asked for in days goes."""
    kept.remove_unused()


@pytest.fixture(scope="session")
def data():
    """The folder of real measurements."""
    folder = checkout.measurements()
    missing = [name for name in MEASUREMENTS if not (folder / name).is_file()]
    if missing:
        pytest.skip(f"real measurements are absent from {folder}: {', '.join(missing)}; MEASURED_BRDF_DATA may name "
                    f"another folder")
    return folder


@pytest.fixture(scope="session")
def curet(data):
    """Load a CURET sample by number or name."""
    import fitter

    return lambda sample: fitter.load(data / "curet" / "abrdf.dat", sample)


@pytest.fixture(scope="session")
def cornell(data):
    """Load a Cornell file by its stem."""
    import fitter

    return lambda stem: fitter.load(data / "cornell" / f"{stem}.astm")


@pytest.fixture(scope="session")
def goniometer():
    """The path of a goniometer's file, by its name."""
    folder = checkout.measurements() / "goniometer"

    def path(name):
        if not (folder / name).is_file():
            pytest.skip(f"{name} is absent from {folder}")
        return folder / name
    return path


@pytest.fixture(scope="session")
def openimageio():
    """OpenImageIO: the folder where it is, if that had to be added to the path, or None."""
    folder = ball_files.add_openimageio()
    if folder is False:
        pytest.skip("OpenImageIO is absent")
    return folder


@pytest.fixture
def random():
    return np.random.default_rng(2002)


@pytest.fixture(scope="session")
def glossy():
    """A synthetic measurement: one Lafortune lobe over a Lambertian, in three channels, at scattered directions."""
    import fitter

    random = np.random.default_rng(1)
    count = 500                 # Gaussian processes take a time that grows with the cube of it
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, count)) * 0.98))
    phi_o = random.random(count) * 2 * np.pi
    cosine = (-np.sin(theta_i) * np.sin(theta_o) * np.cos(phi_o)) + np.cos(theta_i) * np.cos(theta_o)
    lobe = np.maximum(cosine, 0)[:, None] ** np.array([20.0, 18.0, 15.0])
    values = np.array([0.05, 0.08, 0.2]) / np.pi + np.array([0.5, 0.5, 0.4]) * lobe
    return fitter.Samples(theta_i, np.zeros(count), theta_o, phi_o, values, ("R", "G", "B"), "glossy", "synthetic")


@pytest.fixture(scope="session")
def write_astm():
    """Write measurements of red, green and blue as a Cornell file: write_astm(path, samples, name=None)."""

    def write(path, samples, name=None):
        table = np.column_stack([*samples.directions, samples.values])
        rows = [",".join(f"{number:.7f}" for number in row) for row in table]
        path.write_text("\n".join([f"SAMPLE_NAME {name or samples.name}", "VARS theta_i,phi_i,theta_s,phi_s,R,G,B",
                                   *rows]))
        return path

    return write


@pytest.fixture(scope="session")
def extension():
    """The checkout as the package that Blender makes of it, registered."""
    package = checkout.extension()
    kept.keep_all()
    package.register()
    yield package
    package.unregister()


@pytest.fixture
def blender(extension):
    """An empty .blend with the extension enabled, whose panels have asked nothing: the bpy module.

    Preferences stay: to read those of the factory takes five times as long, which a thousand tests would wait for.
    """
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    extension.addon.work.queue.forget(lambda _: True)       # what panels of other tests asked
    return bpy


@pytest.fixture
def fresh():
    """Nothing that was made before is used: for tests that replace what fits or mixtures depend on."""
    with kept.fresh():
        yield


_known = {}


@pytest.fixture
def quick(extension, monkeypatch):
    """Do work that is independent of the open file (fitting, baking, compiling) once for all tests."""
    from measured_brdf.addon.work import tasks
    from measured_brdf.fitter.imaging import pictures

    def remember(function):
        def remembered(*arguments, **more):
            key = repr((function.__module__, function.__name__, arguments))
            if key not in _known:
                _known[key] = function(*arguments, **more)
            return _known[key]
        return remembered

    for module, names in ((tasks, ["outcome", "rebake", "edit_surface"]),
                          (pictures, ["lit_sphere"])):
        for name in names:
            monkeypatch.setattr(module, name, remember(getattr(module, name)))
