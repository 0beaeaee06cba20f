# SPDX-License-Identifier: MIT
"""The Python package against numpy and closed forms: python_package.py SIZES, the sizes of the structs in C."""
import multiprocessing
import os
import pathlib
import pickle
import re
import signal
import sys
import tempfile
import types
import unittest
import unittest.mock

import numpy as np

TOP = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TOP / "python"), str(TOP / "doc/guide")]
import isoshade as iso  # noqa: E402
from isoshade import _native  # noqa: E402

SLAB = {"schema": "isoshade.scene/1", "image": {"width": 24, "height": 20}, "background": [0, 0, 0],
        "camera": {"projection": "orthographic", "fit": True, "direction": [0, 1, 0], "up": [0, 0, 1]},
        "lights": [{"direction": [0, 0, 1], "space": "camera", "intensity": 1}],
        "shading": {"ambient": 1, "diffuse": 0},
        "tf": {"schema": "isoshade.tf/1", "range": [0, 255], "unit_distance_mm": 1, "color_space": "linear",
               "points": [{"value": 0, "r": 1, "g": 0.5, "b": 0.25, "opacity": 0.3},
                          {"value": 255, "r": 1, "g": 0.5, "b": 0.25, "opacity": 0.3}]}}


def ball(shape=(20, 24, 28)):
    z, y, x = np.mgrid[:shape[0], :shape[1], :shape[2]]
    return np.tanh(8 - np.sqrt((x - 13.5) ** 2 + (y - 11.5) ** 2 + (z - 9.5) ** 2)).astype(np.float32)


def slab():
    """6 x 5 x 4 voxels of 1 x .5 x 1 mm, not all equal, so that the range is not empty."""
    array = np.full((5, 6, 4), 200, np.uint8)
    array[0, 0, 0] = 199
    return iso.Volume(array, spacing=(1, 0.5, 1))


def draw(volume):
    return np.array(volume.build(1).render(scene=SLAB_SCENE, threads=4))


SLAB_SCENE = iso.Scene(SLAB)


def never_ends(request):
    raise ZeroDivisionError("a mistake in a renderer")


