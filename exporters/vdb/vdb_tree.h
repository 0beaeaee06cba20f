/* SPDX-License-Identifier: MIT */
/* vdb_tree.h - a tree of a grid that knows which voxels are active, and reads their values when it is written.
 *
 * OpenVDB writes a tree that is complete in memory, 4 bytes a voxel and 12 of a vector. This one is the same to the
 * file, bit for bit, but its leaves have no values: a grid of 512 x 512 x 512 voxels takes 30 MB instead of .5 or 1.6
 * GB.
 *
 * It is for writing alone: nothing may ask it for a value. Private to exporters/vdb. */
#ifndef ISO_VDB_TREE_H
#define ISO_VDB_TREE_H

#include <memory>
#include <vector>

#include <openvdb/openvdb.h>

#include "vdb/vdb_leaves.h"
#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

/* A tree whose leaves hold which voxels are active and no values: these are read from the source when the tree is
 * written. To the file it is the same as a tree with values. */
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

    /* The leaves in the order that the nodes above them have. */
    void writeBuffers(std::ostream &out, bool to_half) const override
    {
        std::vector<const leaf *> leaves;
        leaves.reserve(this->leafCount());
        for (auto i = this->cbeginLeaf(); i; ++i)
            leaves.push_back(&*i);
        write_leaves(out, leaves, *source_, to_half);
    }

    /* Memory of a program that reads the grid. */
    openvdb::Index64 memUsage() const override
    {
        return base::memUsage() + this->leafCount() * leaf::SIZE * sizeof(T);
    }

private:
    const iso_vdb_source *source_;
};

/* A grid for OpenVDB's archive, which writes the type first, and the header from a copy. Two things differ from then
 * on.
 *
 * The class. Fog volumes are written without ZIP, which halves them, though they are read with it: the archive looks at
 * the class before it makes the copy.
 *
 * The type. Of grids of the types that it knows the archive asks all leaves for their values, to note in the header how
 * large they will be (file_delayed_load). Here they have none. Readers do without: they find the sizes in the file as
 * they go. */
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
