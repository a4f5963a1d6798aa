import pytest

from support import ball_files


@pytest.fixture(scope="session")
def openimageio():
    """OpenImageIO: the folder where it is, if that had to be added to the path, or None."""
    folder = ball_files.add_openimageio()
    if folder is False:
        pytest.skip("OpenImageIO is absent")
    return folder
