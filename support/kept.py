"""What many tests need made once: fits, mixtures of closures, bytecode and pictures, kept in build/kept.

An entry lies under a hash of the code that makes it and of its arguments, for a version of Python, NumPy and Blender.
What depends on anything else (functions of a test, constants that a test replaced) is made anew: `fresh` says so.
"""

import dataclasses
import functools
import hashlib
import importlib
import io
import os
import pickle
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from .checkout import ROOT
from .evidence import FITS, digest

FOLDER = Path(os.environ.get("MEASURED_BRDF_KEPT") or ROOT / "build" / "kept")
_COPIES = "measured_brdf.fitter.", "fitter."
_KNOWN = "numpy", "builtins", "collections", "copyreg", "_codecs"
_UNUSED = 3 * 86400         # s, after which an entry goes
_LARGEST = 1 << 26          # bytes of an entry
_on = True


class _UnkeepableError(Exception):
    """An argument's meaning is not in its pickle."""


class _Pickler(pickle.Pickler):
    def persistent_id(self, item):
        if not isinstance(item, type) and not callable(item):
            return None
        module = getattr(item, "__module__", None) or ""
        for prefix in _COPIES:
            if module.startswith(prefix) and isinstance(item, type):
                return module.removeprefix(prefix), item.__qualname__
        if module.split(".")[0] in _KNOWN:
            return None
        raise _UnkeepableError


class _Unpickler(pickle.Unpickler):
    def __init__(self, file, package):
        super().__init__(file)
        self.package = package

    def persistent_load(self, name):
        module, qualname = name
        return functools.reduce(getattr, qualname.split("."), importlib.import_module(self.package + module))


def _pickled(item):
    stream = io.BytesIO()
    try:
        _Pickler(stream, protocol=5).dump(item)
    except (_UnkeepableError, pickle.PicklingError, TypeError, AttributeError):
        return None
    return stream.getvalue()


@functools.cache
def _code(measured=(*FITS, "fitter/cycles")):
    """A name of all code that fits, or of other files, and of what runs it.

    Processes that this one starts are told the digest: it takes as long to make as to start one.
    """
    variable = f"MEASURED_BRDF_DIGEST_{'_'.join(measured)}"
    root, _, known = os.environ.get(variable, "").rpartition(" ")
    if root != str(ROOT):
        known = digest(measured)
        os.environ[variable] = f"{ROOT} {known}"
    return f"{sys.version} {np.__version__} {known}".encode()


def _nameless(item):
    """Samples or a fit without what does not matter to their numbers; anything else as it is."""
    if not hasattr(item, "source") or not dataclasses.is_dataclass(item):
        return item
    return dataclasses.replace(item, name="", source="", **({"notes": ()} if hasattr(item, "notes") else {}))


def _named_as(item, result):
    """A fit that was made of samples of other names, with those of these."""
    if not hasattr(result, "source") or not dataclasses.is_dataclass(result):
        return result
    return dataclasses.replace(result, name=item.name, source=item.source)


def kept(function, code=_code):
    """A function of its arguments alone, as one that does its work once for all tests."""
    package = next((prefix for prefix in _COPIES if function.__module__.startswith(prefix)), _COPIES[-1])
    name = f"{function.__module__.removeprefix(package)}.{function.__qualname__}"

    @functools.wraps(function)
    def once(*arguments, **more):
        asked = _pickled((name, [*map(_nameless, arguments)], sorted(more.items()))) if _on else None
        if asked is None:
            return function(*arguments, **more)
        path = FOLDER / f"{hashlib.blake2b(code() + asked, digest_size=20).hexdigest()}.pickle"
        try:
            with path.open("rb") as file:
                result = _Unpickler(file, package).load()
            path.touch()
            return _named_as(arguments[0], result)
        except FileNotFoundError:
            pass
        result = function(*arguments, **more)
        made = _pickled(result)
        if made is not None and len(made) <= _LARGEST:
            FOLDER.mkdir(parents=True, exist_ok=True)
            beside = path.with_suffix(f".{os.getpid()}")
            beside.write_bytes(made)
            beside.replace(path)
        return result

    once.made_anew = function
    return once


def replace(module, name, code=_code):
    """Put a `kept` function in the place of one, also in modules that have imported it."""
    function = getattr(module, name)
    if hasattr(function, "made_anew"):
        return
    once = kept(function, code)
    for each in list(sys.modules.values()):
        if getattr(each, "__dict__", {}).get(name) is function:
            setattr(each, name, once)


def keep(package):
    """Have a copy of the fitter, "fitter" or "measured_brdf.fitter", make things once."""
    methods = importlib.import_module(f"{package}.methods")
    methods.METHODS.update({name: kept(function) for name, function in methods.METHODS.items()
                            if not hasattr(function, "made_anew")})
    for module, name in (("methods", "prepare"), ("cycles.node_mixture", "cycles_mixture"),
                         ("cycles.node_mixture", "node_mixtures"), ("cycles.principled", "principled")):
        replace(importlib.import_module(f"{package}.{module}"), name)
    replace(importlib.import_module(f"{package}.imaging.pictures"), "lit_sphere", lambda: _code(("fitter",)))


def keep_all():
    """Have the extension, loaded as `measured_brdf`, make things once: fits, mixtures, bytecode, in its workers too."""
    import bpy

    keep("measured_brdf.fitter")
    compiler, process = (importlib.import_module(f"measured_brdf.addon.{name}") for name in (
        "core.shading.compiler", "work.process"))
    code = (bpy.app.version_string + bpy.app.build_hash.decode()).encode() + Path(compiler.__file__).read_bytes()
    replace(compiler, "_bytecode", lambda: code)
    process._WORKER_SCRIPT = ROOT / "support" / "kept_worker.py"


def remove_unused():
    """Remove entries that no test has asked for lately."""
    for path in FOLDER.glob("*") if FOLDER.is_dir() else ():
        if path.stat().st_mtime < time.time() - _UNUSED:
            path.unlink(missing_ok=True)


@contextmanager
def fresh():
    """Make everything anew, where a test has replaced what it depends on."""
    global _on
    _on = False
    try:
        yield
    finally:
        _on = True
