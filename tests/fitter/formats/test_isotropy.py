"""Whether a material is isotropic: analytic ones in tables of one's own, with noise, holes, zeros and repeats."""

import numpy as np
import pytest

import fitter
from fitter import DatasetError
from fitter.formats import isotropy
from fitter.samples import Samples
from support import anisotropic as instruments

ISOTROPIC = {"matte": instruments.ggx(1, 1, 0.5, specular=0), "gloss": instruments.ggx(0.1, 0.1),
             "satin": instruments.ggx(0.3, 0.3), "mirror": instruments.ggx(0.03, 0.03, 0.05)}
ANISOTROPIC = {"GGX": instruments.ggx(), "GGX turned by 45": instruments.ggx(turn=np.pi / 4),
               "Ward": instruments.ward(), "Ward turned by 20": instruments.ward(turn=0.35)}
GRIDS = {"goniometer": instruments.goniometer(), "half a turn": instruments.goniometer(range(0, 180, 15)),
         "three rotations": instruments.grid([20, 50, 70], [0, 45, 90], range(0, 81, 10), range(0, 181, 20)),
         "in plane": instruments.grid([30, 60], range(0, 180, 10), range(0, 81, 5), [0, 180]),
         "scattered": instruments.scattered(2000, np.random.default_rng(5))}
grids = pytest.mark.parametrize("grid", GRIDS)


def found(truth, grid, noise=0.05, floor=0.0, holes=0.0, zeros=False, seed=0):
    """What is found of an instrument's samples: relative noise, noise relative to the mean, the share of holes."""
    random = np.random.default_rng(seed)
    directions = GRIDS[grid] if isinstance(grid, str) else grid
    kept = random.random(len(directions[0])) >= holes
    directions = [angle[kept] for angle in directions]
    values = truth(*directions)[:, :1]
    values = (values * (1 + noise * random.standard_normal(values.shape))
              + floor * values.mean() * random.standard_normal(values.shape))
    if zeros:
        values[directions[2] > np.median(directions[2])] = 0
    return isotropy.decide_isotropy(Samples(*directions, values))


@grids
@pytest.mark.parametrize("name", ISOTROPIC)
@pytest.mark.parametrize("how", [{}, {"noise": 0.2}, {"floor": 0.01}, {"holes": 0.5}, {"zeros": True}], ids=str)
def test_an_isotropic_material_is_isotropic_whatever_the_noise(grid, name, how):
    for seed in range(3):
        samples = found(ISOTROPIC[name], grid, **{"noise": 0.05, "seed": seed} | how)
        assert samples.isotropic
        assert "which agree: taken as isotropic" in samples.notes[0]


@grids
@pytest.mark.parametrize("name", ANISOTROPIC)
@pytest.mark.parametrize("how", [{}, {"noise": 0}, {"floor": 0.02}, {"noise": 0.2, "floor": 0.01, "holes": 0.3},
                                 {"zeros": True}], ids=str)
def test_an_anisotropic_material_is_not_in_any_frame(grid, name, how):
    for seed in range(3):
        samples = found(ANISOTROPIC[name], grid, **{"noise": 0.05, "seed": seed} | how)
        assert not samples.isotropic
        assert samples.notes[0].startswith("Anisotropic, measured at ")


@pytest.mark.parametrize("grid", ["goniometer", "half a turn"])
@pytest.mark.parametrize("name", ANISOTROPIC)
def test_most_of_it_may_be_missing(grid, name):
    assert not found(ANISOTROPIC[name], grid, holes=0.8, zeros=True).isotropic


@pytest.mark.parametrize(("along", "across", "isotropic"), [(0.25, 0.32, False), (0.3, 0.306, True)])
def test_what_rotation_changes_must_matter(along, across, isotropic):
    """The limit is 4.5 % of the BRDF, in the root mean square of cube roots: here 15 %, and 1.5 %."""
    assert found(instruments.ggx(along, across), "goniometer", noise=0).isotropic == isotropic


def test_a_lamp_that_drifts_makes_nothing_anisotropic(random):
    """By 2 % between rotations, everything at a rotation alike."""
    directions = GRIDS["goniometer"]
    rotation = np.unique(directions[1].round(6), return_inverse=True)[1]
    drift = 1 + 0.02 * random.standard_normal(rotation.max() + 1)
    samples = isotropy.decide_isotropy(Samples(*directions, ISOTROPIC["satin"](*directions) * drift[rotation][:, None],
                                               ("R", "G", "B")))
    assert samples.isotropic


@pytest.mark.parametrize("rotations", [[0, 90], [10, 100], [0, 180]])
def test_two_rotations_are_isotropic_and_told(rotations):
    directions = instruments.grid([20, 50], rotations, range(0, 81, 10), range(0, 360, 20))
    samples = found(ANISOTROPIC["GGX"], directions)
    assert samples.isotropic
    assert samples.notes == ("Measured at 2 rotations: taken as isotropic",)
    assert fitter.Samples(*directions, samples.values).isotropic


