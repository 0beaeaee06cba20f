/* SPDX-License-Identifier: MIT */
#include "volume/itk/stack.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

const std::vector<PlaneKey> plane_keys = {
    {"0020|0100", ""},      /* TemporalPositionIdentifier, and TemporalPositionIndex of frames */
    {"0018|1060", "ms"},    /* TriggerTime, and NominalCardiacTriggerDelayTime of frames */
    {"0054|1300", "ms"},    /* FrameReferenceTime */
    {"0020|9241", "%"},     /* NominalPercentageOfCardiacPhase */
    {"0008|002a", "clock"}, /* AcquisitionDateTime, and FrameAcquisitionDateTime of frames */
    {"0008|0032", "clock"}, /* AcquisitionTime */
    {"0020|0012", ""},      /* AcquisitionNumber */
    {"0018|0081", "ms"},    /* EchoTime */
    {"0018|9087", "s/mm2"}, /* DiffusionBValue */
};

namespace {

std::string number(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.6g", value);
    return text;
}

/* Returns the seconds of a clock, within a month of the same year, or the number. NAN if it is neither. */
double value_of(const std::string &text, const char *unit)
{
    char *end;
    const double value = strtod(text.c_str(), &end);
    if (end == text.c_str() || !std::isfinite(value))
        return NAN;
    if (std::string(unit) != "clock")
        return value;
    const double clock = std::fmod(value, 1e6), day = std::floor(value / 1e6);
    const double hours = std::floor(clock / 1e4), minutes = std::floor(std::fmod(clock, 1e4) / 100);
    return 86400 * std::fmod(day, 100) + 3600 * hours + 60 * minutes + std::fmod(clock, 100);
}

using Places = std::vector<std::vector<size_t>>; /* the planes at each place */

Places places_of(const std::vector<Plane> &planes, const Vector &n, double same)
{
    const auto along = [&](size_t i) {
        const Vector &p = planes[i].first;
        return n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
    };
    std::vector<size_t> order(planes.size());
    for (size_t i = 0; i < order.size(); ++i)
        order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return along(a) < along(b); });
    Places places;
    for (const size_t i : order)
        if (places.empty() || along(i) - along(places.back()[0]) > same)
            places.push_back({i});
        else
            places.back().push_back(i);
    return places;
}

[[noreturn]] void fail_at_one_place(const std::vector<Plane> &planes, const Places &places, const std::string &shown)
{
    size_t least = planes.size(), most = 0;
    for (const auto &place : places)
        least = std::min(least, place.size()), most = std::max(most, place.size());
    const auto &place = *std::find_if(places.begin(), places.end(), [&](const auto &p) { return p.size() == most; });
    const std::string two = planes[place[0]].name + ", " + planes[place[1]].name;
    if (least == 1)
        fail(ISO_E_FORMAT, shown + ": two slices at one place (time steps or echoes?): " + two);
    if (least < most)
        fail(ISO_E_FORMAT, shown + ": " + std::to_string(least) + " to " + std::to_string(most) +
                               " slices at a place (a time step is not complete?), such as " + two);
    fail(ISO_E_FORMAT, shown + ": " + std::to_string(most) +
                           " slices at each place, which no time, echo or b-value distinguishes, such as " + two);
}

/* True if the planes of each place differ in the key. */
bool tells_apart(const std::vector<Plane> &planes, const Places &places, size_t key)
{
    for (const auto &place : places) {
        std::set<double> values;
        for (const size_t i : place) {
            const double value = value_of(planes[i].keys[key], plane_keys[key].unit);
            if (std::isnan(value) || !values.insert(value).second)
                return false;
        }
    }
    return true;
}

/* Returns the value that orders frames of the same place; after the last key, the number of the file. */
double order_value(const Plane &plane, size_t key)
{
    return key < plane_keys.size() ? value_of(plane.keys[key], plane_keys[key].unit) : plane.number;
}

/* True if frames differ in InstanceNumber, and there are as many as the files state. */
bool are_numbered(const std::vector<Plane> &planes, const Places &places)
{
    for (const auto &place : places) {
        std::set<double> numbers;
        for (const size_t i : place)
            if (planes[i].times != place.size() || std::isnan(planes[i].number) ||
                !numbers.insert(planes[i].number).second)
                return false;
    }
    return true;
}

