/* SPDX-License-Identifier: MIT */
#include "vdb/vdb_openvdb.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <new>

#include <openvdb/io/Archive.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

using openvdb::Coord;

namespace {

/* The one place where exceptions end. */
template <typename Work> int guarded(iso_vdb_message *message, Work work)
{
    int status = ISO_OPENVDB_FAILED;
    const char *what = "unknown failure";
    try {
        return work();
    } catch (const openvdb::IoError &e) {
        status = ISO_OPENVDB_IO;
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
        return status;
    } catch (const std::ios_base::failure &e) {
        status = ISO_OPENVDB_IO;
        what = "writing failed (is the disk full?)";
    } catch (const std::bad_alloc &) {
        status = ISO_OPENVDB_MEMORY;
        what = "out of memory";
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
        return status;
    } catch (...) {
    }
    std::snprintf(message->text, sizeof message->text, "%s", what);
    return status;
}

/* OpenVDB's File does not look at the stream's state after writing. */
struct archive : openvdb::io::Archive {
    void save(std::ostream &out, const openvdb::GridCPtrVec &grids, const openvdb::MetaMap &meta) const
    {
        write(out, grids, /*seekable=*/true, meta);
    }
};

long clamp(long v, long size)
{
    return v < 0 ? 0 : v < size ? v : size - 1;
}

/* Row (y, z) of eight voxels from x on, with edge values where it leaves the volume. */
void read_row(const iso_vdb_source &s, long x, long y, long z, float *row)
{
    const long nx = static_cast<long>(s.size[0]);
    const long first = clamp(x, nx), last = clamp(x + 7, nx);
    float inside[24];
    s.read(s.user, static_cast<size_t>(first), static_cast<size_t>(clamp(y, static_cast<long>(s.size[1]))),
           static_cast<size_t>(clamp(z, static_cast<long>(s.size[2]))), static_cast<size_t>(last - first + 1), inside);
    for (long i = 0; i < 8; ++i)
        for (int c = 0; c < s.channels; ++c)
            row[i * s.channels + c] = inside[(clamp(x + i, nx) - first) * s.channels + c];
}

void take(const float *v, float &out)
{
    out = v[0];
}
void take(const float *v, openvdb::Vec3f &out)
{
    out = openvdb::Vec3f(v[0], v[1], v[2]);
}

/* Eight voxels from x on of row (y, z): which are active. Nothing is beyond a volume whose voxels are not all
 * active. */
void read_active_row(const iso_vdb_source &s, long x, long y, long z, unsigned char *row)
{
    std::fill_n(row, 8, static_cast<unsigned char>(!s.read_active));
    if (!s.read_active || y < 0 || z < 0 || y >= static_cast<long>(s.size[1]) || z >= static_cast<long>(s.size[2]))
        return;
    const long first = std::max(x, 0L), end = std::min(x + 8, static_cast<long>(s.size[0]));
    if (first < end)
        s.read_active(s.user, static_cast<size_t>(first), static_cast<size_t>(y), static_cast<size_t>(z),
                      static_cast<size_t>(end - first), row + (first - x));
}

/* The active voxels [lo, hi) of one leaf at block; a leaf is made when there is one. */
template <typename Grid>
void fill_leaf(Grid &grid, const iso_vdb_source &s, const long block[3], const long lo[3], const long hi[3])
{
    typename Grid::TreeType::LeafNodeType *leaf = nullptr;
    for (long z = std::max(block[2], lo[2]); z < std::min(block[2] + 8, hi[2]); ++z)
        for (long y = std::max(block[1], lo[1]); y < std::min(block[1] + 8, hi[1]); ++y) {
            float row[24];
            unsigned char active[8];
            const long x0 = block[0] - s.first[0], y0 = y - s.first[1], z0 = z - s.first[2];
            read_active_row(s, x0, y0, z0, active);
            read_row(s, x0, y0, z0, row);
            for (long x = std::max(block[0], lo[0]); x < std::min(block[0] + 8, hi[0]); ++x) {
                if (!active[x - block[0]])
                    continue;
                const Coord at(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
                typename Grid::ValueType value;
                take(row + (x - block[0]) * s.channels, value);
                leaf = leaf ? leaf : grid.tree().touchLeaf(at);
                leaf->setValueOn(at, value);
            }
        }
}

/* Every active voxel of the padded volume is set in a leaf of its own 8 x 8 x 8
 * block: no tiles, which Cycles misreads, and no value is taken for background. */
template <typename Grid> void fill(Grid &grid, const iso_vdb_source &s)
{
    const long pad = static_cast<long>(s.pad);
    long lo[3], hi[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = s.first[a] - pad;
        hi[a] = s.first[a] + static_cast<long>(s.size[a]) + pad;
    }
    for (long bz = lo[2] & ~7L; bz < hi[2]; bz += 8)
        for (long by = lo[1] & ~7L; by < hi[1]; by += 8)
            for (long bx = lo[0] & ~7L; bx < hi[0]; bx += 8) {
                const long block[3] = {bx, by, bz};
                fill_leaf(grid, s, block, lo, hi);
            }
}

void describe(openvdb::GridBase &grid, const iso_vdb_source &s)
{
    openvdb::Mat4d m = openvdb::Mat4d::identity(); /* OpenVDB multiplies row vectors from the left */
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            m(c, r) = s.index_to_world[r][c];
    grid.setTransform(openvdb::math::Transform::createLinearTransform(m));
    grid.setName(s.name);
    grid.setCreator(s.creator);
    grid.setSaveFloatAsHalf(s.half_float);
    if (s.channels == 3) {
        grid.setVectorType(openvdb::VEC_COVARIANT);
        grid.setIsInWorldSpace(true);
    }
    grid.insertMeta("isoshade_level", openvdb::Int32Metadata(s.level));
    grid.insertMeta("isoshade_value_min", openvdb::DoubleMetadata(s.value_min));
    grid.insertMeta("isoshade_value_max", openvdb::DoubleMetadata(s.value_max));
    grid.insertMeta("isoshade_box_index", openvdb::Vec3DMetadata(openvdb::Vec3d(s.box_index)));
    grid.insertMeta("isoshade_spacing_mm", openvdb::Vec3DMetadata(openvdb::Vec3d(s.spacing_mm)));
    grid.insertMeta("isoshade_unit_mm", openvdb::DoubleMetadata(s.unit_mm));
    if (*s.unit)
        grid.insertMeta("isoshade_unit", openvdb::StringMetadata(s.unit));
    grid.insertMeta("isoshade_origin_mm", openvdb::Vec3DMetadata(openvdb::Vec3d(s.origin_mm)));
    grid.insertMeta("isoshade_size",
                    openvdb::Vec3IMetadata(openvdb::Vec3i(static_cast<int>(s.size[0]), static_cast<int>(s.size[1]),
                                                          static_cast<int>(s.size[2]))));
    if (s.reversed_x)
        grid.insertMeta("isoshade_reversed_x", openvdb::BoolMetadata(true));
    grid.insertMeta("isoshade_made_from", openvdb::StringMetadata(s.made_from));
    if (s.labels)
        grid.insertMeta("isoshade_labels", openvdb::StringMetadata(s.labels));
    grid.insertMeta("isoshade_meaning", openvdb::StringMetadata(s.meaning));
}

template <typename Grid> openvdb::GridBase::Ptr build(const iso_vdb_source &s)
{
    typename Grid::ValueType background;
    const float empty[3] = {s.channels == 1 ? s.background : 0, 0, 0};
    take(empty, background);
    typename Grid::Ptr grid = Grid::create(background);
    describe(*grid, s);
    fill(*grid, s);
    return grid;
}

template <typename Grid> void read_dense(const Grid &grid, const size_t size[3], float *out)
{
    auto accessor = grid.getConstAccessor();
    const int channels = sizeof(typename Grid::ValueType) / sizeof(float);
    for (size_t z = 0; z < size[2]; ++z)
        for (size_t y = 0; y < size[1]; ++y)
            for (size_t x = 0; x < size[0]; ++x, out += channels) {
                const auto value = accessor.getValue(
                    Coord(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)));
                std::copy_n(reinterpret_cast<const float *>(&value), channels, out);
            }
}

void read_info(const openvdb::GridBase &grid, const size_t size[3], iso_vdb_grid_info *info)
{
    const openvdb::Mat4d m = grid.transform().baseMap()->getAffineMap()->getMat4();
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            info->index_to_world[r][c] = m(c, r);
    const auto box = grid.getMetadata<openvdb::Vec3DMetadata>("isoshade_box_index");
    const auto unit = grid.getMetadata<openvdb::DoubleMetadata>("isoshade_unit_mm");
    const auto origin = grid.getMetadata<openvdb::Vec3DMetadata>("isoshade_origin_mm");
    info->unit_mm = unit ? unit->value() : 1;
    for (int a = 0; a < 3; ++a)
        info->origin_mm[a] = origin ? origin->value()[a] : 0;
    for (int a = 0; a < 3; ++a)
        info->box_index[a] = box ? box->value()[a] : static_cast<double>(size[a]);
}

} // namespace

