import pytest


@pytest.fixture
def baked_once(extension, monkeypatch):
    """The first fit's shader for every fit: for tests that do not look at what is rendered."""
    from measured_brdf.addon.work import tasks

    made, bake = [], tasks._surface

    def baked(*arguments):
        if not made:
            made.append(bake(*arguments))
        return made[0]

    monkeypatch.setattr(tasks, "_surface", baked)
