/* SPDX-License-Identifier: MIT */
/* hdf5_store.cc - HDF5 and the formats based on it: netCDF-4, MINC 2. */
#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "volume/arrays/store.h"

namespace {

/* Closes an object that HDF5 opened. */
class Handle {
public:
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    Handle(const Handle &) = delete;
    Handle &operator=(const Handle &) = delete;
    ~Handle()
    {
        if (id_ >= 0)
            close_(id_);
    }
    operator hid_t() const
    {
        return id_;
    }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/* Returns the cause of a failure. HDF5 has a text for each step that failed; the innermost has the cause. */
std::string why()
{
    std::string text = "cannot be read";
    H5Ewalk2(
        H5E_DEFAULT, H5E_WALK_UPWARD,
        [](unsigned n, const H5E_error2_t *e, void *out) -> herr_t {
            if (n == 0 && e->desc)
                *static_cast<std::string *>(out) = e->desc;
            return 0;
        },
        &text);
    return text;
}

/* Finds the sample type. Half floats, and other types that fit into a float, become float. */
bool type_of(hid_t stored, iso_type &type, std::string &refused)
{
    const H5T_class_t kind = H5Tget_class(stored);
    const size_t bytes = H5Tget_size(stored);
    if (kind == H5T_FLOAT && bytes <= 8) {
        type = bytes <= 4 ? ISO_F32 : ISO_F64;
        return true;
    }
    if (kind == H5T_ENUM && bytes == 1) { /* Booleans, as h5py writes them */
        type = ISO_U8;
        return true;
    }
    if (kind == H5T_INTEGER && (bytes == 1 || bytes == 2 || bytes == 4)) {
        const bool is_signed = H5Tget_sign(stored) == H5T_SGN_2;
        type = bytes == 1   ? is_signed ? ISO_I8 : ISO_U8
               : bytes == 2 ? is_signed ? ISO_I16 : ISO_U16
               : is_signed  ? ISO_I32
                            : ISO_U32;
        return true;
    }
    if (kind == H5T_INTEGER && bytes == 8) {
        type = ISO_F64; /* marked by the array's is_whole */
        return true;
    }
    refused = kind == H5T_INTEGER    ? "integers of " + std::to_string(8 * bytes) + " bits"
              : kind == H5T_FLOAT    ? "floats of " + std::to_string(8 * bytes) + " bits"
              : kind == H5T_STRING   ? "text"
              : kind == H5T_COMPOUND ? "several components per voxel"
                                     : "a type that is no number";
    return false;
}

hid_t memory_type(iso_type type)
{
    switch (type) {
    case ISO_U8: return H5T_NATIVE_UINT8;
    case ISO_I8: return H5T_NATIVE_INT8;
    case ISO_U16: return H5T_NATIVE_UINT16;
    case ISO_I16: return H5T_NATIVE_INT16;
    case ISO_U32: return H5T_NATIVE_UINT32;
    case ISO_I32: return H5T_NATIVE_INT32;
    case ISO_F32: return H5T_NATIVE_FLOAT;
    case ISO_F64: return H5T_NATIVE_DOUBLE;
    }
    return H5T_NATIVE_DOUBLE;
}

class Hdf5 : public Store {
public:
    explicit Hdf5(const std::string &path) : path_(path), file_(open(path), H5Fclose)
    {
        if (file_ < 0)
            fail(ISO_E_FORMAT, path + ": HDF5: " + why());
    }

    std::vector<Array> arrays() override
    {
        names_.clear();
        const herr_t done = H5Lvisit_by_name(
            file_, "/", H5_INDEX_NAME, H5_ITER_INC,
            [](hid_t group, const char *name, const H5L_info_t *, void *self) -> herr_t {
                static_cast<Hdf5 *>(self)->note(group, name);
                return 0;
            },
            this, H5P_DEFAULT);
        if (done < 0)
            fail(ISO_E_FORMAT, path_ + ": HDF5: " + why());
        std::vector<Array> all;
        for (const auto &name : names_)
            all.push_back(describe(name));
        return all;
    }

