# SPDX-License-Identifier: MIT
"""libisoshade by ctypes: the structs and functions of isoshade.h, and calls that Ctrl-C can end."""
import ctypes
import enum
import os
import pathlib
import re
import signal
import threading
from ctypes import (POINTER, byref, c_bool, c_char, c_char_p, c_double, c_float, c_int, c_size_t, c_ssize_t, c_ubyte,
                    c_void_p)

SONAME = "libisoshade.so.0"


class Status(enum.IntEnum):
    """Cause of an error, with the number that it has in C and as an exit code."""

    OK = 0
    DIFFERS = 1
    USAGE = 2
    IO = 3
    FORMAT = 4
    RANGE = 5
    MEMORY = 6
    MISSING = 7
    PROGRAM = 8
    UNTRUSTED = 9
    CANCELED = 10


class Error(RuntimeError):
    """A call of the library failed: `status` has the cause, the text what is wrong and what helps."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = Status(status)

    def __reduce__(self):
        return Error, (int(self.status), str(self))


class ErrorText(ctypes.Structure):
    _fields_ = [("text", c_char * 1024)]


class Grid(ctypes.Structure):
    _fields_ = [("size", c_size_t * 3), ("index_to_world", (c_double * 4) * 3), ("box_index", c_double * 3),
                ("reserved", c_void_p * 4)]


def check_count(name, value):
    """Refuses a negative number, which ctypes would take for a huge one."""
    if isinstance(value, int) and value < 0:
        raise ValueError(f"{name} is {value}, must be at least 0")


class Options(ctypes.Structure):
    """A struct of options."""

    def __setattr__(self, name, value):
        if dict(self._fields_).get(name) is c_size_t:
            check_count(name, value)
        super().__setattr__(name, value)


class OpenOptions(Options):
    _fields_ = [("series", c_char_p), ("frame", c_char_p), ("channel", c_char_p), ("unit", c_char_p),
                ("spacing", c_double * 3), ("raw_size", c_size_t * 3), ("raw_type", c_char_p),
                ("raw_skip_bytes", c_size_t), ("raw_is_big_endian", c_bool), ("stored", c_bool), ("labels", c_int),
                ("resample", c_bool), ("force_spacing", c_bool), ("no_data", c_char_p), ("reserved", c_void_p * 7)]


PROGRESS = ctypes.CFUNCTYPE(c_bool, c_void_p, c_char_p, c_double)
WARNING = ctypes.CFUNCTYPE(None, c_void_p, c_char_p)


class BuildOptions(Options):
    _fields_ = [("levels", c_size_t), ("code", c_char_p), ("estimator", c_char_p), ("scalar_filter", c_char_p),
                ("direction_filter", c_char_p), ("keep_float", c_bool), ("keep_magnitude", c_bool), ("threads", c_int),
                ("progress", PROGRESS), ("progress_user", c_void_p), ("reserved", c_void_p * 8)]


class LevelView(ctypes.Structure):
    _fields_ = [("grid", Grid), ("min", c_double), ("max", c_double), ("values", POINTER(c_float)), ("code", c_char_p),
                ("codes", POINTER(c_ubyte)), ("directions", POINTER(c_float)), ("magnitudes", POINTER(c_float)),
                ("reserved", c_void_p * 8)]


class TfPoint(ctypes.Structure):
    _fields_ = [("value", c_double), ("rgb_linear", c_double * 3), ("opacity", c_double)]


class LookOptions(Options):
    _fields_ = [("tf", c_char_p), ("view", c_char_p), ("zoom", c_double), ("width", c_size_t), ("height", c_size_t),
                ("reserved", c_void_p * 8)]


class ImageStruct(ctypes.Structure):
    _fields_ = [("width", c_size_t), ("height", c_size_t), ("rgba", POINTER(c_float)), ("origin", c_int * 2),
                ("reserved", c_void_p * 4)]


class MetricsStruct(ctypes.Structure):
    _fields_ = [("rmse", c_double), ("max_abs", c_double), ("p99_abs", c_double), ("psnr_db", c_double),
                ("ssim", c_double), ("flip_mean", c_double), ("nonfinite_count", c_size_t), ("worst", c_size_t * 2),
                ("reserved", c_double * 8)]


class Region(ctypes.Structure):
    _fields_ = [("lo", c_double * 3), ("hi", c_double * 3), ("level", c_size_t), ("band", c_double),
                ("reserved", c_void_p * 4)]


class FrameOptions(Options):
    _fields_ = [("renderer", c_char_p), ("level", c_size_t), ("width", c_size_t), ("height", c_size_t),
                ("tf", c_void_p), ("shading", c_char_p), ("step_voxels", c_double), ("samples", c_int), ("seed", c_int),
                ("threads", c_int), ("progress", PROGRESS), ("progress_user", c_void_p), ("adapt", c_bool),
                ("extinction_scale", c_bool), ("region", POINTER(Region)), ("reserved", c_void_p * 6)]


class ExportOptions(Options):
    _fields_ = [("level", c_size_t), ("level_count", c_size_t), ("width", c_size_t), ("height", c_size_t),
                ("tf", c_void_p), ("half_float", c_bool), ("threads", c_int), ("progress", PROGRESS),
                ("progress_user", c_void_p), ("adapt", c_bool), ("extinction_scale", c_bool),
                ("region", POINTER(Region)), ("plan", c_char_p), ("reserved", c_void_p * 5)]


class PlanOptions(Options):
    _fields_ = [("error", c_double), ("memory_bytes", c_double), ("levels", c_size_t), ("brick_voxels", c_size_t),
                ("views", c_size_t), ("width", c_size_t), ("height", c_size_t), ("threads", c_int),
                ("progress", PROGRESS), ("progress_user", c_void_p), ("reserved", c_void_p * 8)]


class PlanResult(ctypes.Structure):
    _fields_ = [("brick_count", c_size_t), ("drawn_count", c_size_t), ("bytes", c_double), ("full_bytes", c_double),
                ("predicted_rmse", c_double), ("measured_rmse", c_double), ("blank_rmse", c_double), ("json", c_char_p),
                ("reserved", c_void_p * 8)]


class PageOptions(Options):
    _fields_ = [("title", c_char_p), ("most_voxels", c_size_t), ("threads", c_int), ("compact", c_bool),
                ("progress", PROGRESS), ("progress_user", c_void_p), ("reserved", c_void_p * 8)]


class FrameRequest(ctypes.Structure):
    _fields_ = [("width", c_size_t), ("height", c_size_t), ("step_mm", c_double), ("grid", Grid),
                ("values", POINTER(c_float)), ("directions", POINTER(c_float)), ("json", c_char_p), ("scene", c_char_p),
                ("level", c_size_t), ("reserved", c_void_p * 8)]


RENDER = ctypes.CFUNCTYPE(c_bool, c_void_p, POINTER(FrameRequest), POINTER(c_float))


class OwnRenderer(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("render", RENDER), ("user", c_void_p)]


class ValidateOptions(Options):
    _fields_ = [("scene", c_void_p), ("renderers", POINTER(OwnRenderer)), ("renderer_count", c_size_t),
                ("with_", c_char_p), ("folder", c_char_p), ("levels", c_size_t), ("width", c_size_t),
                ("height", c_size_t), ("quick", c_bool), ("progress", PROGRESS), ("progress_user", c_void_p),
                ("reserved", c_void_p * 8)]


class ValidationResult(ctypes.Structure):
    _fields_ = [("agrees", c_bool), ("summary", c_char * 1024), ("json", c_char_p), ("html", c_char_p),
                ("reserved", c_void_p * 8)]


# The structs by their names in C, for a test that compares their sizes.
STRUCTS = {"iso_error": ErrorText, "iso_grid": Grid, "iso_open_options": OpenOptions, "iso_build_options": BuildOptions,
           "iso_level_view": LevelView, "iso_tf_point": TfPoint, "iso_look_options": LookOptions,
           "iso_image": ImageStruct, "iso_metrics": MetricsStruct, "iso_region": Region,
           "iso_frame_options": FrameOptions, "iso_plan_options": PlanOptions, "iso_plan_result": PlanResult,
           "iso_export_options": ExportOptions, "iso_page_options": PageOptions, "iso_frame_request": FrameRequest,
           "iso_own_renderer": OwnRenderer, "iso_validate_options": ValidateOptions,
           "iso_validation_result": ValidationResult}

# Parameters by function. Results: None for an iso_status, which call() checks, and otherwise a type.
_P = c_void_p
_FUNCTIONS = {
    "iso_version": (c_char_p, []),
    "iso_version_number": (c_int, []),
    "iso_warnings_to": (c_void_p, [WARNING, _P]),
    "iso_free": (c_void_p, [_P]),
    "iso_choice_name": (c_char_p, [c_int, c_size_t]),
    "iso_grid_axis_aligned": (Grid, [POINTER(c_size_t), POINTER(c_double)]),
    "iso_grid_spacing_mm": (c_void_p, [POINTER(Grid), POINTER(c_double)]),
    "iso_volume_open_with": (None, [c_char_p, POINTER(OpenOptions), _P, _P]),
    "iso_volume_from_array": (None, [POINTER(Grid), c_char_p, _P, POINTER(c_ssize_t), _P, _P]),
    "iso_volume_grid": (Grid, [_P]),
    "iso_volume_type": (c_char_p, [_P]),
    "iso_volume_samples": (c_void_p, [_P]),
    "iso_volume_save": (None, [_P, c_char_p, c_bool, _P]),
    "iso_volume_free": (c_void_p, [_P]),
    "iso_build_defaults": (BuildOptions, []),
    "iso_build": (None, [_P, POINTER(BuildOptions), _P, _P]),
    "iso_pyramid_open": (None, [c_char_p, _P, _P]),
    "iso_pyramid_save": (None, [_P, c_char_p, _P]),
    "iso_pyramid_level_count": (c_size_t, [_P]),
    "iso_pyramid_level": (None, [_P, c_size_t, POINTER(LevelView), _P]),
    "iso_pyramid_directions": (None, [_P, c_size_t, _P, _P]),
    "iso_pyramid_free": (c_void_p, [_P]),
    "iso_tf_open": (None, [c_char_p, _P, _P]),
    "iso_tf_from_points": (None, [_P, c_size_t, c_double, _P, _P]),
    "iso_tf_from_text": (None, [c_char_p, _P, _P]),
    "iso_tf_text": (None, [_P, _P, _P]),
    "iso_tf_suggest": (None, [_P, c_char_p, _P, _P]),
    "iso_tf_points": (c_size_t, [_P, _P, c_size_t]),
    "iso_tf_adapt": (None, [_P, _P, c_size_t, _P, _P]),
    "iso_tf_evaluate": (None, [_P, _P, _P, c_size_t, _P, _P]),
    "iso_tf_save": (None, [_P, c_char_p, _P]),
    "iso_tf_free": (c_void_p, [_P]),
    "iso_scene_open": (None, [c_char_p, _P, _P]),
    "iso_scene_from_text": (None, [c_char_p, _P, _P]),
    "iso_scene_automatic": (None, [_P, POINTER(LookOptions), _P, _P]),
    "iso_scene_set": (None, [_P, c_char_p, _P]),
    "iso_scene_set_tf": (None, [_P, _P, _P]),
    "iso_scene_text": (None, [_P, _P, _P]),
    "iso_scene_save": (None, [_P, c_char_p, _P]),
    "iso_scene_tf": (c_void_p, [_P]),
    "iso_scene_free": (c_void_p, [_P]),
    "iso_image_destroy": (c_void_p, [POINTER(ImageStruct)]),
    "iso_image_save_exr": (None, [POINTER(ImageStruct), c_char_p, _P, _P]),
    "iso_image_load_exr": (None, [c_char_p, POINTER(ImageStruct), _P]),
    "iso_image_save_png": (None, [POINTER(ImageStruct), c_char_p, c_double, _P]),
    "iso_image_load_png": (None, [c_char_p, POINTER(ImageStruct), _P]),
    "iso_image_png": (None, [POINTER(ImageStruct), c_double, _P, _P, _P]),
    "iso_metrics_measure": (None, [POINTER(ImageStruct), POINTER(ImageStruct), POINTER(MetricsStruct), _P]),
    "iso_frame_defaults": (FrameOptions, []),
    "iso_render": (None, [_P, _P, POINTER(FrameOptions), POINTER(ImageStruct), _P]),
    "iso_plan_defaults": (PlanOptions, []),
    "iso_plan": (None, [_P, _P, POINTER(PlanOptions), POINTER(PlanResult), _P]),
    "iso_plan_result_destroy": (c_void_p, [POINTER(PlanResult)]),
    "iso_export_defaults": (ExportOptions, []),
    "iso_export": (None, [_P, _P, c_char_p, c_char_p, POINTER(ExportOptions), _P]),
    "iso_export_bytes": (None, [_P, _P, c_char_p, POINTER(ExportOptions), _P, _P, _P]),
    "iso_view_page": (None, [_P, _P, POINTER(PageOptions), _P, _P]),
    "iso_validate_defaults": (ValidateOptions, []),
    "iso_validate": (None, [_P, POINTER(ValidateOptions), POINTER(ValidationResult), _P]),
    "iso_validation_result_destroy": (c_void_p, [POINTER(ValidationResult)]),
}


def _candidates():
    """Yields paths and names of the library: $ISOSHADE_LIBRARY, next to the package, a build, the system."""
    chosen = os.environ.get("ISOSHADE_LIBRARY")
    if chosen:
        yield chosen
        return
    here = pathlib.Path(__file__).resolve().parent
    for folder in (here, here.parent.parent / "build" / "release", *(parent / "lib" for parent in here.parents)):
        if (folder / SONAME).is_file():
            yield str(folder / SONAME)
    yield SONAME


def _load():
    tried = []
    for name in _candidates():
        try:
            lib = ctypes.CDLL(name)
        except OSError as failure:
            tried.append(str(failure))
            continue
        if not hasattr(lib, "iso_version_number") or lib.iso_version_number() < 3000:
            tried.append(f"{name}: older than 0.3")
            continue
        return lib
    raise ImportError(f"libisoshade is not found; install it, or set ISOSHADE_LIBRARY to its file ({'; '.join(tried)})")


lib = _load()
for _name, (_result, _parameters) in _FUNCTIONS.items():
    _function = getattr(lib, _name)
    _function.restype = c_int if _result is None else _result
    _function.argtypes = _parameters


# Options of the command line in messages, which are arguments here.
_OPTIONS = re.compile("--((?:series|frame|channel|spacing|unit|resample|force-spacing|no-data|view|size|zoom|tf|level)"
                      r")\b(?!-)")


def call(name, *arguments):
    """Calls a function that returns an iso_status; raises Error."""
    error = ErrorText()
    status = getattr(lib, name)(*arguments, byref(error))
    if status != 0:
        raise Error(status, _OPTIONS.sub(lambda m: m[1].replace("-", "_"), error.text.decode(errors="replace")))


def text(value):
    """Returns bytes for a string or a path; None stays None."""
    if value is None:
        return None
    return os.fsencode(value) if isinstance(value, (str, os.PathLike)) else str(value).encode()


def take_text(pointer):
    """Returns a text that the library made, and frees it."""
    try:
        return ctypes.string_at(pointer).decode()
    finally:
        lib.iso_free(pointer)


def take_bytes(pointer, size):
    """Returns bytes that the library made, and frees them."""
    try:
        return ctypes.string_at(pointer, size.value)
    finally:
        lib.iso_free(pointer)


def _bar(progress):
    """Returns a function of (stage, fraction) for the argument `progress` of long calls, and the bar to close."""
    if progress is None or progress is False or callable(progress):
        return progress or None, None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None, None
    bar = tqdm(total=100, bar_format="{desc} {percentage:3.0f}%|{bar}| {elapsed}")

    def show(stage, fraction):  # a call has several stages
        bar.set_description_str(stage, refresh=False)
        bar.n = 100 * fraction
        bar.refresh()
    return show, bar


class _Watch:
    """The progress function of one call: it reports, and cancels after Ctrl-C or an exception."""

    def __init__(self, progress):
        self.report, self.bar = _bar(progress)
        self.canceled = threading.Event()
        self.failure = None
        self.callback = PROGRESS(self._progress)

    def fail(self, failure):
        """Keeps the first exception of a callback, and cancels the call."""
        self.failure = self.failure or failure
        self.canceled.set()

    def _progress(self, _user, stage, fraction):
        try:
            if self.report and not self.canceled.is_set():
                self.report(stage.decode(errors="replace"), fraction)
        except BaseException as failure:
            self.fail(failure)
        return not self.canceled.is_set()


def _call_in_thread(watch, name, arguments):
    """Calls in another thread, because Python handles signals only while its main thread runs Python code."""
    outcome, done = [], threading.Event()

    def work():
        try:
            call(name, *arguments)
            outcome.append(None)
        except BaseException as failure:
            outcome.append(failure)
        finally:
            done.set()

    # An exception between two lines of the main thread would leave this one with freed objects: it waits for the end.
    failures, handler = [], signal.getsignal(signal.SIGINT)

    def keep(raised):
        failures.append(raised)
        watch.canceled.set()

    def on_interrupt(*signal_and_frame):
        try:
            handler(*signal_and_frame)
        except BaseException as raised:
            keep(raised)

    if callable(handler):
        signal.signal(signal.SIGINT, on_interrupt)
    try:
        threading.Thread(target=work, name=name).start()
        while not done.is_set():  # not thread.join(): interrupted, it takes a running thread for an ended one
            try:
                done.wait(0.05)
            except BaseException as raised:  # by another signal's handler
                keep(raised)
    finally:
        if callable(handler):
            signal.signal(signal.SIGINT, handler)
    for failure in failures + outcome:
        if failure:
            raise failure


def call_long(name, *arguments, options, progress=None, watch=None):
    """Calls a function whose options have a progress callback. Ctrl-C ends it and raises KeyboardInterrupt."""
    watch = watch or _Watch(progress)
    options.progress = watch.callback
    try:
        if threading.current_thread() is threading.main_thread():
            _call_in_thread(watch, name, arguments)
        else:
            call(name, *arguments)
    except Error:
        if watch.failure:
            raise watch.failure
        raise
    finally:
        if watch.bar:
            watch.bar.close()
    if watch.failure:
        raise watch.failure


def pointer(handle, kind):
    """Returns the pointer of an object of a class, by its name."""
    if type(handle).__name__ != kind or not isinstance(handle, Handle):
        raise TypeError(f"{type(handle).__name__} is given, needs an isoshade.{kind}")
    return handle._pointer


def words(value):
    """Returns words with commas, of a text or a sequence."""
    return value if isinstance(value, str) else ",".join(value)


class Handle:
    """An object of the library, which frees it when Python no longer uses it."""

    _free = None

    def __init__(self, pointer):
        self._pointer = pointer

    def __del__(self):
        if getattr(self, "_pointer", None) and lib is not None:  # None while Python ends
            getattr(lib, self._free)(self._pointer)
            self._pointer = None

    @classmethod
    def _made_by(cls, name, *arguments, **long_call):
        """Returns the object that a function creates by a pointer before its iso_error."""
        made = c_void_p()
        if long_call:
            call_long(name, *arguments, byref(made), **long_call)
        else:
            call(name, *arguments, byref(made))
        new = cls.__new__(cls)
        Handle.__init__(new, made.value)
        return new


CHOICES = ("type", "code", "estimator", "scalar filter", "direction filter", "shading", "renderer", "export", "tf",
           "view")


def choices(what):
    """Lists the names of iso_choice `what`."""
    names, number = [], 0
    while name := lib.iso_choice_name(what, number):
        names.append(name.decode())
        number += 1
    return names
