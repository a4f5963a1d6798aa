"""The inspection with made-up mice and keys; its session in a window that is made up too; what is left afterwards."""

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import comparison
from measured_brdf.addon.inspect import inspection, operators, overlay, plot, session, surface, view
from measured_brdf.addon.work import queries, tasks
from measured_brdf.fitter.imaging import plane_plot as drawing_plane

import fitter
from fitter.imaging import plane_plot
from fitter.methods import prior
from support.anisotropic import brushed_fit
from support.cases import release
from support.operators import methods
from support.stage import black_scene, material_for
from tests.addon.answers import answer_all

FIT = brushed_fit()
WIDTH, HEIGHT = 1200, 800


@pytest.fixture
def above():
    """The view straight down: 4 units on 1200 pixels; y is up."""
    matrix = np.diag([2 / 4, 2 / 4 * WIDTH / HEIGHT, -0.01, 1.0])
    return view.View(matrix, WIDTH, HEIGHT)


@pytest.fixture
def inspected():
    spot = surface.Spot(1, 2, np.zeros(3), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), True, 0.0, "around Z")
    made = inspection.Inspection(spot, 0.5, math.radians(40), 0.3)
    made.show(inspection.InspectedSurface(FIT, "steel", "Rec.709"))
    return made


@pytest.fixture
def disc():
    return plot.place_plot((0, 0, WIDTH, HEIGHT), "RIGHT", 1.0)


FRAME = np.eye(4)


def test_what_is_shown_is_the_fit_at_the_direction_of_the_light(inspected):
    x, y, z = inspected.lobe.directions[777]
    expected = FIT.evaluate(math.radians(40), 0.3, math.acos(z), math.atan2(y, x))
    np.testing.assert_allclose(inspected.lobe.values[777], expected, rtol=1e-6)
    assert inspected.longest == pytest.approx(np.cbrt(inspected.lobe.values.mean(axis=1).max()))
    for theta, phi in ((-0.7, 0.3), (0.7, 0.3 + math.pi)):
        np.testing.assert_allclose(values(inspected, theta), FIT.evaluate(math.radians(40), 0.3, 0.7, phi))


def test_the_ridge_lies_on_the_lobe(inspected):
    for point in inspected.ridge()[20:-20:30] * inspected.longest:
        length = np.linalg.norm(point)
        x, y, z = point / length
        value = FIT.evaluate(math.radians(40), 0.3, math.acos(min(z, 1)), math.atan2(y, x)).mean()
        assert length == pytest.approx(np.cbrt(value), rel=1e-5)


def test_pressing_in_the_hemisphere_takes_the_light_there_and_dragging_moves_it(inspected, above, disc):
    inspected.with_plot = False
    far = inspection.HANDLE * 0.5
    assert inspected.press(above, FRAME, disc, above.project((far * math.sin(0.6), 0, 0)))
    assert (inspected.theta_i, inspected.phi_i) == pytest.approx((0.6, 0.0), abs=1e-6)
    inspected.move(above, FRAME, disc, above.project((0, far * math.sin(1.0), 0)))
    assert (inspected.theta_i, inspected.phi_i) == pytest.approx((1.0, math.pi / 2), abs=1e-6)
    coarse = len(inspected.lobe.vertices)
    inspected.release()
    assert len(inspected.lobe.vertices) > 2 * coarse
    assert inspected.drag == ""
    before = inspected.theta_i
    inspected.move(above, FRAME, disc, above.project((0, 0, 0)))
    assert inspected.theta_i == before, "nothing is dragged any more"


def test_dragging_on_the_plot_changes_the_angle_alone(inspected, above, disc):
    assert inspected.press(above, FRAME, disc, disc.disc.points(-0.9, 0.8))
    assert (inspected.theta_i, inspected.phi_i) == pytest.approx((0.9, 0.3))
    inspected.move(above, FRAME, disc, disc.disc.points(-0.2, 0.8))
    assert inspected.theta_i == pytest.approx(0.2)
    inspected.move(above, FRAME, disc, disc.disc.points(0.8, 0.8))
    assert inspected.theta_i == 0, "the light stays on its side"
    inspected.move(above, FRAME, disc, disc.center - (100, 50))
    assert inspected.theta_i == pytest.approx(math.radians(89))