    std::vector<double> numbers(const std::string &array, const std::string &attribute) override
    {
        const Handle a(open_attribute(array, attribute), H5Aclose);
        if (a < 0)
            return {};
        const Handle type(H5Aget_type(a), H5Tclose), space(H5Aget_space(a), H5Sclose);
        const hssize_t n = H5Sget_simple_extent_npoints(space);
        if ((H5Tget_class(type) != H5T_FLOAT && H5Tget_class(type) != H5T_INTEGER) || n < 1 || n > 1 << 16)
            return {};
        std::vector<double> values(static_cast<size_t>(n));
        return H5Aread(a, H5T_NATIVE_DOUBLE, values.data()) < 0 ? std::vector<double>{} : values;
    }

    std::string text(const std::string &array, const std::string &attribute) override
    {
        const Handle a(open_attribute(array, attribute), H5Aclose);
        if (a < 0)
            return "";
        const Handle type(H5Aget_type(a), H5Tclose), space(H5Aget_space(a), H5Sclose);
        const hssize_t count = H5Sget_simple_extent_npoints(space);
        if (H5Tget_class(type) != H5T_STRING || count < 1 || count > 1 << 12)
            return "";
        if (H5Tis_variable_str(type) == 0 && H5Tget_size(type) == 1) /* Imaris has a string a character */
            return joined(a, type, static_cast<size_t>(count));
        if (count != 1)
            return "";
        if (H5Tis_variable_str(type) > 0) {
            char *read = nullptr;
            const Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
            H5Tset_size(memory, H5T_VARIABLE);
            H5Tset_cset(memory, H5Tget_cset(type));
            std::string result = H5Aread(a, memory, &read) >= 0 && read ? read : "";
            if (read)
                H5free_memory(read);
            return result;
        }
        const size_t bytes = H5Tget_size(type);
        if (bytes == 0 || bytes > 1 << 16)
            return "";
        std::string result(bytes, 0);
        if (H5Aread(a, type, &result[0]) < 0)
            return "";
        result.resize(strnlen(result.c_str(), bytes));
        return result;
    }

    double stored_bytes(const Array &array, double) override
    {
        const Handle set(H5Dopen2(file_, array.name.c_str(), H5P_DEFAULT), H5Dclose);
        return set >= 0 ? static_cast<double>(H5Dget_storage_size(set)) : 0;
    }

    /* ---- Imaris: an array for each level, time point and channel; the image as a box ---- */

    std::string main_array(size_t frame, size_t channel) override
    {
        return is_imaris() ? imaris_channel(frame, channel) + "/Data" : "";
    }

    size_t array_frames() override
    {
        size_t count = 1;
        while (is_imaris() && exists(imaris_channel(count, 0)))
            ++count;
        return count;
    }

    size_t array_channels() override
    {
        size_t count = 1;
        while (is_imaris() && exists(imaris_channel(0, count)))
            ++count;
        return count;
    }

    std::vector<std::string> channel_names(const Array &) override
    {
        std::vector<std::string> names;
        for (size_t c = 0; is_imaris() && c < array_channels(); ++c)
            names.push_back(text("DataSetInfo/Channel " + std::to_string(c), "Name"));
        return names;
    }