class Volumes(unittest.TestCase):
    def test_arrays_of_each_type_and_layout_come_back(self):
        whole = np.arange(60).reshape(3, 4, 5)
        for dtype in ("bool", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float16",
                      "float32", "float64", ">i2", ">f8"):
            array = whole.astype(dtype)
            for part in (array, array[::-1, :, ::-2], array.transpose(2, 0, 1), array[:, 1:2]):
                np.testing.assert_array_equal(iso.Volume(part).array, part, f"{dtype} {part.strides}")

    def test_samples_are_shared_read_only_and_outlive_their_volume(self):
        samples = iso.Volume(ball()).array
        np.testing.assert_array_equal(samples, ball())
        with self.assertRaises(ValueError):
            samples[0, 0, 0] = 1

    def test_geometry(self):
        v = iso.Volume(ball(), spacing=(1, 2, 0.5))
        np.testing.assert_array_equal(v.spacing, (1, 2, 0.5))
        np.testing.assert_array_equal(v.index_to_world, [[1, 0, 0, -14], [0, 2, 0, -24], [0, 0, 0.5, -5]])
        turned = [[0, -1, 0, 3], [2, 0, 0, 4], [0, 0, 1, 5]]
        np.testing.assert_array_equal(iso.Volume(ball(), index_to_world=turned).index_to_world, turned)
        self.assertEqual(repr(v), "Volume of 28 x 24 x 20 voxels, 1 x 2 x 0.5 mm, float")

    def test_bad_arrays_are_refused(self):
        with self.assertRaisesRegex(ValueError, "2 dimensions"):
            iso.Volume(np.zeros((2, 2)))
        with self.assertRaisesRegex(iso.Error, r"the first is \(1, 0, 0\)") as caught:
            iso.Volume(np.array([[[0, np.inf]]]))
        self.assertEqual(caught.exception.status, iso.Status.RANGE)
        self.assertEqual(pickle.loads(pickle.dumps(caught.exception)).status, iso.Status.RANGE)
        with self.assertRaisesRegex(iso.Error, "2\\^53"):
            iso.Volume(np.array([[[0, 2**53 + 1]]]))
        for array in np.zeros((2, 2, 2), complex), np.array([[["a"]]]), np.zeros((2, 2, 2), "M8[s]"):
            with self.assertRaisesRegex(TypeError, "must be bool, or integers or floats"):
                iso.Volume(array)
        for spacing in -1, (1, 1), (1, 1, 0), (1, 1, np.nan), np.ones((3, 3)):
            with self.assertRaisesRegex(ValueError, "one or three lengths"):
                iso.Volume(ball(), spacing=spacing)
        self.assertEqual(iso.Volume(ball(), spacing=np.array((1, 2, 3))).spacing, (1, 2, 3))
        self.assertEqual(iso.Volume(ball(), spacing=2).spacing, (2, 2, 2))
        with self.assertRaisesRegex(ValueError, "as .nrrd"):
            iso.Volume(ball()).save("ball.nii")
        with self.assertRaises(iso.Error) as caught:
            iso.open("no such file")
        self.assertEqual(caught.exception.status, iso.Status.IO)

    def test_nan_is_no_data(self):
        for dtype in "float32", "float64", "float16":
            array = np.full((4, 4, 4), 2, dtype)
            array[0, :, 1] = np.nan
            array[3] = 5
            v = iso.Volume(array)
            for one in v, pickle.loads(pickle.dumps(v)):
                np.testing.assert_array_equal(one.array == -2.0**100, np.isnan(array))
                coarse = one.build(levels=2)[1].values
                np.testing.assert_array_equal(coarse[0], 2)  # of the children that have data
                np.testing.assert_array_equal(coarse[1], 3.5)

    def test_masked_samples_are_no_data(self):
        array = np.ma.masked_equal(np.arange(24, dtype=np.uint8).reshape(2, 3, 4), 5)
        np.testing.assert_array_equal(iso.Volume(array).array == -2.0**100, array.mask)
        np.testing.assert_array_equal(iso.Volume(array[1:]).array, array.data[1:])

    def test_files(self):
        iso.Volume(ball(), spacing=(1, 2, 3)).save("ball.nrrd")
        again = iso.open("ball.nrrd", spacing=(1, 1, 4), unit="um")
        np.testing.assert_array_equal(again.array, ball())
        np.testing.assert_allclose(again.spacing, (0.001, 0.001, 0.004), rtol=1e-12)
        pathlib.Path("raw").write_bytes(np.arange(8, dtype=">u2").tobytes())
        raw = iso.open("raw", raw_size=(4, 2, 1), raw_type="uint16", raw_is_big_endian=True, labels=False)
        np.testing.assert_array_equal(raw.array.ravel(), range(8))

    def test_reading_options(self):
        pathlib.Path("uneven.vtk").write_text("""# vtk DataFile Version 3.0
planes at 0, 1 and 3 mm
ASCII
DATASET RECTILINEAR_GRID
DIMENSIONS 2 2 3
X_COORDINATES 2 float
0 1
Y_COORDINATES 2 float
0 1
Z_COORDINATES 3 float
0 1 3
POINT_DATA 12
SCALARS v float 1
LOOKUP_TABLE default
0 0 0 0 1 1 1 1 3 3 3 3
""")
        with self.assertRaisesRegex(iso.Error, "[^-]resample"):  # as the argument is called
            iso.open("uneven.vtk")
        with self.assertWarnsRegex(UserWarning, "2 x 2 x 4 samples are interpolated of 2 x 2 x 3"):
            resampled = iso.open("uneven.vtk", resample=True).array
        np.testing.assert_allclose(resampled[:, 0, 0], [0, 1, 2, 3], atol=1e-6)  # linear; rounding of floats
        forced = iso.open("uneven.vtk", force_spacing=True).array
        np.testing.assert_array_equal(forced[:, 1, 1], [0, 1, 3])
        for no_data, gone in ((1, [1]), ((1, 3), [1, 3]), ("none", [])):
            array = iso.open("uneven.vtk", force_spacing=True, no_data=no_data).array
            np.testing.assert_array_equal(array == -2.0**100, np.isin(forced, gone))

    def test_pickles(self):
        v = iso.Volume(ball(), index_to_world=[[0, -1, 0, 3], [2, 0, 0, 4], [0, 0, 1, 5]])
        again = pickle.loads(pickle.dumps(v))
        np.testing.assert_array_equal(again.array, v.array)
        np.testing.assert_array_equal(again.index_to_world, v.index_to_world)
        tf = iso.Tf([(0, (0, 0, 0), 0), (1, (1, 0.5, 0), 0.5)], unit=2)
        self.assertEqual(pickle.loads(pickle.dumps(tf)).points, tf.points)
        self.assertEqual(pickle.loads(pickle.dumps(SLAB_SCENE)).to_dict(), SLAB_SCENE.to_dict())

    def test_coordinates_are_the_place(self):
        class DataArray:
            """The part of an xarray.DataArray that is read."""

            def __init__(self, array, dims, coords):
                self.array, self.dims, self.coords, self.shape = array, dims, coords, array.shape

            def __array__(self, dtype=None, copy=None):
                return self.array

            def transpose(self, *dims):
                return DataArray(self.array.transpose([self.dims.index(d) for d in dims]), dims, self.coords)

        a = np.arange(24.0).reshape(2, 3, 4)
        coords = {"z": [10, 12.5], "y": [3, 2, 1], "x": [0.5, 1.5, 2.5, 3.5]}
        for one in DataArray(a, ("z", "y", "x"), coords), DataArray(a.T, ("x", "y", "z"), coords):
            v = iso.Volume(one)
            np.testing.assert_array_equal(v.array, a)
            np.testing.assert_array_equal(v.index_to_world, [[1, 0, 0, 0], [0, -1, 0, 3.5], [0, 0, 2.5, 8.75]])
        with self.assertRaisesRegex(ValueError, "along x are not even, 1 to 2 apart"):
            iso.Volume(DataArray(a, ("z", "y", "x"), {**coords, "x": [0, 1, 2, 4]}))
        with self.assertRaisesRegex(ValueError, "along y have the type <U1, must be lengths"):
            iso.Volume(DataArray(a, ("z", "y", "x"), {**coords, "y": ["a", "b", "c"]}))

    def test_xarray(self):
        try:
            import xarray  # noqa: F401
        except ImportError:
            self.skipTest("xarray is not installed")
        a = iso.Volume(ball(), spacing=(1, 2, 0.5)).to_xarray()
        np.testing.assert_array_equal(a.coords["y"], 2 * (np.arange(24) + 0.5) - 24)
        np.testing.assert_allclose(iso.Volume(a).index_to_world, iso.Volume(ball(), spacing=(1, 2, 0.5)).index_to_world)


