/* SPDX-License-Identifier: MIT */
/* vdb_read.cc - the program isoshade-vdb: one grid of an OpenVDB file as a volume, the box of its active voxels. */
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <algorithm>

#include "volume/child_writer.h"

namespace {

constexpr double MOST_VOXELS = 1e13;

std::string sizes_of(const openvdb::Coord &size)
{
    return std::to_string(size.x()) + " x " + std::to_string(size.y()) + " x " + std::to_string(size.z());
}

/* A grid that a file lists. */
struct Entry {
    std::string name, type;
};

bool is_scalar(const std::string &type)
{
    return type == "float" || type == "double" || type == "int32" || type == "bool" || type == "mask" || type == "half";
}

std::string list_of(const std::vector<Entry> &all)
{
    std::string text;
    for (size_t i = 0; i < all.size() && i < 12; ++i)
        text += (i ? ", " : "") + all[i].name + " (" + all[i].type + ")";
    return all.size() > 12 ? text + " and " + std::to_string(all.size() - 12) + " more" : text;
}

std::string choose(const std::vector<Entry> &all, const std::string &wanted, const std::string &path)
{
    size_t scalars = 0;
    std::string only;
    for (const auto &entry : all) {
        if (entry.name == wanted)
            return entry.name;
        if (is_scalar(entry.type))
            ++scalars, only = entry.name;
    }
    if (wanted.empty() && scalars == 1)
        return only;
    if (all.empty())
        fail(ISO_E_FORMAT, path + ": holds no grids");
    if (wanted.empty() && scalars == 0)
        fail(ISO_E_FORMAT, path + ": holds no scalar grid: " + list_of(all));
    fail(ISO_E_USAGE, path +
                          (!wanted.empty() ? ": has no grid \"" + wanted + "\""
                                           : ": holds " + std::to_string(scalars) + " scalar grids") +
                          ", FILE:GRID must name one of: " + list_of(all));
}

/* The samples of one grid, a plane after the other. */
struct Samples {
    virtual ~Samples() = default;
    virtual void read(const openvdb::CoordBBox &plane, char *out) const = 0;
};

template <typename Grid, typename Value> struct SamplesOf : Samples {
    typename Grid::ConstPtr grid;
    explicit SamplesOf(typename Grid::ConstPtr g) : grid(std::move(g)) {}
    void read(const openvdb::CoordBBox &plane, char *out) const override
    {
        openvdb::tools::Dense<Value, openvdb::tools::LayoutXYZ> dense(plane, reinterpret_cast<Value *>(out));
        openvdb::tools::copyToDense(*grid, dense, /*serial=*/true);
    }
};

class VdbReader : public PlaneReader {
public:
    VdbReader(const std::string &path, const std::string &part)
    {
        openvdb::initialize();
        openvdb::io::File file(path);
        file.open(/*delayLoad=*/false); /* without a delay the file is not copied first, since writing may be
                                         * forbidden */
        std::vector<Entry> all;
        for (auto name = file.beginName(); name != file.endName(); ++name)
            all.push_back({name.gridName(), file.readGridMetadata(name.gridName())->valueType()});
        const std::string name = choose(all, part, path);
        shown_ = path + ":" + name;
        const openvdb::GridBase::Ptr grid = file.readGrid(name);
        take_samples(grid);
        take_box(*grid);
        take_place(*grid);
    }

    void read_plane(char *out, size_t bytes) override
    {
        const int z = box_.min().z() + next_++;
        samples_->read({{box_.min().x(), box_.min().y(), z}, {box_.max().x(), box_.max().y(), z}}, out);
        if (reversed_)
            reverse_rows(out, bytes);
    }

private:
    std::string shown_;
    std::unique_ptr<Samples> samples_;
    openvdb::CoordBBox box_;
    int next_ = 0;
    bool reversed_ = false; /* rows run the other way than those of the volume that isoshade wrote */

    void reverse_rows(char *out, size_t bytes) const
    {
        const size_t width = header.size[0], sample = bytes_of(header.type);
        for (char *row = out; row < out + bytes; row += width * sample)
            for (size_t i = 0, j = width - 1; i < j; ++i, --j)
                std::swap_ranges(row + i * sample, row + (i + 1) * sample, row + j * sample);
    }

    template <typename Grid, typename Value> bool take_as(const openvdb::GridBase::Ptr &grid, iso_type type)
    {
        const auto typed = openvdb::gridConstPtrCast<Grid>(grid);
        if (!typed)
            return false;
        samples_ = std::make_unique<SamplesOf<Grid, Value>>(typed);
        header.type = type;
        return true;
    }