    /* VTK's image data: points at Origin and steps of Spacing along the columns of Direction; cells between them. */
    bool place_vtkhdf(const Array &array, iso_child_header &header)
    {
        auto origin = numbers("VTKHDF", "Origin"), spacing = numbers("VTKHDF", "Spacing"),
             direction = numbers("VTKHDF", "Direction");
        const auto extent = numbers("VTKHDF", "WholeExtent");
        const double half = array.name.rfind("VTKHDF/CellData/", 0) == 0 ? 0.5 : 0;
        if (origin.size() != 3 || spacing.size() != 3 || extent.size() != 6)
            return false;
        if (direction.size() != 9)
            direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        header.world = ISO_CHILD_OWN;
        for (size_t r = 0; r < 3; ++r) {
            header.first[r] = origin[r];
            for (size_t a = 0; a < 3; ++a) {
                header.step[a][r] = direction[3 * r + a] * spacing[a];
                header.first[r] += header.step[a][r] * (extent[2 * a] + half);
            }
        }
        return true;
    }

    bool place(const Array &array, const size_t (&space)[3], iso_child_header &header) override
    {
        if (array.name.rfind("VTKHDF/", 0) == 0 && text("VTKHDF", "Type") == "ImageData")
            return place_vtkhdf(array, header);
        if (array.name.rfind("DataSet/ResolutionLevel ", 0) != 0 || !is_imaris())
            return false;
        const std::string unit = text("DataSetInfo/Image", "Unit");
        header.world = ISO_CHILD_OWN;
        for (size_t a = 0; a < 3; ++a) {
            const std::string axis = std::to_string(a);
            const double lo = strtod(text("DataSetInfo/Image", "ExtMin" + axis).c_str(), nullptr),
                         hi = strtod(text("DataSetInfo/Image", "ExtMax" + axis).c_str(), nullptr);
            const double step = (hi - lo) / static_cast<double>(array.size[space[a]]);
            if (!(step > 0))
                snprintf(header.unspaced, sizeof header.unspaced, "of its voxels");
            header.step[a][a] = step > 0 ? step : 1;
            header.first[a] = lo + step / 2;
            snprintf(header.unit[a], sizeof header.unit[a], "%s", unit.empty() ? "um" : unit.c_str());
        }
        return true;
    }

    /* "2005-06-06 12:00:00.000" of each time point; within a month. */
    bool frame_step(const Array &, size_t, double &step, std::string &unit) override
    {
        std::vector<double> at;
        for (size_t k = 0; is_imaris() && k < array_frames(); ++k) {
            int year, month, day, hour, minute;
            double second;
            if (sscanf(text("DataSetInfo/TimeInfo", "TimePoint" + std::to_string(k + 1)).c_str(), "%d-%d-%d %d:%d:%lf",
                       &year, &month, &day, &hour, &minute, &second) == 6)
                at.push_back(86400.0 * day + 3600 * hour + 60 * minute + second);
        }
        step = at.size() > 1 && at.size() == array_frames() ? (at.back() - at[0]) / static_cast<double>(at.size() - 1)
                                                            : 0;
        for (size_t k = 1; k < at.size(); ++k)
            if (!(std::fabs(at[k] - at[k - 1] - step) <= 0.01 * std::fabs(step)))
                step = 0;
        unit = "s";
        return is_imaris();
    }

    std::string coordinate(const Array &array, size_t axis) override
    {
        const Handle set(H5Dopen2(file_, array.name.c_str(), H5P_DEFAULT), H5Dclose);
        std::string name = scale(set, static_cast<unsigned>(axis));
        /* netCDF has dimensions without coordinates, too. */
        return name.empty() || text(name, "NAME").rfind("This is a netCDF dimension but not", 0) == 0 ? "" : name;
    }

    std::vector<double> values(const std::string &array) override
    {
        const Handle set(H5Dopen2(file_, array.c_str(), H5P_DEFAULT), H5Dclose);
        const Handle space(set >= 0 ? H5Dget_space(set) : -1, H5Sclose);
        const hssize_t n = space >= 0 ? H5Sget_simple_extent_npoints(space) : 0;
        if (n < 1 || n > 1 << 24)
            return {};
        std::vector<double> all(static_cast<size_t>(n));
        if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) < 0)
            return {};
        return all;
    }