class Pyramids(unittest.TestCase):
    def test_levels_are_means(self):
        p = iso.Volume(ball()).build(3)
        b = ball().astype(float)
        mean = b.reshape(10, 2, 12, 2, 14, 2).mean((1, 3, 5))
        np.testing.assert_allclose(p[1].values, mean, atol=1e-6)  # floats of values up to 1
        self.assertEqual([level.shape for level in p], [(20, 24, 28), (10, 12, 14), (5, 6, 7)])
        length = np.linalg.norm(p[1].directions, axis=3)
        self.assertLessEqual(length.max(), 1 + 2e-7)  # floats
        self.assertGreater(length.max(), 0.9)
        with self.assertRaises(IndexError):
            p[3]
        with self.assertRaises(TypeError):
            p[0:2]
        self.assertEqual(repr(p[1]), "Level 1 of 14 x 12 x 10 voxels")
        p.save("ball.iso")
        with self.assertRaisesRegex(ValueError, "no options"):
            iso.open("ball.iso", spacing=2)
        np.testing.assert_array_equal(iso.open("ball.iso")[-1].values, p[2].values)

    def test_a_slab_has_its_closed_form(self):
        for renderer, tolerance in (("reference", 2e-7), ("cpu", 1e-5)):  # floats of the image; of its arithmetic
            image = slab().render(scene=SLAB_SCENE, renderer=renderer)
            self.assertEqual((image.shape, image.dtype), ((20, 24, 4), np.float32))
            alpha = 1 - 0.7**3  # 3 mm along y
            np.testing.assert_allclose(image[10, 12], np.array([1, 0.5, 0.25, 1]) * alpha, atol=tolerance)

    def test_tf_and_scene(self):
        p = slab().build(2)
        tf = iso.Tf([(0, (1, 1, 1), 0), (200, (1, 1, 1), 0.5)], unit=1)
        got = tf.evaluate(p, [[0], [200], [1000]])
        np.testing.assert_allclose(got[:, 0, 3], -np.log([1, 0.5, 0.5]), atol=1e-6)  # floats of its table
        image = p.render(scene=SLAB_SCENE, tf=tf, size=(8, 6))
        np.testing.assert_allclose(image[3, 4, 3], 1 - 0.5**3, atol=1e-5)
        scene = p.scene(tf="simulation", view="left", size=32)
        scene["background"] = [0, 1, 0]
        self.assertEqual((scene["background"], scene["image"]["width"]), ([0, 1, 0], 32))
        with self.assertRaisesRegex(iso.Error, "lamp"):
            scene["lamp"] = 1
        scene.save("a.scene.json")
        self.assertEqual(iso.Scene.open("a.scene.json").to_dict(), scene.to_dict())
        self.assertEqual(p.render(scene=scene.to_dict(), size=(8, 6)).shape, (6, 8, 4))
        with self.assertRaisesRegex(ValueError, r"must be \(value, \(r, g, b\), opacity\)"):
            iso.Tf([(0, 0), (1, 1)])
        self.assertGreaterEqual(len(p.suggest().points), 2)
        with self.assertRaises(iso.Error):
            p.render(tf="no-such-preset")

    def test_wrong_arguments_are_refused(self):
        p = slab().build(2)
        for call, kind, words in (
                (lambda: slab().build(-1), ValueError, "levels is -1, must be at least 0"),
                (lambda: p.render(size=8, level=-1), ValueError, "level is -1"),
                (lambda: p.suggest().adapt(p, -1), ValueError, "level is -1"),
                (lambda: p.render(size=0), ValueError, "size is 0"),
                (lambda: p.render(size=8, view="sideways"), iso.Error, '^view is "sideways"'),
                (lambda: p.render(size=8, scene=p.suggest()), TypeError, "needs an isoshade.Scene"),
                (lambda: p.suggest().evaluate(slab(), [1]), TypeError, "needs an isoshade.Pyramid"),
                (lambda: iso.validate(p), TypeError, "needs an isoshade.Volume"),
                (lambda: p.export("slab.vdb", tf="ct-bone"), ValueError, "export to vdb has no scene, tf"),
                (lambda: iso.choices("tfs"), ValueError, "must be one of type, code"),
                (lambda: iso.compare(np.zeros((2, 2, 4), np.uint8), np.zeros((2, 2, 4))), TypeError, "must be floats")):
            with self.assertRaisesRegex(kind, words):
                call()

    def test_exports_and_pages(self):
        p = slab().build(2)
        p.export("slab.vdb", levels=2)
        p.export("slab-pov", to="povray", size=16)
        self.assertTrue(pathlib.Path("slab.vdb").is_file() and pathlib.Path("slab-pov/slab-pov.ini").is_file())
        with self.assertRaisesRegex(ValueError, "nanovdb"):
            p.export("slab.obj")
        self.assertIn("<canvas", p.page(title="a slab"))
        self.assertTrue(slab()._repr_html_().startswith("<iframe srcdoc="))

    def test_a_region_and_an_extinction_scale_are_options(self):
        p = iso.Volume(ball(), spacing=(1, 1, 1.25)).build(3)
        z, y, x = p[0].shape
        fine, coarse = p.render(size=24), p.render(size=24, level=2, adapt=False)
        inside = p.render(size=24, level=2, roi=((0, 0, 0), (x, y, z)))
        self.assertLess(iso.compare(fine, inside).rmse, 0.1 * iso.compare(fine, coarse).rmse)
        scaled = p.render(size=24, level=2, adapt=False, extinction_scale=True)
        self.assertGreater(iso.compare(coarse, scaled).max_abs, 1e-4)
        with self.assertRaisesRegex(iso.Error, "must be finer"):
            p.render(size=24, level=1, roi=((0, 0, 0), (x, y, z), 1))
        plain = p.export(None, to="vdb", level=1)
        self.assertEqual(plain[:4], b" BDV")
        self.assertNotEqual(len(p.export(None, to="vdb", level=1, extinction_scale=True)), len(plain))
        p.export("part-pov", to="povray", size=16, level=1, roi=((0, 0, 0), (x / 2, y, z)), adapt=True)
        self.assertTrue(pathlib.Path("part-pov/part-pov.ini").is_file())

    def test_a_plan_and_a_figure(self):
        p = iso.Volume(ball(), spacing=(1, 1, 1.25)).build(2)
        rough, fine = (p.plan(error, size=24, levels=2) for error in (0.1, 1e-4))
        self.assertLess(rough["bytes"], fine["bytes"])
        self.assertLessEqual(rough["measured_rmse"], 0.1)
        self.assertLessEqual(p.plan(memory=rough["bytes"], size=24, levels=2)["bytes"], rough["bytes"])
        part, whole = p.export(None, to="vdb", size=24, plan=rough), p.export(None, to="vdb")
        self.assertNotEqual(part, whole)
        with self.assertRaisesRegex(iso.Error, "error is 2"):
            p.plan(2)
        for form, magic in ("pdf", b"%PDF"), ("svg", b"<?xml"), ("png", b"\x89PNG"):
            self.assertEqual(p.figure("tf", format=form, width=85, dpi=60)[:len(magic)], magic)
        with self.assertRaisesRegex(iso.Error, "best") as caught:
            p.figure("best")
        self.assertEqual(caught.exception.status, iso.Status.USAGE)
        with self.assertRaisesRegex(ValueError, "must be pdf"):
            p.figure("tf", format="gif")

    def test_names_are_listed(self):
        self.assertIn("ct-bone", iso.choices("tf"))
        self.assertIn("povray", iso.choices("export"))
        self.assertIn("front", iso.choices("view"))


