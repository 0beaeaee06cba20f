/* SPDX-License-Identifier: MIT */
#include "volume/itk/dicom_segments.h"

#include <cmath>

namespace {

/* Returns the distance of a frame from the file's first along the unit normal. */
double distance_of(const DicomFile &file, size_t frame, const Vector &n)
{
    const Vector &first = file.frames[0].plane.first, &own = file.frames[frame].plane.first;
    return n[0] * (own[0] - first[0]) + n[1] * (own[1] - first[1]) + n[2] * (own[2] - first[2]);
}

/* The slices of all frames. */
struct Slices {
    Vector normal{0, 0, 1};
    double least = 0, step = 0; /* distance of the first slice from the first frame; mm between slices */
    size_t count = 1;
    std::vector<size_t> of_frame;
};

Slices slices_of(const DicomFile &file)
{
    constexpr double same = 1e-3, most_slices = 65536;
    const Vector &u = file.frames[0].u, &v = file.frames[0].v;
    Slices s;
    s.normal = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::hypot(s.normal[0], s.normal[1], s.normal[2]);
    for (double &c : s.normal)
        c /= length;
    std::vector<double> places;
    for (size_t k = 0; k < file.frames.size(); ++k)
        places.push_back(distance_of(file, k, s.normal));
    std::sort(places.begin(), places.end());
    s.least = places.front();
    double gap = INFINITY;
    for (size_t i = 1; i < places.size(); ++i)
        gap = places[i] - places[i - 1] > same ? std::min(gap, places[i] - places[i - 1]) : gap;
    const double all = places.back() - s.least;
    if (!std::isfinite(gap))
        fail(ISO_E_FORMAT, file.path + ": segments of one slice; a volume has more");
    if (!(all / gap < most_slices))
        fail(ISO_E_FORMAT, file.path + ": damaged: slices " + std::to_string(gap) + " to " + std::to_string(all) +
                               " mm apart");
    s.count = static_cast<size_t>(std::round(all / gap)) + 1;
    s.step = all / static_cast<double>(s.count - 1);
    for (size_t k = 0; k < file.frames.size(); ++k) {
        const double at = (distance_of(file, k, s.normal) - s.least) / s.step;
        if (!(std::fabs(at - std::round(at)) <= 0.02))
            fail(ISO_E_FORMAT, file.path + ": its slices are not at even distances: " + file.frames[k].plane.name +
                                   " is " + std::to_string(at * s.step) + " mm from the first, one slice is " +
                                   std::to_string(s.step) + " mm");
        s.of_frame.push_back(static_cast<size_t>(std::round(at)));
    }
    return s;
}

class SegmentReader : public PlaneReader {
public:
    SegmentReader(const DicomFile &file, size_t channel)
        : file_(file), slices_(slices_of(file)), coded_(coded_samples(file))
    {
        if (file_.segments.empty())
            for (const auto &frame : file_.frames)
                add_segment(frame.segment);
        plane_ = file_.rows * file_.columns;
        is_fractional_ = file_.coding.bits > 1;
        const bool overlap = !is_fractional_ && !put_all(0);
        if (is_fractional_ || overlap) {
            if (channel >= file_.segments.size())
                fail(ISO_E_RANGE, file_.path + ": has no such segment");
            put_all(file_.segments[channel].number);
            name_channels();
        }
        header.is_labels = !is_fractional_;
        name_segments(file_, header);
        header.size[0] = file_.columns, header.size[1] = file_.rows, header.size[2] = slices_.count;
        header.type = ISO_U16;
        place();
    }

    void read_plane(char *out, size_t bytes) override
    {
        memcpy(out, &values_[plane_ * next_++], bytes);
    }

private:
    DicomFile file_;
    Slices slices_;
    Coded coded_;
    std::vector<uint16_t> values_;
    size_t plane_ = 0, next_ = 0;
    bool is_fractional_ = false;

    void add_segment(unsigned number)
    {
        for (const auto &segment : file_.segments)
            if (segment.number == number)
                return;
        file_.segments.push_back({number, ""});
    }

    /* Puts frames into values_: of one segment, 0: of all. False if segments overlap. */
    bool put_all(unsigned segment)
    {
        std::vector<char> own;
        values_.assign(plane_ * slices_.count, 0);
        for (size_t k = 0; k < file_.frames.size(); ++k) {
            const unsigned number = file_.frames[k].segment;
            if (segment != 0 && number != segment)
                continue;
            const char *samples = frame_samples(file_, coded_, k, own);
            uint16_t *to = &values_[plane_ * slices_.of_frame[k]];
            for (size_t i = 0; i < plane_; ++i) {
                const unsigned value = static_cast<unsigned char>(samples[i]);
                if (value == 0)
                    continue;
                if (to[i] != 0 && to[i] != number)
                    return false;
                to[i] = static_cast<uint16_t>(is_fractional_ ? value : number);
            }
        }
        return true;
    }

    void name_channels()
    {
        header.channels = file_.segments.size();
        for (size_t c = 0; c < header.channels && c < ISO_CHILD_CHANNELS; ++c)
            snprintf(header.channel_name[c], sizeof header.channel_name[c], "%s", file_.segments[c].name.c_str());
    }

    void place()
    {
        const DicomFrame &first = file_.frames[0];
        for (size_t r = 0; r < 3; ++r) {
            header.first[r] = first.plane.first[r] + slices_.least * slices_.normal[r];
            header.step[0][r] = first.u[r];
            header.step[1][r] = first.v[r];
            header.step[2][r] = slices_.step * slices_.normal[r];
        }
        header.world = first.has_place && file_.has_direction ? ISO_CHILD_LPS : ISO_CHILD_CENTERED;
        for (auto &unit : header.unit)
            snprintf(unit, sizeof unit, "mm");
        snprintf(header.unspaced, sizeof header.unspaced, "%s", file_.unspaced.c_str());
        snprintf(header.warning, sizeof header.warning, "%s", file_.warning.c_str());
    }
};

} // namespace

bool is_of_segments(const DicomFile &file)
{
    return std::all_of(file.frames.begin(), file.frames.end(), [](const auto &frame) { return frame.segment > 0; });
}

std::unique_ptr<PlaneReader> open_segments(const DicomFile &file, size_t channel)
{
    if (file.coding.bits > 8 || file.channels > 1)
        fail(ISO_E_FORMAT, file.path + ": segments of " + std::to_string(file.coding.bits) +
                               " bits per voxel, must be 1 or 8");
    return std::make_unique<SegmentReader>(file, channel);
}

void name_segments(const DicomFile &file, iso_child_header &header)
{
    size_t count = 0;
    for (const auto &segment : file.segments) {
        if (segment.name.empty() || count == ISO_CHILD_SEGMENTS)
            continue;
        iso_child_segment &to = header.segment[count++];
        to.label = static_cast<uint16_t>(segment.number);
        snprintf(to.name, sizeof to.name, "%s", segment.name.c_str());
    }
}
