/* SPDX-License-Identifier: MIT */
#include "volume/itk/dicom_series.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "volume/itk/pictures.h"

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

namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_in(const std::string &folder)
{
    std::vector<std::string> files;
    for (const auto &entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename().string()[0] != '.')
            files.push_back(entry.path().string());
    std::sort(files.begin(), files.end(), comes_before);
    return files;
}

/* Returns the DICOM files of all folders below, such as those of a CD. */
std::vector<std::string> files_below(const std::string &folder)
{
    std::vector<std::string> files;
    for (const auto &entry : fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied))
        if (entry.is_regular_file() && entry.path().parent_path() != fs::path(folder) &&
            has_mark_of_dicom(entry.path().string()))
            files.push_back(entry.path().string());
    std::sort(files.begin(), files.end(), comes_before);
    return files;
}

bool near(const Vector &a, const Vector &b)
{
    const double most = 1e-3 * std::hypot(a[0], a[1], a[2]);
    return std::fabs(a[0] - b[0]) <= most && std::fabs(a[1] - b[1]) <= most && std::fabs(a[2] - b[2]) <= most;
}

bool belong_together(const DicomFile &a, const DicomFile &b)
{
    return a.series == b.series && a.rows == b.rows && a.columns == b.columns && near(a.frames[0].u, b.frames[0].u) &&
           near(a.frames[0].v, b.frames[0].v);
}

std::string content_of(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/* Returns the file of the series with the same bytes; NULL: none. */
const DicomFile *twin_in(const DicomSeries &series, const DicomFile &file)
{
    for (const auto &other : series.files)
        if (!file.instance.empty() && other.instance == file.instance &&
            content_of(other.path) == content_of(file.path))
            return &other;
    return nullptr;
}

void enter(std::vector<DicomSeries> &all, const DicomFile &file)
{
    auto own = std::find_if(all.begin(), all.end(), [&](const auto &s) { return belong_together(s.files[0], file); });
    if (own == all.end())
        return all.push_back({file.description.empty() ? file.series : file.description, {file}, ""});
    if (const DicomFile *twin = twin_in(*own, file)) {
        own->warning = file.path + " is ignored: it is the same as " + twin->path;
        return;
    }
    own->files.push_back(file);
}

std::vector<DicomSeries> series_in(const std::vector<std::string> &files)
{
    std::vector<DicomSeries> all;
    for (const auto &path : files) {
        DicomFile file;
        if (read_dicom(path, file))
            enter(all, file);
    }
    std::sort(all.begin(), all.end(), [](const auto &a, const auto &b) {
        return a.name != b.name ? comes_before(a.name, b.name) : comes_before(a.files[0].path, b.files[0].path);
    });
    return all;
}

size_t slices_of(const DicomSeries &series)
{
    size_t count = 0;
    for (const auto &file : series.files)
        count += file.frames.size();
    return count;
}

/* Returns the only series of more than one slice; NULL: none or several. */
const DicomSeries *only_volume(const std::vector<DicomSeries> &all)
{
    const DicomSeries *found = nullptr;
    for (const auto &series : all)
        if (slices_of(series) > 1 || all.size() == 1) {
            if (found)
                return nullptr;
            found = &series;
        }
    return found;
}

/* Returns the properties in which series of one name may differ. */
std::vector<std::string> properties_of(const DicomSeries &series)
{
    const DicomFile &file = series.files[0];
    const Vector &u = file.frames[0].u, &v = file.frames[0].v;
    const auto key = [&](const char *tag) {
        for (size_t i = 0; i < plane_keys.size(); ++i)
            if (std::string(plane_keys[i].tag) == tag)
                return file.frames[0].plane.keys[i];
        return std::string();
    };
    const double normal[3] = {std::fabs(u[1] * v[2] - u[2] * v[1]), std::fabs(u[2] * v[0] - u[0] * v[2]),
                              std::fabs(u[0] * v[1] - u[1] * v[0])};
    static const char *const planes[] = {"sagittal", "coronal", "axial"};
    const fs::path path = file.path;
    char spacing[64];
    snprintf(spacing, sizeof spacing, "%.4g x %.4g mm", std::hypot(u[0], u[1], u[2]), std::hypot(v[0], v[1], v[2]));
    const std::string echo = key("0018|0081"), time = key("0008|0032");
    return {std::to_string(file.columns) + " x " + std::to_string(file.rows),
            spacing,
            planes[std::max_element(normal, normal + 3) - normal],
            echo.empty() ? "" : "echo at " + echo + " ms",
            time.empty() ? "" : "at " + time,
            "in " + (series.files.size() == 1 ? path : path.parent_path()).filename().string()};
}

/* Returns what tells a series apart from others of its name, or from others without a name, each after a comma. */
std::string difference_of(const std::vector<DicomSeries> &all, const DicomSeries &series)
{
    const auto own = properties_of(series);
    std::vector<bool> differs(own.size());
    for (const auto &other : all) {
        const auto theirs = properties_of(other);
        const bool is_named = series.name != series.files[0].series || other.name != other.files[0].series;
        for (size_t i = 0; (other.name == series.name || !is_named) && i < own.size(); ++i)
            differs[i] = differs[i] || theirs[i] != own[i];
    }
    std::string text;
    for (size_t i = 0; i < own.size(); ++i)
        text += differs[i] && !own[i].empty() ? ", " + own[i] : "";
    return text;
}

[[noreturn]] void fail_to_choose(const std::vector<DicomSeries> &all, const char *wanted, const std::string &folder)
{
    constexpr size_t listed = 16;
    std::string list;
    for (size_t i = 0; i < std::min(all.size(), listed); ++i)
        list += (i ? ", " : "") + std::to_string(i + 1) + " \"" + all[i].name + "\" (" +
                std::to_string(all[i].files.size()) + (all[i].files.size() == 1 ? " file" : " files") +
                difference_of(all, all[i]) + ")";
    if (all.size() > listed)
        list += ", and " + std::to_string(all.size() - listed) + " more";
    fail(ISO_E_USAGE, folder + ": " +
                          (wanted ? "has no series \"" + std::string(wanted) + "\""
                                  : "holds " + std::to_string(all.size()) + " series") +
                          ", --series must be one of: " + list);
}

} // namespace

DicomSeries choose_series(const std::string &folder, const char *wanted)
{
    std::vector<DicomSeries> all = series_in(files_in(folder));
    if (all.empty() && !holds_pictures(folder))
        all = series_in(files_below(folder));
    if (all.empty())
        return {};
    for (size_t i = 0; wanted && i < all.size(); ++i)
        if (all[i].name == wanted || std::to_string(i + 1) == wanted)
            return all[i];
    const DicomSeries *only = wanted ? nullptr : only_volume(all);
    if (!only && !wanted && slices_of(all[0]) == 1 && slices_of(all[1]) == 1 &&
        all[0].files[0].series == all[1].files[0].series)
        fail(ISO_E_FORMAT, folder + ": slices of different sizes, directions or spacings: " + all[0].files[0].path +
                               ", " + all[1].files[0].path);
    if (!only)
        fail_to_choose(all, wanted, folder);
    DicomSeries chosen = *only;
    for (const auto &series : all)
        if (&series != only)
            chosen.warning += (chosen.warning.empty() ? "" : "; ") + series.files[0].path +
                              " is left out: one slice of another direction, size, spacing or series";
    return chosen;
}