def test_pressing_beside_the_disc_on_the_box_does_nothing(inspected, above, disc):
    before = inspected.theta_i
    assert inspected.press(above, FRAME, disc, np.array([disc.x + 5, disc.y + 5]))
    assert (inspected.drag, inspected.theta_i) == ("", before)


def test_keys_switch_the_radius_and_the_plot_and_move_the_light(inspected):
    rooted = inspected.longest
    assert inspected.key("R")
    assert inspected.longest == pytest.approx(rooted ** 3)
    assert inspected.key("P")
    assert not inspected.with_plot
    assert inspected.key("LEFT_ARROW")
    assert inspected.theta_i == pytest.approx(math.radians(41))
    assert inspected.key("UP_ARROW")
    assert inspected.phi_i == pytest.approx(0.3 + math.radians(1))
    for _ in range(60):
        inspected.key("RIGHT_ARROW")
    assert inspected.theta_i == 0
    assert not inspected.key("G")


def test_another_fit_has_another_curve_and_other_values(inspected):
    other = inspection.InspectedSurface(prior.lambertian(np.array([[0.2]])), "paper", "Rec.709")
    assert inspected.show(other)
    assert not inspected.show(other)
    np.testing.assert_allclose(inspected.curve[1], 0.2)
    assert inspected.plane.largest == pytest.approx(0.2)
    np.testing.assert_allclose(values(inspected, 0.1), [0.2])
    inspected.show(None)
    assert (inspected.lobe, inspected.curve) == (None, None)


def values(inspected, theta):
    return [value for _, value in inspected.plane.read(theta)]


# -- in Blender, without a window ------------------------------------------------------------------------------------

@pytest.fixture
def stage(blender, monkeypatch):
    """A sphere of an anisotropic material before a made-up window; a function begins the operator."""
    black_scene(8, 8, 1, 1)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    bpy.ops.object.shade_smooth()
    item = bpy.context.object
    item.data.materials.append(material_for(FIT))
    bpy.context.view_layer.update()
    matrix = np.diag([2 / 4, 2 / 4 * WIDTH / HEIGHT, -0.01, 1.0])
    region = SimpleNamespace(type="WINDOW", x=10, y=20, width=WIDTH, height=HEIGHT,
                    data=SimpleNamespace(perspective_matrix=matrix))
    area = SimpleNamespace(type="VIEW_3D", regions=[region], width=WIDTH, height=HEIGHT, as_pointer=lambda: 4711,
                           tag_redraw=lambda: None)
    timers, handlers = [], []
    manager = SimpleNamespace(
        event_timer_add=lambda step, window: timers.append(step) or timers, modal_handler_add=lambda operator: None,
        event_timer_remove=lambda timer: timer.pop(), windows=[])
    space = SimpleNamespace(draw_handler_add=lambda *given: handlers.append(given) or given,
                            draw_handler_remove=lambda given, kind: handlers.remove(given))
    window = SimpleNamespace(screen=SimpleNamespace(areas=[area]))
    manager.windows.append(window)
    context = SimpleNamespace(area=area, window=window, window_manager=manager, workspace=None, object=item,
                              scene=bpy.context.scene, region=region, region_data=region.data,
                              evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
                              preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)))
    monkeypatch.setattr(operators, "bpy", SimpleNamespace(app=SimpleNamespace(background=False)))
    fake = SimpleNamespace(context=context, data=bpy.data, app=bpy.app, types=SimpleNamespace(SpaceView3D=space))
    monkeypatch.setattr(session, "bpy", fake)

    operator, reports = type("Driven", (), methods(operators.MEASUREDBRDF_OT_inspect))(), []
    operator.place, operator.reports = "MOUSE", reports
    operator.report = lambda kind, message: reports.append((kind, message))
    made = SimpleNamespace(item=item, area=area, region=region, window=window, context=context, timers=timers,
                           handlers=handlers, operator=operator)

    def send(kind="MOUSEMOVE", value="NOTHING", at=(WIDTH / 2, HEIGHT / 2), **modifiers):
        keys = {"ctrl": False, "alt": False, "shift": False, "oskey": False} | modifiers
        event = SimpleNamespace(type=kind, value=value, mouse_x=at[0] + region.x, mouse_y=at[1] + region.y, **keys)
        return made.operator.modal(context, event)

    def begin(at=(WIDTH / 2, HEIGHT / 2)):
        event = SimpleNamespace(mouse_x=at[0] + region.x, mouse_y=at[1] + region.y)
        return made.operator.invoke(context, event)

    def show():
        """Begin, and take the fit once it is there: the inspection."""
        begin()
        answer_all()
        send("TIMER")
        return session.running.inspection

    made.send, made.begin, made.show = send, begin, show
    yield made
    session.stop()


