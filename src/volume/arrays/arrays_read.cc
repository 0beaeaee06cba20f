/* SPDX-License-Identifier: MIT */
/* arrays_read.cc - the program isoshade-arrays: one array of an HDF5, netCDF, MINC or Zarr file as a volume. */
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "volume/arrays/placement.h"
#include "volume/arrays/store.h"

namespace {

constexpr size_t SLAB_BYTES = 256 << 20;

/* A header of a few bytes may promise samples of the fill value that take hours. Up to this size, a volume of 2048^3
 * floats, they take minutes, as in a sparse volume; a plane costs as much as LEAST_OF_A_PLANE bytes. */
constexpr double MOST_WITHOUT_CHUNKS = 2048. * 2048 * 2048 * 4, LEAST_OF_A_PLANE = 4096;

std::unique_ptr<Store> open_store(const std::string &path)
{
    char head[4] = "";
    if (std::filesystem::is_directory(path))
        return open_zarr(path);
    std::ifstream(path, std::ios::binary).read(head, 4);
    return memcmp(head, "CDF", 3) == 0 ? open_netcdf(path) : open_hdf5(path);
}

std::string sizes_of(const Array &array)
{
    std::string text;
    for (size_t a = array.size.size(); a-- > 0;)
        text += std::to_string(array.size[a]) + (a ? " x " : "");
    return text;
}

bool is_grid(const Array &array)
{
    return array.size.size() >= 3;
}

/* Lists the first dozen arrays, for messages. */
std::string list_of(const std::vector<Array> &all)
{
    std::string text;
    size_t count = 0;
    for (const auto &array : all)
        if (is_grid(array) && ++count <= 12)
            text += (text.empty() ? "" : ", ") + array.name + " (" + sizes_of(array) + ")";
    return count > 12 ? text + " and " + std::to_string(count - 12) + " more" : text;
}

const Array &choose(const std::vector<Array> &all, std::string wanted, const std::string &path)
{
    const size_t grids = static_cast<size_t>(std::count_if(all.begin(), all.end(), is_grid));
    while (!wanted.empty() && wanted[0] == '/')
        wanted.erase(0, 1);
    for (const auto &array : all)
        if (array.name == wanted && is_grid(array))
            return array;
    if (wanted.empty() && grids == 1)
        return *std::find_if(all.begin(), all.end(), is_grid);
    if (grids == 0)
        fail(ISO_E_FORMAT, path + ": holds no dataset of three axes");
    fail(ISO_E_USAGE, path +
                          (wanted.empty() ? ": holds " + std::to_string(grids) + " datasets of three axes or more"
                                          : ": has no dataset \"" + wanted + "\" of three axes") +
                          ", FILE:DATASET must name one of: " + list_of(all));
}

/* An array's axes: those of the grid, the fastest first, and any others. */
struct Axes {
    size_t space[3] = {};
    long frame = -1, channel = -1;
};

[[noreturn]] void refuse_axes(const Array &array, const std::string &path)
{
    std::string names;
    for (const auto &name : array.axes)
        names += name.empty() ? "" : (names.empty() ? " (" : ", ") + name;
    fail(ISO_E_FORMAT, path + ": " + sizes_of(array) + " samples along " + std::to_string(array.size.size()) + " axes" +
                           (names.empty() ? " without names" : names + ", the last the fastest)") +
                           ": names for a volume's three axes are missing");
}

bool is_channel(const std::string &name)
{
    return name == "c" || name == "channel" || name == "channels" || name == "band" || name == "component" ||
           name == "vector_dimension";
}

/* Sorts four axes without names as NumPy's: the fastest has channels if it has at most four samples, or else the slowest
 * time. */
Axes unnamed_axes(const Array &array, const std::vector<size_t> &left)
{
    Axes axes;
    const bool has_channels = array.size[left[3]] <= 4;
    (has_channels ? axes.channel : axes.frame) = static_cast<long>(left[has_channels ? 3 : 0]);
    for (size_t a = 0; a < 3; ++a)
        axes.space[a] = left[(has_channels ? 2 : 3) - a];
    return axes;
}

/* Finds the axes of space. Axes of one sample are left out until three remain; with more, x, y and z have to be
 * found by their names. */
Axes axes_of(const Array &array, const std::string &path)
{
    Axes axes;
    std::vector<size_t> left(array.size.size()), space;
    for (size_t a = 0; a < left.size(); ++a)
        left[a] = a;
    for (size_t i = 0; left.size() > 3 && i < left.size();)
        if (array.size[left[i]] == 1 && world_axis_of(array.axes[left[i]], "") < 0)
            left.erase(left.begin() + static_cast<long>(i));
        else
            ++i;
    if (left.size() == 4 && std::all_of(left.begin(), left.end(), [&](size_t a) { return array.axes[a].empty(); }))
        return unnamed_axes(array, left);
    int seen = 0;
    for (const size_t a : left) {
        const int world = world_axis_of(array.axes[a], "");
        const bool is_space = left.size() == 3 || world >= 0;
        if (is_space)
            space.push_back(a), seen |= world < 0 ? 0 : 1 << world;
        else if (is_channel(array.axes[a]) && axes.channel < 0)
            axes.channel = static_cast<long>(a);
        else if (axes.frame < 0)
            axes.frame = static_cast<long>(a);
        else
            refuse_axes(array, path);
    }
    if (space.size() != 3 || (left.size() > 3 && seen != 7))
        refuse_axes(array, path);
    for (size_t a = 0; a < 3; ++a)
        axes.space[a] = space[2 - a];
    return axes;
}

class ArrayReader : public PlaneReader {
public:
    ArrayReader(const std::string &path, const Wanted &wanted) : store_(open_store(path)), wanted_(wanted)
    {
        const std::string main = wanted.part.empty() ? store_->main_array(wanted.frame, wanted.channel) : wanted.part;
        array_ = choose(store_->arrays(), main, path);
        shown_ = array_.name.empty() ? path : path + ":" + array_.name;
        if (!array_.refused.empty())
            fail(ISO_E_FORMAT, shown_ + ": " + array_.refused);
        axes_ = axes_of(array_, shown_);
        for (int a = 0; a < 3; ++a)
            header.size[a] = array_.size[axes_.space[a]];
        take_choices();
        if (std::count(header.size, header.size + 3, 0))
            fail(ISO_E_FORMAT, shown_ + ": has no samples: " + sizes_of(array_));
        header.type = array_.type;
        check_stored_bytes();
        allow_slab();
        place(*store_, array_, axes_.space, shown_, header);
        snprintf(header.value_unit, sizeof header.value_unit, "%s", store_->text(array_.name, "units").c_str());
        if (header.frames > 1)
            take_frame_step(*store_, array_, axes_.frame < 0 ? 0 : static_cast<size_t>(axes_.frame), header);
        scales_ = take_scale(*store_, array_, header.size[2], wanted.frame, shown_, header);
        if (!scales_.slope.empty())
            header.type = ISO_F32;
        header.is_whole = array_.is_whole && scales_.slope.empty();
        take_fills();
    }