/* Chooses the key of frames. One with as many values as frames precedes one by which each slice has its own time. */
size_t choose_key(const std::vector<Plane> &planes, const Places &places, const std::string &shown)
{
    size_t found = plane_keys.size();
    for (size_t key = plane_keys.size(); key-- > 0;)
        if (tells_apart(planes, places, key))
            found = key;
    for (size_t key = found; key < plane_keys.size(); ++key) {
        std::set<double> values;
        for (const auto &plane : planes)
            values.insert(value_of(plane.keys[key], plane_keys[key].unit));
        if (values.size() == places[0].size() && tells_apart(planes, places, key))
            return key;
    }
    if (found == plane_keys.size() && !are_numbered(planes, places))
        fail_at_one_place(planes, places, shown);
    return found;
}

/* Takes the distance of frames if it is even (within 1 %): by the first key that is a time. */
void take_frame_step(const std::vector<Plane> &planes, const std::vector<size_t> &place, Stack &stack)
{
    const double resolution = planes[place[0]].resolution_ms;
    if (resolution > 0) {
        stack.frame_step = resolution, stack.frame_unit = "ms";
        return;
    }
    for (size_t key = 0; key < plane_keys.size(); ++key) {
        const std::string unit = plane_keys[key].unit;
        std::vector<double> at;
        for (const size_t i : place)
            at.push_back(value_of(planes[i].keys[key], plane_keys[key].unit));
        const double step = (at.back() - at.front()) / static_cast<double>(at.size() - 1);
        bool even = !unit.empty() && step > 0;
        for (size_t i = 1; i < at.size(); ++i)
            even = even && std::fabs(at[i] - at[i - 1] - step) <= 0.01 * step;
        if (even) {
            stack.frame_step = step, stack.frame_unit = unit == "clock" ? "s" : unit;
            return;
        }
    }
}

/* Returns the vector from a plane of the stack to another. */
Vector from_to(const std::vector<Plane> &planes, const Stack &stack, size_t a, size_t b)
{
    Vector off;
    for (size_t r = 0; r < 3; ++r)
        off[r] = planes[stack.planes[b]].first[r] - planes[stack.planes[a]].first[r];
    return off;
}

double length_of(const Vector &v)
{
    return std::hypot(v[0], v[1], v[2]);
}

/* Returns the place of each plane along the line from the first to the last, on which they have to be. */
std::vector<double> places_along(const std::vector<Plane> &planes, const Stack &stack, double same,
                                 const std::string &shown)
{
    const size_t count = stack.planes.size();
    const Vector all = from_to(planes, stack, 0, count - 1);
    const double length = length_of(all), most = 0.02 * length / static_cast<double>(count - 1) + same;
    std::vector<double> at;
    for (size_t i = 0; i < count; ++i) {
        const Vector off = from_to(planes, stack, 0, i);
        const double along = (off[0] * all[0] + off[1] * all[1] + off[2] * all[2]) / length;
        const double beside = std::sqrt(std::max(0., length_of(off) * length_of(off) - along * along));
        if (!(beside <= most))
            fail(ISO_E_FORMAT, shown + ": " + planes[stack.planes[i]].name + " is " + number(beside) +
                                   " mm off the line through the other slices");
        at.push_back(along);
    }
    return at;
}

/* Puts slices at the smallest distance of two planes. */
void resample(const std::vector<Plane> &planes, double same, const std::string &shown, Stack &stack)
{
    constexpr double most_times = 16;
    const std::vector<double> at = places_along(planes, stack, same, shown);
    const double count = static_cast<double>(at.size()), length = at.back();
    double least = INFINITY;
    for (size_t i = 1; i < at.size(); ++i)
        least = std::min(least, at[i] - at[i - 1]);
    const double steps = std::round(length / least);
    if (!(steps < most_times * count))
        fail(ISO_E_FORMAT, shown + ": --resample would make " + number(steps + 1) + " slices of " + number(count) +
                               ", must be at most " + number(most_times * count) + "; the smallest distance is " +
                               number(least) + " mm");
    const double step = length / steps;
    for (size_t k = 0, i = 0; k <= static_cast<size_t>(steps); ++k) {
        const double place = step * static_cast<double>(k);
        while (i + 2 < at.size() && at[i + 1] <= place)
            ++i;
        const double gap = at[i + 1] - at[i], exact = std::clamp((place - at[i]) / gap, 0., 1.);
        const double weight = exact * gap <= same ? 0 : (1 - exact) * gap <= same ? 1 : exact;
        stack.made += weight > 0 && weight < 1;
        stack.slices.push_back({i, i + 1, weight});
    }
    const Vector all = from_to(planes, stack, 0, at.size() - 1);
    for (size_t r = 0; r < 3; ++r)
        stack.step[r] = all[r] / steps;
}