def test_it_begins_at_the_spot_under_the_mouse_and_takes_the_fit_of_its_material(stage):
    assert stage.begin(at=(WIDTH / 2 + 150, HEIGHT / 2)) == {"RUNNING_MODAL"}
    assert len(stage.handlers) == 2
    assert len(stage.timers) == 1
    running = session.running.inspection
    frame = running.spot.frame(np.eye(4))
    np.testing.assert_allclose(frame[:2, 3], (0.5, 0), atol=0.01)
    np.testing.assert_allclose(frame[:3, 2], (0.5, 0, math.sqrt(0.75)), atol=0.02)
    assert running.lobe is None
    answer_all()
    assert stage.send("TIMER") == {"PASS_THROUGH"}
    np.testing.assert_allclose(values(running, 0.4), FIT.evaluate(running.theta_i, running.phi_i, 0.4, math.pi),
                               rtol=1e-5)


@pytest.mark.parametrize(("file", "source"), [("published:chrome", "published fit"), ("brass.astm", "measured")])
def test_the_dots_of_a_published_fit_are_not_called_measured(stage, monkeypatch, file, source):
    answered = SimpleNamespace(finished=1.0, result=(np.array([0.1]), np.ones((1, 3)), 0.7))
    monkeypatch.setattr(session.queries, "samples_near_plane", lambda *_: answered)
    stage.item.active_material.measured_brdf.filepath = file
    running, said = stage.show(), []
    monkeypatch.setattr(overlay.drawing, "text", lambda text, *_, **room: said.append(text) or 0)
    overlay._draw_titles(running, plot.place_plot((0, 0, WIDTH, HEIGHT), "RIGHT", 1.0), running.plane)
    assert f"dots: {source} at 40.1\u00b0" in said[-1]


def test_dots_of_the_same_values_at_other_angles_are_drawn_anew(stage, monkeypatch):
    dots = SimpleNamespace(finished=1.0, result=(np.array([0.1]), np.ones((1, 3)), 0.7))
    monkeypatch.setattr(session.queries, "samples_near_plane", lambda *_: dots)
    stage.show()
    drawn = []
    monkeypatch.setattr(session.Session, "redraw", lambda _: drawn.append(True))
    session.running.refresh()
    assert not drawn
    dots.result = (np.array([0.2]), *dots.result[1:])
    session.running.refresh()
    assert drawn