def test_of_one_rotation_nothing_is_said_or_worked_out(monkeypatch):
    monkeypatch.setattr(isotropy, "_compare_rotations", None)
    samples = Samples([0.5] * 3, [0.7] * 3, [0.1, 0.2, 0.3], [0, 1, 2], [[1], [2], [3]])
    assert isotropy.decide_isotropy(samples) is samples


def test_at_the_normal_there_are_no_rotations():
    directions = instruments.grid([0], range(0, 360, 10), [20, 40], [0, 60])
    samples = isotropy.decide_isotropy(Samples(*directions, np.ones((len(directions[0]), 1))))
    assert samples.isotropic
    assert samples.notes == ()


def test_directions_that_have_little_in_common_tell_nothing(curet):
    """CURET's geometry, as a table of one's own: 205 pairs, which follow the paths of a robot."""
    samples = curet("corduroy")
    assert samples.isotropic
    assert not any("rotation" in note for note in samples.notes)
    as_a_table = isotropy.decide_isotropy(Samples(*samples.directions, samples.values))
    assert as_a_table.isotropic
    assert as_a_table.notes == ("Measured at 22 rotations, but too few directions in common to compare them: taken as "
                                "isotropic",)


def test_repeated_measurements_tell_the_noise_of_few_directions(tmp_path):
    """Six directions at three rotations: by themselves too few, unless it is known how little they scatter."""
    directions = instruments.grid([45], [0, 40, 80], [35, 45, 60], [165, 180])
    values = instruments.ggx(0.3, 0.45, turn=0.5)(*directions)[:, 0]
    random = np.random.default_rng(1)

    def table(times, noise):
        rows = [",".join(f"{number:.8f}" for number in (*np.degrees(row[:4]), row[4] * (1 + noise * random.normal())))
                for row in np.column_stack([*directions, values]) for _ in range(times)]
        path = tmp_path / "few.csv"
        path.write_text("\n".join(["theta_i[deg],phi_i[deg],theta_o[deg],phi_o[deg],BRDF", *rows]))
        return fitter.load(path)

    assert table(1, 0).isotropic
    samples = table(4, 0.02)
    assert not samples.isotropic
    assert len(samples) == len(values)              # no two rotations are averaged
    np.testing.assert_allclose(samples.values[:, 0], values, rtol=0.05)
    assert table(4, 0.5).isotropic


def written(path, directions, values, before="", names="theta_i[deg],phi_i[deg],theta_o[deg],phi_o[deg],R,G,B"):
    rows = [",".join(f"{number:.6f}" for number in row) for row in np.column_stack([*np.degrees(directions), values])]
    path.write_text("\n".join([*([before] if before else []), names, *rows]))
    return path


@pytest.fixture
def table(tmp_path):
    def table(truth=ANISOTROPIC["GGX"], rotations=range(0, 91, 15), before="", apart=range(0, 360, 30), **options):
        directions = instruments.grid([20, 50], rotations, range(10, 81, 10), apart)
        return fitter.load(written(tmp_path / "brushed.csv", directions, truth(*directions), before), **options)
    return table


def test_tables_and_astm_files_are_examined_and_options_win(table, tmp_path):
    samples = table()
    assert not samples.isotropic
    assert samples.notes[-1] == "Anisotropic, measured at 7 rotations from 0 to 90 degrees"
    asked = table(isotropic=True)
    assert asked.isotropic
    assert asked.notes[-1] == "Taken as isotropic, as asked"
    even = table(ISOTROPIC["satin"], isotropic=False)
    assert not even.isotropic
    assert even.notes[-2:] == ("Taken as anisotropic, as asked",
                               "Anisotropic, measured at 7 rotations from 0 to 90 degrees")
    path = written(tmp_path / "brushed.astm", samples.directions, samples.values,
                   names="VARS theta_i[deg],phi_i[deg],theta_s[deg],phi_s[deg],R,G,B")
    assert not fitter.load(path).isotropic
    assert fitter.load(path).notes == samples.notes[-1:]
    with pytest.raises(DatasetError, match="isotropic 'yes' found, expected True or False"):
        fitter.load(path, isotropic="yes")


@pytest.mark.parametrize(("said", "symmetry"), [
    ("180 degrees", "half turn"), ("180°", "half turn"), ("mirror", "mirror"), ("Mirror", "mirror"),
    ("180 degrees and mirror", "half turn and mirror"), ("mirror, 180 deg", "half turn and mirror"), ("none", None)])