    void read(const Array &array, const std::vector<size_t> &start, const std::vector<size_t> &count,
              void *out) override
    {
        if (set_name_ != array.name) {
            set_ = std::make_unique<Handle>(H5Dopen2(file_, array.name.c_str(), H5P_DEFAULT), H5Dclose);
            set_name_ = array.name;
        }
        const Handle space(H5Dget_space(*set_), H5Sclose), type(H5Dget_type(*set_), H5Tclose);
        const std::vector<hsize_t> from(start.begin(), start.end()), n(count.begin(), count.end());
        const Handle memory(H5Screate_simple(static_cast<int>(n.size()), n.data(), nullptr), H5Sclose);
        const hid_t as = H5Tget_class(type) == H5T_ENUM ? static_cast<hid_t>(type) : memory_type(array.type);
        if (H5Sselect_hyperslab(space, H5S_SELECT_SET, from.data(), nullptr, n.data(), nullptr) < 0 ||
            H5Dread(*set_, as, memory, space, H5P_DEFAULT, out) < 0)
            fail(ISO_E_FORMAT, path_ + ": dataset " + array.name + ": damaged or truncated: HDF5: " + why());
    }

private:
    /* Opens an attribute for a Handle to close; -1 if there is none. The file stays open for it without its object. */
    hid_t open_attribute(const std::string &array, const std::string &name) const
    {
        const Handle object(H5Oopen(file_, array.c_str(), H5P_DEFAULT), H5Oclose);
        return object >= 0 && H5Aexists(object, name.c_str()) > 0 ? H5Aopen(object, name.c_str(), H5P_DEFAULT) : -1;
    }

    std::string path_;
    Handle file_;
    std::vector<std::string> names_;
    std::unique_ptr<Handle> set_;
    std::string set_name_;

    bool exists(const std::string &path) const
    {
        for (size_t at = path.find('/'); at != std::string::npos; at = path.find('/', at + 1))
            if (H5Lexists(file_, path.substr(0, at).c_str(), H5P_DEFAULT) <= 0)
                return false;
        return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
    }

    bool is_imaris() const
    {
        return exists("DataSetInfo/Image") && exists(imaris_channel(0, 0) + "/Data");
    }

    static std::string imaris_channel(size_t frame, size_t channel)
    {
        return "DataSet/ResolutionLevel 0/TimePoint " + std::to_string(frame) + "/Channel " + std::to_string(channel);
    }

    static std::string joined(hid_t attribute, hid_t type, size_t count)
    {
        std::string result(count, 0);
        if (H5Aread(attribute, type, &result[0]) < 0)
            return "";
        result.resize(strnlen(result.c_str(), count));
        return result;
    }

    /* Takes the image's size: Imaris fills its arrays up to whole chunks. */
    void take_imaris_size(Array &array)
    {
        const std::string group = array.name.substr(0, array.name.rfind('/'));
        if (array.name.rfind("DataSet/ResolutionLevel ", 0) != 0 || array.size.size() != 3)
            return;
        for (size_t a = 0; a < 3; ++a) {
            const size_t own = strtoull(text(group, std::string("ImageSize") + "ZYX"[a]).c_str(), nullptr, 10);
            if (own > 0 && own < array.size[a])
                array.size[a] = own;
        }
    }

    void note(hid_t group, const char *name)
    {
        const Handle object(H5Oopen(group, name, H5P_DEFAULT), H5Oclose);
        if (object >= 0 && H5Iget_type(object) == H5I_DATASET)
            names_.push_back(name);
    }

    static hid_t open(const std::string &path)
    {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    }

    /* The path of the scale that is attached to an axis. */
    static std::string scale(hid_t set, unsigned axis)
    {
        std::string name;
        if (set >= 0 && H5DSget_num_scales(set, axis) > 0)
            H5DSiterate_scales(
                set, axis, nullptr,
                [](hid_t, unsigned, hid_t found, void *out) -> herr_t {
                    char path[256] = "";
                    if (H5Iget_name(found, path, sizeof path) > 0)
                        *static_cast<std::string *>(out) = path[0] == '/' ? path + 1 : path;
                    return 1;
                },
                &name);
        return name;
    }

