/* SPDX-License-Identifier: MIT */
/* vdb_tree.h - a tree of a grid that knows which voxels are active, and reads their values when it is written.
 *
 * OpenVDB writes a tree that is complete in memory, 4 bytes a voxel and 12 of a vector. This one is the same to the file,
 * bit for bit, but its leaves have no values: a grid of 512 x 512 x 512 voxels takes 30 MB instead of .5 or 1.6 GB.
 *
 * It is for writing alone: nothing may ask it for a value. Private to exporters/vdb. */
#ifndef ISO_VDB_TREE_H
#define ISO_VDB_TREE_H

#include <algorithm>
#include <memory>

#include <openvdb/io/Compression.h>
#include <openvdb/openvdb.h>

#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

inline long clamp(long v, long size)
{
    return v < 0 ? 0 : v < size ? v : size - 1;
}

/* Row (y, z) of eight voxels from x on, counted from the first one, with edge values where it leaves the volume. */
inline void read_row(const iso_vdb_source &s, long x, long y, long z, float *row)
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

inline void take(const float *v, float &out)
{
    out = v[0];
}
inline void take(const float *v, openvdb::Vec3f &out)
{
    out = openvdb::Vec3f(v[0], v[1], v[2]);
}

/* A tree whose leaves hold which voxels are active and no values: these are read from the source when the tree is written.
 * To the file it is the same as a tree with values. */
template <typename T> class written_tree : public openvdb::tree::Tree4<T, 5, 4, 3>::Type {
    using base = typename openvdb::tree::Tree4<T, 5, 4, 3>::Type;
    using leaf = typename base::LeafNodeType;
    using mask = typename leaf::NodeMaskType;

public:
    written_tree(const T &background, const iso_vdb_source *source) : base(background), source_(source) {}

    void add(const openvdb::Coord &origin, const mask &active)
    {
        leaf *made = new leaf(openvdb::PartialCreate(), origin, this->background());
        made->setValueMask(active);
        this->addLeaf(made);
    }

    /* The leaves in the order that the nodes above them have, each as LeafNode::writeBuffers does. */
    void writeBuffers(std::ostream &out, bool to_half) const override
    {
        T values[leaf::SIZE];
        for (auto i = this->cbeginLeaf(); i; ++i) {
            const mask &active = i->getValueMask();
            read(i->origin(), active, values);
            active.save(out);
            openvdb::io::writeCompressedValues(out, values, leaf::SIZE, active, mask(), to_half);
        }
    }

    /* What a program that reads the grid will hold. */
    openvdb::Index64 memUsage() const override
    {
        return base::memUsage() + this->leafCount() * leaf::SIZE * sizeof(T);
    }

private:
    static bool is_active(const mask &active, int x, int y, int z)
    {
        return active.isOn(static_cast<openvdb::Index>(64 * x + 8 * y + z));
    }

    static bool any_active(const mask &active, int y, int z)
    {
        bool any = false;
        for (int x = 0; x < 8; ++x)
            any = any || is_active(active, x, y, z);
        return any;
    }

    /* Voxels of a leaf follow each other along z, then y. */
    void read(const openvdb::Coord &at, const mask &active, T *values) const
    {
        const iso_vdb_source &s = *source_;
        float row[24];
        std::fill_n(values, +leaf::SIZE, this->background());
        for (int z = 0; z < 8; ++z)
            for (int y = 0; y < 8; ++y) {
                if (!any_active(active, y, z))
                    continue;
                read_row(s, at.x() - s.first[0], at.y() + y - s.first[1], at.z() + z - s.first[2], row);
                for (int x = 0; x < 8; ++x)
                    if (is_active(active, x, y, z))
                        take(row + x * s.channels, values[64 * x + 8 * y + z]);
            }
    }

    const iso_vdb_source *source_;
};

/* A grid for OpenVDB's archive, which writes the type first, and the header from a copy. Two things differ from then on.
 *
 * The class. Fog volumes are written without ZIP, which halves them, though they are read with it: the archive looks at the
 * class before it makes the copy.
 *
 * The type. Of grids of the types that it knows the archive asks all leaves for their values, to note in the header how large
 * they will be (file_delayed_load). Here they have none. Readers do without: they find the sizes in the file as they go. */
template <typename T> class written_grid : public openvdb::Grid<typename openvdb::tree::Tree4<T, 5, 4, 3>::Type> {
    using base = openvdb::Grid<typename openvdb::tree::Tree4<T, 5, 4, 3>::Type>;

public:
    written_grid(const typename base::TreePtrType &tree, bool fog_volume) : base(tree), fog_volume_(fog_volume) {}

    openvdb::Name type() const override
    {
        return for_header_ ? "written" : base::type();
    }
    openvdb::GridBase::Ptr copyGrid() override
    {
        return header();
    }
    openvdb::GridBase::ConstPtr copyGrid() const override
    {
        return header();
    }

private:
    openvdb::GridBase::Ptr header() const
    {
        for_header_ = true;
        const auto copy = std::make_shared<written_grid>(*this);
        if (fog_volume_)
            copy->setGridClass(openvdb::GRID_FOG_VOLUME);
        return copy;
    }

    bool fog_volume_;
    mutable bool for_header_ = false; /* the type has been written */
};

} // namespace iso_vdb

#endif