class Images(unittest.TestCase):
    def test_comparison_has_its_closed_form(self):
        a = np.random.default_rng(1).random((9, 12, 4)).astype(np.float32)
        b = a + np.float32(0.125)
        m = iso.compare(a, b)
        self.assertAlmostEqual(m.rmse, 0.125, delta=1e-7)  # floats
        self.assertAlmostEqual(m.max_abs, 0.125, delta=1e-7)
        self.assertIs(type(a.view(iso.Image).mean()), np.float32)
        b[1, 2, 0] = 5
        self.assertEqual(iso.compare(a, b).worst, (2, 1))

    def test_files(self):
        image = slab().render(scene=SLAB_SCENE)
        image.save("a.exr")
        image.save("a.png")
        np.testing.assert_array_equal(iso.load_image("a.exr"), image)
        self.assertEqual(image._repr_png_(), pathlib.Path("a.png").read_bytes())
        self.assertIsNone(image[0]._repr_png_())
        with self.assertRaisesRegex(ValueError, "exr or .png"):
            image.save("a.gif")


class LongCalls(unittest.TestCase):
    """A picture of this size takes minutes: a call that is not ended is seen."""

    SIZE = 4096

    def setUp(self):
        self.pyramid = iso.Volume(ball()).build(1)

    def test_ctrl_c_ends_a_call(self):
        self.interrupt("reference")

    def test_ctrl_c_ends_a_draw_by_opengl(self):
        try:
            self.pyramid.render(renderer="gl", size=8)
        except iso.Error as failure:
            if failure.status != iso.Status.MISSING:
                raise
            self.skipTest(str(failure))
        self.interrupt("gl")

    def interrupt(self, renderer):
        signal.signal(signal.SIGINT, signal.default_int_handler)
        reports = []

        def interrupt(stage, fraction):  # several times: one may come between two lines that wait
            for _ in range(20):
                os.kill(os.getpid(), signal.SIGINT)
            reports.append(fraction)
        with self.assertRaises(KeyboardInterrupt):
            self.pyramid.render(renderer=renderer, size=self.SIZE, step=0.01, progress=interrupt)
        self.assertLess(max(reports), 0.5)

    def test_a_bar_shows_all_stages_and_is_closed(self):
        shown, closed = [], []

        class Bar:
            """The part of tqdm that is used."""

            def __init__(self, total, bar_format):
                self.total = total

            def set_description_str(self, text, refresh):
                self.text = text

            def refresh(self):
                shown.append((self.text, self.n / self.total, len(closed)))

            def close(self):
                closed.append(self)

        with unittest.mock.patch.dict(sys.modules, {"tqdm": types.SimpleNamespace(), "tqdm.auto":
                                                    types.SimpleNamespace(tqdm=Bar)}):
            self.pyramid.plan(size=16, progress=True)
            self.assertLessEqual({("plan", 1, 0), ("verify", 1, 0)}, set(shown))
            self.assertEqual(len(closed), 1)
            with self.assertRaises(iso.Error):
                self.pyramid.render(level=9, progress=True)
            self.assertEqual(len(closed), 2)

    def test_an_exception_of_the_progress_function_ends_a_call(self):
        with self.assertRaises(ZeroDivisionError):
            self.pyramid.render(renderer="reference", size=self.SIZE, progress=lambda stage, fraction: 1 / 0)

    def test_children_work_on(self):
        here = draw(slab())
        for method in ("fork", "spawn"):
            with multiprocessing.get_context(method).Pool(2) as pool:
                for there in pool.map_async(draw, [slab(), slab()]).get(300):
                    np.testing.assert_array_equal(there, here, method)