def test_a_table_says_its_symmetry(table, said, symmetry):
    samples = table(before=f"# symmetry: {said}")
    plain = table()
    assert len(samples) >= len(plain)
    assert (len(samples) > len(plain)) == (symmetry is not None)
    assert any(f"Symmetry, {symmetry}: {len(plain):,} samples stand for" in note
               for note in samples.notes) == (symmetry is not None)
    np.testing.assert_allclose(samples.values, ANISOTROPIC["GGX"](*samples.directions), rtol=1e-3)
    assert len(table(before=f"# symmetry: {said}", symmetry="none")) == len(plain)


def test_an_asked_symmetry_wins_over_the_tables(table):
    one, other = table(before="# symmetry: mirror", symmetry="half_turn"), table(before="# symmetry: 180 degrees")
    np.testing.assert_array_equal(one.phi_i, other.phi_i)
    assert table(symmetry="half_turn_and_mirror").notes == table(before="# symmetry: 180 degrees and mirror").notes
    with pytest.raises(DatasetError, match="symmetry '180' found, expected none, half_turn, mirror or half_turn_and"):
        table(symmetry="180")


def test_an_isotropic_material_has_no_use_for_a_symmetry(table):
    samples = table(ISOTROPIC["satin"], before="# symmetry: 180 degrees")
    assert samples.isotropic
    assert samples.notes[-1] == "Symmetry, half turn: adds nothing to an isotropic material"
    assert len(samples) == 2 * 7 * 8 * 12


@pytest.mark.parametrize("said", ["90 degrees", "yes", "", "mirrored at phi = 45", "180 180 turn"])
def test_another_symmetry_is_refused_with_its_line(table, said):
    with pytest.raises(DatasetError, match=r"brushed\.csv:2: symmetry .* found, expected 180 degrees, or mirror, or"):
        table(before=f"# mine\n# symmetry: {said}")


def test_formats_that_define_an_isotropic_material_are_not_examined(curet, data, monkeypatch):
    monkeypatch.setattr(isotropy, "_compare_rotations", None)
    assert curet(1).isotropic
    path = data / "cornell" / "garnet_red.astm"
    assert fitter.load(path).isotropic
    assert fitter.load(path, isotropic=True).notes[-2] == "Taken as isotropic, as asked"


@pytest.mark.parametrize("count", [5, 300])
def test_azimuths_may_be_of_many_turns(random, count):
    angles = random.random((4, count)) * [[1.5], [6], [1.5], [6]]
    angles[1, ::2], angles[3, ::2] = -1e6, 1e6
    for values in (np.ones((count, 1)), random.random((count, 1)) - 0.5, np.zeros((count, 1))):
        assert isotropy.decide_isotropy(Samples(*angles, values)).isotropic


def test_of_very_many_samples_in_one_patch_all_are_compared(monkeypatch):
    monkeypatch.setattr(isotropy, "_MOST", 10)
    directions = instruments.grid([45], range(0, 180, 10), range(60, 80, 1), [90])
    samples = isotropy.decide_isotropy(Samples(*directions, instruments.ggx()(*directions), ("R", "G", "B")))
    assert not samples.isotropic


def test_very_many_samples_are_compared_in_part(monkeypatch):
    monkeypatch.setattr(isotropy, "_MOST", 5000)
    sizes = []
    monkeypatch.setattr(isotropy, "_is_at_several", lambda cell, rotation, known=isotropy._is_at_several: (
        sizes.append(len(cell)) or known(cell, rotation)))
    assert not found(ANISOTROPIC["GGX"], "goniometer").isotropic
    assert found(ISOTROPIC["gloss"], "goniometer").isotropic
    assert all(1000 < size < 12_000 for size in sizes)


@pytest.mark.parametrize(("returned", "told"), [("one side", True), ("both sides", False)])
def test_a_tape_that_returns_light_to_one_side_is_told(tmp_path, returned, told):
    """Light returns in a lobe 20 degrees beside the source, of isotropic material at one rotation, with noise."""
    theta_i, phi_i, theta_o, phi_o = instruments.grid([20, 40, 60], [0], range(10, 81, 10), range(0, 360, 20))
    turn = (phi_o + np.pi) % (2 * np.pi) - np.pi
    turn = turn if returned == "one side" else np.abs(turn)
    away = (theta_o - theta_i) ** 2 + (turn - np.radians(20)) ** 2
    values = 0.1 + 20 * np.exp(-away / 0.02)
    values *= 1 + 0.1 * np.random.default_rng(1).standard_normal(len(values))
    path = written(tmp_path / "tape.csv", (theta_i, phi_i, theta_o, phi_o), values,
                   names="theta_i,phi_i,theta_o,phi_o,grey")
    samples = fitter.load(path, angles="degrees", quantity="brdf")
    assert samples.isotropic
    assert (isotropy.ONE_SIDED in samples.notes) == told
