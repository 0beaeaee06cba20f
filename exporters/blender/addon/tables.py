# SPDX-License-Identifier: MIT
"""Transfer functions as stops, tables and files. Independent of Blender; input is checked, and never run.

A curve is a function from value to linear red, green, blue and the opacity of a unit distance. A table has entries at
even distances over [lo, hi], each with color and extinction; renderers interpolate between them."""
import json
import math

import numpy

MOST_STOPS = 32
MOST_POINTS = 65536
MOST_OPACITY = 0.9999  # as in src/tf/tf.h: keeps extinction finite
CLOSE_ENOUGH = 1 / 1024  # for fitted stops
STEP = 4 * 2.0 ** -23  # stops closer than this are a step at one value


class Refused(Exception):
    """An error to show, in one sentence."""


def extinction(opacity, unit):
    return -numpy.log1p(-numpy.minimum(opacity, MOST_OPACITY)) / unit


def opacity(extinction_of, unit):
    return -numpy.expm1(-numpy.asarray(extinction_of, float) * unit)


def values_of(lo, hi, count):
    return lo + numpy.arange(count) / (count - 1) * (hi - lo)


def evaluate(points, values):
    """points: rows of value, r, g, b, opacity, ascending; of two at the same value, the later one applies from there
    on."""
    points = numpy.asarray(points, float)
    above = numpy.searchsorted(points[:, 0], values, side="right")
    a = points[numpy.clip(above - 1, 0, len(points) - 1)]
    b = points[numpy.clip(above, 0, len(points) - 1)]
    span = b[:, 0] - a[:, 0]
    f = numpy.where(span > 0, (values - a[:, 0]) / numpy.where(span > 0, span, 1), 0)[:, None]
    return (1 - numpy.clip(f, 0, 1)) * a[:, 1:] + numpy.clip(f, 0, 1) * b[:, 1:]


def make_table(curve, lo, hi, count, unit):
    """curve: function from values to rows of r, g, b, opacity. Returns rows of r, g, b, extinction."""
    rows = numpy.array(curve(values_of(lo, hi, count)), float)
    rows[:, 3] = extinction(rows[:, 3], unit)
    return rows.astype(numpy.float32)


def look_up(table, lo, hi, values, unit):
    """Interpolates color and opacity of a table of r, g, b, extinction at values."""
    x = numpy.clip((values - lo) / (hi - lo), 0, 1) * (len(table) - 1)
    i = numpy.minimum(x.astype(int), len(table) - 2)
    f = (x - i)[:, None]
    rows = (1 - f) * table[i].astype(float) + f * table[i + 1].astype(float)
    rows[:, 3] = opacity(rows[:, 3], unit)
    return rows


# ---- single precision and decimals -------------------------------------------------------------------------------


def shortest(value, is_it):
    """Returns the shortest decimal for which is_it() holds, or the value itself."""
    for digits in range(1, 17):
        short = float(f"{value:.{digits}g}")
        if is_it(short):
            return short
    return float(value)


def plain(value):
    """Restores the decimal of a number that Blender keeps in single precision."""
    return shortest(value, lambda short: numpy.float32(short) == numpy.float32(value))


def near(value):
    """Restores the decimal of a number that passed through single precision, and perhaps a driver's arithmetic."""
    return shortest(value, lambda short: abs(short - value) <= 3e-7 * abs(value))


def value_at(position, lo, hi):
    """Returns the value of a stop's position."""
    value = lo + position * (hi - lo)
    return shortest(value, lambda short: numpy.float32((short - lo) / (hi - lo)) == numpy.float32(position))


def points_of_stops(stops, lo, hi):
    """stops: rows of position, r, g, b, opacity, ascending. Stops closer together than people set them are a step."""
    points, start = [], None
    for position, *rgba in stops:
        if start is None or position - start[0] > STEP:
            start = (position, value_at(position, lo, hi))
        points.append([start[1], *(plain(v) for v in rgba)])
    if len(stops) > 1 and stops[-1][0] == 1 and stops[-2][0] < 1 and 1 - stops[-2][0] <= STEP:
        points[-2][0] = points[-1][0] = float(hi)
    return points


def stops_of_points(points, lo, hi):
    """Returns rows of position, r, g, b, opacity. Positions are kept apart, since Blender sorts them."""
    apart = 2.0 ** -23
    x = [float(numpy.float32(min(max((p[0] - lo) / (hi - lo), 0), 1))) for p in points]
    for i in range(1, len(x)):
        x[i] = max(x[i], x[i - 1] + apart)
    x[-1] = min(x[-1], 1.0)
    for i in range(len(x) - 2, -1, -1):
        x[i] = min(x[i], x[i + 1] - apart)
    return [[position, *(float(v) for v in p[1:])] for position, p in zip(x, points)]


