import pytest

from support import panel_work


def test_the_values_that_were_used_last_are_kept():
    gone = []
    recent = panel_work.load().Recent(2, gone.append)
    recent["a"], recent["b"] = 1, 2
    assert recent["a"] == 1
    recent["c"] = 3
    assert ([*recent.items()], gone) == ([("a", 1), ("c", 3)], ["b"])
    recent["a"] = 4                     # writing is a use, looking is none
    assert recent.get("c") == 3
    assert "c" in recent
    recent["d"] = 5
    assert ([*recent.items()], gone) == ([("a", 4), ("d", 5)], ["b", "c"])
    with pytest.raises(KeyError):
        recent["c"]