    void read_plane(char *out, size_t) override
    {
        const size_t count = header.size[0] * header.size[1], plane = count * bytes_of(array_.type);
        if (next_ >= slab_first_ + slab_planes_)
            load_slab(plane);
        const char *from = slab_.data() + (next_ - slab_first_) * plane;
        if (scales_.slope.empty())
            memcpy(out, from, plane);
        else
            scale(from, count, scales_.slope[next_], scales_.intercept[next_], reinterpret_cast<float *>(out));
        ++next_;
    }

private:
    std::unique_ptr<Store> store_;
    Array array_;
    std::string shown_;
    Wanted wanted_;
    Axes axes_;
    SliceScales scales_;
    std::vector<char> slab_; /* planes that chunks hold together */
    size_t slab_first_ = 0, slab_planes_ = 0, next_ = 0;

    void take_choices()
    {
        const bool is_main = wanted_.part.empty();
        header.frames = axes_.frame < 0 ? (is_main ? store_->array_frames() : 1)
                                        : array_.size[static_cast<size_t>(axes_.frame)];
        header.channels = axes_.channel < 0 ? (is_main ? store_->array_channels() : 1)
                                            : array_.size[static_cast<size_t>(axes_.channel)];
        const auto names = store_->channel_names(array_);
        for (size_t c = 0; c < names.size() && c < sizeof header.channel_name / sizeof *header.channel_name; ++c)
            snprintf(header.channel_name[c], sizeof header.channel_name[c], "%s", names[c].c_str());
        if (wanted_.frame >= header.frames || wanted_.channel >= header.channels)
            fail(ISO_E_RANGE, shown_ + ": has no such frame or channel");
    }

