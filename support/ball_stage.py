"""A ball, a camera and a lamp in a Blender scene, and its picture as a `fitter.BallPhotograph`."""

import math

import bpy
import numpy as np

import fitter
from fitter.photographs.rig import camera

from . import ball_scene, stage

RADIUS, DISTANCE, LENS, SENSOR = 1.0, 30.0, 500.0, 36.0     # of the ball and the camera, metres; mm
POWER, LAMP_RADIUS, FAR = 20_000.0, 0.3, 20.0               # W; metres


def scene(phase, turn=0.0, size=96, samples=16):
    """A black scene of a unit ball without a material, whose lamp stands at an angle from the camera, degrees."""
    made = stage.black_scene(size, size, samples, span=2)
    made.cycles.max_bounces = 0
    made.cycles.pixel_filter_type = "BOX"
    stage.add_sphere()
    stage.look((0, -DISTANCE, 0), lens=LENS)
    made.camera.data.sensor_width = SENSOR
    added = stage.add_lamp("POINT", POWER, lamp_place(phase, turn), shadow_soft_size=LAMP_RADIUS)
    added.data.use_soft_falloff = False         # a ball
    return made


def lamp_place(phase, turn):
    """Where a lamp stands at an angle from the camera, and turned about its axis, degrees."""
    phase, turn = math.radians(phase), math.radians(turn)
    return tuple(FAR * np.array([math.sin(phase) * math.cos(turn), -math.cos(phase), math.sin(phase) * math.sin(turn)]))


def lamp(made):
    return next(item for item in made.objects if item.type == "LIGHT")


def as_scene(made, size):
    """The same as a `ball_scene.Scene`."""
    return ball_scene.Scene((0.0, -DISTANCE, 0.0), radius=RADIUS, lamp=tuple(lamp(made).location),
                            intensity=(POWER / (4 * math.pi),) * 3, lamp_radius=LAMP_RADIUS, size=(size, size),
                            angle=math.degrees(2 * math.atan(SENSOR / (2 * LENS))))


def photograph(made, radiance):
    """The photograph of a scene, of its picture (height, width, 3 or 4): places are those of the scene's objects."""
    bpy.context.view_layer.update()
    pose = np.array(made.camera.matrix_world)
    source = lamp(made)
    rays = camera.rays(*radiance.shape[:2], camera.lens_angle(made.camera.data.lens, made.camera.data.sensor_width),
                       pose[:3, :3])
    return fitter.BallPhotograph(radiance[..., :3], rays, pose[:3, 3], np.zeros(3), RADIUS, np.array(source.location),
                                 np.full(3, source.data.energy / (4 * math.pi)), LAMP_RADIUS)