def fewest_stops(rows):
    """Chooses at most 32 of evenly spaced rows, each as far after the previous one as color and opacity allow. The same
    as exporters/blender/ramp.c."""
    within = CLOSE_ENOUGH
    while True:
        chosen, at = [0], 0
        while at < len(rows) - 1 and len(chosen) <= MOST_STOPS:
            reach = at + 1
            while reach < len(rows) - 1:
                f = (numpy.arange(1, reach + 1 - at) / (reach + 1 - at))[:, None]
                want = rows[at + 1:reach + 1]
                off = abs((1 - f) * rows[at] + f * rows[reach + 1] - want)
                off[want[:, 3] < CLOSE_ENOUGH, :3] = 0  # transparent entries have no visible color
                if off.max() > within:
                    break
                reach += 1
            chosen.append(reach)
            at = reach
        if len(chosen) <= MOST_STOPS:
            return chosen
        within *= 1.25


def fit(points):
    """Returns points for a ramp: the given ones if they fit, else the fewest of their values at even distances."""
    if len(points) <= MOST_STOPS:
        return [list(map(float, p)) for p in points]
    values = numpy.array([p[0] for p in points], float)
    even = values_of(values[0], values[-1], min(len(points), 4096))
    rows = evaluate(points, even)
    return [[float(even[i]), *map(float, rows[i])] for i in fewest_stops(rows)]


# ---- files -------------------------------------------------------------------------------------------------------


# Limits in mm and values, same as in isoshade: ISO_TF_LEAST_UNIT, ISO_TF_MOST_UNIT, ISO_MOST_VALUE.
LEAST_MM, MOST_MM, MOST_VALUE = 1e-30, 1e33, 3.4028235e38


def number(value, what, least=-MOST_VALUE, most=MOST_VALUE):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value) or not least <= value <= most:
        raise Refused(f"{what} is {value!r:.40}, must be a number from {least:g} to {most:g}")
    return float(value)


def to_json(points, lo, hi, unit_mm, count):
    """Returns an object of the form isoshade.tf/1."""
    return {"schema": "isoshade.tf/1", "range": [lo, hi], "unit_distance_mm": unit_mm, "color_space": "linear",
            "table_size": int(count),
            "points": [dict(zip(("value", "r", "g", "b", "opacity"), (p[0], *(min(max(v, 0.0), 1.0) for v in p[1:])))) for p in points]}


POINT = {"value": 0, "r": 1, "g": 0.5, "b": 0, "opacity": 0.2}
EXAMPLE = {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_mm": 1, "color_space": "srgb", "points": [POINT]}


def need_keys(found, keys, what, example):
    missing = [f'"{key}"' for key in keys if key not in found]
    if missing:
        raise Refused(f"{what} lacks {', '.join(missing)}; an example: {json.dumps(example)}")


def from_json(text, where, fit_range, voxel_mm=None):
    """Reads points, lo, hi, unit_mm of an isoshade.tf/1 file. fit_range: the volume's range, for "range": "fit"."""
    try:
        root = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Refused(f"{where}: is not valid JSON: {error}") from None
    if not isinstance(root, dict):
        raise Refused(f"{where}: is not an object of JSON")
    unit = "unit_distance_voxels" if "unit_distance_voxels" in root else "unit_distance_mm"
    need_keys(root, ("schema", "range", unit, "color_space", "points"), f"{where}: the transfer function", EXAMPLE)
    if root["schema"] != "isoshade.tf/1":
        raise Refused(f'{where}: its "schema" is not isoshade.tf/1; isoshade tf convert reads other formats')
    listed = root["points"]
    if not isinstance(listed, list) or not 1 <= len(listed) <= MOST_POINTS or not all(isinstance(p, dict) for p in listed):
        raise Refused(f'{where}: "points" must be a list of 1 to {MOST_POINTS} objects')
    for point in listed:
        need_keys(point, POINT, f"{where}: a point", POINT)
    points = [[number(p.get("value"), f"{where}: a value")]
              + [number(p.get(key), f"{where}: {key} of a point", 0, 1) for key in ("r", "g", "b", "opacity")] for p in listed]
    if any(a[0] > b[0] for a, b in zip(points, points[1:])):
        raise Refused(f"{where}: values of points must ascend")
    if root.get("color_space") == "srgb":
        points = [[p[0]] + [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in p[1:4]] + [p[4]] for p in points]
    elif root.get("color_space") != "linear":
        raise Refused(f'{where}: "color_space" must be linear or srgb')
    wanted = root.get("range")
    if wanted == "fit":
        lo, hi = fit_range
        points = [[lo + p[0] * (hi - lo)] + p[1:] for p in points]
    elif isinstance(wanted, list) and len(wanted) == 2:
        lo, hi = (number(v, f"{where}: the range") for v in wanted)
    else:
        raise Refused(f'{where}: "range" must be two numbers or "fit"')
    if not hi > lo:
        raise Refused(f"{where}: the range is {lo:g} to {hi:g}, its end must exceed its start")
    if unit == "unit_distance_voxels" and not voxel_mm:
        raise Refused(f'{where}: "unit_distance_voxels" needs the volume\'s voxels, which are not found')
    length = number(root[unit], f"{where}: {unit}", LEAST_MM, MOST_MM)
    return points, lo, hi, length if unit == "unit_distance_mm" else length * voxel_mm
