/* SPDX-License-Identifier: MIT */
#include "volume/arrays/placement.h"

#include <algorithm>
#include <cmath>

int world_axis_of(const std::string &name, const std::string &letter)
{
    static const struct {
        int axis;
        const char *name;
    } known[] = {{0, "xspace"},  {1, "yspace"}, {2, "zspace"},   {0, "x"},        {0, "lon"},      {0, "longitude"},
                 {0, "easting"}, {1, "y"},      {1, "lat"},      {1, "latitude"}, {1, "northing"}, {2, "z"},
                 {2, "depth"},   {2, "height"}, {2, "altitude"}, {2, "lev"},      {2, "level"}};
    if (letter == "X" || letter == "Y" || letter == "Z")
        return letter[0] - 'X';
    std::string low;
    for (const char c : name)
        low += static_cast<char>(tolower(static_cast<unsigned char>(c)));
    for (const auto &k : known)
        if (low == k.name)
            return k.axis;
    return -1;
}

namespace {

std::string number(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.6g", value);
    return text;
}

void take_unit(iso_child_header &header, int axis, const std::string &unit)
{
    snprintf(header.unit[axis], sizeof header.unit[axis], "%s", unit.c_str());
}

/* ---- MINC: a variable an axis, without samples but with these attributes ---- */

bool is_minc(const Array &array, const size_t (&space)[3])
{
    for (const size_t axis : space)
        if (array.axes[axis] != "xspace" && array.axes[axis] != "yspace" && array.axes[axis] != "zspace")
            return false;
    return true;
}

/* Returns the folder of the dimensions: "" in MINC 1. */
std::string minc_dimensions(const Array &array)
{
    return array.name.find('/') == std::string::npos ? "" : "minc-2.0/dimensions/";
}

void place_minc(Store &store, const Array &array, const size_t (&space)[3], const std::string &path,
                iso_child_header &header)
{
    header.world = ISO_CHILD_RAS;
    for (int a = 0; a < 3; ++a) {
        const std::string name = array.axes[space[a]], variable = minc_dimensions(array) + name;
        const int world = name[0] - 'x';
        const auto start = store.numbers(variable, "start"), step = store.numbers(variable, "step");
        auto cosines = store.numbers(variable, "direction_cosines");
        if (store.text(variable, "spacing") == "irregular")
            fail(ISO_E_FORMAT, path + ": its axis " + name + " is irregularly spaced, a grid is not");
        if (cosines.size() != 3) {
            cosines.assign(3, 0);
            cosines[static_cast<size_t>(world)] = 1;
        }
        if (step.empty())
            snprintf(header.unspaced, sizeof header.unspaced, "along its axis %s", name.c_str());
        for (size_t r = 0; r < 3; ++r) {
            header.step[a][r] = (step.empty() ? 1 : step[0]) * cosines[r];
            header.first[r] += (start.empty() ? 0 : start[0]) * cosines[r];
        }
        take_unit(header, world, store.text(variable, "units"));
    }
}

/* ---- coordinates of netCDF's conventions, and of HDF5's dimension scales ---- */

/* True if the coordinates are equally far apart within 1 %: they are often floats. Otherwise `uneven` gives the
 * range. */
bool take_steps(const std::vector<double> &at, double &step, std::string &uneven)
{
    double least = INFINITY, most = -INFINITY;
    step = at.size() > 1 ? (at.back() - at.front()) / static_cast<double>(at.size() - 1) : 1;
    for (size_t i = 1; i < at.size(); ++i) {
        least = std::min(least, at[i] - at[i - 1]);
        most = std::max(most, at[i] - at[i - 1]);
    }
    const bool even = at.size() == 1 || (std::isfinite(step) && step != 0 && most - least <= 0.01 * std::fabs(step));
    uneven = even ? "" : number(least) + " to " + number(most);
    return even;
}

void place_by_coordinates(Store &store, const Array &array, const size_t (&space)[3], iso_child_header &header)
{
    std::string coordinate[3], lacking, uneven;
    int world[3], seen = 0;
    for (int a = 0; a < 3; ++a) {
        coordinate[a] = store.coordinate(array, space[a]);
        world[a] = world_axis_of(array.axes[space[a]], coordinate[a].empty() ? "" : store.text(coordinate[a], "axis"));
        seen |= world[a] < 0 ? 0 : 1 << world[a];
    }
    bool any = false, all = true;
    for (int a = 0; a < 3; ++a) {
        const int to = seen == 7 ? world[a] : a;
        const auto at = coordinate[a].empty() ? std::vector<double>() : store.values(coordinate[a]);
        double step = 1;
        std::string off;
        header.step[a][to] = 1;
        if (at.size() != array.size[space[a]] || at.empty()) {
            lacking += (lacking.empty() ? "" : ", ") + array.axes[space[a]];
            all = false;
            continue;
        }
        any = true;
        if (!take_steps(at, step, off))
            uneven = "evenly: the steps of " + array.axes[space[a]] + " are " + off;
        else if (at.size() == 1) {
            lacking += (lacking.empty() ? "" : ", ") + array.axes[space[a]];
            all = false;
        }
        header.step[a][to] = std::isfinite(step) && step != 0 ? step : 1;
        header.first[to] = at[0];
        take_unit(header, to, store.text(coordinate[a], "units"));
    }
    header.world = any ? ISO_CHILD_OWN : ISO_CHILD_CENTERED;
    if (!uneven.empty() || !all)
        snprintf(header.unspaced, sizeof header.unspaced, "%s",
                 !uneven.empty() ? uneven.c_str()
                 : any           ? ("along its axis " + lacking).c_str()
                                 : "of its voxels");
}

/* Places the samples of microscopy's HDF5 files: one number per axis, in micrometers. */
bool place_by_element_size(Store &store, const Array &array, const size_t (&space)[3], iso_child_header &header)
{
    const auto size = store.numbers(array.name, "element_size_um");
    if (size.size() != 3 || array.size.size() != 3)
        return false;
    header.world = ISO_CHILD_CENTERED;
    for (int a = 0; a < 3; ++a) {
        header.step[a][a] = size[space[a]];
        take_unit(header, a, "um");
    }
    return true;
}

} // namespace

