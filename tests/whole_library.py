# SPDX-License-Identifier: MIT
"""A program by ctypes that calls each function of isoshade.h once, as whole_library.c does, with the structs of the
package. Writes into the current folder. Ends with an exception if a call fails."""
import ctypes as c
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python"))
from isoshade import _native as n  # noqa: E402

lib = n.lib
SIZE, SPACING = (c.c_size_t * 3)(9, 8, 7), (c.c_double * 3)(1, 1, 1.25)
COUNT = 9 * 8 * 7
SAMPLES = (c.c_ubyte * COUNT)(*(28 * (i % 9) for i in range(COUNT)))
# Functions that the package does not need.
for name in "iso_status_text", "iso_directions_bytes":
    getattr(lib, name).restype = c.c_char_p if name.endswith("text") else c.c_size_t
lib.iso_region_of.restype = n.Region
lib.iso_volume_values.argtypes = [c.c_void_p, c.c_void_p]


def made(name, *arguments):
    """Returns the handle, or the text, that a function creates before its iso_error."""
    out = c.c_void_p()
    n.call(name, *arguments, c.byref(out))
    assert out.value
    return out


def bytes_of(name, *arguments):
    data, size = c.c_void_p(), c.c_size_t()
    n.call(name, *arguments, c.byref(data), c.byref(size))
    return n.take_bytes(data, size)


def use_volumes():
    grid = lib.iso_grid_axis_aligned(SIZE, SPACING)
    volume = made("iso_volume_from_memory", c.byref(grid), b"uint8", SAMPLES)
    n.call("iso_volume_save", volume, b"volume.nrrd", True)
    file, values = made("iso_volume_open", b"volume.nrrd"), (c.c_float * COUNT)()
    lib.iso_volume_values(file, values)
    assert values[4] == SAMPLES[4] and c.string_at(lib.iso_volume_samples(file), COUNT) == bytes(SAMPLES)
    lib.iso_volume_free(file)
    options = n.OpenOptions(unit=b"um", spacing=(2000, 2000, 2000))
    file, edges = made("iso_volume_open_with", b"volume.nrrd", c.byref(options)), (c.c_double * 3)()
    scaled = lib.iso_volume_grid(file)
    lib.iso_grid_spacing_mm(c.byref(scaled), edges)
    assert abs(edges[2] - 2) < 1e-3 and lib.iso_volume_type(file) == b"uint8"
    lib.iso_volume_free(file)
    strides = (c.c_ssize_t * 3)(1, 9, 72)
    lib.iso_volume_free(made("iso_volume_from_array", c.byref(grid), b"bool", SAMPLES, strides))
    return volume


def use_pyramids(volume):
    options, level = lib.iso_build_defaults(), n.LevelView()
    options.levels = 2
    built = made("iso_build", volume, c.byref(options))
    n.call("iso_pyramid_save", built, b"volume.iso")
    lib.iso_pyramid_free(built)
    pyramid, directions, codes = made("iso_pyramid_open", b"volume.iso"), (c.c_float * (3 * COUNT))(), b"\0" * 3 * COUNT
    n.call("iso_pyramid_level", pyramid, 0, c.byref(level))
    n.call("iso_pyramid_directions", pyramid, 0, directions)
    assert lib.iso_pyramid_level_count(pyramid) == 2 and lib.iso_directions_bytes(level.code) == 3
    n.call("iso_directions_encode", level.code, directions, c.c_size_t(COUNT), codes)
    n.call("iso_directions_decode", level.code, codes, c.c_size_t(COUNT), directions)
    return pyramid


def use_scenes(pyramid):
    color, points = (c.c_double * 4)(), (n.TfPoint * 64)()
    tf = made("iso_tf_suggest", pyramid, b"simulation")
    count = lib.iso_tf_points(tf, points, 64)
    n.call("iso_tf_save", tf, b"a.tf.json")
    copy = made("iso_tf_from_text", n.take_text(made("iso_tf_text", tf)).encode())
    file = made("iso_tf_open", b"a.tf.json")
    adapted = made("iso_tf_adapt", file, pyramid, 1)
    n.call("iso_tf_evaluate", adapted, pyramid, c.byref(c.c_double(100)), 1, color)
    again = made("iso_tf_from_points", points, count, 1)
    assert 2 <= count <= 64 and color[3] >= 0
    automatic = made("iso_scene_automatic", pyramid, None)
    n.call("iso_scene_set", automatic, b'{"image": {"width": 12, "height": 12}}')
    n.call("iso_scene_set_tf", automatic, again)
    assert lib.iso_tf_points(lib.iso_scene_tf(automatic), None, 0) == count
    n.call("iso_scene_save", automatic, b"a.scene.json")
    opened = made("iso_scene_open", b"a.scene.json")
    scene = made("iso_scene_from_text", n.take_text(made("iso_scene_text", opened)).encode())
    for handle in tf, copy, file, adapted, again:
        lib.iso_tf_free(handle)
    for handle in automatic, opened:
        lib.iso_scene_free(handle)
    return scene


