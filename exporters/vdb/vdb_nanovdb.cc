/* SPDX-License-Identifier: MIT */
#include "vdb/vdb_nanovdb.h"
#include "vdb/vdb_tree.h"

#if __has_include(<nanovdb/util/OpenToNanoVDB.h>) /* until OpenVDB 11; later versions have another layout */

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

namespace {

using checksum = std::uint_fast32_t; /* as NanoVDB sums them up */

/* Statistics of the active values of a node, their box, and the checksum of a written leaf. */
template <typename Value> struct node_sums {
    nanovdb::Stats<Value> stats;
    nanovdb::CoordBBox box;
    checksum crc = 0;

    void add(const node_sums &child)
    {
        stats.add(child.stats);
        box[0].minComponent(child.box[0]);
        box[1].maxComponent(child.box[1]);
    }

    template <typename Data> void store(Data *data) const
    {
        data->setMin(stats.min());
        data->setMax(stats.max());
        data->setAvg(stats.avg());
        data->setDev(stats.std());
    }
};

template <typename T> checksum checksum_of(const T *node)
{
    return libdeflate_crc32(0, node, sizeof *node);
}

/* Rounds a value as a half float does. */
template <typename Value> Value halved(const Value &value)
{
    return Value(openvdb::io::RealToHalf<Value>::convert(value));
}

/* Makes leaves from the source's values. One per thread. */
template <typename Value> class nano_leaf_writer {
    using open_leaf = typename openvdb::tree::Tree4<Value, 5, 4, 3>::Type::LeafNodeType;
    using nano_value = typename nanovdb::OpenToNanoType<Value>::Type;
    using nano_leaf = nanovdb::NanoLeaf<nano_value>;

public:
    nano_leaf_writer(const iso_vdb_source &source, const nano_value &background, node_sums<nano_value> *done)
        : source_(source), background_(background), done_(done)
    {
    }

    std::string take_bytes()
    {
        return std::move(bytes_);
    }

    void write(const open_leaf &from, size_t number)
    {
        node_sums<nano_value> &sums = done_[number];
        auto *leaf = reinterpret_cast<nano_leaf *>(room_);
        auto *data = leaf->data();
        std::memset(room_, 0, sizeof room_);
        data->mBBoxMin = nanovdb::Coord(from.origin().x(), from.origin().y(), from.origin().z());
        data->mValueMask = from.valueMask();
        fill(from, data, sums.stats);
        leaf->updateBBox();
        sums.box = {data->mBBoxMin,
                    data->mBBoxMin + nanovdb::Coord(data->mBBoxDif[0], data->mBBoxDif[1], data->mBBoxDif[2])};
        sums.store(data);
        sums.crc = checksum_of(leaf);
        bytes_.append(room_, sizeof room_);
    }

private:
    void fill(const open_leaf &from, typename nano_leaf::DataType *data, nanovdb::Stats<nano_value> &stats)
    {
        const size_t count = iso_vdb::read_active(source_, from, values_);
        if (source_.half_float)
            std::transform(values_, values_ + count, values_, halved<Value>);
        std::fill_n(data->mValues, static_cast<size_t>(open_leaf::SIZE), background_);
        const Value *value = values_;
        for (auto i = data->mValueMask.beginOn(); i; ++i) {
            data->mValues[*i] = *value++;
            stats.add(data->mValues[*i]);
        }
    }

    const iso_vdb_source &source_;
    const nano_value &background_;
    node_sums<nano_value> *done_;
    std::string bytes_;
    Value values_[open_leaf::SIZE];
    alignas(32) char room_[sizeof(nano_leaf)];
};

/* Writes a grid: its leaves first, then all before them. */
template <typename Value> class grid_writer {
    using open_grid = openvdb::Grid<typename openvdb::tree::Tree4<Value, 5, 4, 3>::Type>;
    using open_upper = typename open_grid::TreeType::RootNodeType::ChildNodeType;
    using open_lower = typename open_upper::ChildNodeType;
    using open_leaf = typename open_lower::ChildNodeType;
    using nano_value = typename nanovdb::OpenToNanoType<Value>::Type;
    using nano_grid = nanovdb::NanoGrid<nano_value>;
    using nano_root = nanovdb::NanoRoot<nano_value>;
    using nano_upper = nanovdb::NanoUpper<nano_value>;
    using nano_lower = nanovdb::NanoLower<nano_value>;
    using nano_leaf = nanovdb::NanoLeaf<nano_value>;
    using sums = node_sums<nano_value>;

public:
    grid_writer(std::ostream &out, const openvdb::GridBase &grid, const iso_vdb_source &source)
        : out_(out), open_(static_cast<const open_grid &>(grid)), source_(source), counts_(open_.tree().nodeCount())
    {
        at_[UPPER] = nano_grid::memUsage() + nanovdb::NanoTree<nano_value>::memUsage() +
                     nano_root::memUsage(open_.tree().root().getTableSize());
        at_[LOWER] = at_[UPPER] + counts_[2] * sizeof(nano_upper);
        at_[LEAF] = at_[LOWER] + counts_[1] * sizeof(nano_lower);
        at_[END] = at_[LEAF] + counts_[0] * sizeof(nano_leaf);
        nodes_ = nanovdb::HostBuffer::create(at_[LEAF]);
        std::memset(nodes_.data(), 0, at_[LEAF]);
        begin();
    }

    /* Writes the grid at the position of the stream. values: a note on all values, or empty. */
    nanovdb::io::GridMetaData write(const std::string &values)
    {
        const auto start = out_.tellp();
        out_.seekp(start + static_cast<std::streamoff>(at_[LEAF]));
        write_leaves();
        if (!values.empty())
            write_note("isoshade_values", values);
        finish();
        const auto end = out_.tellp();
        out_.seekp(start);
        out_.write(reinterpret_cast<const char *>(nodes_.data()), static_cast<std::streamsize>(at_[LEAF]));
        out_.seekp(end);
        nanovdb::io::GridMetaData about(grid()->gridSize(), nanovdb::io::Codec::NONE, *grid());
        about.fileSize = grid()->gridSize();
        return about;
    }

private:
    enum { UPPER, LOWER, LEAF, END };

    nano_grid *grid()
    {
        return reinterpret_cast<nano_grid *>(nodes_.data());
    }
    typename nano_root::DataType *root()
    {
        return grid()->tree().root().data();
    }

    /* NanoVDB itself makes the grid's head: that of a grid without voxels. */
    void begin()
    {
        const auto empty = open_grid::create(source_.half_float ? halved(open_.background()) : open_.background());
        empty->setName(open_.getName());
        empty->setTransform(open_.transform().copy());
        if (source_.fog_volume && source_.channels == 1) /* NanoVDB allows fog volumes for one channel only */
            empty->setGridClass(openvdb::GRID_FOG_VOLUME);
        const auto made = nanovdb::openToNanoVDB(*empty, nanovdb::StatsMode::All, nanovdb::ChecksumMode::Full);
        std::memcpy(nodes_.data(), made.data(), made.size());
        grid()->data()->mGridSize = at_[END];
    }

    void write_leaves()
    {
        auto *upper = reinterpret_cast<nano_upper *>(nodes_.data() + at_[UPPER]);
        auto *lower = reinterpret_cast<nano_lower *>(nodes_.data() + at_[LOWER]);
        for (auto u = open_.tree().root().cbeginChildOn(); u; ++u, ++upper) {
            sums all;
            begin_node(*u, upper);
            for (auto l = u->cbeginChildOn(); l; ++l, ++lower) {
                upper->data()->setChild(l.pos(), lower);
                begin_node(*l, lower);
                const sums of_lower = write_leaves_of(*l, lower);
                finish_node(lower, of_lower, crcs_[LOWER]);
                all.add(of_lower);
            }
            finish_node(upper, all, crcs_[UPPER]);
            root()->tile(root()->mTableSize++)->setChild(u.getCoord(), upper, root());
            total_.add(all);
        }
    }

    sums write_leaves_of(const open_lower &from, nano_lower *to)
    {
        std::vector<const open_leaf *> leaves;
        auto leaf = static_cast<std::int64_t>(at_[LEAF] + crcs_[LEAF].size() * sizeof(nano_leaf)) -
                    (reinterpret_cast<std::uint8_t *>(to) - nodes_.data());
        for (auto i = from.cbeginChildOn(); i; ++i, leaf += sizeof(nano_leaf)) {
            to->data()->mTable[i.pos()].child = leaf;
            leaves.push_back(&*i);
        }
        const iso_vdb::leaf_run<open_leaf> run = {leaves.data(), leaves.size()};
        std::vector<sums> done(run.count);
        iso_vdb::prepare_run(run, source_);
        iso_vdb::write_run(out_, run, source_,
                           [&] { return nano_leaf_writer<Value>(source_, root()->mBackground, done.data()); });
        sums all;
        for (const sums &leaf_sums : done) {
            all.add(leaf_sums);
            crcs_[LEAF].push_back(leaf_sums.crc);
        }
        return all;
    }

    template <typename From, typename To> void begin_node(const From &from, To *to)
    {
        auto *data = to->data();
        data->mValueMask = from.getValueMask();
        data->mChildMask = from.getChildMask();
        for (auto i = from.getChildMask().beginOff(); i; ++i)
            data->setValue(i.pos(), root()->mBackground);
    }

    template <typename Node> void finish_node(Node *node, const sums &of_node, std::vector<checksum> &crcs)
    {
        auto *data = node->data();
        data->mBBox = of_node.box;
        data->mFlags = 2; /* it has active values */
        of_node.store(data);
        crcs.push_back(checksum_of(node));
    }

    /* Writes a text as blind data: NanoVDB has no metadata. A reader finds it by the name. */
    void write_note(const char *name, const std::string &text)
    {
        std::string bytes((sizeof(nanovdb::GridBlindMetaData) + text.size() + 32) / 32 * 32, '\0');
        auto *note = reinterpret_cast<nanovdb::GridBlindMetaData *>(&bytes[0]);
        note->mSemantic = nanovdb::GridBlindDataSemantic::Unknown;
        note->mDataClass = nanovdb::GridBlindDataClass::Unknown;
        note->mDataType = nanovdb::GridType::Unknown;
        std::strcpy(note->mName, name);
        note->setBlindData(note + 1);
        note->mElementCount = text.size() + 1;
        std::memcpy(note + 1, text.data(), text.size());
        out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        grid()->data()->mBlindMetadataOffset = static_cast<std::int64_t>(at_[END]);
        grid()->data()->mBlindMetadataCount = 1;
        grid()->data()->mGridSize += bytes.size();
    }

    void finish()
    {
        const bool is_empty = crcs_[LEAF].empty();
        if (!is_empty)
            finish_tree();
        const checksum head = nanovdb::checksum(*grid(), nanovdb::ChecksumMode::Partial);
        grid()->data()->mChecksum = is_empty ? head : (head & 0xffffffff) | checksum_of_nodes() << 32;
    }

    void finish_tree()
    {
        auto *tree = grid()->tree().data();
        const auto &box = total_.box;
        tree->setFirstNode(reinterpret_cast<nano_upper *>(nodes_.data() + at_[UPPER]));
        tree->setFirstNode(reinterpret_cast<nano_lower *>(nodes_.data() + at_[LOWER]));
        tree->setFirstNode(reinterpret_cast<nano_leaf *>(nodes_.data() + at_[LEAF]));
        std::copy_n(counts_.begin(), 3, tree->mNodeCount);
        tree->mVoxelCount = total_.stats.size();
        root()->mBBox = box;
        total_.store(root());
        for (int i = 0; i < 8; ++i)
            grid()->data()->mWorldBBox.expand(grid()->map().applyMap(
                nanovdb::Vec3d(i & 1 ? box[1][0] + 1 : box[0][0], i & 2 ? box[1][1] + 1 : box[0][1],
                               i & 4 ? box[1][2] + 1 : box[0][2])));
        grid()->data()->setBBoxOn(true);
    }

    checksum checksum_of_nodes() const
    {
        std::uint32_t crc = 0;
        for (const auto &crcs : crcs_)
            crc = libdeflate_crc32(crc, crcs.data(), crcs.size() * sizeof(checksum));
        return crc;
    }

    std::ostream &out_;
    const open_grid &open_;
    const iso_vdb_source &source_;
    const std::vector<openvdb::Index32> counts_; /* of leaves, lower and upper nodes */
    size_t at_[END + 1];                         /* bytes of the grid before its nodes of a kind */
    nanovdb::HostBuffer nodes_;                  /* all before the leaves */
    sums total_;
    std::vector<checksum> crcs_[END]; /* of nodes of each kind */
};

using sourced_grid = std::pair<const openvdb::GridBase *, const iso_vdb_source *>;

/* In the order of the names, but density first: many programs take the first grid. */
bool comes_first(const sourced_grid &a, const sourced_grid &b)
{
    const std::string name = a.first->getName(), other = b.first->getName();
    const bool is_density = name.rfind("density", 0) == 0, other_is = other.rfind("density", 0) == 0;
    return is_density != other_is ? is_density : name < other;
}

} // namespace