def test_what_nobody_measured_is_dashed_and_said(stage, monkeypatch):
    """Measured up to 60 degrees of one direction and 75 of the other; the light is at 40 or at 70."""
    settings = stage.item.active_material.measured_brdf
    settings.least, settings.farthest = 60, 75
    running, disc = stage.show(), plot.place_plot((0, 0, WIDTH, HEIGHT), "RIGHT", 1.0)
    angles = np.radians([-80, -70, 0, 59, 70, 80])
    running.theta_i = math.radians(40)
    assert running.is_extrapolated(angles).tolist() == [True, False, False, False, False, True]
    running.theta_i = math.radians(70)
    assert running.is_extrapolated(angles).tolist() == [True, True, False, False, True, True]
    drawn = []
    for how in ("line", "strokes"):
        monkeypatch.setattr(overlay.drawing, how, lambda points, *_, how=how: drawn.append((how, points)))
    monkeypatch.setattr(overlay.drawing, "text", lambda text, *_, **room: drawn.append(("text", text)) or 0)
    running.release()                       # evaluates what was set
    plane = running.plane
    plane_plot._draw_curve(overlay.drawing, disc.disc, plane.curves[0], plane)
    for how, points in drawn:
        polar = np.degrees([disc.angle(each) for each in points])
        assert (np.abs(polar) > 58).all() if how == "strokes" else (np.abs(polar) < 62).all()
    assert {how for how, _ in drawn} == {"line", "strokes"}
    overlay._draw_titles(running, disc, plane)
    assert drawn[-1][1].endswith("dashed: a guess")


@pytest.mark.parametrize("is_pinned", [False, True])
def test_the_viewport_shows_the_plane_that_the_panel_shows(stage, monkeypatch, random, is_pinned):
    """One drawing of one plane: the fit, its samples and what is a guess, into a picture and over the viewport; and the
    material that Compare has pinned."""
    theta, phi = random.uniform(0, 1.5, (2, 300)), random.uniform(0, 6, (2, 300))
    paper = fitter.Samples(theta[0], phi[0], theta[1], phi[1], np.tile([0.2, 0.1, 0.05], (300, 1)),
                           ("R", "G", "B"))
    dull = fitter.fit(paper, 2, None, method="mba")
    other = material_for(dull)
    other.name, other.measured_brdf.least, other.measured_brdf.farthest = "Paper", 50, 50
    comparison.get(bpy.context.scene).pinned = other if is_pinned else None
    settings = stage.item.active_material.measured_brdf
    settings.least, settings.farthest = 60, 75
    dots = np.radians([10.0, 20.0]), np.full((2, 1), 0.1), math.radians(40)
    monkeypatch.setattr(session.queries, "samples_near_plane", lambda *_: SimpleNamespace(finished=1.0, result=dots))
    monkeypatch.setattr(drawing_plane, "samples_near_plane", lambda *_: dots)
    monkeypatch.setattr(tasks, "load_samples", lambda _data: "samples")
    running, drawn, said = stage.show(), [], []
    monkeypatch.setattr(drawing_plane, "draw", lambda _pen, _disc, plane: drawn.append(plane))
    for name in ("fan", "line", "discs"):
        monkeypatch.setattr(overlay.drawing, name, lambda *_: 0.0)
    monkeypatch.setattr(overlay.drawing, "text",
                        lambda text, _at, _size, color, *_, **room: said.append((text, color)) or 0.0)
    monkeypatch.setattr(overlay, "gpu", SimpleNamespace(state=SimpleNamespace(blend_set=lambda _mode: None)))
    overlay.draw_plot(running, plot.place_plot((0, 0, WIDTH, HEIGHT), "RIGHT", 1.0), "")
    fits = [(queries.shown_fits(each), queries.reaches(each)) for each in (stage.item.active_material, other)]
    tasks.polar_plot(fits if is_pinned else fits[:1], object(), running.theta_i, running.phi_i)
    (viewport, picture) = drawn
    assert (viewport.theta_i, viewport.phi_i, viewport.radius) == (picture.theta_i, picture.phi_i, picture.radius)
    assert len(viewport.curves) == len(picture.curves) == 1 + is_pinned
    for one, other in zip(viewport.curves, picture.curves, strict=True):
        for ours, theirs in zip((*one[:2], one.is_extrapolated, *(one.samples or ())),
                                (*other[:2], other.is_extrapolated, *(other.samples or ())), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-6)
        assert one.colors == other.colors
        assert one.is_extrapolated.any()
    if is_pinned:
        theta = viewport.curves[1].theta
        phi_o = running.phi_i + np.where(theta < 0, 0, math.pi)
        expected = dull.evaluate(np.full(len(theta), running.theta_i), np.full(len(theta), running.phi_i),
                                 np.abs(theta), phi_o) @ (0.2126, 0.7152, 0.0722)
        np.testing.assert_allclose(viewport.curves[1].values[:, 0], expected, rtol=1e-3)
        assert [each.colors[0] for each in viewport.curves] == list(plane_plot.PAIR)
        assert ("B: Paper", plane_plot.PAIR[1]) in said
        mirror = plane_plot.shown_value(np.interp(running.theta_i, theta, expected))
        assert (f"B {mirror}", plane_plot.PAIR[1]) in said


