/* SPDX-License-Identifier: MIT */
/* itk_read.cc - the program isoshade-itk (child_stream.h): DICOM by GDCM's parser and decoders, pictures by ITK.
 * Slices in files of their own are read one after the other. */
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <gdcmTrace.h>
#include <itkObject.h>
#include <memory>
#include <vector>

#include "volume/itk/dicom.h"
#include "volume/itk/dicom_series.h"
#include "volume/itk/pictures.h"

/* ---- segmentations ---- */

/* Segmentations whose frames belong to one segment each (PS3.3 C.8.20): a label map.
 *
 * A voxel's label is the number of its segment. Segments that overlap, and those of fractional values, are channels
 * instead, named as the segments. Slices that the file leaves out are empty. */
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
        fail(ISO_E_FORMAT,
             file.path + ": damaged: slices " + std::to_string(gap) + " to " + std::to_string(all) + " mm apart");
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

/* Copies the names of its segments to the header of a label map. */
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

/* True if each frame belongs to a segment. */
bool is_of_segments(const DicomFile &file)
{
    return std::all_of(file.frames.begin(), file.frames.end(), [](const auto &frame) { return frame.segment > 0; });
}

/* Reads all frames. Throws Failure if slices have no even distance. */
std::unique_ptr<PlaneReader> open_segments(const DicomFile &file, size_t channel)
{
    if (file.coding.bits > 8 || file.channels > 1)
        fail(ISO_E_FORMAT,
             file.path + ": segments of " + std::to_string(file.coding.bits) + " bits per voxel, must be 1 or 8");
    return std::make_unique<SegmentReader>(file, channel);
}

/* ---- DICOM ---- */

class DicomReader : public PlaneReader {
public:
    DicomReader(const DicomSeries &series, const std::string &shown, const Wanted &wanted) : files_(series.files)
    {
        std::vector<Plane> planes;
        const DicomFile &first = files_[0];
        take_channel(shown, wanted.channel);
        place_by_number(shown);
        for (size_t f = 0; f < files_.size(); ++f)
            for (size_t k = 0; k < files_[f].frames.size(); ++k) {
                planes.push_back(files_[f].frames[k].plane);
                from_.push_back({f, k});
            }
        if (planes.size() < 2)
            fail(ISO_E_FORMAT, first.path + ": is one slice; a volume is the folder of its slices");
        const Stack stack = stack_of(planes, first.frames[0].u, first.frames[0].v, wanted, shown);
        if (stack.planes.size() < 2)
            fail(ISO_E_FORMAT, shown + ": one slice, " + std::to_string(stack.frames) + " times; a volume has more");
        order_ = stack.planes;
        slices_ = stack.slices;
        take_size();
        take_stack(stack, planes[order_[0]].first);
        take_words(series);
        take_made(stack, shown);
    }

    void read_plane(char *out, size_t bytes) override
    {
        const size_t k = next_++;
        if (slices_.empty())
            return read_stored(order_[k], out);
        const Between &between = slices_[k];
        if (between.weight == 0 || between.weight == 1)
            return read_stored(order_[between.weight == 0 ? between.first : between.second], out);
        std::vector<char> second(bytes);
        read_stored(order_[between.first], out);
        read_stored(order_[between.second], second.data());
        blend(header.type, between.weight, second.data(), bytes / bytes_of(header.type), out);
    }

private:
    std::vector<DicomFile> files_;
    std::vector<std::pair<size_t, size_t>> from_; /* of each plane, its file and the frame of that */
    std::vector<size_t> order_;                   /* of the planes that are wanted */
    Coded coded_;                                 /* of the file held_ */
    std::vector<char> own_;
    std::vector<Between> slices_; /* empty: each plane is a slice */
    size_t held_ = 0, next_ = 0;

    void read_stored(size_t plane, char *out)
    {
        const auto [f, k] = from_[plane];
        const DicomFile &file = files_[f];
        if (coded_.bytes.empty() || held_ != f) {
            coded_ = {};
            coded_ = coded_samples(file);
            held_ = f;
        }
        values_of_frame(file, k, frame_samples(file, coded_, k, own_), header.type, out);
    }

    /* Chooses the channel of colors, which all files have. */
    void take_channel(const std::string &shown, size_t channel)
    {
        const size_t channels = files_[0].channels;
        for (auto &file : files_) {
            if (file.channels != channels)
                fail(ISO_E_FORMAT, shown + ": slices of gray and of colors: " + files_[0].path + ", " + file.path);
            choose_channel(file, channel);
        }
        if (channel > (channels > 1 ? channels : 0))
            fail(ISO_E_RANGE, shown + ": has no such channel");
        header.channels = channels;
        header.is_color = channels > 1;
        header.is_labels = files_[0].is_label_map;
        if (header.is_labels)
            name_segments(files_[0], header);
    }