/* Checks for a missing slice. */
void check_steps(const std::vector<Plane> &planes, double same, size_t uneven, const std::string &shown, Stack &stack)
{
    const Vector mean = stack.step;
    const double length = length_of(mean);
    double widest = 0, off_by = 0;
    std::string behind;
    for (size_t i = 1; i < stack.planes.size(); ++i) {
        const Vector off = from_to(planes, stack, i - 1, i);
        off_by = std::max(off_by, std::hypot(off[0] - mean[0], off[1] - mean[1], off[2] - mean[2]));
        if (length_of(off) > widest)
            widest = length_of(off), behind = planes[stack.planes[i]].name;
    }
    if (off_by <= 0.02 * length + same || uneven == ISO_UNEVEN_FORCE)
        return;
    if (uneven == ISO_UNEVEN_RESAMPLE)
        return resample(planes, same, shown, stack);
    fail(ISO_E_FORMAT, shown + ": slices are not equally far apart (one is missing?): " + number(widest) +
                           " mm before " + behind + ", " + number(length) +
                           " mm on average; --resample interpolates, --force-spacing takes the average");
}

/* Puts the step along the normal if rounding explains the difference: one unit in the last digit of the places per
 * slice, as of steps that were rounded and then added up, and that of the directions. No slice moves by a twentieth of
 * a pixel. */
void straighten(const std::vector<Plane> &planes, const Vector &n, double pixel, Stack &stack)
{
    double digit = INFINITY, turn_digit = INFINITY, along = 0, off = 0;
    for (const size_t i : stack.planes)
        digit = std::min(digit, planes[i].digit), turn_digit = std::min(turn_digit, planes[i].turn_digit);
    for (size_t r = 0; r < 3; ++r)
        along += stack.step[r] * n[r];
    for (size_t r = 0; r < 3; ++r)
        off = std::hypot(off, stack.step[r] - along * n[r]);
    const double rounding = std::sqrt(3) * (digit + turn_digit * std::fabs(along));
    if (off <= rounding && off * static_cast<double>(stack.planes.size() - 1) <= pixel / 20)
        stack.step = {along * n[0], along * n[1], along * n[2]};
}

} // namespace

Stack stack_of(const std::vector<Plane> &planes, const Vector &u, const Vector &v, const Wanted &wanted,
               const std::string &shown)
{
    const Vector n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::hypot(n[0], n[1], n[2]),
                 pixel = std::min(std::hypot(u[0], u[1], u[2]), std::hypot(v[0], v[1], v[2]));
    const double same = std::min(1e-3, pixel / 100); /* mm: one place */
    const Vector normal{n[0] / length, n[1] / length, n[2] / length};
    Places places = places_of(planes, normal, same);
    Stack stack;
    stack.frames = places[0].size();
    for (const auto &place : places)
        if (place.size() != stack.frames)
            fail_at_one_place(planes, places, shown);
    if (wanted.frame >= stack.frames)
        fail(ISO_E_RANGE, shown + ": has no such frame");
    if (stack.frames > 1) {
        const size_t key = choose_key(planes, places, shown);
        for (auto &place : places)
            std::sort(place.begin(), place.end(),
                      [&](size_t a, size_t b) { return order_value(planes[a], key) < order_value(planes[b], key); });
        take_frame_step(planes, places[0], stack);
        const double repetition = planes[places[0][0]].repetition_ms;
        if (key == plane_keys.size() && stack.frame_step == 0 && repetition > 0)
            stack.frame_step = repetition / 1000, stack.frame_unit = "s";
    }
    for (const auto &place : places)
        stack.planes.push_back(place[wanted.frame]);
    const Vector &first = planes[stack.planes.front()].first, &last = planes[stack.planes.back()].first;
    for (size_t r = 0; r < 3 && places.size() > 1; ++r)
        stack.step[r] = (last[r] - first[r]) / static_cast<double>(places.size() - 1);
    check_steps(planes, same, wanted.uneven, shown, stack);
    straighten(planes, normal, pixel, stack);
    return stack;
}
