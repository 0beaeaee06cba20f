/* SPDX-License-Identifier: MIT */
/* itk_read.cc - the program isoshade-itk: volumes by ITK's readers (child_stream.h). A file that holds a volume is read
 * at once; slices in files of their own are read one after the other. */
#include <gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

#include "volume/itk/slice.h"

namespace {

std::string number(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.6g", value);
    return text;
}

/* ---- folders ---- */

/* "a9" before "a10": runs of digits count as numbers. */
bool comes_before(const std::string &a, const std::string &b)
{
    size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (!isdigit(static_cast<unsigned char>(a[i])) || !isdigit(static_cast<unsigned char>(b[j]))) {
            if (a[i] != b[j])
                return a[i] < b[j];
            ++i, ++j;
            continue;
        }
        const auto run = [](const std::string &s, size_t &at) {
            while (at + 1 < s.size() && s[at] == '0' && isdigit(static_cast<unsigned char>(s[at + 1])))
                ++at;
            const size_t start = at;
            while (at < s.size() && isdigit(static_cast<unsigned char>(s[at])))
                ++at;
            return s.substr(start, at - start);
        };
        const std::string x = run(a, i), y = run(b, j);
        if (x != y)
            return x.size() != y.size() ? x.size() < y.size() : x < y;
    }
    return a.size() - i < b.size() - j;
}

std::string trimmed(std::string text)
{
    text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
    const size_t last = text.find_last_not_of(' ');
    return last == std::string::npos ? "" : text.substr(0, last + 1);
}

struct Series {
    std::string name;
    std::vector<std::string> files;
};

std::string name_of_series(const std::string &file)
{
    const auto io = itk::GDCMImageIO::New();
    io->SetFileName(file);
    io->ReadImageInformation();
    std::string text;
    itk::ExposeMetaData<std::string>(io->GetMetaDataDictionary(), "0008|103e", text);
    text = trimmed(text);
    if (text.empty())
        itk::ExposeMetaData<std::string>(io->GetMetaDataDictionary(), "0020|000e", text);
    return trimmed(text);
}

std::vector<Series> series_in(const std::string &folder)
{
    const auto names = itk::GDCMSeriesFileNames::New();
    names->SetUseSeriesDetails(true);
    names->SetDirectory(folder);
    std::vector<Series> all;
    for (const auto &uid : names->GetSeriesUIDs()) {
        const auto files = names->GetFileNames(uid);
        all.push_back({name_of_series(files.front()), files});
    }
    std::sort(all.begin(), all.end(), [](const Series &a, const Series &b) {
        return a.name != b.name ? comes_before(a.name, b.name) : a.files.front() < b.files.front();
    });
    return all;
}

const Series &choose(const std::vector<Series> &all, const char *wanted, const std::string &folder)
{
    if (!wanted && all.size() == 1)
        return all[0];
    for (size_t i = 0; wanted && i < all.size(); ++i)
        if (all[i].name == wanted || std::to_string(i + 1) == wanted)
            return all[i];
    std::string list;
    for (size_t i = 0; i < all.size(); ++i)
        list += (i ? ", " : "") + std::to_string(i + 1) + " \"" + all[i].name + "\" (" +
                std::to_string(all[i].files.size()) + " files)";
    fail(ISO_E_USAGE, folder + ": " +
                          (wanted ? "has no series \"" + std::string(wanted) + "\""
                                  : "holds " + std::to_string(all.size()) + " series") +
                          ", --series must be one of: " + list);
}

/* ---- a volume ---- */

class Reader : public PlaneReader {
public:
    Reader(const std::string &path, const char *series)
    {
        if (!std::filesystem::is_directory(path))
            open_file(path);
        else if (const auto all = series_in(path); !all.empty())
            open_series(choose(all, series, path), path);
        else
            open_pictures(path);
    }

    void read_plane(char *out, size_t plane) override
    {
        take_plane(out, plane);
        ++next_;
    }

private:
    std::vector<Slice> slices_;
    std::vector<char> whole_; /* of a file that holds all planes */
    size_t next_ = 0;

    void take_header(const Slice &s, size_t planes)
    {
        header.size[0] = s.size[0];
        header.size[1] = s.size[1];
        header.size[2] = planes;
        header.type = s.type;
        header.world = ISO_CHILD_CENTERED;
        for (int a = 0; a < 3; ++a) {
            header.first[a] = s.first[a];
            for (int r = 0; r < 3; ++r)
                header.step[a][r] = s.step[a][r];
        }
    }

    void set_patient()
    {
        header.world = ISO_CHILD_LPS;
        for (auto &unit : header.unit)
            snprintf(unit, sizeof unit, "mm");
    }

    void open_file(const std::string &path)
    {
        const Slice s = open_slice(path);
        if (s.size[2] < 2)
            fail(ISO_E_FORMAT, path + ": is one slice; a volume is the folder of its slices");
        take_header(s, s.size[2]);
        if (is_patient(s))
            set_patient();
        if (!is_patient(s) && s.io->GetSpacing(2) <= 0)
            snprintf(header.unspaced, sizeof header.unspaced, "of its voxels");
        slices_.push_back(s);
    }

