/* SPDX-License-Identifier: MIT */
#include "vdb/vdb_guarded.h"
#include "vdb/vdb_nanovdb.h"
#include "vdb/vdb_openvdb.h"
#include "vdb/vdb_tree.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include <openvdb/io/Archive.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

using iso_vdb::guarded;
using openvdb::Coord;

namespace {

/* OpenVDB writes file positions into the file without checking that tellp() succeeded. */
struct checked_places : std::filebuf {
    bool failed = false;

    pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode mode) override
    {
        const pos_type place = std::filebuf::seekoff(offset, from, mode);
        failed = failed || place == pos_type(off_type(-1));
        return place;
    }
};

/* OpenVDB's File does not check the stream after writing. */
struct archive : openvdb::io::Archive {
    void save(std::ostream &out, const openvdb::GridCPtrVec &grids, const openvdb::MetaMap &meta, bool small)
    {
        /* Blosc, the default, does not compress directions; ZIP halves them, in several times the time */
        if (small)
            setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
        write(out, grids, /*seekable=*/true, meta);
    }
};

/* Reads active flags of the eight voxels from x on of row (y, z), counted from the first voxel. Voxels beyond the rim
 * are inactive. */
void read_active_row(const iso_vdb_source &s, const long at[3], unsigned char *row)
{
    const long pad = static_cast<long>(s.pad);
    long size[3];
    std::fill_n(row, 8, static_cast<unsigned char>(0));
    for (int a = 0; a < 3; ++a)
        size[a] = static_cast<long>(s.size[a]) + 2 * pad;
    const long x = at[0] + pad, y = at[1] + pad, z = at[2] + pad;
    const long first = std::max(x, 0L), end = std::min(x + 8, size[0]);
    if (y < 0 || z < 0 || y >= size[1] || z >= size[2] || first >= end)
        return;
    if (!s.read_active)
        std::fill(row + (first - x), row + (end - x), static_cast<unsigned char>(1));
    else
        s.read_active(s.active_user, static_cast<size_t>(first), static_cast<size_t>(y), static_cast<size_t>(z),
                      static_cast<size_t>(end - first), row + (first - x));
}

/* Returns the active voxels of the leaf at `block`. */
openvdb::util::NodeMask<3> active_voxels(const iso_vdb_source &s, const long block[3])
{
    openvdb::util::NodeMask<3> mask;
    unsigned char row[8];
    for (int z = 0; z < 8; ++z)
        for (int y = 0; y < 8; ++y) {
            const long at[3] = {block[0] - s.first[0], block[1] + y - s.first[1], block[2] + z - s.first[2]};
            read_active_row(s, at, row);
            for (int x = 0; x < 8; ++x)
                if (row[x])
                    mask.setOn(static_cast<openvdb::Index>(64 * x + 8 * y + z));
        }
    return mask;
}

/* Makes a leaf for each 8 x 8 x 8 block with an active voxel, and no tiles, which Cycles misreads. */
template <typename Tree> void fill(Tree &tree, const iso_vdb_source &s)
{
    const long pad = static_cast<long>(s.pad);
    long lo[3], hi[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = (s.first[a] - pad) & ~7L;
        hi[a] = s.first[a] + static_cast<long>(s.size[a]) + pad;
    }
    for (long z = lo[2]; z < hi[2]; z += 8)
        for (long y = lo[1]; y < hi[1]; y += 8)
            for (long x = lo[0]; x < hi[0]; x += 8) {
                const long block[3] = {x, y, z};
                const auto mask = active_voxels(s, block);
                if (mask.isOff())
                    continue;
                const Coord origin(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
                tree.add(origin, mask);
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
    if (s.y_up)
        grid.insertMeta("isoshade_up", openvdb::StringMetadata("y"));
    if (s.channels == 3 && s.is_color) {
        grid.setVectorType(openvdb::VEC_INVARIANT);
    } else if (s.channels == 3) {
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
    if (s.direction_scale != 1)
        grid.insertMeta("isoshade_direction_scale", openvdb::DoubleMetadata(s.direction_scale));
    if (s.reversed_x)
        grid.insertMeta("isoshade_reversed_x", openvdb::BoolMetadata(true));
    grid.insertMeta("isoshade_made_from", openvdb::StringMetadata(s.made_from));
    if (s.labels)
        grid.insertMeta("isoshade_labels", openvdb::StringMetadata(s.labels));
    grid.insertMeta("isoshade_meaning", openvdb::StringMetadata(s.meaning));
}

template <typename Value> openvdb::GridBase::Ptr build(const iso_vdb_source &s)
{
    using Tree = iso_vdb::written_tree<Value>;
    Value background;
    const float empty[3] = {s.channels == 1 ? s.background : 0, 0, 0};
    iso_vdb::take(empty, background);
    const auto tree = std::make_shared<Tree>(background, &s);
    fill(*tree, s);
    const auto grid = std::make_shared<iso_vdb::written_grid<Value>>(tree, s.fog_volume);
    describe(*grid, s);
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
    const auto up = grid.getMetadata<openvdb::StringMetadata>("isoshade_up");
    if (up && up->value() == "y") /* (x, y, z) of the file is (x, -z, y) of ours: fields.h */
        for (int c = 0; c < 4; ++c) {
            const double y = info->index_to_world[1][c];
            info->index_to_world[1][c] = -info->index_to_world[2][c];
            info->index_to_world[2][c] = y;
        }
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

static iso_vdb_file *create_file()
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

static int add_grid(iso_vdb_file *file, const iso_vdb_source *source, iso_vdb_message *message)
{
    return guarded(message, [&] {
        file->sources.push_back(*source);
        const iso_vdb_source &own = file->sources.back();
        file->grids.push_back(own.channels == 3 ? build<openvdb::Vec3f>(own) : build<float>(own));
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

static int note_text(iso_vdb_file *file, const char *key, const char *text, iso_vdb_message *message)
{
    return guarded(message, [&] {
        file->about.insertMeta(key, openvdb::StringMetadata(text));
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

static int write_file(const iso_vdb_file *file, const char *path, iso_openvdb_form form, iso_vdb_message *message)
{
    return guarded(message, [&] {
        checked_places buffer;
        if (!buffer.open(path, std::ios::out | std::ios::binary | std::ios::trunc))
            throw std::ios::failure("the file cannot be opened");
        std::ostream out(&buffer);
        out.exceptions(std::ios::failbit | std::ios::badbit);
        if (form == ISO_OPENVDB_NANO)
            iso_vdb::write_nanovdb(out, *file);
        else
            archive().save(out, file->grids, file->about, form == ISO_OPENVDB_SMALL);
        if (!buffer.close() || buffer.failed)
            throw std::ios::failure("the file cannot be written");
        return static_cast<int>(ISO_OPENVDB_OK);
    });
}

static void destroy_file(iso_vdb_file *file)
{
    delete file;
}

static int read_grid(const char *path, const char *name, int channels, const size_t size[3], float *out,
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
            std::snprintf(message->text, sizeof message->text, "grid \"%s\" has values of type %s, must be %s", name,
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

static int measure(const char *path, size_t *active_voxels, size_t *memory_bytes, iso_vdb_message *message)
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

extern "C" const iso_openvdb iso_openvdb_functions; /* a C++ constant is local to its file without extern */
const iso_openvdb iso_openvdb_functions = {create_file,  add_grid,  note_text, write_file,
                                           destroy_file, read_grid, measure,   iso_vdb::nanovdb_version};