def use_images(pyramid, scene):
    options, a, b, black, metrics = lib.iso_frame_defaults(), *(n.ImageStruct() for _ in range(3)), n.MetricsStruct()
    region = lib.iso_region_of((c.c_double * 3)(), (c.c_double * 3)(9, 8, 7))
    options.level, options.region, options.renderer = 1, c.pointer(region), b"cpu"
    try:
        n.call("iso_render", pyramid, scene, c.byref(options), c.byref(a))
        raise AssertionError("cpu draws no regions")
    except n.Error as error:
        assert error.status == n.Status.USAGE
    options.region = None
    n.call("iso_render", pyramid, scene, c.byref(options), c.byref(a))
    n.call("iso_image_create", c.byref(black), c.c_size_t(12), c.c_size_t(12))
    n.call("iso_metrics_measure", c.byref(a), c.byref(black), c.byref(metrics))
    assert metrics.max_abs > 0
    for save, load, more in (("iso_image_save_exr", "iso_image_load_exr", None),
                             ("iso_image_save_png", "iso_image_load_png", 1.0)):
        n.call(save, c.byref(a), b"a.picture", more)
        n.call(load, b"a.picture", c.byref(b))
        lib.iso_image_destroy(c.byref(b))
    assert bytes_of("iso_image_png", c.byref(a), 1.0)[1:4] == b"PNG"
    assert len(bytes_of("iso_image_exr", c.byref(a))) > 4 * 12 * 12
    for image in a, black:
        lib.iso_image_destroy(c.byref(image))


def use_exports(pyramid, scene):
    limits, options, plan = lib.iso_plan_defaults(), lib.iso_export_defaults(), n.PlanResult()
    limits.brick_voxels = 8
    n.call("iso_plan", pyramid, scene, c.byref(limits), c.byref(plan))
    assert plan.measured_rmse <= limits.error and plan.drawn_count > 0
    options.plan = plan.json
    n.call("iso_export", pyramid, scene, b"vdb", b"planned.vdb", c.byref(options))
    assert bytes_of("iso_export_bytes", pyramid, scene, b"vdb", c.byref(options))[:4] == b" BDV"
    lib.iso_plan_result_destroy(c.byref(plan))
    assert "<canvas" in n.take_text(made("iso_view_page", pyramid, scene, None))


def use_validation(volume, scene):
    drawn = []
    black = n.RENDER(lambda user, request, rgba: not drawn.append(request.contents.scene))
    options, result = lib.iso_validate_defaults(), n.ValidationResult()
    own = n.OwnRenderer(b"black", black, None)
    options.scene, options.renderers, options.renderer_count = scene, c.pointer(own), 1
    n.call("iso_validate", volume, c.byref(options), c.byref(result))
    assert not result.agrees and b"black" in result.summary and b"<html" in result.html and len(drawn) >= 8
    lib.iso_validation_result_destroy(c.byref(result))


warned = []
warn = n.WARNING(lambda user, text: warned.append(text))
lib.iso_warnings_to(warn, None)
assert lib.iso_version_number() == 3000 and lib.iso_version() == b"0.3.0"
assert b"file" in lib.iso_status_text(3) and lib.iso_choice_name(9, 0)
a_volume = use_volumes()
a_pyramid = use_pyramids(a_volume)
a_scene = use_scenes(a_pyramid)
use_images(a_pyramid, a_scene)
use_exports(a_pyramid, a_scene)
use_validation(a_volume, a_scene)
lib.iso_free(None)
lib.iso_scene_free(a_scene)
lib.iso_pyramid_free(a_pyramid)
lib.iso_volume_free(a_volume)
lib.iso_warnings_to(n.WARNING(), None)
assert not warned, warned