class Validation(unittest.TestCase):
    VOLUME = iso.Volume(ball(), spacing=(1, 1, 1.25))

    def renderer(self, change=lambda grid: grid):
        from numpy_renderer import render
        return lambda r: render(r.json, change(r.grid), r.step_mm)

    def test_a_right_renderer_agrees(self):
        report = iso.validate(self.VOLUME, renderers={"mine": self.renderer()}, size=16, folder="right")
        self.assertTrue(report.agrees, report.summary)
        self.assertRegex(report.summary, "^The renderers agree")
        self.assertIn("<html", report.html)
        self.assertTrue(pathlib.Path("right/index.html").is_file())

    def test_the_mistake_of_a_wrong_one_is_named(self):
        right = self.renderer()
        wrong = {"mirror": (self.renderer(lambda grid: grid[:, :, ::-1]), ["mirrored along x"]),
                 "rows": (lambda r: right(r)[::-1], ["the first row were the bottom one"]),
                 "both": (lambda r: (right(r) * right(r)[..., 3:] ** [1, 1, 1, 0])[::-1],
                          ["the first row were the bottom one", "multiplied by alpha twice"])}
        report = iso.validate(self.VOLUME, renderers={name: f for name, (f, _) in wrong.items()}, size=16,
                              folder="wrong")
        self.assertFalse(report.agrees)
        for name, (_, words) in wrong.items():
            for word in words:
                self.assertIn(word, report.json["mistakes"][name])
            wanted, got, explained = (iso.load_image(f"wrong/images/mistake-{name}-{part}.exr")
                                      for part in ("wanted", "got", "explained"))
            self.assertGreater(iso.compare(got, wanted).rmse, 0.05, name)
            self.assertLess(iso.compare(got, explained).rmse, 6e-3, name)  # the most that a mistake may leave
        self.assertRegex(report.summary, "^mirror draws as if the volume were mirrored along x")

    def test_its_exception_is_raised(self):
        with self.assertRaises(ZeroDivisionError):
            iso.validate(self.VOLUME, renderers={"mine": never_ends}, size=16)
        with self.assertRaisesRegex(ValueError, "shape"):
            iso.validate(self.VOLUME, renderers={"mine": lambda r: np.zeros((2, 2, 4))}, size=16)
        with self.assertRaisesRegex(iso.Error, "letters"):
            iso.validate(self.VOLUME, renderers={"a b": never_ends})


