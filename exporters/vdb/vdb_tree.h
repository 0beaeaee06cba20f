/* SPDX-License-Identifier: MIT */
/* vdb_tree.h - a tree that holds only the active flags of a grid, and reads the values when it is written.
 *
 * OpenVDB writes trees that are complete in memory: 4 bytes per voxel, 12 per vector. This tree gives the same file,
 * bit for bit, but its leaves have no values: a grid of 512 x 512 x 512 voxels takes 30 MB instead of .5 or 1.6 GB.
 *
 * For writing only: values cannot be queried. Private to exporters/vdb. */
#pragma once

#include <list>
#include <memory>
#include <vector>

#include <openvdb/openvdb.h>

#include "vdb/vdb_leaves.h"
#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

/* A tree whose leaves hold active flags and no values; these are read from the source while the tree is written. The
 * file is the same as that of a tree with values. */
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

    /* Writes the leaves in the order of the nodes above them. */
    void writeBuffers(std::ostream &out, bool to_half) const override
    {
        std::vector<const leaf *> leaves;
        leaves.reserve(this->leafCount());
        for (auto i = this->cbeginLeaf(); i; ++i)
            leaves.push_back(&*i);
        write_leaves(out, leaves, *source_, to_half);
    }

    /* Memory of the grid in a reader. */
    openvdb::Index64 memUsage() const override
    {
        return base::memUsage() + this->leafCount() * leaf::SIZE * sizeof(T);
    }

private:
    const iso_vdb_source *source_;
};

/* A grid for OpenVDB's archive, which writes the type first, and then the header from a copy. From then on, two things
 * differ.
 *
 * The class: fog volumes are written without ZIP, which would halve them, although readers accept it. The archive
 * checks the class before it makes the copy.
 *
 * The type: for known types the archive asks all leaves for their values, to note their size in the header
 * (file_delayed_load). Here they have none. Readers do without: they find the sizes in the file. */
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

/* A file to be written: its grids and, in the same order, the sources of their values, which must not move. */
struct iso_vdb_file {
    std::list<iso_vdb_source> sources;
    openvdb::GridCPtrVec grids;
    openvdb::MetaMap about;
};
