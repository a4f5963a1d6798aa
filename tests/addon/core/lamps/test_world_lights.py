"""Bright spots of the world, against synthetic images and against panoramas that Cycles renders."""

import math
import os

import numpy as np
import pytest
from measured_brdf.addon.core.lamps import list_lamps, world_lights

from support import stage

DISK = math.radians(1.5)


def panorama(places, radius=DISK, rows=256, around=0.2, light=500.0):
    """An equirectangular image, lowest row first, with disks in it."""
    latitude, longitude = np.meshgrid((np.arange(rows) + 0.5) * np.pi / rows - np.pi / 2,
                                      np.pi - (np.arange(2 * rows) + 0.5) * np.pi / rows, indexing="ij")
    unit = np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], -1)
    radiance = np.full(latitude.shape, around)
    for place in places:
        radiance[unit @ (np.array(place) / np.linalg.norm(place)) > math.cos(radius)] = light
    return radiance


def apart(one, other):
    """The angle between two directions."""
    one, other = np.array(one), np.array(other)
    return math.acos(min(one @ other / np.linalg.norm(one) / np.linalg.norm(other), 1))


@pytest.mark.parametrize("place", [(1, 0.3, 0.5), (-1, 0, 0), (-0.5, -1, -0.2), (0.1, 0, 1)])
def test_a_disk_in_an_image_is_found_with_its_size_and_light(place):
    (direction, radius, light), = world_lights.spots(panorama([place]))
    assert apart(direction, place) < math.radians(0.4)
    assert radius == pytest.approx(DISK, abs=math.radians(0.8))
    assert light == pytest.approx(500 * 2 * math.pi * (1 - math.cos(DISK)), rel=0.2)


def test_several_disks_are_found_and_even_skies_have_none():
    places = (1, 0, 0.5), (0, 1, 0.2), (-1, -1, 1)
    directions = [direction for direction, *_ in world_lights.spots(panorama(places))]
    assert len(directions) == 3
    assert all(min(apart(place, direction) for direction in directions) < math.radians(0.4) for place in places)
    spots = world_lights.spots
    assert spots(np.full((128, 256), 0.7)) == []
    assert spots(np.zeros((64, 128))) == []
    assert spots(np.linspace(0, 1, 128)[:, None] * np.ones(256)) == []          # brighter toward the zenith
    assert spots(np.ones((1, 1))) == spots(np.full((64, 128), np.nan)) == []
    assert not any(spots(image) for image, _ in bright_texels(15)), "of too few rows"


def rendered(scene):
    """Where a panorama of the world is brightest."""
    scene.render.film_transparent = False
    camera = scene.camera
    camera.data.type = "PANO"
    settings = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
    settings.panorama_type = "EQUIRECTANGULAR"
    camera.location, camera.rotation_euler = (0, 0, 0), (math.pi / 2, 0, -math.pi / 2)      # its centre looks along x
    picture = stage.render(scene)[::-1, :, :3].mean(axis=2)
    row, column = np.unravel_index(picture.argmax(), picture.shape)
    latitude = (row + 0.5) / len(picture) * math.pi - math.pi / 2
    longitude = math.pi - (column + 0.5) / picture.shape[1] * 2 * math.pi
    return (math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude))


@pytest.mark.parametrize(("rotation", "elevation"), [(0.0, 0.3), (1.0, 0.5), (4.0, 0.9)])
def test_the_sun_of_a_sky_texture_stands_where_cycles_shows_it(blender, rotation, elevation):
    scene = stage.black_scene(256, 128, 16, 2)
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sun_disc, sky.sun_size, sky.sun_rotation, sky.sun_elevation = True, math.radians(2), rotation, elevation
    assert world_lights.bright_spots(scene.world) == []            # it lights nothing yet
    tree.links.new(sky.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 1
    (direction, radius, _), = world_lights.bright_spots(scene.world)
    assert apart(direction, rendered(scene)) < math.radians(2)
    assert radius == pytest.approx(math.radians(1))


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", None])
def test_a_turned_environment_has_its_spot_where_cycles_shows_it(blender, kind):
    scene = stage.black_scene(256, 128, 16, 2)
    tree = stage.sky_image(panorama([(0.5, 1, 0.4)])).node_tree
    texture = next(node for node in tree.nodes if node.type == "TEX_ENVIRONMENT")
    if kind is not None:
        mapping, coordinate = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
        mapping.vector_type = kind
        mapping.inputs["Rotation"].default_value = (0.3, -0.5, 1.1)
        tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    scene.update_tag()
    blender.context.view_layer.update()
    depsgraph = blender.context.evaluated_depsgraph_get()
    (position, size, *_), = list_lamps(depsgraph)
    assert apart(position, rendered(scene)) < math.radians(2)
    assert -size == pytest.approx(DISK, abs=math.radians(0.8))


def test_an_image_is_searched_anew_where_its_file_its_pixels_or_its_colours_are_others(blender, tmp_path):
    def save(direction):
        pixels = np.zeros((32, 64, 4), np.float32)
        pixels[16, direction] = 1000
        image = blender.data.images.new("Written", 64, 32, float_buffer=True)
        image.pixels.foreach_set(pixels.ravel())
        image.filepath_raw, image.file_format = str(path), "OPEN_EXR"
        image.save()
        return pixels

    def found():
        return [spot.direction for spot in world_lights._image_spots(image)]

    path = tmp_path / "sky.exr"
    save(5)
    image = blender.data.images.load(str(path))
    first = found()
    assert len(first) == 1
    pixels = save(37)
    os.utime(path, (1, 1))
    image.reload()
    second = found()
    assert second != first
    pixels[16] = np.roll(pixels[16], 9, axis=0)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    third = found()
    assert third not in (first, second)


def bright_texels(rows):
    """Images with one bright texel, at each height, and where that is: pairs of (rows, 2 rows) and (3,)."""
    for row in range(rows):
        image = np.ones((rows, 2 * rows))
        image[row, 5] = 1000
        latitude, longitude = (row + 0.5) * math.pi / rows - math.pi / 2, math.pi - 5.5 * math.pi / rows
        yield image, (math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude),
                      math.sin(latitude))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rows", [16, 19, 21, 32])
def test_a_bright_texel_of_few_rows_is_a_spot_wherever_it_is(rows):
    for image, place in bright_texels(rows):
        (direction, radius, _), = world_lights.spots(image)
        assert direction == pytest.approx(place, abs=1e-6)
        assert radius == pytest.approx(math.pi / rows / 2)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", ["missing", "tiled"])
def test_an_image_that_is_not_there_or_has_tiles_has_no_spot(blender, kind):
    image = blender.data.images.new("Sky", 64, 32, float_buffer=True, tiled=kind == "tiled")
    pixels = np.zeros((32, 64, 4), np.float32)
    pixels[16, 5] = 1000
    image.pixels.foreach_set(pixels.ravel())
    if kind == "missing":
        assert len(world_lights._image_spots(image)) == 1
        image.source, image.filepath = "FILE", "//nowhere.exr"
    assert world_lights._image_spots(image) == []


def test_images_are_looked_at_once_however_many_a_world_has(blender, monkeypatch):
    looked, spots = [], world_lights.spots
    monkeypatch.setattr(world_lights, "spots", lambda radiance: looked.append(1) or spots(radiance))
    images = [blender.data.images.new("Sky", 64, 32, float_buffer=True) for _ in range(2)]
    for _ in range(3):
        for image in images:
            world_lights._image_spots(image)
    assert len(looked) == 2
