/* SPDX-License-Identifier: MIT */
/* itk_read.cc - the program isoshade-itk: volumes by ITK's readers (child_stream.h). A file that holds a volume is read
 * at once; slices in files of their own are read one after the other. */
#include <gdcmReader.h>
#include <gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <stdexcept>
#include <vector>

#include "volume/itk/multiframe.h"

namespace {

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

bool has_mark_of_dicom(const std::filesystem::path &file)
{
    char head[132] = "";
    std::ifstream(file, std::ios::binary).read(head, sizeof head);
    return memcmp(head + 128, "DICM", 4) == 0;
}

/* GDCM passes over a slice that breaks off, as over files of other kinds: the volume would lack it without a word. */
void check_none_is_damaged(const std::string &folder, const std::vector<Series> &all)
{
    std::set<std::string> taken;
    for (const auto &series : all)
        for (const auto &file : series.files)
            taken.insert(std::filesystem::path(file).filename());
    for (const auto &entry : std::filesystem::directory_iterator(folder)) {
        if (!entry.is_regular_file() || taken.count(entry.path().filename()) || !has_mark_of_dicom(entry.path()))
            continue;
        gdcm::Reader reader;
        reader.SetFileName(entry.path().c_str());
        if (!reader.Read())
            fail(ISO_E_FORMAT, entry.path().string() + ": a DICOM file that is damaged");
    }
}

double most_to_parse(const std::string &folder)
{
    double most = 0;
    for (const auto &entry : std::filesystem::directory_iterator(folder))
        if (entry.is_regular_file())
            most = std::max(most, bytes_to_parse(entry.path().string()));
    return most;
}

std::vector<Series> series_in(const std::string &folder)
{
    const ParseMemory memory(most_to_parse(folder));
    const auto names = itk::GDCMSeriesFileNames::New();
    names->SetUseSeriesDetails(true);
    names->SetDirectory(folder);
    std::vector<Series> all;
    for (const auto &uid : names->GetSeriesUIDs()) {
        const auto files = names->GetFileNames(uid);
        all.push_back({name_of_series(files.front()), files});
    }
    if (!all.empty())
        check_none_is_damaged(folder, all);
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
    Reader(const std::string &path, const char *series, size_t frame) : frame_(frame)
    {
        if (!std::filesystem::is_directory(path))
            open_file(path);
        else if (const auto all = series_in(path); !all.empty())
            open_series(choose(all, series, path), path);
        else if (series)
            fail(ISO_E_USAGE, path + ": holds no series, --series chooses among those of a folder of DICOM slices");
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
    std::vector<char> whole_;   /* of a file that holds all planes */
    std::vector<size_t> order_; /* of its frames; empty: as they are */
    size_t frame_, next_ = 0;

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
            take_frames(s);
        if (!is_patient(s) && s.io->GetSpacing(2) <= 0)
            snprintf(header.unspaced, sizeof header.unspaced, "of its voxels");
        slices_.push_back(s);
    }

    /* One file, whose frames may stand in any order, at several times. */
    void take_frames(const Slice &s)
    {
        const FramePlanes found = planes_in(s.path, s.size[2]);
        if (found.planes.empty()) {
            set_patient();
            if (!found.is_spaced)
                snprintf(header.unspaced, sizeof header.unspaced, "between its frames");
            return;
        }
        const Stack stack = stack_of(found.planes, found.u, found.v, frame_, s.path);
        if (stack.planes.size() < 2)
            fail(ISO_E_FORMAT, s.path + ": one slice, " + std::to_string(stack.frames) + " times; a volume has more");
        order_ = stack.planes;
        header.size[2] = order_.size();
        for (size_t r = 0; r < 3; ++r) {
            header.step[0][r] = found.u[r];
            header.step[1][r] = found.v[r];
        }
        take_stack(stack, found.planes[order_[0]].first);
    }

    /* Of a slice of a series, what the stack needs. */
    static Plane plane_of(const Slice &s)
    {
        Plane plane;
        const auto &words = s.io->GetMetaDataDictionary();
        std::string text;
        plane.name = s.path;
        plane.first = s.first;
        for (const auto &key : plane_keys) {
            text.clear();
            itk::ExposeMetaData<std::string>(words, key.tag, text);
            plane.keys.push_back(trimmed(text));
        }
        text.clear();
        itk::ExposeMetaData<std::string>(words, "0020|0110", text);
        plane.resolution_ms = strtod(text.c_str(), nullptr);
        text.clear();
        itk::ExposeMetaData<std::string>(words, "0008|0008", text);
        if (text.find("MOSAIC") != std::string::npos)
            fail(ISO_E_FORMAT, s.path + ": a mosaic of slices in one picture, which is not read; dcm2niix converts it");
        return plane;
    }

    void take_stack(const Stack &stack, const Vector &first)
    {
        header.frames = stack.frames;
        header.frame_step = stack.frame_step;
        snprintf(header.frame_unit, sizeof header.frame_unit, "%s", stack.frame_unit.c_str());
        for (int r = 0; r < 3; ++r) {
            header.first[r] = first[static_cast<size_t>(r)];
            header.step[2][r] = stack.step[static_cast<size_t>(r)];
        }
        set_patient();
    }

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
        check_turned(folder);
        std::vector<Plane> planes;
        for (const auto &s : slices_)
            planes.push_back(plane_of(s));
        const Stack stack = stack_of(planes, slices_[0].step[0], slices_[0].step[1], frame_, folder);
        if (stack.planes.size() < 2)
            fail(ISO_E_FORMAT, folder + ": one slice, " + std::to_string(stack.frames) + " times; a volume has more");
        take_header(slices_[0], stack.planes.size());
        std::vector<Slice> chosen;
        for (const size_t i : stack.planes)
            chosen.push_back(slices_[i]);
        slices_ = chosen;
        take_stack(stack, slices_[0].first);
    }

    void check_turned(const std::string &folder) const
    {
        for (const auto &s : slices_)
            for (size_t a = 0; a < 2; ++a)
                for (size_t r = 0; r < 3; ++r)
                    if (!(std::fabs(s.step[a][r] - slices_[0].step[a][r]) <=
                          1e-3 * std::fabs(s.io->GetSpacing(0)) + 1e-6))
                        fail(ISO_E_FORMAT, folder + ": slices of different directions or spacings: " + slices_[0].path +
                                               ", " + s.path);
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
                whole_.resize(plane * slices_[0].size[2]);
                read_samples(slices_[0], whole_.data(), whole_.size());
            }
            memcpy(out, whole_.data() + (order_.empty() ? next_ : order_[next_]) * plane, plane);
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
    be_silent();
    return std::make_unique<Reader>(path, wanted.part.empty() ? nullptr : wanted.part.c_str(), wanted.frame);
}

} // namespace

const ChildProgram child_program = {open_reader, cause_of};