void iso_vdb::write_nanovdb(std::ostream &out, const iso_vdb_file &file)
{
    const auto about = file.about.getMetadata<openvdb::StringMetadata>("values");
    const std::string note = about ? about->value() : "";
    std::vector<sourced_grid> grids;
    nanovdb::io::Segment segment;
    auto source = file.sources.begin();
    std::streamoff head = sizeof segment.header;
    for (const auto &grid : file.grids) {
        grids.emplace_back(grid.get(), &*source++);
        head += static_cast<std::streamoff>(sizeof(nanovdb::io::MetaData) + grid->getName().size() + 1);
    }
    std::sort(grids.begin(), grids.end(), comes_first);
    out.seekp(head);
    for (const auto &g : grids)
        segment.meta.push_back(g.second->channels == 3
                                   ? grid_writer<openvdb::Vec3f>(out, *g.first, *g.second).write(note)
                                   : grid_writer<float>(out, *g.first, *g.second).write(note));
    segment.header.gridCount = static_cast<std::uint16_t>(grids.size());
    out.seekp(0);
    segment.write(out);
}

const char *iso_vdb::nanovdb_version()
{
#define NUMBERS_AS_TEXT(a, b, c) #a "." #b "." #c
#define VERSION_TEXT(a, b, c) NUMBERS_AS_TEXT(a, b, c)
    return VERSION_TEXT(NANOVDB_MAJOR_VERSION_NUMBER, NANOVDB_MINOR_VERSION_NUMBER, NANOVDB_PATCH_VERSION_NUMBER);
}

#else /* built without the headers */

void iso_vdb::write_nanovdb(std::ostream &, const iso_vdb_file &) {}

const char *iso_vdb::nanovdb_version()
{
    return nullptr;
}

#endif
