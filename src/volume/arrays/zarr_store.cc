/* SPDX-License-Identifier: MIT */
/* zarr_store.cc - Zarr 2 and 3: one folder per array. Its `.zarray` describes how the chunks are packed, one file each;
 * attributes stand in `.zattrs`. Zarr 3 has both in `zarr.json`, and may put many chunks into one file, a shard.
 * OME-Zarr 0.4 and 0.5 add axes and scales in the attributes of the folder above [moore-2023]. */
#include <archive.h>
#include <blosc.h>
#include <jansson.h>
#include <lz4.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>

#include "volume/arrays/store.h"
#include "volume/half.h"

namespace {

namespace fs = std::filesystem;

/* True if the file exists and is regular: reading a pipe would wait. */
bool has_file(const std::string &path)
{
    if (!fs::exists(path))
        return false;
    if (!fs::is_regular_file(path))
        fail(ISO_E_IO, path + ": is not a regular file");
    return true;
}

/* A JSON file, freed with it; null if there is none. */
class Json {
public:
    explicit Json(const std::string &path)
    {
        json_error_t error;
        if (!has_file(path))
            return;
        root_ = json_load_file(path.c_str(), 0, &error);
        if (!root_)
            fail(ISO_E_FORMAT, path + ": line " + std::to_string(error.line) + ": " + error.text);
    }
    Json(Json &&other) noexcept : root_(other.root_)
    {
        other.root_ = nullptr;
    }
    ~Json()
    {
        json_decref(root_);
    }
    operator const json_t *() const
    {
        return root_;
    }

private:
    json_t *root_ = nullptr;
};

std::string word(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

bool is_of_version_3(const std::string &folder)
{
    return fs::exists(folder + "/zarr.json");
}

/* True if the folder is an array, of either version. */
bool is_array(const std::string &folder)
{
    return is_of_version_3(folder) ? word(Json(folder + "/zarr.json"), "node_type") == "array"
                                   : fs::exists(folder + "/.zarray");
}

/* The attributes of a folder. */
class Attributes {
public:
    explicit Attributes(const std::string &folder)
        : is_3_(is_of_version_3(folder)), file_(folder + (is_3_ ? "/zarr.json" : "/.zattrs"))
    {
    }
    operator const json_t *() const
    {
        return is_3_ ? json_object_get(file_, "attributes") : static_cast<const json_t *>(file_);
    }
    /* Returns those of OME, which version 0.5 puts into an object of their own. */
    const json_t *ome() const
    {
        const json_t *own = json_object_get(*this, "ome");
        return own ? own : static_cast<const json_t *>(*this);
    }

private:
    bool is_3_;
    Json file_;
};

/* How an array's chunks are stored. */
struct Layout {
    std::vector<size_t> size, chunk;
    std::string kind; /* of numpy: "<u2" without its byte order */
    size_t bytes = 0; /* of a sample */
    bool swapped = false, fortran = false;
    std::string codec, separator = ".", prefix; /* before the chunk's numbers */
    double fill = 0;
    std::vector<std::string> deltas; /* the types of numpy of filters: sums of differences */
    size_t ending = 0;               /* bytes of a checksum after the packed bytes */
    std::vector<size_t> shard;       /* chunks per shard, along each axis; empty: a file per chunk */
    bool index_first = false;        /* a shard's index is before its chunks; false: after them */
    size_t index_ending = 0;
};

template <typename T> void put_number(double value, char *out)
{
    const T number = static_cast<T>(value);
    memcpy(out, &number, sizeof number);
}

class Zarr : public Store {
public:
    explicit Zarr(std::string folder) : folder_(std::move(folder))
    {
        while (folder_.size() > 1 && folder_.back() == '/')
            folder_.pop_back();
    }

    std::vector<Array> arrays() override
    {
        std::vector<Array> all;
        collect("", 0, all);
        std::sort(all.begin(), all.end(), [](const Array &a, const Array &b) { return a.name < b.name; });
        return all;
    }

    std::vector<double> numbers(const std::string &array, const std::string &attribute) override
    {
        const Attributes attributes(path_of(array));
        return numbers_of(json_object_get(attributes, attribute.c_str()));
    }

    std::string text(const std::string &array, const std::string &attribute) override
    {
        const Attributes attributes(path_of(array));
        return word(attributes, attribute.c_str());
    }

    std::string coordinate(const Array &array, size_t axis) override
    {
        const size_t at = array.name.find_last_of('/');
        const std::string name = (at == std::string::npos ? "" : array.name.substr(0, at + 1)) + array.axes[axis];
        return !array.axes[axis].empty() && is_array(path_of(name)) ? name : "";
    }

    std::vector<double> values(const std::string &name) override
    {
        const Array array = describe(name);
        if (!array.refused.empty() || array.size.size() != 1 || array.size[0] == 0 || array.size[0] > 1 << 24)
            return {};
        std::vector<char> raw(array.size[0] * bytes_of(array.type));
        read(array, {0}, array.size, raw.data());
        std::vector<double> all(array.size[0]);
        for (size_t i = 0; i < all.size(); ++i)
            all[i] = value_at(raw.data() + i * bytes_of(array.type), array.type);
        return all;
    }

    void read(const Array &array, const std::vector<size_t> &start, const std::vector<size_t> &count,
              void *out) override
    {
        const Layout &l = layout(array.name);
        const size_t rank = l.size.size();
        std::vector<size_t> first(rank), last(rank);
        for (size_t a = 0; a < rank; ++a) {
            first[a] = start[a] / l.chunk[a];
            last[a] = (start[a] + count[a] - 1) / l.chunk[a];
        }
        for_each(first, last, [&](const std::vector<size_t> &at) {
            copy_chunk(array, l, at, start, count, static_cast<char *>(out));
        });
    }

    double stored_bytes(const Array &array, double enough) override
    {
        double there = 0;
        for (const auto &entry : fs::recursive_directory_iterator(path_of(array.name))) {
            if (entry.is_regular_file() && entry.path().filename().string()[0] != '.')
                there += static_cast<double>(entry.file_size());
            if (there >= enough) /* mostly by the first one */
                break;
        }
        return there;
    }

    /* zstd and blosc pack zeros better than deflate. Fewer bytes than that are refused before a chunk has memory. */
    size_t chunk_memory(const Array &array) override
    {
        const double chunk = chunk_bytes(layout(array.name));
        return stored_bytes(array, chunk / MOST_OF_A_BYTE) < chunk / MOST_OF_A_BYTE ? 0 : static_cast<size_t>(chunk);
    }

    /* Returns the fill values. Writers without one of their own put 0. */
    std::vector<double> fills(const Array &array) override
    {
        const Layout &l = layout(array.name);
        return l.fill == 0 || l.kind == "b1" ? std::vector<double>{} : std::vector<double>{l.fill};
    }

    std::string main_array(size_t, size_t) override
    {
        /* bioformats2raw puts the images of a file into folders 0, 1 and so on. */
        const Attributes root(folder_);
        const bool is_only = json_object_get(root.ome(), "bioformats2raw.layout") && !fs::exists(path_of("1"));
        const std::string image = is_only ? "0" : "";
        const Attributes attributes(path_of(image));
        const json_t *all = json_object_get(attributes.ome(), "multiscales");
        if (json_array_size(all) > 1)
            fail(ISO_E_FORMAT,
                 folder_ + ": holds " + std::to_string(json_array_size(all)) + " multiscale images, must be one");
        const std::string path = word(json_array_get(json_object_get(json_array_get(all, 0), "datasets"), 0), "path");
        return is_only && !path.empty() ? image + "/" + path : path;
    }

    std::vector<std::string> channel_names(const Array &array) override
    {
        const Image image = image_of(array.name);
        std::vector<std::string> names;
        if (!image.attributes)
            return names;
        const json_t *channels = json_object_get(json_object_get(image.attributes->ome(), "omero"), "channels");
        for (size_t c = 0; c < json_array_size(channels); ++c)
            names.push_back(word(json_array_get(channels, c), "label"));
        return names;
    }

    bool place(const Array &array, const size_t (&space)[3], iso_child_header &header) override
    {
        const Image image = image_of(array.name);
        const size_t rank = array.size.size();
        if (!image.level)
            return false;
        std::vector<double> scale(rank, 1), shift(rank, 0);
        const bool scaled = transform(json_object_get(image.level, "coordinateTransformations"), scale, shift);
        const bool whole = transform(json_object_get(image.image, "coordinateTransformations"), scale, shift);
        if (!scaled && !whole)
            snprintf(header.unspaced, sizeof header.unspaced, "of its voxels");
        const json_t *axes = json_object_get(image.image, "axes");
        header.world = scaled || whole ? ISO_CHILD_OWN : ISO_CHILD_CENTERED;
        for (int a = 0; a < 3; ++a) {
            const int world = world_axis(array, space, a);
            header.step[a][world] = scale[space[a]];
            header.first[world] = shift[space[a]];
            snprintf(header.unit[world], sizeof header.unit[world], "%s",
                     word(json_array_get(axes, space[a]), "unit").c_str());
        }
        return true;
    }

    bool frame_step(const Array &array, size_t axis, double &step, std::string &unit) override
    {
        const Image image = image_of(array.name);
        std::vector<double> scale(array.size.size(), 1), shift(array.size.size(), 0);
        if (!image.level)
            return false;
        const bool scaled = transform(json_object_get(image.level, "coordinateTransformations"), scale, shift);
        const bool whole = transform(json_object_get(image.image, "coordinateTransformations"), scale, shift);
        unit = word(json_array_get(json_object_get(image.image, "axes"), axis), "unit");
        /* Writers put a scale of 1 without a unit if they have none. */
        step = (scaled || whole) && !(scale[axis] == 1 && unit.empty()) ? scale[axis] : 0;
        return true;
    }

private:
    /* Of a multiscale image: all of it, and the level that an array is. */
    struct Image {
        std::shared_ptr<Attributes> attributes;
        const json_t *image = nullptr, *level = nullptr;
    };

    std::string folder_;
    std::map<std::string, Layout> layouts_;

    std::string path_of(const std::string &array) const
    {
        return array.empty() ? folder_ : folder_ + "/" + array;
    }
    std::string shown(const std::string &array) const
    {
        return array.empty() ? folder_ : folder_ + ":" + array;
    }

    static std::vector<double> numbers_of(const json_t *value)
    {
        std::vector<double> all;
        if (json_is_number(value))
            all.push_back(json_number_value(value));
        for (size_t i = 0; i < json_array_size(value); ++i)
            all.push_back(json_number_value(json_array_get(value, i)));
        return all;
    }

    /* x, y and z by their names, or by their order where these are others. */
    static int world_axis(const Array &array, const size_t (&space)[3], int a)
    {
        int seen = 0, of[3];
        for (int b = 0; b < 3; ++b) {
            const std::string &name = array.axes[space[b]];
            of[b] = name == "x" ? 0 : name == "y" ? 1 : name == "z" ? 2 : -1;
            seen |= of[b] < 0 ? 0 : 1 << of[b];
        }
        return seen == 7 ? of[a] : a;
    }

    Image image_of(const std::string &array) const
    {
        Image image;
        const size_t at = array.find_last_of('/');
        const std::string group = at == std::string::npos ? "" : array.substr(0, at);
        if (array.empty())
            return image;
        image.attributes = std::make_shared<Attributes>(path_of(group));
        const json_t *all = json_object_get(image.attributes->ome(), "multiscales");
        for (size_t i = 0; i < json_array_size(all); ++i) {
            const json_t *datasets = json_object_get(json_array_get(all, i), "datasets");
            for (size_t k = 0; k < json_array_size(datasets); ++k)
                if (word(json_array_get(datasets, k), "path") == array.substr(at == std::string::npos ? 0 : at + 1)) {
                    image.image = json_array_get(all, i);
                    image.level = json_array_get(datasets, k);
                }
        }
        return image;
    }

    /* Applies scales and translations, in their order; false if there are none. */
    bool transform(const json_t *steps, std::vector<double> &scale, std::vector<double> &shift) const
    {
        for (size_t i = 0; i < json_array_size(steps); ++i) {
            const json_t *step = json_array_get(steps, i);
            const std::string type = word(step, "type");
            const auto by = numbers_of(json_object_get(step, type.c_str()));
            if ((type != "scale" && type != "translation") || by.size() != scale.size())
                fail(ISO_E_FORMAT, folder_ + ": coordinateTransformations: a \"" + type + "\" of " +
                                       std::to_string(by.size()) + " numbers, must be a scale or translation of " +
                                       std::to_string(scale.size()));
            for (size_t a = 0; a < by.size(); ++a) {
                if (type == "scale")
                    scale[a] *= by[a], shift[a] *= by[a];
                else
                    shift[a] += by[a];
            }
        }
        return json_array_size(steps) > 0;
    }

    /* Folders that have an array; those of its chunks are not looked through. */
    void collect(const std::string &name, int depth, std::vector<Array> &all)
    {
        if (is_array(path_of(name))) {
            all.push_back(describe(name));
            return;
        }
        if (depth == 6)
            return;
        for (const auto &entry : fs::directory_iterator(path_of(name)))
            if (entry.is_directory())
                collect((name.empty() ? "" : name + "/") + entry.path().filename().string(), depth + 1, all);
    }

    static bool take_codec(const json_t *meta, Layout &l, std::string &refused)
    {
        const json_t *filters = json_object_get(meta, "filters");
        for (size_t i = 0; i < json_array_size(filters) && refused.empty(); ++i) {
            const json_t *filter = json_array_get(filters, i);
            const std::string id = word(filter, "id"), type = word(filter, "dtype"), stored = word(filter, "astype");
            const std::string own = word(meta, "dtype");
            if (id == "bitround" || (id == "quantize" && type == own && (stored.empty() || stored == own)))
                continue; /* rounded when written; the bytes are the values */
            if (id == "quantize")
                refused = "filtered by quantize of the types \"" + type + "\" and \"" + stored +
                          "\", must be that of the array";
            else if (id != "delta")
                refused = "filtered by \"" + id + "\", must be bitround, delta, quantize or nothing";
            else if (type.size() != 3 || type.substr(1) != l.kind || (!stored.empty() && stored != type) ||
                     l.kind == "f2")
                refused = "filtered by delta of the types \"" + type + "\" and \"" + stored +
                          "\", must be that of the array";
            l.deltas.push_back(type);
        }
        return refused.empty() && take_packer(word(json_object_get(meta, "compressor"), "id"), l, refused);
    }

    static bool take_packer(const std::string &name, Layout &l, std::string &refused)
    {
        static const char *const known[] = {"", "zlib", "blosc", "lz4"};
        l.codec = name;
        if (std::find(std::begin(known), std::end(known), name) == std::end(known) && !archive_filters().count(name))
            refused = "packed by \"" + name + "\", must be blosc, bz2, gzip, lz4, lzma, zlib, zstd or nothing";
        return refused.empty();
    }

    /* ---- Zarr 3 ---- */

    static std::vector<size_t> sizes_in(const json_t *object, const char *key)
    {
        std::vector<size_t> sizes;
        for (const double n : numbers_of(json_object_get(object, key)))
            sizes.push_back(n >= 0 && n < 9e15 ? static_cast<size_t>(n) : 0);
        return sizes;
    }

    /* Reads the name of a codec or type: a text, or an object with a name. */
    static std::string name_of(const json_t *value)
    {
        return json_is_string(value) ? json_string_value(value) : word(value, "name");
    }

    /* Applies the codecs, whose order is that of writing: an array's order and bytes, then packers of bytes. */
    static bool take_codecs(const json_t *codecs, Layout &l, std::string &refused)
    {
        for (size_t i = 0; i < json_array_size(codecs) && refused.empty(); ++i) {
            const json_t *codec = json_array_get(codecs, i), *about = json_object_get(codec, "configuration");
            const std::string name = name_of(codec);
            if (name == "bytes")
                l.swapped = word(about, "endian") == "big" && l.bytes > 1;
            else if (name == "crc32c")
                l.ending += 4;
            else if (name == "transpose")
                take_order(about, l, refused);
            else if (name == "sharding_indexed")
                take_shards(about, l, refused);
            else if (!l.codec.empty())
                refused = "packed by \"" + l.codec + "\" and \"" + name + "\", must be one";
            else
                take_packer(name, l, refused);
        }
        return refused.empty();
    }

    static void take_order(const json_t *about, Layout &l, std::string &refused)
    {
        const auto order = sizes_in(about, "order");
        bool is_plain = order.size() == l.size.size(), is_reversed = is_plain;
        for (size_t a = 0; a < order.size(); ++a) {
            is_plain = is_plain && order[a] == a;
            is_reversed = is_reversed && order[a] == order.size() - 1 - a;
        }
        l.fortran = is_reversed && !is_plain;
        if (!is_plain && !is_reversed)
            refused = "a transposition that is not a reversal of all axes, which is not read";
    }

    static void take_shards(const json_t *about, Layout &l, std::string &refused)
    {
        const std::vector<size_t> inner = sizes_in(about, "chunk_shape"), outer = l.chunk;
        const json_t *index = json_object_get(about, "index_codecs");
        if (!l.shard.empty() || inner.size() != outer.size() || std::count(inner.begin(), inner.end(), 0)) {
            refused = "\"chunk_shape\" of its shards does not fit";
            return;
        }
        for (size_t a = 0; a < inner.size(); ++a) {
            l.shard.push_back(outer[a] / inner[a]);
            if (outer[a] % inner[a] != 0)
                refused = "a shard that its chunks do not fill";
        }
        l.chunk = inner;
        l.index_first = word(about, "index_location") == "start";
        for (size_t i = 0; i < json_array_size(index); ++i) {
            const std::string name = name_of(json_array_get(index, i));
            if (name == "crc32c")
                l.index_ending = 4;
            else if (name != "bytes" ||
                     word(json_object_get(json_array_get(index, i), "configuration"), "endian") == "big")
                refused = "an index of shards by \"" + name + "\", must be bytes, little-endian, and crc32c";
        }
        if (refused.empty())
            take_codecs(json_object_get(about, "codecs"), l, refused);
    }

    static bool take_meta_3(const json_t *meta, Layout &l, iso_type &type, std::string &refused)
    {
        static const struct {
            const char *name, *kind;
        } names[] = {{"bool", "|b1"},  {"uint8", "|u1"},   {"int8", "|i1"},    {"uint16", "<u2"},
                     {"int16", "<i2"}, {"uint32", "<u4"},  {"int32", "<i4"},   {"uint64", "<u8"},
                     {"int64", "<i8"}, {"float16", "<f2"}, {"float32", "<f4"}, {"float64", "<f8"}};
        const std::string name = name_of(json_object_get(meta, "data_type"));
        std::string kind = name;
        for (const auto &n : names)
            kind = name == n.name ? n.kind : kind;
        const json_t *grid = json_object_get(meta, "chunk_grid"), *keys = json_object_get(meta, "chunk_key_encoding");
        const bool is_default = word(keys, "name") != "v2";
        l.size = sizes_in(meta, "shape");
        l.chunk = sizes_in(json_object_get(grid, "configuration"), "chunk_shape");
        l.separator = word(json_object_get(keys, "configuration"), "separator");
        l.separator = l.separator.empty() ? (is_default ? "/" : ".") : l.separator;
        l.prefix = is_default ? "c" : "";
        if (word(grid, "name") != "regular")
            refused = "a grid of chunks \"" + word(grid, "name") + "\", must be regular";
        else if (l.size.size() != l.chunk.size() || std::count(l.chunk.begin(), l.chunk.end(), 0))
            refused = "\"shape\" and \"chunk_shape\" of zarr.json do not fit";
        return refused.empty() && take_type(kind, l, type, refused) &&
               take_codecs(json_object_get(meta, "codecs"), l, refused);
    }

    static bool take_type(const std::string &dtype, Layout &l, iso_type &type, std::string &refused)
    {
        static const struct {
            const char *kind;
            iso_type type;
            size_t bytes;
        } types[] = {{"b1", ISO_U8, 1},  {"u1", ISO_U8, 1},  {"i1", ISO_I8, 1},  {"u2", ISO_U16, 2},
                     {"i2", ISO_I16, 2}, {"u4", ISO_U32, 4}, {"i4", ISO_I32, 4}, {"f2", ISO_F32, 2},
                     {"f4", ISO_F32, 4}, {"f8", ISO_F64, 8}, {"i8", ISO_F64, 8}, {"u8", ISO_F64, 8}};
        for (const auto &t : types)
            if (dtype.size() == 3 && dtype.substr(1) == t.kind) {
                l.kind = t.kind;
                l.bytes = t.bytes;
                l.swapped = dtype[0] == '>' && t.bytes > 1;
                type = t.type;
                return true;
            }
        refused = "type \"" + dtype + "\", must be an integer or a float";
        return false;
    }

    static bool take_sizes(const json_t *meta, Layout &l, std::string &refused)
    {
        for (const double n : numbers_of(json_object_get(meta, "shape")))
            l.size.push_back(n >= 0 && n < 9e15 ? static_cast<size_t>(n) : 0);
        for (const double n : numbers_of(json_object_get(meta, "chunks")))
            l.chunk.push_back(n >= 0 && n < 9e15 ? static_cast<size_t>(n) : 0);
        if (refused.empty() && (l.size.size() != l.chunk.size() || std::count(l.chunk.begin(), l.chunk.end(), 0)))
            refused = "\"shape\" and \"chunks\" of .zarray do not fit";
        return refused.empty();
    }

    static void check_chunks(const Layout &l, std::string &refused)
    {
        if (chunks_of(l) > MOST_CHUNKS)
            refused = "more than " + std::to_string(MOST_CHUNKS) + " chunks";
        else if (chunk_bytes(l) > 2147483647.)
            refused = "chunks of more than 2 GB";
    }

    Array describe(const std::string &name)
    {
        const bool is_3 = is_of_version_3(path_of(name));
        const Json meta(path_of(name) + (is_3 ? "/zarr.json" : "/.zarray"));
        const Attributes attributes(path_of(name));
        Array array;
        Layout l;
        array.name = name;
        if (json_integer_value(json_object_get(meta, "zarr_format")) != (is_3 ? 3 : 2))
            array.refused = is_3 ? "\"zarr_format\" of zarr.json must be 3" : "\"zarr_format\" of .zarray must be 2";
        const json_t *fill = json_object_get(meta, "fill_value");
        const std::string special = json_is_string(fill) ? json_string_value(fill) : "";
        l.fill = special == "NaN"         ? std::numeric_limits<double>::quiet_NaN()
                 : special == "Infinity"  ? std::numeric_limits<double>::infinity()
                 : special == "-Infinity" ? -std::numeric_limits<double>::infinity()
                 : json_is_true(fill)     ? 1
                                          : json_number_value(fill);
        l.fortran = word(meta, "order") == "F";
        if (!word(meta, "dimension_separator").empty())
            l.separator = word(meta, "dimension_separator");
        if (is_3)
            take_meta_3(meta, l, array.type, array.refused);
        else if (take_sizes(meta, l, array.refused) && take_type(word(meta, "dtype"), l, array.type, array.refused) &&
                 take_codec(meta, l, array.refused))
            check_chunks(l, array.refused);
        if (is_3 && array.refused.empty())
            check_chunks(l, array.refused);
        array.size = l.size; /* also of refused arrays, whose name and cause the message has */
        array.is_whole = l.kind == "i8" || l.kind == "u8";
        for (size_t a = 0; a < l.size.size(); ++a)
            array.axes.push_back(axis_name(name,
                                           is_3 ? json_object_get(meta, "dimension_names")
                                                : json_object_get(attributes, "_ARRAY_DIMENSIONS"),
                                           a));
        array.chunk = l.chunk;
        layouts_[name] = l;
        return array;
    }

    std::string axis_name(const std::string &name, const json_t *names, size_t axis) const
    {
        const char *text = json_string_value(json_array_get(names, axis));
        if (text)
            return text;
        const Image image = image_of(name);
        const json_t *of = json_array_get(json_object_get(image.image, "axes"), axis);
        return json_is_string(of) ? json_string_value(of) : word(of, "name"); /* OME-Zarr 0.3: the name alone */
    }

    const Layout &layout(const std::string &name)
    {
        if (!layouts_.count(name))
            describe(name);
        return layouts_.at(name);
    }

    /* All index vectors from first to last, the last axis fastest. */
    template <typename Work>
    static void for_each(const std::vector<size_t> &first, const std::vector<size_t> &last, Work work)
    {
        std::vector<size_t> at = first;
        for (size_t a = at.size(); a != SIZE_MAX;) {
            work(at);
            for (a = at.size() - 1; a != SIZE_MAX && at[a] == last[a]; --a)
                at[a] = first[a];
            if (a != SIZE_MAX)
                ++at[a];
        }
    }

    /* 51 bytes of a run take one of a block of 900,000, and a block of runs takes about 40. */
    static constexpr double MOST_OF_A_BYTE_BZ2 = 1 << 21;

    /* Returns libarchive's filters by codec: streams that state their own end. */
    static const std::map<std::string, int> &archive_filters()
    {
        static const std::map<std::string, int> filters = {{"bz2", ARCHIVE_FILTER_BZIP2},
                                                           {"gzip", ARCHIVE_FILTER_GZIP},
                                                           {"lzma", ARCHIVE_FILTER_XZ},
                                                           {"zstd", ARCHIVE_FILTER_ZSTD}};
        return filters;
    }

    /* The filter is set, not guessed: samples that look packed stay as they are. */
    static size_t unpack_archive(int filter, const std::string &packed, std::vector<char> &out)
    {
        const std::unique_ptr<archive, int (*)(archive *)> a(archive_read_new(), archive_read_free);
        archive_entry *entry;
        char beyond;
        archive_read_support_format_raw(a.get());
        if (archive_read_append_filter(a.get(), filter) != ARCHIVE_OK ||
            archive_read_open_memory(a.get(), packed.data(), packed.size()) != ARCHIVE_OK ||
            archive_read_next_header(a.get(), &entry) != ARCHIVE_OK)
            return 0;
        const la_ssize_t size = archive_read_data(a.get(), out.data(), out.size());
        return size > 0 && archive_read_data(a.get(), &beyond, 1) == 0 ? static_cast<size_t>(size) : 0;
    }

    /* Limit of the chunks. Each is looked up, which takes microseconds if it does not exist: a few bytes of .zarray
     * may promise any number. 4096^3 samples in chunks of 32^3 reach it. */
    static constexpr size_t MOST_CHUNKS = 1 << 21;

    static double chunk_bytes(const Layout &l)
    {
        double bytes = static_cast<double>(l.bytes);
        for (const size_t n : l.chunk)
            bytes *= static_cast<double>(n);
        return bytes;
    }

    static double chunks_of(const Layout &l)
    {
        double count = 1;
        for (size_t a = 0; a < l.size.size(); ++a)
            count *= std::ceil(static_cast<double>(l.size[a]) / static_cast<double>(l.chunk[a]));
        return count;
    }

    [[noreturn]] static void fail_to_unpack(const std::string &path, double bytes)
    {
        fail(ISO_E_FORMAT, path + ": truncated or damaged: a chunk that does not unpack to " +
                               std::to_string(static_cast<size_t>(bytes)) + " bytes");
    }

    /* Reads bytes of a file; all of it if `bytes` is 0. */
    static std::string bytes_in(const std::string &path, size_t at, size_t bytes)
    {
        std::ifstream file(path, std::ios::binary);
        if (bytes == 0)
            return {std::istreambuf_iterator<char>(file), {}};
        std::string data(bytes, 0);
        file.seekg(static_cast<std::streamoff>(at));
        if (!file.read(&data[0], static_cast<std::streamsize>(bytes)))
            fail(ISO_E_FORMAT, path + ": truncated: no " + std::to_string(bytes) + " bytes at " + std::to_string(at));
        return data;
    }

    /* Returns the packed bytes of chunk number k of a shard; none if it was never written. */
    static std::string chunk_in_shard(const std::string &path, const Layout &l, size_t k)
    {
        size_t chunks = 1;
        for (const size_t n : l.shard)
            chunks *= n;
        const size_t all = static_cast<size_t>(fs::file_size(path)), index = 16 * chunks + l.index_ending;
        uint64_t entry[2];
        if (index > all)
            fail(ISO_E_FORMAT, path + ": truncated: " + std::to_string(all) + " bytes, the index of its shard has " +
                                   std::to_string(index));
        const std::string data = bytes_in(path, (l.index_first ? 0 : all - index) + 16 * k, sizeof entry);
        memcpy(entry, data.data(), sizeof entry);
        if (entry[0] == UINT64_MAX && entry[1] == UINT64_MAX)
            return "";
        if (entry[1] == 0 || entry[0] > all || entry[1] > all - entry[0])
            fail(ISO_E_FORMAT,
                 path + ": damaged: a chunk at byte " + std::to_string(entry[0]) + " of " + std::to_string(all));
        return bytes_in(path, entry[0], entry[1]);
    }

    /* Returns the packed bytes of a chunk, and its file; none if it was never written. */
    std::string packed_chunk(const Array &array, const Layout &l, const std::vector<size_t> &at,
                             std::string &path) const
    {
        std::string name = l.prefix;
        size_t k = 0;
        for (size_t a = 0; a < at.size(); ++a) {
            const size_t per = l.shard.empty() ? 1 : l.shard[a];
            name += (name.empty() ? "" : l.separator) + std::to_string(at[a] / per);
            k = k * per + at[a] % per;
        }
        path = path_of(array.name) + "/" + (name.empty() ? "0" : name);
        if (!has_file(path))
            return "";
        const std::string packed = l.shard.empty() ? bytes_in(path, 0, 0) : chunk_in_shard(path, l, k);
        if (l.shard.empty() && packed.empty())
            fail_to_unpack(path, chunk_bytes(l));
        return packed;
    }

    template <typename T> static void add_up(std::vector<char> &samples, bool is_swapped)
    {
        T sum{};
        for (size_t at = 0; at + sizeof sum <= samples.size(); at += sizeof sum) {
            T value;
            char *here = samples.data() + at;
            if (is_swapped)
                std::reverse(here, here + sizeof value);
            memcpy(&value, here, sizeof value);
            sum = static_cast<T>(sum + value);
            memcpy(here, &sum, sizeof sum);
            if (is_swapped)
                std::reverse(here, here + sizeof sum);
        }
    }

    /* Sums the differences that a filter stored; unsigned sums are those of signed numbers. */
    static void undo_delta(const std::string &type, std::vector<char> &samples)
    {
        const bool is_swapped = type[0] == '>' && type[2] != '1';
        const std::string kind = type.substr(1);
        if (kind == "f4")
            add_up<float>(samples, is_swapped);
        else if (kind == "f8")
            add_up<double>(samples, is_swapped);
        else if (kind[1] == '1')
            add_up<uint8_t>(samples, false);
        else if (kind[1] == '2')
            add_up<uint16_t>(samples, is_swapped);
        else if (kind[1] == '4')
            add_up<uint32_t>(samples, is_swapped);
        else
            add_up<uint64_t>(samples, is_swapped);
    }

    /* Unpacks into `out`; returns the bytes that the packer gave, 0 if it failed. */
    static size_t unpack(const Layout &l, const std::string &packed, std::vector<char> &out)
    {
        size_t size = 0, told = 0;
        if (l.codec.empty() && packed.size() == out.size()) {
            memcpy(out.data(), packed.data(), size = packed.size());
        } else if (archive_filters().count(l.codec)) {
            size = unpack_archive(archive_filters().at(l.codec), packed, out);
        } else if (l.codec == "zlib") {
            uLongf room = out.size();
            const int code = uncompress(reinterpret_cast<Bytef *>(out.data()), &room,
                                        reinterpret_cast<const Bytef *>(packed.data()), packed.size());
            size = code == Z_OK ? room : 0;
        } else if (l.codec == "lz4" && packed.size() > 4) { /* after the size, which numcodecs puts first */
            const int code = LZ4_decompress_safe(packed.data() + 4, out.data(), static_cast<int>(packed.size() - 4),
                                                 static_cast<int>(out.size()));
            size = code > 0 ? static_cast<size_t>(code) : 0;
        } else if (l.codec == "blosc" && blosc_cbuffer_validate(packed.data(), packed.size(), &told) == 0 &&
                   told == out.size()) {
            const int code = blosc_decompress_ctx(packed.data(), out.data(), out.size(), 1);
            size = code > 0 ? static_cast<size_t>(code) : 0;
        }
        return size;
    }

    /* Loads a chunk's samples as stored; none if the chunk was never written. */
    std::vector<char> load_chunk(const Array &array, const Layout &l, const std::vector<size_t> &at) const
    {
        std::string path, packed = packed_chunk(array, l, at, path);
        if (packed.empty())
            return {};
        packed.resize(packed.size() - std::min(packed.size(), l.ending));
        const double most = l.codec == "bz2" ? MOST_OF_A_BYTE_BZ2 : MOST_OF_A_BYTE;
        if (chunk_bytes(l) > most * static_cast<double>(packed.size()))
            fail_to_unpack(path, chunk_bytes(l));
        std::vector<char> out(static_cast<size_t>(chunk_bytes(l)));
        if (unpack(l, packed, out) != out.size())
            fail_to_unpack(path, chunk_bytes(l));
        for (size_t i = l.deltas.size(); i-- > 0;)
            undo_delta(l.deltas[i], out);
        return out;
    }

    static double value_at(const char *from, iso_type type)
    {
        const auto as = [from](auto value) {
            memcpy(&value, from, sizeof value);
            return static_cast<double>(value);
        };
        switch (type) {
        case ISO_U8: return as(uint8_t());
        case ISO_I8: return as(int8_t());
        case ISO_U16: return as(uint16_t());
        case ISO_I16: return as(int16_t());
        case ISO_U32: return as(uint32_t());
        case ISO_I32: return as(int32_t());
        case ISO_F32: return as(float());
        default: return as(double());
        }
    }

    static void store(double value, iso_type type, char *out)
    {
        switch (type) {
        case ISO_U8: return put_number<uint8_t>(value, out);
        case ISO_I8: return put_number<int8_t>(value, out);
        case ISO_U16: return put_number<uint16_t>(value, out);
        case ISO_I16: return put_number<int16_t>(value, out);
        case ISO_U32: return put_number<uint32_t>(value, out);
        case ISO_I32: return put_number<int32_t>(value, out);
        case ISO_F32: return put_number<float>(value, out);
        default: return put_number<double>(value, out);
        }
    }

    /* A stored sample in the machine's byte order, a half float as float. */
    static void convert(const Layout &l, const char *from, char *out)
    {
        char sample[8];
        memcpy(sample, from, l.bytes);
        if (l.swapped)
            std::reverse(sample, sample + l.bytes);
        if (l.kind == "f2") {
            uint16_t half;
            memcpy(&half, sample, 2);
            put_number<float>(iso_half_to_float(half), out);
        } else if (l.kind == "i8" || l.kind == "u8") {
            int64_t number;
            memcpy(&number, sample, 8);
            put_number<double>(l.kind == "i8" ? static_cast<double>(number)
                                              : static_cast<double>(static_cast<uint64_t>(number)),
                               out);
        } else {
            memcpy(out, sample, l.bytes);
        }
    }

    void copy_chunk(const Array &array, const Layout &l, const std::vector<size_t> &at,
                    const std::vector<size_t> &start, const std::vector<size_t> &count, char *out) const
    {
        const size_t rank = l.size.size(), bytes = bytes_of(array.type);
        size_t samples = 1;
        std::vector<size_t> stride(rank), first(rank), last(rank), to(rank, 1);
        for (size_t i = 0; i < rank; ++i) {
            const size_t a = l.fortran ? i : rank - 1 - i;
            stride[a] = samples;
            samples *= l.chunk[a];
        }
        for (size_t a = rank; a-- > 0;) {
            to[a] = a + 1 < rank ? to[a + 1] * count[a + 1] : 1;
            first[a] = std::max(at[a] * l.chunk[a], start[a]);
            last[a] = std::min((at[a] + 1) * l.chunk[a], start[a] + count[a]) - 1;
        }
        const std::vector<char> stored = load_chunk(array, l, at);
        const bool there = !stored.empty();
        char fill[8];
        store(l.fill, array.type, fill);
        const bool plain = there && !l.swapped && l.kind != "f2" && !array.is_whole && stride[rank - 1] == 1;
        std::vector<size_t> row_last = last;
        row_last[rank - 1] = first[rank - 1];
        const size_t n = last[rank - 1] - first[rank - 1] + 1;
        std::vector<char> filled;
        for (size_t i = 0; i < n && !there; ++i)
            filled.insert(filled.end(), fill, fill + bytes);
        for_each(first, row_last, [&](const std::vector<size_t> &row) {
            size_t from = 0, into = 0;
            for (size_t a = 0; a < rank; ++a) {
                from += (row[a] - at[a] * l.chunk[a]) * stride[a];
                into += (row[a] - start[a]) * to[a];
            }
            if (plain || !there)
                memcpy(out + into * bytes, there ? stored.data() + from * bytes : filled.data(), n * bytes);
            for (size_t i = 0; i < n && there && !plain; ++i)
                convert(l, stored.data() + (from + i * stride[rank - 1]) * l.bytes, out + (into + i) * bytes);
        });
    }
};

} // namespace

std::unique_ptr<Store> open_zarr(const std::string &folder)
{
    return std::make_unique<Zarr>(folder);
}