    /* Sorted along the normal of their planes, which have to be as far from each other everywhere. The step from one to
     * the next is what their positions say: under a tilted gantry it is oblique to the planes. */
    void open_series(const Series &series, const std::string &folder)
    {
        for (const auto &file : series.files)
            slices_.push_back(open_slice(file));
        check_alike(folder);
        if (slices_.size() == 1) {
            const Slice only = slices_[0];
            slices_.clear();
            return open_file(only.path);
        }
        const Vector &u = slices_[0].step[0], &v = slices_[0].step[1];
        const Vector n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        const auto along = [&n](const Slice &s) { return n[0] * s.first[0] + n[1] * s.first[1] + n[2] * s.first[2]; };
        std::sort(slices_.begin(), slices_.end(), [&](const Slice &a, const Slice &b) { return along(a) < along(b); });
        take_header(slices_[0], slices_.size());
        for (int r = 0; r < 3; ++r)
            header.step[2][r] = (slices_.back().first[r] - slices_[0].first[r]) /
                                static_cast<double>(slices_.size() - 1);
        check_steps(folder);
        set_patient();
    }

    /* A missing slice, time steps, or echoes of one place. */
    void check_steps(const std::string &folder) const
    {
        const double *mean = header.step[2], length = std::hypot(mean[0], mean[1], mean[2]);
        double widest = 0, off_by = 0;
        std::string behind;
        for (size_t i = 1; i < slices_.size(); ++i) {
            Vector off;
            for (int r = 0; r < 3; ++r)
                off[r] = slices_[i].first[r] - slices_[i - 1].first[r];
            const double step = std::hypot(off[0], off[1], off[2]);
            if (step < 1e-4)
                fail(ISO_E_FORMAT, folder + ": two slices at one place (time steps or echoes?): " +
                                       slices_[i - 1].path + ", " + slices_[i].path);
            off_by = std::max(off_by, std::hypot(off[0] - mean[0], off[1] - mean[1], off[2] - mean[2]));
            if (step > widest)
                widest = step, behind = slices_[i].path;
        }
        if (!(off_by <= 0.02 * length + 1e-3))
            fail(ISO_E_FORMAT, folder + ": slices are not equally far apart (one is missing?): " + number(widest) +
                                   " mm before " + behind + ", " + number(length) + " mm on average");
    }

    /* One size; and one type, or float where rescaling gives them several. */
    void check_alike(const std::string &folder)
    {
        for (const auto &s : slices_) {
            if (s.size != slices_[0].size || (slices_.size() > 1 && s.size[2] != 1))
                fail(ISO_E_FORMAT, folder + ": slices of different sizes: " + slices_[0].path + ", " + s.path);
            if (s.type != slices_[0].type && slices_[0].type != ISO_F32)
                slices_[0].type = ISO_F32;
        }
    }

    void open_pictures(const std::string &folder)
    {
        std::vector<std::string> files;
        for (const auto &entry : std::filesystem::directory_iterator(folder)) {
            const std::string path = entry.path().string();
            if (entry.is_regular_file() && entry.path().filename().string()[0] != '.')
                files.push_back(path);
        }
        std::sort(files.begin(), files.end(), comes_before);
        for (const auto &file : files)
            slices_.push_back(open_slice(file));
        for (const auto &s : slices_)
            if (s.size[2] != 1)
                fail(ISO_E_FORMAT, folder + ": holds volumes, not slices: " + s.path);
        for (const auto &s : slices_)
            if (s.type != slices_[0].type)
                fail(ISO_E_FORMAT, folder + ": slices of different types: " + slices_[0].path + ", " + s.path);
        check_alike(folder);
        take_header(slices_[0], slices_.size());
        for (int a = 0; a < 3; ++a)
            for (int r = 0; r < 3; ++r)
                header.step[a][r] = a == r;
        snprintf(header.unspaced, sizeof header.unspaced, "of its voxels, as pictures do not");
    }

    template <typename T> static void to_float(const char *from, float *out, size_t count)
    {
        for (size_t i = 0; i < count; ++i) {
            T value;
            memcpy(&value, from + i * sizeof value, sizeof value);
            out[i] = static_cast<float>(value);
        }
    }

    static void as_float(iso_type type, const char *from, float *out, size_t count)
    {
        switch (type) {
        case ISO_U8: return to_float<uint8_t>(from, out, count);
        case ISO_I8: return to_float<int8_t>(from, out, count);
        case ISO_U16: return to_float<uint16_t>(from, out, count);
        case ISO_I16: return to_float<int16_t>(from, out, count);
        case ISO_U32: return to_float<uint32_t>(from, out, count);
        case ISO_I32: return to_float<int32_t>(from, out, count);
        case ISO_F32: return to_float<float>(from, out, count);
        case ISO_F64: return to_float<double>(from, out, count);
        }
    }

    void take_plane(char *out, size_t plane)
    {
        if (slices_.size() == 1) {
            if (whole_.empty()) {
                whole_.resize(plane * header.size[2]);
                read_samples(slices_[0], whole_.data(), whole_.size());
            }
            memcpy(out, whole_.data() + next_ * plane, plane);
            return;
        }
        /* The reader again: it holds its file open, and thousands of them are too many. */
        const Slice s = open_slice(slices_[next_].path);
        if (s.type == header.type)
            return read_samples(s, out, plane);
        const size_t count = header.size[0] * header.size[1];
        std::vector<char> stored(count * bytes_of(s.type));
        read_samples(s, stored.data(), stored.size());
        as_float(s.type, stored.data(), reinterpret_cast<float *>(out), count);
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

std::unique_ptr<PlaneReader> open_reader(const std::string &path, const Wanted &wanted)
{
    return std::make_unique<Reader>(path, wanted.part.empty() ? nullptr : wanted.part.c_str());
}

} // namespace

int main(int argc, char **argv)
{
    be_silent();
    return run_child({open_reader, cause_of}, argc, argv);
}
