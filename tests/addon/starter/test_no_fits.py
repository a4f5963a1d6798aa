"""An asset library of ready fits, where there are none, is an error and not an empty file."""

from pathlib import Path

import measured_brdf
import pytest
from measured_brdf.addon.core.libraries.library_file import LibraryError
from measured_brdf.addon.starter import starter
from measured_brdf.fitter.library import ready


def test_where_no_fit_has_been_made_there_is_no_library(extension, tmp_path, monkeypatch):
    root = Path(measured_brdf.__file__).parent
    assert root / "starter_library" / "fits" == ready.FOLDER
    monkeypatch.setattr(ready, "FOLDER", tmp_path)
    with pytest.raises(LibraryError, match="no fit of the library"):
        list(starter.build(tmp_path / "library", only_ready=True))
    assert not (tmp_path / "library").exists()