struct iso_vdb_file {
    openvdb::GridCPtrVec grids;
};

iso_vdb_file *iso_vdb_file_create(void)
{
    iso_vdb_file *file = nullptr;
    iso_vdb_message ignored;
    guarded(&ignored, [&] {
        openvdb::initialize();
        file = new iso_vdb_file;
        return 0;
    });
    return file;
}

int iso_vdb_file_add(iso_vdb_file *file, const iso_vdb_source *source, iso_vdb_message *message)
{
    return guarded(message, [&] {
        file->grids.push_back(source->channels == 3 ? build<openvdb::Vec3SGrid>(*source)
                                                    : build<openvdb::FloatGrid>(*source));
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

int iso_vdb_file_write(const iso_vdb_file *file, const char *path, iso_vdb_message *message)
{
    return guarded(message, [&] {
        std::ofstream out;
        out.exceptions(std::ios::failbit | std::ios::badbit);
        out.open(path, std::ios::out | std::ios::binary | std::ios::trunc);
        archive().save(out, file->grids, openvdb::MetaMap());
        out.close();
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

void iso_vdb_file_destroy(iso_vdb_file *file)
{
    delete file;
}

int iso_openvdb_read(const char *path, const char *name, int channels, const size_t size[3], float *out,
                     iso_vdb_grid_info *info, iso_vdb_message *message)
{
    return guarded(message, [&] {
        openvdb::initialize();
        openvdb::io::File file(path);
        file.open(/*delayLoad=*/false);
        if (!file.hasGrid(name)) {
            std::snprintf(message->text, sizeof message->text, "has no grid \"%s\"", name);
            return static_cast<int>(ISO_OPENVDB_NO_GRID);
        }
        openvdb::GridBase::Ptr base = file.readGrid(name);
        const auto scalars = openvdb::gridPtrCast<openvdb::FloatGrid>(base);
        const auto vectors = openvdb::gridPtrCast<openvdb::Vec3SGrid>(base);
        if (channels == 1 ? !scalars : !vectors) {
            std::snprintf(message->text, sizeof message->text, "grid \"%s\" has values of type %s, wanted %s", name,
                          base->valueType().c_str(), channels == 1 ? "float" : "vec3s");
            return static_cast<int>(ISO_OPENVDB_NO_GRID);
        }
        if (scalars)
            read_dense(*scalars, size, out);
        else
            read_dense(*vectors, size, out);
        read_info(*base, size, info);
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

int iso_openvdb_measure(const char *path, size_t *active_voxels, size_t *memory_bytes, iso_vdb_message *message)
{
    return guarded(message, [&] {
        openvdb::initialize();
        openvdb::io::File file(path);
        file.open(/*delayLoad=*/false);
        *active_voxels = *memory_bytes = 0;
        const auto grids = file.getGrids();
        for (const auto &grid : *grids) {
            *active_voxels += grid->activeVoxelCount();
            *memory_bytes += grid->memUsage();
        }
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

const char *iso_openvdb_version(void)
{
    return openvdb::getLibraryVersionString();
}