def test_dragging_and_keys_are_taken_and_everything_else_is_passed_through(stage):
    running = stage.show()
    reach = inspection.HANDLE * running.size * WIDTH / 4
    place = (WIDTH / 2, HEIGHT / 2 + 0.5 * reach)
    running.with_plot = False
    assert stage.send("LEFTMOUSE", "PRESS", place) == {"RUNNING_MODAL"}
    assert running.theta_i == pytest.approx(math.asin(0.5), abs=0.02)
    assert stage.send(at=(WIDTH / 2, HEIGHT / 2 + 0.8 * reach)) == {"RUNNING_MODAL"}
    assert running.theta_i == pytest.approx(math.asin(0.8), abs=0.02)
    assert stage.send("LEFTMOUSE", "RELEASE", (-500, -500)) == {"RUNNING_MODAL"}, "also outside of the view"
    assert running.drag == ""
    assert stage.send("R", "PRESS") == {"RUNNING_MODAL"}
    assert running.radius == "linear"
    for kind, value, more in (("R", "PRESS", {"ctrl": True}), ("G", "PRESS", {}), ("MIDDLEMOUSE", "PRESS", {}),
                              ("WHEELUPMOUSE", "PRESS", {}), ("LEFTMOUSE", "PRESS", {"at": (5, 5)}),
                              ("RIGHTMOUSE", "PRESS", {"at": (-60, 5)}), ("R", "PRESS", {"at": (-60, 5)})):
        assert stage.send(kind, value, **more) == {"PASS_THROUGH"}, kind
    assert running.radius == "linear"
    assert session.running is not None


def test_a_click_with_ctrl_takes_another_spot(stage):
    stage.begin()
    before = session.running.inspection.spot
    assert stage.send("LEFTMOUSE", "PRESS", (WIDTH / 2, HEIGHT / 2 + 200), ctrl=True) == {"RUNNING_MODAL"}
    after = session.running.inspection.spot
    np.testing.assert_allclose(after.location[:2] - before.location[:2], (0, 200 / 300), atol=0.02)
    assert stage.send("LEFTMOUSE", "PRESS", (5, 5), ctrl=True) == {"PASS_THROUGH"}
    assert session.running.inspection.spot is after


def broken(*_):
    raise ZeroDivisionError("no length")


def gone(stage):
    return session.running is None and not stage.handlers and not stage.timers


CHANGES = {"the area closes": lambda stage: stage.window.screen.areas.clear(),
           "the area becomes another editor": lambda stage: setattr(stage.area, "type", "IMAGE_EDITOR"),
           "the object is deleted": lambda stage: bpy.data.objects.remove(stage.item),
           "the material is deleted": lambda stage: bpy.data.materials.remove(stage.item.active_material),
           "it is measured no more": lambda stage: stage.item.active_material.node_tree.nodes.clear()}


@pytest.mark.parametrize("change", CHANGES)
def test_it_ends_where_what_it_shows_is_gone(stage, change):
    stage.show()
    CHANGES[change](stage)
    assert stage.send("TIMER") == {"CANCELLED"}
    assert gone(stage)