class Interface(unittest.TestCase):
    def test_structs_are_those_of_the_header(self):
        sizes = dict(line.split() for line in SIZES.read_text().splitlines())
        self.assertEqual({name: int(size) for name, size in sizes.items()},
                         {name: _native.ctypes.sizeof(s) for name, s in _native.STRUCTS.items()})

    def test_statuses_are_those_of_the_header(self):
        header = (TOP / "src/isoshade.h").read_text()
        listed = {name.removeprefix("E_"): int(n) for name, n in re.findall(r"X\(ISO_(\w+), (\d+),", header)}
        self.assertEqual(listed, {s.name: s.value for s in iso.Status})

    def test_examples_of_the_pages_run(self):
        os.symlink(TOP / "refscenes", "refscenes")
        iso.Volume(ball(), spacing=(1, 1, 1.25)).save("scan.nrrd")
        iso.Volume(ball() / 2 + 0.5, spacing=(1, 1, 1.25)).save("ml.nrrd")
        for page in "python.md", "judging-a-renderer.md":
            blocks = re.findall(r"```python\n(.*?)```", (TOP / "doc/guide" / page).read_text(), re.S)
            self.assertEqual(len(blocks), 1)
            exec(compile(blocks[0], page, "exec"), names := {})
        self.assertTrue(names["report"].agrees)


if __name__ == "__main__":
    SIZES = pathlib.Path(sys.argv.pop(1)).resolve()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        unittest.main(verbosity=2)
