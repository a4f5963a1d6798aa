"""What photographs are judged by, in words and by the exit status: those of balls and of flat samples alike."""

import numpy as np
import pytest

import fitter
from fitter import cli
from fitter.photographs.ball import coverage
from support import ball_files, ball_scene, flat_files, flat_scene

NAMES = [f"lamp{number}.exr" for number in range(1, 9)]
LAMPS = flat_scene.lamps(len(NAMES))
PHASES = 15, 40, 70, 100, 130


@pytest.fixture(scope="module")
def paints(cornell):
    return [fitter.fit(cornell(name), **fitter.PRESETS["Draft"]) for name in ("garnet_red_RGB", "krylon_blue_RGB")]


@pytest.fixture(scope="module")
def flat(openimageio, paints, tmp_path_factory):
    """The folder of photographs of a flat sample of two materials, which are saved beside them."""
    folder = tmp_path_factory.mktemp("flat")
    for fit, name in zip(paints, "ab", strict=True):
        fit.save(folder / f"{name}.npz")
    sample = flat_scene.Sample(tuple(paints), flat_scene.smooth_weights(2), flat_scene.bumps)
    return flat_files.write(folder, sample, LAMPS).parent


@pytest.fixture(scope="module")
def ball(openimageio, paints, tmp_path_factory):
    """The description of photographs of a ball."""
    scenes = [ball_scene.at_phase(angle, turn=50 * k) for k, angle in enumerate(PHASES)]
    return ball_files.write(tmp_path_factory.mktemp("ball"), paints[0], scenes)


@pytest.fixture(autouse=True)
def short_advice(monkeypatch):
    """The place of a next lamp, of which nothing is asked here, is found by few samples."""
    monkeypatch.setattr(coverage, "_SAMPLES", 200)


@pytest.fixture
def run(capsys, tmp_path):
    """Run a command on a description: its exit code, its lines, and those with a mark."""
    def run(command, path):
        code = cli.main([command, str(path), "-o", str(tmp_path / "out.npz")])
        told = capsys.readouterr()
        lines = (told.err if code == 1 else told.out).splitlines()
        return code, lines, [line for line in lines if line.endswith("(!)")]
    return run


def described(folder, names=NAMES, lamps=LAMPS, texels=20, **how):
    path = folder / "setup.toml"
    top = f"texels = {texels}\nmaterials = ['a.npz', 'b.npz']"
    path.write_text(flat_files.description(names, lamps, top=top, **how))
    return path


def predicted(lines):
    """The share by which a photograph is missed, and its grade."""
    line, = [line for line in lines if "is predicted within" in line]
    number, _, words = line.partition("is predicted within ")[2].partition("%: ")
    return float(number) / 100, words.split(".")[0]


def test_flat_photographs_that_are_described_rightly_are_good_and_exit_0(flat, run):
    code, lines, doubts = run("flat", described(flat))
    missed, grade = predicted(lines)
    assert (code, grade, doubts) == (0, "excellent", [])
    assert 0.005 < missed < 0.05            # the noise is 1 %


@pytest.mark.parametrize("lamps", [np.roll(LAMPS, 3, axis=0), LAMPS + 0.06 * np.random.default_rng(1).normal(
    size=LAMPS.shape)], ids=["shuffled", "5 degrees"])
def test_flat_photographs_with_lamps_elsewhere_are_not_predicted_and_exit_3(flat, run, lamps, tmp_path):
    code, lines, doubts = run("flat", described(flat, lamps=lamps, texels=14))
    missed, grade = predicted(lines)
    assert (code, grade) == (cli.BAD, "poor") == (3, "poor")
    assert missed > 0.2
    assert "So the photographs are not predicted: lamps" in doubts[0]
    assert "not predicted" in (tmp_path / "out.npz" / "report.txt").read_text("utf-8"), "the result is written"


def test_one_photograph_many_times_is_told(flat, run):
    code, _, doubts = run("flat", described(flat, names=NAMES[:1] * len(NAMES), texels=6))
    assert code == 3
    assert "7 of 8 photographs repeat the picture of another one, lamp1.exr for one" in doubts[0]


def test_what_is_read_or_is_somebody_elses_is_not_written_over(flat, ball, tmp_path, capsys):
    for name in (ball.name, "lamp1.exr", "card.exr"):
        before = ball.with_name(name).read_bytes()
        assert cli.main(["photographs", str(ball), "-o", str(ball.with_name(name))]) == 1
        assert f"{name}: is read, and would be replaced" in capsys.readouterr().err
        assert ball.with_name(name).read_bytes() == before
    command, mine = ["flat", str(described(flat)), "-o", str(tmp_path)], tmp_path / "mask-2.png"
    mine.write_text("drawn by hand")
    assert cli.main(command) == 1
    assert f"{tmp_path}: mask-2.png: not written by an earlier run, or changed since" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mask-2.png"]
    mine.unlink()
    assert cli.main(command) == cli.main(command) == 0
    mine.write_text("painted over")
    assert cli.main(command) == 1
    assert mine.read_text() == "painted over"