    static std::string axis_name(hid_t set, unsigned axis)
    {
        char label[64] = "";
        if (H5DSget_label(set, axis, label, sizeof label) > 0 && label[0])
            return label;
        const std::string name = scale(set, axis);
        return name.substr(name.find_last_of('/') + 1);
    }

    static std::string missing_filter(hid_t list)
    {
        for (int i = 0; i < H5Pget_nfilters(list); ++i) {
            unsigned flags = 0, config = 0;
            size_t count = 0;
            char name[64] = "";
            const H5Z_filter_t id = H5Pget_filter2(list, static_cast<unsigned>(i), &flags, &count, nullptr, sizeof name,
                                                   name, &config);
            if (id >= 0 && H5Zfilter_avail(id) <= 0)
                return "packed by filter " + std::to_string(id) + (name[0] ? " (" + std::string(name) + ")" : "") +
                       ", which HDF5 has no plugin for";
        }
        return "";
    }

    Array describe(const std::string &name)
    {
        Array array;
        array.name = name;
        const Handle set(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
        const Handle space(set >= 0 ? H5Dget_space(set) : -1, H5Sclose),
            type(set >= 0 ? H5Dget_type(set) : -1, H5Tclose);
        const Handle list(set >= 0 ? H5Dget_create_plist(set) : -1, H5Pclose);
        hsize_t size[H5S_MAX_RANK], chunk[H5S_MAX_RANK];
        const int rank = space >= 0 ? H5Sget_simple_extent_dims(space, size, nullptr) : -1;
        if (rank < 0 || type < 0 || list < 0) {
            array.refused = "damaged: HDF5: " + why();
            return array;
        }
        array.size.assign(size, size + rank);
        for (int a = 0; a < rank; ++a)
            array.axes.push_back(axis_name(set, static_cast<unsigned>(a)));
        take_minc_axes(array);
        if (type_of(type, array.type, array.refused))
            array.refused = missing_filter(list);
        array.is_whole = H5Tget_class(type) == H5T_INTEGER && array.type == ISO_F64;
        if (H5Pget_layout(list) == H5D_CHUNKED && H5Pget_chunk(list, rank, chunk) == rank)
            array.chunk.assign(chunk, chunk + rank);
        else if (array.refused.empty() && H5Pget_layout(list) == H5D_VIRTUAL)
            array.refused = "virtual: its samples are in other files, which are not read";
        else if (array.refused.empty())
            check_storage(set, type, size, rank, array);
        take_imaris_size(array);
        return array;
    }

    /* MINC 2 names them in an attribute: "zspace,yspace,xspace". */
    void take_minc_axes(Array &array)
    {
        std::string names = text(array.name, "dimorder") + ",";
        if (std::count(names.begin(), names.end(), ',') == static_cast<long>(array.axes.size()))
            for (auto &axis : array.axes) {
                axis = names.substr(0, names.find(','));
                names.erase(0, names.find(',') + 1);
            }
    }

    /* Samples that were never written, or that a truncated file lacks. */
    static void check_storage(hid_t set, hid_t type, const hsize_t *size, int rank, Array &array)
    {
        double need = static_cast<double>(H5Tget_size(type));
        for (int a = 0; a < rank; ++a)
            need *= static_cast<double>(size[a]);
        const double there = static_cast<double>(H5Dget_storage_size(set));
        if (there < need)
            array.refused = "truncated: holds " + std::to_string(static_cast<unsigned long long>(there)) +
                            " bytes of samples, needs " + std::to_string(static_cast<unsigned long long>(need));
    }
};

} // namespace

std::unique_ptr<Store> open_hdf5(const std::string &path)
{
    return std::make_unique<Hdf5>(path);
}