    /* Orders slices without positions by their numbers, at the distance of --spacing. */
    void place_by_number(const std::string &shown)
    {
        size_t placed = 0, single = 0;
        for (const auto &file : files_)
            placed += file.frames[0].has_place, single += file.frames.size() == 1;
        if (placed == files_.size() || files_.size() == 1)
            return;
        if (placed > 0 || single < files_.size())
            fail(ISO_E_FORMAT, shown + ": slices without ImagePositionPatient, their position");
        std::sort(files_.begin(), files_.end(), [](const auto &a, const auto &b) { return a.number < b.number; });
        for (size_t f = 0; f < files_.size(); ++f) {
            if (std::isnan(files_[f].number) || (f > 0 && files_[f].number == files_[f - 1].number))
                fail(ISO_E_FORMAT, shown + ": slices without ImagePositionPatient, and without numbers of their own: " +
                                       files_[f].path);
            const Vector &u = files_[0].frames[0].u, &v = files_[0].frames[0].v;
            Vector &first = files_[f].frames[0].plane.first;
            const double k = static_cast<double>(f);
            first = {k * (u[1] * v[2] - u[2] * v[1]), k * (u[2] * v[0] - u[0] * v[2]), k * (u[0] * v[1] - u[1] * v[0])};
        }
        files_[0].unspaced = "between its slices";
    }

    void take_size()
    {
        header.size[0] = files_[0].columns;
        header.size[1] = files_[0].rows;
        header.size[2] = slices_.empty() ? order_.size() : slices_.size();
        header.type = type_of_values(files_);
        take_padding();
    }

    /* Gives the values of padding. Frames of many scales have more of them than fit: then none is given. */
    void take_padding()
    {
        std::vector<double> values;
        for (const auto &file : files_)
            for (const auto &frame : file.frames) {
                const double value = frame.slope * file.padding + frame.intercept;
                if (file.padding != 0 && std::find(values.begin(), values.end(), value) == values.end())
                    values.push_back(value);
            }
        if (values.size() > sizeof header.fill / sizeof *header.fill)
            return;
        header.fill_count = values.size();
        std::copy(values.begin(), values.end(), header.fill);
    }

    void take_stack(const Stack &stack, const Vector &first)
    {
        const DicomFrame &frame = files_[0].frames[0];
        header.frames = stack.frames;
        header.frame_step = stack.frame_step;
        snprintf(header.frame_unit, sizeof header.frame_unit, "%s", stack.frame_unit.c_str());
        snprintf(header.value_unit, sizeof header.value_unit, "%s", files_[0].value_unit.c_str());
        for (size_t r = 0; r < 3; ++r) {
            header.first[r] = first[r];
            header.step[0][r] = frame.u[r];
            header.step[1][r] = frame.v[r];
            header.step[2][r] = stack.step[r];
        }
        header.world = frame.has_place && files_[0].has_direction ? ISO_CHILD_LPS : ISO_CHILD_CENTERED;
        for (auto &unit : header.unit)
            snprintf(unit, sizeof unit, "mm");
    }

    void take_words(const DicomSeries &series)
    {
        const DicomFile &first = files_[0];
        for (const auto &file : files_)
            if (!file.unspaced.empty())
                snprintf(header.unspaced, sizeof header.unspaced, "%s", file.unspaced.c_str());
        const std::string both = series.warning + (series.warning.empty() || first.warning.empty() ? "" : "; ") +
                                 first.warning;
        snprintf(header.warning, sizeof header.warning, "%s", both.c_str());
    }

    void take_made(const Stack &stack, const std::string &shown)
    {
        const std::string made = shown + ": " + std::to_string(stack.made) + " of " +
                                 std::to_string(stack.slices.size()) + " slices are interpolated; " + header.warning;
        if (stack.made > 0)
            snprintf(header.warning, sizeof header.warning, "%s",
                     header.warning[0] ? made.c_str() : made.substr(0, made.size() - 2).c_str());
    }
};

/* ---- the output ---- */

void be_silent()
{
    itk::Object::GlobalWarningDisplayOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    gdcm::Trace::DebugOff();
}

std::unique_ptr<PlaneReader> open_file(const std::string &path, const Wanted &wanted)
{
    DicomFile file;
    if (read_dicom(path, file) && is_of_segments(file))
        return open_segments(file, wanted.channel);
    if (!file.frames.empty())
        return std::make_unique<DicomReader>(DicomSeries{"", {file}, ""}, path, wanted);
    if (std::filesystem::path(path).filename() == "DICOMDIR")
        fail(ISO_E_FORMAT, path + ": the index of a folder; give the folder, which stands for all below it");
    if (has_mark_of_dicom(path))
        fail(ISO_E_FORMAT, path + ": a DICOM file without an image");
    open_slice(path);
    fail(ISO_E_FORMAT, path + ": is one slice; a volume is the folder of its slices");
}

std::unique_ptr<PlaneReader> open_reader(const std::string &path, const Wanted &wanted)
{
    be_silent();
    if (!std::filesystem::is_directory(path))
        return open_file(path, wanted);
    const DicomSeries series = choose_series(path, wanted.part.empty() ? nullptr : wanted.part.c_str());
    if (series.files.size() == 1 && is_of_segments(series.files[0]))
        return open_segments(series.files[0], wanted.channel);
    if (!series.files.empty())
        return std::make_unique<DicomReader>(series, path, wanted);
    if (!wanted.part.empty())
        fail(ISO_E_USAGE, path + ": holds no series, --series chooses among those of a folder of DICOM slices");
    return open_pictures(path, wanted.channel);
}

} // namespace

const ChildProgram child_program = {open_reader, cause_of};