void take_frame_step(Store &store, const Array &array, size_t axis, iso_child_header &header)
{
    double step = 0;
    std::string unit, uneven;
    if (!store.frame_step(array, axis, step, unit)) {
        const std::string coordinate = store.coordinate(array, axis);
        const auto at = coordinate.empty() ? std::vector<double>() : store.values(coordinate);
        if (at.size() != array.size[axis] || at.size() < 2 || !take_steps(at, step, uneven))
            return;
        unit = store.text(coordinate, "units");
        unit = unit.substr(0, unit.find(" since ")); /* "days since 1970-01-01" */
    }
    if (std::isfinite(step) && step > 0) {
        header.frame_step = step;
        snprintf(header.frame_unit, sizeof header.frame_unit, "%s", unit.c_str());
    }
}

void place(Store &store, const Array &array, const size_t (&space)[3], const std::string &path,
           iso_child_header &header)
{
    if (is_minc(array, space))
        place_minc(store, array, space, path, header);
    else if (!store.place(array, space, header) && !place_by_element_size(store, array, space, header))
        place_by_coordinates(store, array, space, header);
}

namespace {

void type_range(iso_type type, double range[2])
{
    const int bits = static_cast<int>(8 * bytes_of(type));
    const bool is_signed = type == ISO_I8 || type == ISO_I16 || type == ISO_I32;
    range[0] = is_signed ? -std::ldexp(1, bits - 1) : 0;
    range[1] = std::ldexp(1, is_signed ? bits - 1 : bits) - 1;
}

/* Keeps the scales of a frame, of a file that has them for each slice of each frame, or for each frame. */
void take_frame(std::vector<double> &scales, size_t planes, size_t frame, const iso_child_header &header)
{
    const size_t frames = std::max<size_t>(header.frames, 1);
    const size_t count = scales.size() == frames * planes ? planes : scales.size() == frames ? 1 : 0;
    if (frames > 1 && count > 0)
        scales = {scales.begin() + static_cast<long>(frame * count),
                  scales.begin() + static_cast<long>((frame + 1) * count)};
}

SliceScales minc_scale(Store &store, const Array &array, size_t planes, size_t frame, const std::string &path,
                       iso_child_header &header)
{
    const std::string folder = array.name.substr(0, array.name.find_last_of('/') + 1);
    auto least = store.values(folder + "image-min"), most = store.values(folder + "image-max");
    SliceScales scales;
    take_frame(least, planes, frame, header);
    take_frame(most, planes, frame, header);
    if (array.type == ISO_F32 || array.type == ISO_F64 || least.empty() || least.size() != most.size())
        return scales;
    double range[2];
    type_range(array.type, range);
    auto valid = store.numbers(array.name, "valid_range");
    if (valid.size() == 2 && valid[0] != valid[1])
        range[0] = std::min(valid[0], valid[1]), range[1] = std::max(valid[0], valid[1]);
    for (size_t i = 0; i < least.size(); ++i) {
        const bool as_stored = least[i] == range[0] && most[i] == range[1];
        const double slope = as_stored ? 1 : (most[i] - least[i]) / (range[1] - range[0]);
        scales.slope.push_back(slope);
        scales.intercept.push_back(as_stored ? 0 : least[i] - slope * range[0]);
    }
    const auto all_same = [](const std::vector<double> &v) {
        return std::all_of(v.begin(), v.end(), [&v](double x) { return x == v[0]; });
    };
    if (all_same(scales.slope) && all_same(scales.intercept)) {
        if (scales.slope[0] != 0) {
            header.slope = scales.slope[0];
            header.intercept = scales.intercept[0];
        }
        return {};
    }
    if (scales.slope.size() != planes)
        fail(ISO_E_FORMAT,
             path + ": " + std::to_string(scales.slope.size()) + " scales for " + std::to_string(planes) + " slices");
    return scales;
}

} // namespace

SliceScales take_scale(Store &store, const Array &array, size_t planes, size_t frame, const std::string &path,
                       iso_child_header &header)
{
    const std::string leaf = array.name.substr(array.name.find_last_of('/') + 1);
    const bool is_minc = std::any_of(array.axes.begin(), array.axes.end(),
                                     [](const std::string &axis) { return axis == "xspace"; });
    if (leaf == "image" && is_minc)
        return minc_scale(store, array, planes, frame, path, header);
    const auto slope = store.numbers(array.name, "scale_factor"), offset = store.numbers(array.name, "add_offset");
    if (slope.size() == 1 && slope[0] != 0)
        header.slope = slope[0];
    if (offset.size() == 1)
        header.intercept = offset[0];
    return {};
}