def test_a_flat_sample_that_reflects_more_than_it_gets_is_told(flat, run):
    """Millimetres for metres: the maps are as good as ever."""
    places = [[round(float(x), 3) for x in place] for place in flat_files.corners()]
    code, lines, doubts = run("flat", described(
        flat, lamps=1000 * LAMPS, sample=f"width = 100\nheight = 80\ncorners = {places}"))
    assert predicted(lines)[1] == "excellent"
    assert code == 3
    assert len(doubts) == 1
    assert doubts[0].startswith("More light leaves than arrives")
    assert 1e4 < float(doubts[0].split()[5]) < 2e5           # a million times some percent


def test_a_guess_says_the_largest_albedo_that_there_can_be(flat, run):
    code, _, doubts = run("flat", described(flat, scale="albedo = 0.9", texels=10))
    doubt, = [each for each in doubts if each.startswith("More light leaves than arrives")]
    largest = float(doubt.partition("an albedo of ")[2].split()[0])
    assert code == 3
    assert 0.2 < largest < 0.9
    _, _, doubts = run("flat", described(flat, scale=f"albedo = {0.98 * largest:.2g}", texels=10))
    assert not [each for each in doubts if each.startswith("More light leaves than arrives")]


def test_a_black_photograph_is_refused_with_its_name(flat, ball, run, tmp_path):
    ball_files.write_picture(flat / "black.exr", np.zeros((*flat_files.SIZE, 3)))
    ball_files.write_picture(ball.with_name("black.exr"), np.zeros((120, 120, 3)))
    other = ball.with_name("with_black.toml")
    other.write_text(ball.read_text("utf-8").replace("lamp3.exr", "black.exr"), "utf-8")
    for command, path in (("flat", described(flat, names=[*NAMES[:3], "black.exr", *NAMES[4:]])),
                          ("photographs", other)):
        code, (line,), _ = run(command, path)
        assert code == 1
        assert line.startswith(f"error: {path.with_name('black.exr')}: a black photograph: ")
    assert not list(tmp_path.iterdir())


def test_black_arrays_are_refused_too(flat):
    rays = flat_scene.rays((20, 20))
    shots = [fitter.FlatPhotograph(np.full((20, 20, 3), value), rays, flat_scene.CAMERA, lamp, np.ones(3), name=name)
             for value, lamp, name in ((0.3, LAMPS[0], "grey"), (0.0, LAMPS[1], "night"))]
    with pytest.raises(fitter.DatasetError, match="night: a black photograph"):
        fitter.maps_from_flat(shots, flat_scene.corners(), (4, 4))


def test_a_ball_is_judged_by_a_photograph_that_others_surround_whatever_their_order(openimageio, paints, run, tmp_path):
    """In the same words. Nobody knows what is beyond the largest phase angle."""
    scenes = [ball_scene.at_phase(angle, turn=50 * k) for k, angle in enumerate((15, 70, 130, 100, 40))]
    code, lines, doubts = run("photographs", ball_files.write(tmp_path / "ball", paints[0], scenes))
    assert (code, doubts) == (0, [])
    assert predicted(lines)[1] in ("excellent", "good")
    assert any(line.startswith("  Without lamp2.exr, ") for line in lines)


@pytest.mark.parametrize("command", ["flat", "photographs"])
def test_two_photographs_say_that_they_are_not_judged(flat, paints, run, tmp_path, command):
    path = (described(flat, names=NAMES[:2], lamps=LAMPS[:2], texels=6) if command == "flat" else
            ball_files.write(tmp_path / "ball", paints[0], [ball_scene.at_phase(angle) for angle in (15, 70)]))
    code, lines, doubts = run(command, path)
    assert (code, doubts) == (0, [])
    assert len([line for line in lines if "described rightly is not judged: two others" in line]) == 1


def test_a_ball_with_lamps_elsewhere_is_not_predicted(ball, run):
    """By 10 degrees: lamps that are farther off are refused, because the ball's lit edge is elsewhere."""
    random, lines = np.random.default_rng(0), []
    for line in ball.read_text("utf-8").splitlines():
        if line.startswith("lamp = ["):
            lamp = np.array(list(map(float, line[8:-1].split(","))))
            off = np.radians(10) * np.linalg.norm(lamp) * random.normal(0, 0.7, 3)
            line = f"lamp = {(lamp + off).tolist()}"
        lines.append(line)
    other = ball.with_name("beside.toml")
    other.write_text("\n".join(lines), "utf-8")
    code, lines, doubts = run("photographs", other)
    missed, grade = predicted(lines)
    assert (code, grade) == (3, "poor")
    assert missed > 0.2
    assert "So the photographs are not predicted" in doubts[0]