def open_another():
    for handler in bpy.app.handlers.load_pre:
        if handler.__module__ == session.__name__:
            handler("another.blend")


ENDS = {"Esc": lambda stage: stage.send("ESC", "PRESS"),
        "the right mouse": lambda stage: stage.send("RIGHTMOUSE", "PRESS"),
        "another call": lambda stage: stage.begin(), "another file": lambda _: open_another(),
        "Blender": lambda stage: stage.operator.cancel(stage.context), "unregistering": lambda _: session.unregister()}


@pytest.mark.parametrize("end", ENDS)
def test_whatever_ends_it_leaves_nothing(stage, end):
    stage.begin()
    assert ENDS[end](stage) in (None, {"FINISHED"})
    assert gone(stage)
    assert stage.send("TIMER") == {"CANCELLED"}


def test_an_error_in_an_event_takes_everything_away(stage, monkeypatch):
    stage.begin()
    monkeypatch.setattr(inspection.Inspection, "key", broken)
    with pytest.raises(ZeroDivisionError):
        stage.send("R", "PRESS")
    assert gone(stage)


def test_an_error_at_the_beginning_leaves_nothing(stage, monkeypatch):
    monkeypatch.setattr(session.queries, "fit_job", broken)
    with pytest.raises(ZeroDivisionError):
        stage.begin()
    assert gone(stage)


def test_an_error_in_drawing_is_told_once_and_ends_it(stage, monkeypatch, capfd):
    stage.begin()
    monkeypatch.setattr(session.overlay, "draw_labels", broken)
    for _ in range(3):
        stage.handlers[1][0]()
    assert capfd.readouterr().err.count("Traceback") == 1
    assert stage.send("TIMER") == {"CANCELLED"}
    (kind, message), = stage.operator.reports
    assert kind == {"ERROR"}
    assert "no length" in message
    assert gone(stage)


def test_an_object_without_a_surface_is_reported(stage):
    for vertex in stage.item.data.vertices:
        vertex.co = (0, 0, 0)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.delete(type="VERT")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert stage.begin() == {"CANCELLED"}
    assert "no surface" in stage.operator.reports[0][1]
    assert gone(stage)


def test_no_3d_view_is_reported(stage):
    stage.area.type = "IMAGE_EDITOR"
    assert stage.begin() == {"CANCELLED"}
    assert "No 3D viewport" in stage.operator.reports[0][1]
    assert gone(stage)


@release
def test_an_undone_material_is_followed(stage):
    """The shader changes under the inspection, as undo, an edit or a refit changes it."""
    before = stage.show().shown
    other = material_for(brushed_fit(0.3, 0.5))
    group, its = (next(node for node in each.node_tree.nodes if node.type == "GROUP")
                  for each in (stage.item.active_material, other))
    group.node_tree = its.node_tree
    stage.send("TIMER")
    answer_all()
    stage.send("TIMER")
    assert session.running.inspection.shown.fit is not before.fit


def test_without_a_window_it_says_so_and_does_nothing(blender):
    black_scene(8, 8, 1, 1)
    bpy.ops.mesh.primitive_uv_sphere_add()
    assert not bpy.ops.measured_brdf.inspect.poll()
    bpy.context.object.data.materials.append(material_for(FIT))
    with pytest.raises(RuntimeError, match="draws in a 3D viewport"):
        bpy.ops.measured_brdf.inspect()
    with pytest.raises(RuntimeError, match="draws in a 3D viewport"):
        bpy.ops.measured_brdf.inspect("INVOKE_DEFAULT")


def test_a_plot_that_is_drawn_again_evaluates_no_fit(inspected, monkeypatch):
    drawn = inspected.plane.curves
    monkeypatch.setattr(type(FIT), "evaluate", lambda *_: pytest.fail("evaluated again"))
    np.testing.assert_array_equal(inspected.plane.curves[0].values, drawn[0].values)