    void take_samples(const openvdb::GridBase::Ptr &grid)
    {
        if (!take_as<openvdb::FloatGrid, float>(grid, ISO_F32) &&
            !take_as<openvdb::DoubleGrid, double>(grid, ISO_F64) &&
            !take_as<openvdb::Int32Grid, int32_t>(grid, ISO_I32) &&
            !take_as<openvdb::BoolGrid, uint8_t>(grid, ISO_U8) && !take_as<openvdb::MaskGrid, uint8_t>(grid, ISO_U8))
            fail(ISO_E_FORMAT,
                 shown_ + ": values of type " + grid->valueType() + ", must be float, double, int32 or bool");
    }

    /* Takes the level's size from isoshade's own files, which may have a rim around it. */
    void take_box(const openvdb::GridBase &grid)
    {
        box_ = grid.evalActiveVoxelBoundingBox();
        if (box_.empty())
            fail(ISO_E_FORMAT, shown_ + ": has no active voxels");
        const auto size = grid.getMetadata<openvdb::Vec3IMetadata>("isoshade_size");
        const auto inner = grid.getMetadata<openvdb::Vec3DMetadata>("isoshade_box_index");
        if (size && size->value()[0] > 0 && size->value()[1] > 0 && size->value()[2] > 0) {
            const openvdb::Coord last(size->value()[0] - 1, size->value()[1] - 1, size->value()[2] - 1);
            const openvdb::CoordBBox level(openvdb::Coord(0), last);
            if (box_.isInside(level)) {
                box_ = level;
                const auto reversed = grid.getMetadata<openvdb::BoolMetadata>("isoshade_reversed_x");
                reversed_ = reversed && reversed->value();
                for (int a = 0; inner && a < 3; ++a)
                    header.box[a] = inner->value()[a] > 0 && inner->value()[a] <= size->value()[a] ? inner->value()[a]
                                                                                                   : 0;
            }
        }
        double voxels = 1;
        for (int a = 0; a < 3; ++a) {
            const double n = static_cast<double>(box_.max()[a]) - static_cast<double>(box_.min()[a]) + 1;
            header.size[a] = static_cast<size_t>(n);
            voxels *= n;
        }
        if (voxels > MOST_VOXELS)
            fail(ISO_E_RANGE, shown_ + ": its active voxels are " + sizes_of(box_.min()) + " to " +
                                  sizes_of(box_.max()) + ", too far apart for a volume");
    }

    /* OpenVDB multiplies row vectors from the left, and has the centers of voxels at integers. */
    void take_place(const openvdb::GridBase &grid)
    {
        if (!grid.transform().isLinear())
            fail(ISO_E_FORMAT, shown_ + ": a transform of type " + grid.transform().mapType() + ", must be linear");
        const openvdb::Mat4d m = grid.transform().baseMap()->getAffineMap()->getMat4();
        for (int r = 0; r < 3; ++r) {
            header.first[r] = m(3, r);
            for (int a = 0; a < 3; ++a) {
                header.step[a][r] = m(a, r);
                header.first[r] += m(a, r) * box_.min()[a];
            }
        }
        for (int r = 0; r < 3 && reversed_; ++r) {
            header.first[r] += header.step[0][r] * static_cast<double>(header.size[0] - 1);
            header.step[0][r] = -header.step[0][r];
        }
        header.world = ISO_CHILD_OWN;
        take_unit(grid);
    }

    static void turn_back(double v[3])
    {
        const double y = v[1];
        v[1] = -v[2];
        v[2] = y;
    }

    /* Takes the unit and the origin from isoshade's own files; OpenVDB has no unit. */
    void take_unit(const openvdb::GridBase &grid)
    {
        const auto name = grid.getMetadata<openvdb::StringMetadata>("isoshade_unit");
        const auto mm = grid.getMetadata<openvdb::DoubleMetadata>("isoshade_unit_mm");
        const auto origin = grid.getMetadata<openvdb::Vec3DMetadata>("isoshade_origin_mm");
        for (auto &text : header.unit)
            snprintf(text, sizeof text, "%s", name ? name->value().c_str() : mm ? "mm" : "");
        const double scale = mm && !name ? mm->value() : 1;
        const auto up = grid.getMetadata<openvdb::StringMetadata>("isoshade_up");
        if (up && up->value() == "y") { /* (x, y, z) of the file is (x, -z, y) of ours */
            turn_back(header.first);
            for (auto &step : header.step)
                turn_back(step);
        }
        for (int r = 0; r < 3; ++r) {
            header.first[r] = scale * header.first[r] +
                              (origin && mm ? origin->value()[r] / (name ? mm->value() : 1) : 0);
            for (int a = 0; a < 3; ++a)
                header.step[a][r] *= scale;
        }
    }
};

std::unique_ptr<PlaneReader> open_reader(const std::string &path, const Wanted &wanted)
{
    return std::make_unique<VdbReader>(path, wanted.part);
}

std::string cause_of(const std::exception &e)
{
    return std::string("OpenVDB: ") + e.what();
}

} // namespace

const ChildProgram child_program = {open_reader, cause_of};
