"""Which device renders a scene: what Cycles makes of its settings, the preferences and the command line."""

import sys
from types import SimpleNamespace

import pytest
from measured_brdf.addon.core.blender import device as module

GPU = ("Some GPU", "OPTIX", "OPTIX_1")
LISTED = {"OPTIX": [("Some CPU", "CPU", "CPU"), GPU], "CUDA": [("Some CPU", "CPU", "CPU")]}


@pytest.fixture
def device(extension):
    """The module, which has listed no device yet."""
    module._available.cache_clear()
    yield module
    module._available.cache_clear()


@pytest.fixture
def asked(device, monkeypatch):
    """The types of devices that were listed; this machine has those of LISTED."""
    types = []
    fake = SimpleNamespace(available_devices=lambda kind: types.append(kind) or LISTED[kind])
    monkeypatch.setitem(sys.modules, "_cycles", fake)
    return types


def prefer(device, monkeypatch, kind, used=("OPTIX_1", "CPU")):
    devices = [SimpleNamespace(id=name, use=name in used) for name in ("OPTIX_1", "CUDA_1", "CPU")]
    preferences = SimpleNamespace(compute_device_type=kind, devices=devices)
    addons = {} if kind is None else {"cycles": SimpleNamespace(preferences=preferences)}
    context = SimpleNamespace(preferences=SimpleNamespace(addons=addons))
    monkeypatch.setattr(device, "bpy", SimpleNamespace(context=context))


def scene(wanted="GPU"):
    return SimpleNamespace(cycles=SimpleNamespace(device=wanted))


@pytest.mark.parametrize(("kind", "used", "wanted", "found"), [
    ("OPTIX", ("OPTIX_1",), "GPU", "OPTIX"),
    ("OPTIX", ("OPTIX_1", "CPU"), "GPU", "OPTIX"),
    ("OPTIX", ("OPTIX_1",), "CPU", "CPU"),
    ("OPTIX", ("CPU",), "GPU", "CPU"),              # no device of the type is in use
    ("OPTIX", (), "GPU", "CPU"),
    ("CUDA", ("CUDA_1",), "GPU", "CPU"),            # the card is no longer there
    ("NONE", ("OPTIX_1",), "GPU", "CPU"),
    ("", ("OPTIX_1",), "GPU", "CPU"),
    (None, ("OPTIX_1",), "GPU", "CPU"),             # Cycles is not enabled
])
def test_the_device_is_the_one_that_cycles_takes(device, asked, monkeypatch, kind, used, wanted, found):
    prefer(device, monkeypatch, kind, used)
    assert device.effective_device(scene(wanted)) == found
    assert device.renders_on_gpu(scene(wanted)) == (found != "CPU")


@pytest.mark.parametrize(("arguments", "found"), [
    (["blender", "--", "--cycles-device", "HIP"], "HIP"),
    (["blender", "-b", "--", "--other", "--cycles-device=OPTIX+CPU"], "OPTIX"),
    (["blender", "--", "--cycles-device", "CPU"], "CPU"),
    (["blender", "--cycles-device", "HIP"], "CUDA"),            # not for Cycles
    (["blender", "--", "--cycles-device"], "CUDA"),
])
def test_the_command_line_overrides_scene_and_preferences(device, monkeypatch, arguments, found):
    prefer(device, monkeypatch, "CUDA", ("CUDA_1",))
    monkeypatch.setattr(device, "_available", lambda kind: {"CUDA_1"})
    monkeypatch.setattr(sys, "argv", arguments)
    assert device.effective_device(scene()) == found


def test_devices_are_listed_once_and_only_where_a_scene_wants_a_gpu(device, asked, monkeypatch):
    prefer(device, monkeypatch, "OPTIX")
    device.effective_device(scene("CPU"))
    assert asked == []
    for _ in range(3):
        device.effective_device(scene())
    assert asked == ["OPTIX"]


def test_a_scene_of_this_blender_is_rendered_on_its_cpu(blender, device):
    """Real settings and preferences, none of them faked."""
    scene = blender.context.scene
    assert device.effective_device(scene) == "CPU"
    assert not device.renders_on_gpu(scene)
