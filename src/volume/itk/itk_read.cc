/* SPDX-License-Identifier: MIT */
/* itk_read.cc - the program isoshade-itk (child_stream.h): DICOM by GDCM's parser and decoders, pictures by ITK.
 * Slices in files of their own are read one after the other. */
#include <gdcmTrace.h>
#include <itkObject.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include "volume/itk/dicom_series.h"

namespace {

/* ---- DICOM ---- */

class DicomReader : public PlaneReader {
public:
    DicomReader(const DicomSeries &series, const std::string &shown, size_t frame) : files_(series.files)
    {
        std::vector<Plane> planes;
        const DicomFile &first = files_[0];
        place_by_number(shown);
        for (size_t f = 0; f < files_.size(); ++f)
            for (size_t k = 0; k < files_[f].frames.size(); ++k) {
                planes.push_back(files_[f].frames[k].plane);
                from_.push_back({f, k});
            }
        if (planes.size() < 2)
            fail(ISO_E_FORMAT, first.path + ": is one slice; a volume is the folder of its slices");
        const Stack stack = stack_of(planes, first.frames[0].u, first.frames[0].v, frame, shown);
        if (stack.planes.size() < 2)
            fail(ISO_E_FORMAT, shown + ": one slice, " + std::to_string(stack.frames) + " times; a volume has more");
        order_ = stack.planes;
        take_size();
        take_stack(stack, planes[order_[0]].first);
        take_words(series);
    }

    void read_plane(char *out, size_t) override
    {
        const auto [f, k] = from_[order_[next_++]];
        const DicomFile &file = files_[f];
        if (stored_.empty() || held_ != f) {
            stored_ = {};
            stored_ = stored_samples(file);
            held_ = f;
        }
        values_of_frame(file, k, stored_.data() + k * stored_frame_bytes(file), header.type, out);
    }

private:
    std::vector<DicomFile> files_;
    std::vector<std::pair<size_t, size_t>> from_; /* of each plane, its file and the frame of that */
    std::vector<size_t> order_;                   /* of the planes that are wanted */
    std::vector<char> stored_;                    /* of the file held_ */
    size_t held_ = 0, next_ = 0;

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
        header.size[2] = order_.size();
        header.type = type_of_values(files_);
    }

    void take_stack(const Stack &stack, const Vector &first)
    {
        const DicomFrame &frame = files_[0].frames[0];
        header.frames = stack.frames;
        header.frame_step = stack.frame_step;
        snprintf(header.frame_unit, sizeof header.frame_unit, "%s", stack.frame_unit.c_str());
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
};

/* ---- pictures ---- */

class PictureReader : public PlaneReader {
public:
    explicit PictureReader(const std::string &folder)
    {
        open_pictures(folder);
    }

    void read_plane(char *out, size_t plane) override
    {
        /* The reader again: it holds its file open, and thousands of them are too many. */
        read_samples(open_slice(slices_[next_].path), out, plane);
        ++next_;
    }

private:
    std::vector<Slice> slices_;
    size_t next_ = 0;

    void open_pictures(const std::string &folder)
    {
        std::vector<std::string> files;
        for (const auto &entry : std::filesystem::directory_iterator(folder)) {
            const std::string path = entry.path().string();
            if (entry.is_regular_file() && entry.path().filename().string()[0] != '.')
                files.push_back(path);
        }
        if (files.empty())
            fail(ISO_E_FORMAT, folder + ": holds no regular file, which a slice is");
        std::sort(files.begin(), files.end(), comes_before);
        for (const auto &file : files)
            slices_.push_back(open_slice(file));
        for (const auto &s : slices_)
            if (s.size[2] != 1)
                fail(ISO_E_FORMAT, folder + ": holds volumes, not slices: " + s.path);
        for (const auto &s : slices_)
            if (s.type != slices_[0].type)
                fail(ISO_E_FORMAT, folder + ": slices of different types: " + slices_[0].path + ", " + s.path);
        for (const auto &s : slices_)
            if (s.size != slices_[0].size)
                fail(ISO_E_FORMAT, folder + ": slices of different sizes: " + slices_[0].path + ", " + s.path);
        header.size[0] = slices_[0].size[0];
        header.size[1] = slices_[0].size[1];
        header.size[2] = slices_.size();
        header.type = slices_[0].type;
        header.world = ISO_CHILD_CENTERED;
        for (int a = 0; a < 3; ++a)
            header.step[a][a] = 1;
        snprintf(header.unspaced, sizeof header.unspaced, "of its voxels, as pictures do not");
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

std::unique_ptr<PlaneReader> open_file(const std::string &path, size_t frame)
{
    DicomFile file;
    if (read_dicom(path, file))
        return std::make_unique<DicomReader>(DicomSeries{"", {file}, ""}, path, frame);
    if (has_mark_of_dicom(path))
        fail(ISO_E_FORMAT, path + ": a DICOM file without an image");
    open_slice(path);
    fail(ISO_E_FORMAT, path + ": is one slice; a volume is the folder of its slices");
}

std::unique_ptr<PlaneReader> open_reader(const std::string &path, const Wanted &wanted)
{
    be_silent();
    if (!std::filesystem::is_directory(path))
        return open_file(path, wanted.frame);
    const DicomSeries series = choose_series(path, wanted.part.empty() ? nullptr : wanted.part.c_str());
    if (!series.files.empty())
        return std::make_unique<DicomReader>(series, path, wanted.frame);
    if (!wanted.part.empty())
        fail(ISO_E_USAGE, path + ": holds no series, --series chooses among those of a folder of DICOM slices");
    return std::make_unique<PictureReader>(path);
}

} // namespace

const ChildProgram child_program = {open_reader, cause_of};