    /* Reads the fill values under the names of CF, netCDF and Zarr. */
    void take_fills()
    {
        auto all = store_->fills(array_);
        for (const char *name : {"_FillValue", "missing_value"})
            for (const double value : store_->numbers(array_.name, name))
                all.push_back(value);
        for (const double value : all)
            if (header.fill_count < sizeof header.fill / sizeof *header.fill &&
                std::find(header.fill, header.fill + header.fill_count, value) == header.fill + header.fill_count)
                header.fill[header.fill_count++] = value;
    }

    double plane_bytes() const
    {
        return static_cast<double>(header.size[0]) * static_cast<double>(header.size[1]) *
               static_cast<double>(bytes_of(array_.type));
    }

    void check_stored_bytes()
    {
        const double planes = static_cast<double>(header.size[2]), need = planes * plane_bytes();
        if (planes * std::max(plane_bytes(), LEAST_OF_A_PLANE) <= MOST_WITHOUT_CHUNKS)
            return;
        const double enough = need / MOST_OF_A_BYTE, there = store_->stored_bytes(array_, enough);
        if (there < enough)
            fail(ISO_E_FORMAT, shown_ + ": its chunks have " + std::to_string(static_cast<size_t>(there)) +
                                   " bytes, each of which can hold " +
                                   std::to_string(static_cast<size_t>(MOST_OF_A_BYTE)) + " of samples: too few for " +
                                   sizes_of(array_));
    }

    /* Allows memory for a slab, a plane in the file's type, and a chunk. For a sparse volume, or well packed zeros,
     * the file's size does not bound them. A plane larger than a slab has to fit the bound by the file's size, as
     * all other memory does. */
    void allow_slab()
    {
        const double plane = std::min(plane_bytes(), static_cast<double>(SLAB_BYTES));
        allow_memory(SLAB_BYTES + static_cast<size_t>(plane) + store_->chunk_memory(array_));
    }

    void load_slab(size_t plane)
    {
        const size_t fits = std::max<size_t>(SLAB_BYTES / plane, 1);
        const size_t axis = axes_.space[2],
                     chunk = axis < array_.chunk.size() ? std::max<size_t>(array_.chunk[axis], 1) : 1;
        slab_first_ = next_;
        slab_planes_ = std::min({chunk, fits, header.size[2] - next_});
        slab_.resize(slab_planes_ * plane);
        std::vector<size_t> start(array_.size.size(), 0), count(array_.size.size(), 1);
        for (const size_t a : axes_.space)
            count[a] = array_.size[a];
        start[axis] = slab_first_;
        count[axis] = slab_planes_;
        if (axes_.frame >= 0)
            start[static_cast<size_t>(axes_.frame)] = wanted_.frame;
        if (axes_.channel >= 0)
            start[static_cast<size_t>(axes_.channel)] = wanted_.channel;
        store_->read(array_, start, count, slab_.data());
    }

    template <typename T>
    static void scale_as(const char *from, size_t count, double slope, double intercept, float *out)
    {
        for (size_t i = 0; i < count; ++i) {
            T value;
            memcpy(&value, from + i * sizeof value, sizeof value);
            out[i] = static_cast<float>(slope * static_cast<double>(value) + intercept);
        }
    }

    void scale(const char *from, size_t count, double slope, double intercept, float *out) const
    {
        switch (array_.type) {
        case ISO_U8: return scale_as<uint8_t>(from, count, slope, intercept, out);
        case ISO_I8: return scale_as<int8_t>(from, count, slope, intercept, out);
        case ISO_U16: return scale_as<uint16_t>(from, count, slope, intercept, out);
        case ISO_I16: return scale_as<int16_t>(from, count, slope, intercept, out);
        case ISO_U32: return scale_as<uint32_t>(from, count, slope, intercept, out);
        case ISO_I32: return scale_as<int32_t>(from, count, slope, intercept, out);
        case ISO_F32: return scale_as<float>(from, count, slope, intercept, out);
        case ISO_F64: return scale_as<double>(from, count, slope, intercept, out);
        }
    }
};

std::unique_ptr<PlaneReader> open_reader(const std::string &path, const Wanted &wanted)
{
    return std::make_unique<ArrayReader>(path, wanted);
}

std::string cause_of(const std::exception &e)
{
    return e.what();
}

} // namespace

const ChildProgram child_program = {open_reader, cause_of};
